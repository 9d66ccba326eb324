#include <fmt/format.h>

#include <map>
#include <type_traits>

#include "model/agent.h"
#include "tools/files/new_folder.h"
#include "tools/log/closed_roads.h"
#include "tools/log/export.h"
#include "tools/log/legs.h"
#include "tools/log/mission_stream.h"

namespace muster::tools {
namespace {

/// RFC 4180: quoted where it must be.
std::string Quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

/// "1200,800 1200,900" without the comma: "x y;x y".
std::string LineText(const std::vector<Point>& line) {
  std::string text;
  for (const Point& p : line) text += fmt::format("{}{} {}", text.empty() ? "" : ";", p.x_m, p.y_m);
  return text;
}

std::string WayRow(const Leg& leg) {
  const AgentState& a = leg.agent;
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\r\n", ToString<AgentKind>(a.kind), a.id,
                     a.decision, static_cast<int>(a.action), a.target, ToSeconds(a.depart_us),
                     ToSeconds(a.arrive_us), ToSeconds(leg.until_us), Distance(a.from, a.to),
                     a.leg_ways->Length(a.kind, a.from, a.to),
                     a.leg_ways->GroundLength(a.kind, a.from, a.to), LineText(leg.Line()));
}

std::string ClosedRow(const ClosedRoad& closed, const Roads& roads) {
  const Road& road = roads.roads[static_cast<std::size_t>(closed.road)];
  const std::string until =
      closed.until_us == kNever ? "" : fmt::to_string(ToSeconds(closed.until_us));
  return fmt::format("{},{},{},{},{},{}\r\n", closed.road, road.id, ToSeconds(closed.from_us),
                     until, Quoted(closed.order), Quoted(closed.name));
}

}  // namespace

void ExportCsv(LogSource* source, const std::string& out) {
  const MissionHead head = ReadMissionHead(source);
  NewFolder folder(out);
  auto& agents = folder.Add("agents.csv");
  auto& decisions = folder.Add("decisions.csv");
  auto& actions = folder.Add("actions.csv");
  auto& events = folder.Add("events.csv");
  auto& tasks = folder.Add("tasks.csv");
  auto& processes = folder.Add("processes.csv");
  auto& ways = folder.Add("ways.csv");
  agents.Write(
      "tick,sim_s,class,id,x_m,y_m,range_left_m,status,action,target,partner,decision\r\n");
  decisions.Write("decision,tick,sim_s,policy,weight,bound,candidates,solve_s,actions\r\n");
  actions.Write("decision,kind,symbol,uav,worker,vehicle,task,charge,x_m,y_m,weight\r\n");
  events.Write("sim_s,kind,uav,worker,vehicle,task,charge,fault,detail\r\n");
  tasks.Write("tick,sim_s,task,status\r\n");
  processes.Write(
      "sim_s,wall_us,name,start,state,received,lost,rejected,resent,cpu_s,rss_bytes\r\n");
  ways.Write(
      "class,id,decision,action,target,depart_s,arrive_s,until_s,straight_m,way_m,ground_m,"
      "line\r\n");
  LegReader legs;
  const auto write_way = [&](const Leg& leg) { ways.Write(WayRow(leg)); };
  TimeUs now_us = 0;
  std::vector<std::int8_t> status(head.scenario.tasks.size(), -1);
  const auto scenario_at_end = ForEachMessage(
      source, head.run_id, [&](const Message& message, const Packet&, const Scenario& scenario) {
        if (const auto* m = std::get_if<agent_states_t>(&message)) {
          now_us = std::max(now_us, m->header.sim_us);
          legs.Add(*m, scenario, write_way);
          const auto n =
              static_cast<std::int32_t>(scenario.n_agents(static_cast<AgentKind>(m->kind)));
          for (const agent_t& a : m->agents) {
            if (a.id >= n) continue;  // room for one who has not joined
            agents.Write(fmt::format(
                "{},{},{},{},{},{},{},{},{},{},{},{}\r\n", m->tick, ToSeconds(m->header.sim_us),
                ToString<AgentKind>(m->kind), a.id, a.x_m, a.y_m, a.range_left_m,
                ToString<AgentStatus>(a.status), a.action, a.target_id, a.partner_id, a.decision));
          }
        } else if (const auto* s = std::get_if<schedule_t>(&message)) {
          decisions.Write(fmt::format("{},{},{},{},{},{},{},{},{}\r\n", s->decision, s->tick,
                                      ToSeconds(s->header.sim_us), Quoted(s->policy), s->weight,
                                      s->bound == s->bound ? fmt::format("{}", s->bound) : "",
                                      s->candidates, ToSeconds(s->solve_us), s->actions.size()));
          for (const action_t& a : s->actions) {
            actions.Write(fmt::format("{},{},{},{},{},{},{},{},{},{},{}\r\n", s->decision, a.kind,
                                      ToString<ActionKind>(a.kind), a.uav_id, a.worker_id,
                                      a.vehicle_id, a.task_id, a.charge_id, a.x_m, a.y_m,
                                      a.weight));
          }
        } else if (const auto* e = std::get_if<event_t>(&message)) {
          events.Write(fmt::format("{},{},{},{},{},{},{},{},{}\r\n", ToSeconds(e->at_us),
                                   ToString<EventKind>(e->kind), e->uav_id, e->worker_id,
                                   e->vehicle_id, e->task_id, e->charge_id, Quoted(e->fault_id),
                                   Quoted(e->detail)));
        } else if (const auto* w = std::get_if<world_state_t>(&message)) {
          // Behind them is room for tasks that no order has added.
          for (std::size_t x = 0; x < scenario.n_tasks() && x < w->task_status.size(); ++x) {
            if (status[x] == w->task_status[x]) continue;
            status[x] = w->task_status[x];
            tasks.Write(fmt::format("{},{},{},{}\r\n", w->tick, ToSeconds(w->header.sim_us), x,
                                    ToString<TaskStatus>(status[x])));
          }
        } else if (const auto* p = std::get_if<process_status_t>(&message)) {
          processes.Write(fmt::format("{},{},{},{},{},{},{},{},{},{},{}\r\n",
                                      ToSeconds(p->header.sim_us), p->header.wall_us,
                                      Quoted(p->name), p->header.boot_id, p->state, p->received,
                                      p->lost, p->rejected, p->resent, p->cpu_s, p->rss_bytes));
        }
      });
  legs.Finish(now_us, write_way);
  if (scenario_at_end && scenario_at_end->roads) {
    auto& closed_roads = folder.Add("closed_roads.csv");
    closed_roads.Write("road,map_id,from_s,until_s,order,name\r\n");
    for (const ClosedRoad& closed : ClosedRoadsOf(*scenario_at_end)) {
      closed_roads.Write(ClosedRow(closed, *scenario_at_end->roads->network));
    }
  }
  folder.Commit();
}

}  // namespace muster::tools
