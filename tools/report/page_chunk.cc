#include "tools/report/page_chunk.h"

#include <cmath>
#include <tuple>

#include "model/high_zones.h"
#include "tools/record/report_json.h"
#include "tools/report/directive_rows.h"

namespace muster::tools {
namespace {

using nlohmann::ordered_json;

std::int64_t Whole(double metres) {
  return std::isfinite(metres) ? static_cast<std::int64_t>(std::llround(metres)) : 0;
}
ordered_json Number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json();
}

/// Appends what is new in `growing` to `list` through write(row); returns the index of the first
/// row written, -1 when nothing is new. A last row that may have changed is written again.
template <class T, class Write>
std::int64_t Fresh(const Growing<T>& growing, PageCursor::Place* place, ordered_json* list,
                   Write write) {
  if (place->version == growing.version) return -1;
  std::size_t from = place->rows > 0 ? place->rows - 1 : 0;
  if (place->rebuilt != growing.rebuilt) from = 0;
  for (std::size_t i = from; i < growing.rows.size(); ++i) write(growing.rows[i], list);
  *place = {growing.rows.size(), growing.version, growing.rebuilt};
  return static_cast<std::int64_t>(from);
}

/// [from, [numbers of all rows, one after the other]]; nothing when nothing is new.
template <class T, class Write>
void Flat(const char* key, const Growing<T>& growing, PageCursor::Place* place, ordered_json* chunk,
          Write write) {
  ordered_json list = ordered_json::array();
  const std::int64_t from = Fresh(growing, place, &list, write);
  if (from >= 0) (*chunk)[key] = {from, std::move(list)};
}

void WriteAction(const action_t& a, ordered_json* list) {
  list->insert(list->end(), {a.kind, a.uav_id, a.worker_id, a.vehicle_id, a.task_id, a.charge_id,
                             Whole(a.x_m), Whole(a.y_m), Number(a.weight)});
}

void WriteSchedule(const schedule_t& s, ordered_json* list) {
  ordered_json actions = ordered_json::array();
  for (const action_t& action : s.actions) WriteAction(action, &actions);
  list->push_back({s.decision, Ms(s.header.sim_us), Number(s.weight), Number(s.bound), s.candidates,
                   s.solve_us, s.policy, std::move(actions)});
}

/// What a task has in version 2 of the scenario only. One that is never reported is vacant: an
/// order may fill its place.
ordered_json TaskTime(const Task& task) {
  const auto time = [](TimeUs t) { return t == kNever ? ordered_json() : ordered_json(Ms(t)); };
  ordered_json row = {time(task.reported_us), time(task.due_us), time(task.expires_us),
                      static_cast<int>(task.priority), task.name};
  if (!task.note.empty()) row.push_back(task.note);
  return row;
}

ordered_json TaskTimes(const Scenario& scenario) {
  ordered_json rows = ordered_json::array();
  for (const Task& task : scenario.tasks) rows.push_back(TaskTime(task));
  return rows;
}

/// Of each class how many agents at the list's end are never online: orders may fill their places.
ordered_json VacantAgents(const Scenario& scenario) {
  ordered_json counts = ordered_json::array();
  for (const AgentKind kind : kAgentKinds) {
    const auto& agents = scenario.agents(kind);
    std::size_t n = 0;
    while (n < agents.size()) {
      const AgentSpec& agent = agents[agents.size() - 1 - n];
      if (agent.online_until_us > agent.online_from_us) break;
      ++n;
    }
    counts.push_back(n);
  }
  return counts;
}

/// Whether the page shows them alike.
bool SameTask(const Task& a, const Task& b) {
  const auto of = [](const Task& task) {
    return std::tie(task.at.x_m, task.at.y_m, task.cost_m, task.reported_us, task.due_us,
                    task.expires_us, task.priority, task.name);
  };
  return of(a) == of(b);
}

bool SameAgent(const AgentSpec& a, const AgentSpec& b) {
  const auto of = [](const AgentSpec& agent) {
    return std::tie(agent.online_from_us, agent.online_until_us, agent.range_full_m);
  };
  return of(a) == of(b);
}

/// What orders have made of the scenario since the cursor was here. They fill places of its lists,
/// whose lengths stay.
void WriteChanges(const Timeline& timeline, PageCursor* cursor, ordered_json* chunk) {
  const Scenario& scenario = timeline.scenario();
  if (!scenario.IsOpen()) return;
  ordered_json task_rows = ordered_json::array(), agent_rows = ordered_json::array();
  auto& tasks = cursor->told_tasks;
  for (std::size_t x = 0; x < tasks.size() && x < scenario.tasks.size(); ++x) {
    const Task& task = scenario.tasks[x];
    if (SameTask(tasks[x], task)) continue;
    ordered_json row = {x, Whole(task.at.x_m), Whole(task.at.y_m), Whole(task.cost_m)};
    for (ordered_json& value : TaskTime(task)) row.push_back(std::move(value));
    task_rows.push_back(std::move(row));
  }
  for (const AgentKind kind : kAgentKinds) {
    const auto& agents = scenario.agents(kind);
    const auto& told = cursor->told_agents[kind];
    for (std::size_t id = 0; id < told.size() && id < agents.size(); ++id) {
      if (SameAgent(told[id], agents[id])) continue;
      agent_rows.push_back({timeline.IndexOf(kind, id), Whole(agents[id].range_full_m)});
    }
  }
  if (tasks.empty() || !task_rows.empty()) tasks = scenario.tasks;
  for (const AgentKind kind : kAgentKinds) {
    if (cursor->told_agents[kind].empty() || !agent_rows.empty()) {
      cursor->told_agents[kind] = scenario.agents(kind);
    }
  }
  if (!task_rows.empty()) (*chunk)["task_rows"] = std::move(task_rows);
  if (!agent_rows.empty()) (*chunk)["agent_rows"] = std::move(agent_rows);
}

/// What kinds there are, {name, for workers, for vehicles}, and each road: [kind, x, y, x, y, ...].
ordered_json RoadLines(const ScenarioRoads& roads) {
  const Roads& network = *roads.network;
  ordered_json classes = ordered_json::array(), lines = ordered_json::array();
  for (const RoadClass& one : network.classes) {
    classes.push_back({one.name, one.percent.workers, one.percent.vehicles});
  }
  for (const Road& road : network.roads) {
    ordered_json line = {road.road_class};
    for (const std::int32_t point : road.points) {
      const RoadPoint& at = network.points[static_cast<std::size_t>(point)];
      line.insert(line.end(), {Whole(at.x_mm / 1000.0), Whole(at.y_mm / 1000.0)});
    }
    lines.push_back(std::move(line));
  }
  return {{"source", network.source}, {"classes", std::move(classes)}, {"lines", std::move(lines)}};
}

/// Outline and holes of a zone: [x, y, x, y, ...] each.
ordered_json RingsOf(const Zone& zone) {
  ordered_json rings = ordered_json::array();
  for (const std::vector<Point>& ring : zone.rings) {
    ordered_json places = ordered_json::array();
    for (const Point at : ring) places.insert(places.end(), {Whole(at.x_m), Whole(at.y_m)});
    rings.push_back(std::move(places));
  }
  return rings;
}

/// Of each zone that UAVs fly below: its name, where it begins, until when it holds, its rings.
ordered_json HighZoneRows(const ScenarioAir& air) {
  ordered_json rows = ordered_json::array();
  for (const PlannedZone& planned : air.zones) {
    if (!IsHigh(planned, air)) continue;
    const bool ends = planned.until_us != kNever;
    rows.push_back({planned.zone.name, planned.lower_m,
                    ends ? ordered_json(Ms(planned.until_us)) : ordered_json(),
                    RingsOf(planned.zone)});
  }
  return rows;
}

/// Each change of roads and zones: from when, and what is closed then, {order, name, since, roads}
/// each, and of a zone its rings.
ordered_json RoadChanges(const Scenario& scenario) {
  ordered_json changes = ordered_json::array();
  for (std::size_t i = 1; i < scenario.changed_ways.size(); ++i) {
    const Scenario::WaysSince& change = scenario.changed_ways[i];
    ordered_json closures = ordered_json::array();
    for (const Closure& closure : change.closures) {
      closures.push_back({closure.order, closure.name, Ms(closure.since_us), closure.roads});
      if (closure.zone) closures.back().push_back(RingsOf(*closure.zone));
    }
    changes.push_back({Ms(change.at_us), std::move(closures)});
  }
  return changes;
}

ordered_json Places(const Scenario& scenario) {
  ordered_json tasks = ordered_json::array();
  for (const Task& task : scenario.tasks) {
    tasks.insert(tasks.end(), {Whole(task.at.x_m), Whole(task.at.y_m), Whole(task.cost_m)});
  }
  ordered_json charging = ordered_json::array();
  for (const ChargingPoint& point : scenario.charging_points) {
    charging.insert(charging.end(),
                    {Whole(point.at.x_m), Whole(point.at.y_m),
                     point.capacity ? ordered_json(*point.capacity) : ordered_json()});
  }
  ordered_json range = ordered_json::array();
  for (const AgentSpec& uav : scenario.uavs) range.push_back(Whole(uav.range_full_m));
  ordered_json place = {{"name", scenario.name},
                        {"seed", scenario.seed},
                        {"width_m", Whole(scenario.width_m)},
                        {"height_m", Whole(scenario.height_m)},
                        {"interval_ms", Ms(scenario.rules.interval_us)},
                        {"limit_ms", Ms(scenario.rules.limit_us)},
                        {"tick_ms", Ms(scenario.rules.tick_us)},
                        {"uavs", scenario.uavs.size()},
                        {"workers", scenario.workers.size()},
                        {"vehicles", scenario.vehicles.size()},
                        {"tasks", std::move(tasks)},
                        {"charging_points", std::move(charging)},
                        {"range_full_m", std::move(range)}};
  if (scenario.roads) place["roads"] = RoadLines(*scenario.roads);
  if (scenario.air) {
    place["air"] = {{"margin_m", scenario.air->margin_m},
                    {"high_zones", HighZoneRows(*scenario.air)}};
  }
  if (const Separation* minima = scenario.separation()) {
    place["air"]["separation"] = {{"horizontal_m", minima->horizontal_m},
                                  {"vertical_m", minima->vertical_m}};
    auto& measured = place["air"]["measured"] = nlohmann::ordered_json::array();
    for (std::size_t id = 0; id < scenario.uavs.size(); ++id) {
      if (scenario.uavs[id].measured) measured.push_back(id);
    }
  }
  if (scenario.IsOpen()) place["vacant"] = VacantAgents(scenario);
  if (scenario.IsOpen()) place["task_times"] = TaskTimes(scenario);
  if (scenario.origin) {
    place["origin"] = {scenario.origin->latitude_deg, scenario.origin->longitude_deg};
  }
  if (scenario.start) {
    place["start"] = {Ms(scenario.start->unix_us), scenario.start->offset_min};
  }
  return place;
}

/// The names of the numbers that the page's rows hold.
ordered_json Words() {
  ordered_json statuses = ordered_json::array();
  for (const std::string_view name : kNames<AgentStatus>) statuses.push_back(Spaced(name));
  return {{"agents", kNames<AgentKind>},        {"statuses", std::move(statuses)},
          {"tasks", kNames<TaskStatus>},        {"actions", kNames<ActionKind>},
          {"activities", kNames<ActivityKind>}, {"processes", kNames<ProcessState>}};
}

ordered_json Numbers(const RunRecord& record) {
  ordered_json report = Report(record);
  for (const char* list : {"tasks", "uavs", "decisions"}) report.erase(list);
  return report;
}

/// [[index, from, [numbers]], ...] of all items that changed.
template <class Items, class Get, class Write>
void FlatOfEach(const char* key, const Items& items, std::vector<PageCursor::Place>* places,
                ordered_json* chunk, Get get, Write write) {
  ordered_json all = ordered_json::array();
  places->resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    ordered_json list = ordered_json::array();
    const std::int64_t from = Fresh(get(items[i]), &(*places)[i], &list, write);
    if (from >= 0) all.push_back({i, from, std::move(list)});
  }
  if (!all.empty()) (*chunk)[key] = std::move(all);
}

