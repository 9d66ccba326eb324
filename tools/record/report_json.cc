#include "tools/record/report_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <vector>

#include "base/check.h"
#include "protocol/fault_switch.h"
#include "tools/log/air_record.h"
#include "tools/record/digest.h"
#include "tools/record/service.h"

namespace muster::tools {
namespace {

using nlohmann::ordered_json;

/// JSON has neither NaN nor infinity.
ordered_json Number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json();
}

ordered_json Decisions(const RunRecord& record) {
  ordered_json list = ordered_json::array();
  const Rules& rules = record.scenario()->rules;
  for (const auto& [index, schedule] : record.schedules()) {
    ordered_json actions = ordered_json::array();
    for (const action_t& a : schedule.actions) {
      actions.push_back({{"kind", a.kind},
                         {"uav", a.uav_id},
                         {"worker", a.worker_id},
                         {"vehicle", a.vehicle_id},
                         {"task", a.task_id},
                         {"charge", a.charge_id},
                         {"x_m", Number(a.x_m)},
                         {"y_m", Number(a.y_m)},
                         {"weight", Number(a.weight)}});
    }
    list.push_back({{"index", index},
                    {"sim_s", ToSeconds(rules.TimeOfDecision(index))},
                    {"policy", schedule.policy},
                    {"weight", Number(schedule.weight)},
                    {"bound", Number(schedule.bound)},
                    {"candidates", schedule.candidates},
                    {"solve_s", ToSeconds(schedule.solve_us)},
                    {"actions", std::move(actions)}});
  }
  return list;
}

ordered_json FailedAgents(const RunRecord& record) {
  ordered_json list = ordered_json::array();
  for (const event_t& event : record.events()) {
    if (event.kind != EventKind::kAgentFailed) continue;
    const auto [kind, id] = event.uav_id >= 0 ? std::pair(AgentKind::kUav, event.uav_id)
                            : event.worker_id >= 0
                                ? std::pair(AgentKind::kWorker, event.worker_id)
                                : std::pair(AgentKind::kVehicle, event.vehicle_id);
    list.push_back({{"agent", fmt::format("{}:{}", ToString(kind), id)},
                    {"at_s", ToSeconds(event.at_us)},
                    {"why", event.detail}});
  }
  return list;
}

/// What outside schedulers said and nobody obeyed.
ordered_json RefusedAnswers(const RunRecord& record) {
  ordered_json list = ordered_json::array();
  for (const event_t& event : record.events()) {
    if (event.kind != EventKind::kAnswerRefused) continue;
    list.push_back({{"sim_s", ToSeconds(event.at_us)}, {"why", event.detail}});
  }
  return list;
}

ordered_json SeparationOf(const RunRecord& record) {
  const Scenario& scenario = *record.scenario();
  const Separation& minima = *scenario.separation();
  const AirSummary air = SummaryOf(record.air(), scenario, record.skipped_decisions());
  ordered_json closest;
  if (air.closest) {
    closest = {{"horizontal_m", air.closest->approach.horizontal_m},
               {"vertical_m", air.closest->approach.vertical_m},
               {"decision", air.closest->decision},
               {"at_s", ToSeconds(air.closest->at_us)},
               {"uavs", {air.closest->uavs.first, air.closest->uavs.second}}};
  }
  return {{"horizontal_m", minima.horizontal_m}, {"vertical_m", minima.vertical_m},
          {"altitudes_m", air.altitudes_m},      {"held", air.held},
          {"held_s", ToSeconds(air.held_us)},    {"conflicts", air.conflicts},
          {"closest", std::move(closest)}};
}

ordered_json Tasks(const RunRecord& record) {
  const std::size_t n_tasks = record.scenario()->tasks.size();
  std::vector<const event_t*> done(n_tasks, nullptr);
  for (const event_t& event : record.events()) {
    const auto task = static_cast<std::size_t>(event.task_id);
    if (event.kind == EventKind::kSensingDone && event.task_id >= 0 && task < n_tasks &&
        !done[task]) {
      done[task] = &event;
    }
  }
  ordered_json list = ordered_json::array();
  for (std::size_t task = 0; task < n_tasks; ++task) {
    const int status = record.final_world() ? record.final_world()->task_status[task] : -1;
    ordered_json row = {{"id", task}, {"status", ToString<TaskStatus>(status)}};
    if (const event_t* event = done[task]) {
      row["done_s"] = ToSeconds(event->at_us);
      row["uav"] = event->uav_id;
      row["worker"] = event->worker_id;
    }
    list.push_back(std::move(row));
  }
  return list;
}

ordered_json Faults(const RunRecord& record) {
  ordered_json list = ordered_json::array();
  for (const auto& [id, fault] : record.faults()) {
    ordered_json row = {
        {"id", id},
        {"kind", ToString<FaultKind>(fault.kind)},
        {"target", fault.target},
        {"at_s", ToSeconds(fault.at_us)},
        {"for_s", fault.for_us == kNever ? ordered_json() : ordered_json(ToSeconds(fault.for_us))},
        {"probability", Number(fault.probability)},
        {"applied_s", nullptr},
        {"ended_s", nullptr},
        {"packets", nullptr}};
    for (const event_t& event : record.events()) {
      if (event.fault_id != id) continue;
      const bool ends = event.kind == EventKind::kFaultEnded;
      if (event.kind == EventKind::kFaultApplied && row["applied_s"].is_null()) {
        row["applied_s"] = ToSeconds(event.at_us);
      }
      if (ends) row["ended_s"] = ToSeconds(event.at_us);
      if (const auto hits = ends ? HitsOf(event.detail) : std::nullopt) {
        row["packets"] =
            (row["packets"].is_null() ? 0 : row["packets"].get<std::int64_t>()) + *hits;
      }
    }
    list.push_back(std::move(row));
  }
  return list;
}

ordered_json Processes(const RunRecord& record) {
  ordered_json list = ordered_json::array();
  // Counters count from each start: a process's are the sums over its starts.
  for (auto it = record.processes().begin(); it != record.processes().end();) {
    const std::string& name = it->first.first;
    std::int64_t received = 0, lost = 0, rejected = 0, resent = 0, rss = 0;
    double cpu_s = 0;
    const process_status_t* newest = nullptr;
    int starts = 0;
    for (; it != record.processes().end() && it->first.first == name; ++it) {
      const process_status_t& status = it->second;
      received += status.received;
      lost += status.lost;
      rejected += status.rejected;
      resent += status.resent;
      cpu_s += status.cpu_s;
      rss = std::max(rss, status.rss_bytes);
      newest = &status;
      ++starts;
    }
    list.push_back({{"name", newest->name},
                    {"host", newest->host},
                    {"received", received},
                    {"lost", lost},
                    {"rejected", rejected},
                    {"resent", resent},
                    {"restarts", starts - 1},
                    {"ended", newest->state == ProcessState::kEnded},
                    {"cpu_s", Number(cpu_s)},
                    {"rss_bytes", rss}});
  }
  return list;
}

ordered_json Log(const RunRecord& record) {
  const RunRecord::Completeness completeness = record.CheckComplete();
  const auto list = [](const std::vector<RunRecord::Gap>& gaps) {
    ordered_json rows = ordered_json::array();
    for (const RunRecord::Gap& gap : gaps) {
      rows.push_back({{"sender", gap.sender},
                      {"boot_id", gap.boot_id},
                      {"first_seq", gap.first_seq},
                      {"last_seq", gap.last_seq}});
    }
    return rows;
  };
  ordered_json missing = ordered_json::array();
  for (const RunRecord::Missing& m : completeness.missing) {
    missing.push_back({{"owner", m.owner}, {"first", m.first_tick}, {"last", m.last_tick}});
  }
  return {{"complete", completeness.complete},
          {"messages", record.counts().messages},
          {"duplicates", record.counts().duplicates},
          {"strangers", record.counts().strangers},
          {"undecodable", record.counts().undecodable},
          {"foreign", record.counts().foreign},
          {"gaps", list(completeness.gaps)},
          {"lost_tails", list(completeness.lost_tails)},
          {"n_missing", completeness.n_missing},
          {"missing", std::move(missing)},
          {"repeated", completeness.repeated},
          {"damage", completeness.damage},
          {"torn_tails", completeness.torn_tails}};
}

std::string PolicyOf(const RunRecord& record) {
  std::set<std::string> names;
  for (const auto& [index, schedule] : record.schedules()) names.insert(schedule.policy);
  return fmt::format("{}", fmt::join(names, "+"));
}

}  // namespace

