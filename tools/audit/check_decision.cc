// A decision against the situation in which it was made.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/audit/checks.h"

namespace muster::tools::audit {
namespace {

/// What is wrong with the ids of an action; "": nothing.
std::string WrongIds(const View& view, const action_t& a) {
  // Of each kind of action up to charging: UAV, worker, vehicle, task, charging point.
  constexpr std::string_view kIds[] = {"u", "w", "v", "ut", "wt", "uc", "vc", "uwt", "uvc"};
  if (!IsWord<ActionKind>(a.kind)) return "no such kind";
  std::string ids;
  const std::tuple<char, int, std::size_t> all[] = {
      {'u', a.uav_id, view.agents[kUav].size()},
      {'w', a.worker_id, view.agents[kWorker].size()},
      {'v', a.vehicle_id, view.agents[kVehicle].size()},
      {'t', a.task_id, view.scenario.tasks.size()},
      {'c', a.charge_id, view.scenario.charges.size()}};
  for (const auto& [letter, id, n] : all) {
    if (id < -1 || id >= static_cast<int>(n)) return "names what the scenario does not have";
    if (id >= 0) ids += letter;
  }
  if (a.kind == ActionKind::kGoTo) {
    return ids == "u" || ids == "w" || ids == "v" ? "" : "names not one agent";
  }
  return ids == kIds[a.kind] ? "" : "has not the ids of its kind";
}

/// A place on a road where its agents can wait: roads lead out of the area, too.
bool IsStop(const AgentModel& agent, Place at) {
  const auto [stop, number] = agent.ways->StopNear(agent.kind, at);
  return number >= 0 && Apart(stop, at) <= kTolerance_m;
}

void CheckAction(View& view, const action_t& a, const std::string& name) {
  std::vector<AgentModel*> members;
  if (a.uav_id >= 0) members.push_back(&view.Model(kUav, a.uav_id));
  if (a.worker_id >= 0) members.push_back(&view.Model(kWorker, a.worker_id));
  if (a.vehicle_id >= 0) members.push_back(&view.Model(kVehicle, a.vehicle_id));
  const Place to{a.x_m, a.y_m};
  const Scenario::Task* task = a.task_id >= 0 ? &view.TaskOf(a.task_id) : nullptr;
  const Place expected = task != nullptr ? task->at
                         : a.charge_id >= 0
                             ? view.scenario.charges[static_cast<std::size_t>(a.charge_id)].at
                         : a.kind == ActionKind::kGoTo ? to
                                                       : members[0]->to;
  const bool outside =
      a.kind == ActionKind::kGoTo && !view.IsInside(to) && !IsStop(*members[0], to);
  if (Apart(to, expected) > kTolerance_m || outside) {
    view.Violate("decision", "{}: leads to ({:.3f}, {:.3f}) m, expected {}", name, a.x_m, a.y_m,
                 outside ? "a place inside the area"
                         : fmt::format("({:.3f}, {:.3f}) m", expected.x_m, expected.y_m));
  }
  if (a.kind <= NumberOf(ActionKind::kVehicleStays)) {
    for (AgentModel* member : members) member->decision = view.schedule->decision;
    return;
  }
  std::int64_t end = view.now_us;
  std::int64_t latest = kForever;
  for (const AgentModel* member : members) {
    end = std::max(end,
                   view.now_us + DurationUs(member->WayM(member->to, to), member->spec->speed_m_s));
    latest = std::min(latest, view.LatestEnd(*member));
  }
  if (task != nullptr && end >= task->expires_us) {
    view.Violate("expiry", "{}: there at {} us, the task expires at {} us", name, end,
                 task->expires_us);
  }
  if (a.uav_id >= 0) {
    const AgentModel& uav = *members[0];
    const double range = uav.RangeAt(view.now_us);
    const double way = uav.WayM(uav.to, to);
    if (task != nullptr && way + task->cost_m + task->to_charge_m > range + kTolerance_m) {
      view.Violate("constraint-6",
                   "{}: {:.3f} m of way, {:.3f} m to sense, {:.3f} m to the nearest charging "
                   "point, {:.3f} m of range",
                   name, way, task->cost_m, task->to_charge_m, range);
    }
    if (task == nullptr && way > range + kTolerance_m) {
      view.Violate("constraint-5", "{}: {:.3f} m of way, {:.3f} m of range", name, way, range);
    }
    if (a.kind == ActionKind::kSense) end += DurationUs(task->cost_m, uav.spec->speed_m_s);
    if (a.kind == ActionKind::kCharge) {
      const double missing = uav.spec->range_full_m - std::max(0.0, range - way);
      end += DurationUs(missing, members[1]->spec->charge_rate_m_s);
    }
  }
  if (latest != kForever && end > latest + kToleranceUs) {
    view.Violate("availability", "{}: ends at {} us, its agents must be free at {} us", name, end,
                 latest);
  }
  for (const AgentModel* member : members) {
    view.commands[{member->kind, member->id}] = {a, view.schedule->decision, view.now_us};
  }
}

}  // namespace

void AllowOwnActions(View& view) {
  constexpr double kReserveShare = 0.5;
  if (view.scenario.separation) return;
  for (const AgentModel& uav : view.agents[kUav]) {
    if (uav.StatusAt(view.now_us) != AgentStatus::kIdle) continue;
    const double range_m = uav.RangeAt(view.now_us);
    if (range_m >= kReserveShare * uav.spec->range_full_m + kTolerance_m) continue;
    action_t action{};
    action.kind = NumberOf(ActionKind::kUavToCharge);
    action.uav_id = uav.id;
    action.worker_id = action.vehicle_id = action.task_id = action.charge_id = -1;
    double nearest_m = range_m + kTolerance_m;
    for (std::size_t y = 0; y < view.scenario.charges.size(); ++y) {
      const Place at = view.scenario.charges[y].at;
      const double way_m = uav.WayM(uav.to, at);
      if (way_m >= nearest_m) continue;
      nearest_m = way_m;
      action.charge_id = static_cast<std::int32_t>(y);
      action.x_m = at.x_m;
      action.y_m = at.y_m;
    }
    if (action.charge_id < 0) continue;
    const std::int64_t latest = view.LatestEnd(uav);
    const std::int64_t end = view.now_us + DurationUs(nearest_m, uav.spec->speed_m_s);
    if (latest != kForever && end > latest + kToleranceUs) continue;
    view.commands[{kUav, uav.id}] = {action, view.due, view.now_us, true};
  }
}

void CheckDecision(View& view) {
  const schedule_t& schedule = *view.schedule;
  std::map<AgentKey, std::size_t> used;
  std::map<std::int32_t, std::size_t> tasks;
  std::vector<std::int64_t> load(view.scenario.charges.size(), 0);
  for (const AgentModel& uav : view.agents[kUav]) {
    if (uav.action == ActionKind::kCharge && !uav.failed)
      ++load[static_cast<std::size_t>(uav.target)];
  }
  double weight = 0;
  for (std::size_t i = 0; i < schedule.actions.size(); ++i) {
    const action_t& action = schedule.actions[i];
    const std::string name =
        fmt::format("decision {}, action {} ({})", schedule.decision, i, Name(action));
    weight += action.weight;
    if (const std::string wrong = WrongIds(view, action); !wrong.empty()) {
      view.Violate("decision", "{}: {}", name, wrong);
      continue;
    }
    const int ids[] = {action.uav_id, action.worker_id, action.vehicle_id};
    bool usable = true;
    for (const int kind : kClasses) {
      if (ids[kind] < 0) continue;
      const AgentModel& model = view.Model(kind, ids[kind]);
      const auto [first, is_new] = used.try_emplace({kind, ids[kind]}, i);
      if (!is_new) {
        view.Violate("one-action-per-agent", "{}: {} is in action {} too", name, model.name(),
                     first->second);
      }
      if (model.StatusAt(view.now_us) == AgentStatus::kIdle) continue;
      usable = false;
      view.Violate("idle-agents-only", "{}: {} is {}, busy until {} us, online in [{}, {}) us",
                   name, model.name(), ToString(model.StatusAt(view.now_us)), model.busy_until_us,
                   model.spec->online_from_us, model.spec->online_until_us);
    }
    if (action.task_id >= 0) {
      const auto [first, is_new] = tasks.try_emplace(action.task_id, i);
      if (!is_new) {
        view.Violate("task-open", "{}: the task is in action {} too", name, first->second);
      }
      const std::int8_t status = view.task_status[static_cast<std::size_t>(action.task_id)];
      if (status != TaskStatus::kOpen) {
        view.Violate("task-open", "{}: the task is {}", name, TaskWords(status));
      }
    }
    if (action.charge_id >= 0) {
      const auto site = static_cast<std::size_t>(action.charge_id);
      if (++load[site] > view.scenario.charges[site].capacity) {
        view.Violate("capacity", "{}: {} at or on the way to a charging point of capacity {}", name,
                     load[site], view.scenario.charges[site].capacity);
      }
    }
    if (usable) CheckAction(view, action, name);
  }
  if (!(std::abs(weight - schedule.weight) <= 1e-9 * std::max(1.0, std::abs(weight)))) {
    view.Violate("weight",
                 "decision {} says weight {:.17g}, its actions sum to "
                 "{:.17g}",
                 schedule.decision, schedule.weight, weight);
  }
  if (schedule.bound < weight - 1e-6 * std::max(1.0, std::abs(weight))) {
    view.Violate("weight", "decision {} weighs {:.17g}, more than its bound {:.17g}",
                 schedule.decision, weight, schedule.bound);
  }
}

}  // namespace muster::tools::audit