void WriteProcesses(const Timeline& timeline, PageCursor* cursor, ordered_json* chunk) {
  ordered_json processes = ordered_json::array();
  for (const auto& [process, samples] : timeline.processes()) {
    ordered_json list = ordered_json::array();
    const std::int64_t from =
        Fresh(samples, &cursor->processes[process], &list,
              [](const Timeline::ProcessSample& s, ordered_json* rows) {
                rows->insert(rows->end(), {s.t_ms, Ms(s.wall_us), s.boot_id, s.received, s.lost,
                                           s.rejected, s.resent, s.cpu_s, s.rss_bytes, s.state});
              });
    if (from >= 0) processes.push_back({process, from, std::move(list)});
  }
  if (!processes.empty()) (*chunk)["processes"] = std::move(processes);
}

void WriteFaultsAndRoads(const Timeline& timeline, PageCursor* cursor, ordered_json* chunk) {
  if (cursor->faults != timeline.faults().size()) {
    ordered_json faults = ordered_json::array();
    for (const auto& [id, f] : timeline.faults()) {
      faults.push_back({id, ToString<FaultKind>(f.kind), f.target, Ms(f.at_us), Ms(f.for_us),
                        Number(f.probability)});
    }
    (*chunk)["faults"] = std::move(faults);
    cursor->faults = timeline.faults().size();
  }
  const std::size_t n_road_changes = timeline.scenario().changed_ways.size();
  if (cursor->road_changes != n_road_changes) {
    (*chunk)["road_changes"] = RoadChanges(timeline.scenario());
    cursor->road_changes = n_road_changes;
  }
}

}  // namespace