DecisionTime DecisionTimeOf(const RunRecord& record) {
  std::vector<std::int64_t> us;
  for (const auto& [index, schedule] : record.schedules()) us.push_back(schedule.solve_us);
  if (us.empty()) return {};
  std::sort(us.begin(), us.end());
  const std::size_t half = us.size() / 2;
  const double median = us.size() % 2 == 1 ? ToSeconds(us[half])
                                           : (ToSeconds(us[half - 1]) + ToSeconds(us[half])) / 2;
  return {median, ToSeconds(us.back())};
}

nlohmann::ordered_json Report(const RunRecord& record) {
  ordered_json report = {{"version", kReportVersion}, {"run_id", record.run_id()}};
  if (!record.scenario()) {
    report["log"] = Log(record);
    return report;
  }
  const Scenario& scenario = *record.scenario();
  const Rules& rules = scenario.rules;
  report["policy"] = PolicyOf(record);
  report["seed"] = scenario.seed;
  report["scenario"] = {
      {"name", scenario.name},
      {"sha256", record.scenario_sha256()},
      {"interval_s", ToSeconds(rules.interval_us)},
      {"limit_s", ToSeconds(rules.limit_us)},
      {"tick_s", ToSeconds(rules.tick_us)},
      {"availability", rules.availability == Availability::kStrict ? "strict" : "overrun"},
      {"uavs", scenario.n_agents(AgentKind::kUav)},
      {"workers", scenario.n_agents(AgentKind::kWorker)},
      {"vehicles", scenario.n_agents(AgentKind::kVehicle)},
      {"charging_points", scenario.charging_points.size()}};
  if (scenario.start) report["scenario"]["start"] = scenario.start->text;

  const std::size_t total = scenario.n_tasks();
  std::size_t done = 0;
  if (record.final_world()) {
    const auto& status = record.final_world()->task_status;
    done = static_cast<std::size_t>(std::count(status.begin(), status.end(), TaskStatus::kDone));
  }
  std::array<std::int64_t, kNames<EventKind>.size()> counts{};
  for (const event_t& event : record.events()) ++counts[static_cast<std::uint8_t>(event.kind)];
  ordered_json events = ordered_json::object();
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    if (counts[kind] == 0 && IsSpecial(static_cast<EventKind>(kind))) continue;
    events[std::string(kNames<EventKind>[kind])] = counts[kind];
  }

  ordered_json uavs = ordered_json::array();
  double flown_m = 0;
  for (std::size_t id = 0; id < record.tracks().size(); ++id) {
    const Track& track = record.tracks()[id];
    flown_m += track.length_m();
    uavs.push_back({{"id", id},
                    {"flown_m", Number(track.length_m())},
                    {"range_left_m", Number(track.final_range_m())}});
  }
  const DecisionTime time = DecisionTimeOf(record);

  report["tasks_total"] = total;
  report["tasks_done"] = done;
  report["completion_rate"] =
      total == 0 ? 0.0 : static_cast<double>(done) / static_cast<double>(total);
  if (scenario.IsOpen()) report["service"] = ToJson(ServiceOf(record, scenario));
  report["charges"] = counts[NumberOf(EventKind::kChargingDone)];
  report["flown_m"] = Number(flown_m);
  report["wall_s"] = record.wall_s();
  report["decision_time"] = {{"median_s", time.median_s}, {"max_s", time.max_s}};
  report["events"] = std::move(events);
  report["tasks"] = Tasks(record);
  report["uavs"] = std::move(uavs);
  if (const auto legs = record.measured_legs(); !legs.empty())
    report["measured_agents"] = ToJson(legs);
  report["decisions"] = Decisions(record);
  if (scenario.separation() != nullptr) report["separation"] = SeparationOf(record);
  report["skipped_decisions"] = record.skipped_decisions();
  report["failed_agents"] = FailedAgents(record);
  report["refused_answers"] = RefusedAnswers(record);
  report["faults"] = Faults(record);
  report["processes"] = Processes(record);
  report["log"] = Log(record);
  report["digest"] = Digest(record);
  return report;
}

}  // namespace muster::tools