ordered_json PageChunk(const MissionFeed& feed, const std::string& name, PageCursor* cursor,
                       bool with_report) {
  const Timeline& timeline = feed.timeline();
  ordered_json chunk = ordered_json::object();
  if (!cursor->begun) {
    chunk["version"] = 1;
    chunk["name"] = name;
    chunk["words"] = Words();
    chunk["scenario"] = Places(timeline.scenario());
    cursor->begun = true;
  }
  WriteChanges(timeline, cursor, &chunk);
  chunk["now_ms"] = timeline.now_ms();
  chunk["epoch_ms"] = Ms(feed.epoch_us());
  chunk["ended"] = timeline.ended();
  if (with_report) chunk["report"] = Numbers(feed.record());

  FlatOfEach(
      "stops", timeline.agents(), &cursor->stops, &chunk,
      [](const Timeline::Agent& agent) -> const auto& { return agent.stops; },
      [](const Timeline::Stop& s, ordered_json* list) {
        list->insert(list->end(), {s.t_ms, Whole(s.x_m), Whole(s.y_m), Whole(s.range_m)});
      });
  FlatOfEach(
      "spans", timeline.agents(), &cursor->spans, &chunk,
      [](const Timeline::Agent& agent) -> const auto& { return agent.spans; },
      [](const Timeline::Span& s, ordered_json* list) {
        list->insert(list->end(), {s.t_ms, s.status});
      });
  FlatOfEach(
      "tasks", timeline.tasks(), &cursor->tasks, &chunk,
      [](const Growing<Timeline::TaskChange>& task) -> const auto& { return task; },
      [](const Timeline::TaskChange& c, ordered_json* list) {
        list->insert(list->end(), {c.t_ms, c.status});
      });
  Flat("done", timeline.done(), &cursor->done, &chunk,
       [](const Timeline::Done& d, ordered_json* list) {
         list->insert(list->end(), {d.t_ms, d.tasks});
       });
  Flat("decisions", timeline.schedules(), &cursor->schedules, &chunk,
       [&](const schedule_t& s, ordered_json* list) {
         // The record knows which schedule holds when there are several, and which decisions never
         // were in force.
         const auto held = feed.record().schedules().find(s.decision);
         if (held != feed.record().schedules().end()) WriteSchedule(held->second, list);
       });
  Flat("activities", timeline.activities(), &cursor->activities, &chunk,
       [](const activity_t& a, ordered_json* list) {
         list->insert(list->end(),
                      {a.kind, a.uav_id, a.partner_id, a.site_id, Ms(a.start_us), Ms(a.end_us)});
       });
  Flat("events", timeline.events(), &cursor->events, &chunk,
       [](const event_t& e, ordered_json* list) {
         list->push_back({ToString<EventKind>(e.kind), Ms(e.at_us), e.uav_id, e.worker_id,
                          e.vehicle_id, e.task_id, e.charge_id, e.fault_id, e.detail});
       });
  Flat("altitudes", timeline.heights(), &cursor->heights, &chunk,
       [](const Timeline::Height& h, ordered_json* list) {
         ordered_json row = {h.uav};
         for (const auto& [t_ms, up_m] : h.knots) {
           row.insert(row.end(), {t_ms, std::round(up_m * 10) / 10});
         }
         list->push_back(std::move(row));
       });
  WriteProcesses(timeline, cursor, &chunk);
  WriteFaultsAndRoads(timeline, cursor, &chunk);
  const OrderBook& orders = feed.record().reader().orders();
  if (cursor->orders != orders.size()) {
    cursor->orders = orders.size();
    ordered_json rows = DirectiveRows(orders);
    if (!rows.empty()) chunk["directives"] = std::move(rows);
  }
  return chunk;
}

}  // namespace muster::tools
