// A decision against the situation in which it was made.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/audit/auditor.h"
#include "tools/audit/values.h"

namespace muster::tools::audit {

std::int64_t Auditor::LatestEnd(const AgentModel& model) const {
  return scenario_->strict ? std::min(model.spec->online_until_us, scenario_->limit_us) : kForever;
}

void Auditor::CheckDecision(const schedule_t& schedule) {
  std::map<AgentKey, std::size_t> used;
  std::map<std::int32_t, std::size_t> tasks;
  std::vector<std::int64_t> load(scenario_->charges.size(), 0);
  for (const AgentModel& uav : models_[kUav]) {
    if (uav.action == ActionKind::kCharge && !uav.failed)
      ++load[static_cast<std::size_t>(uav.target)];
  }
  double weight = 0;
  for (std::size_t i = 0; i < schedule.actions.size(); ++i) {
    const action_t& action = schedule.actions[i];
    const std::string name =
        fmt::format("decision {}, action {} ({})", schedule.decision, i, Name(action));
    weight += action.weight;
    if (!CheckShape(action, name)) continue;
    const int ids[] = {action.uav_id, action.worker_id, action.vehicle_id};
    bool usable = true;
    for (const int kind : {kUav, kWorker, kVehicle}) {
      if (ids[kind] < 0) continue;
      const AgentModel& model = Model(kind, ids[kind]);
      const auto [first, is_new] = used.try_emplace({kind, ids[kind]}, i);
      if (!is_new) {
        Violate(now_us_, "one-action-per-agent",
                fmt::format("{}: {} is in action {} too", name, model.name(), first->second));
      }
      if (model.StatusAt(now_us_) == AgentStatus::kIdle) continue;
      usable = false;
      Violate(now_us_, "idle-agents-only",
              fmt::format("{}: {} is {}, busy until {} us, online in [{}, {}) us", name,
                          model.name(), ToString(model.StatusAt(now_us_)), model.busy_until_us,
                          model.spec->online_from_us, model.spec->online_until_us));
    }
    if (action.task_id >= 0) {
      const auto [first, is_new] = tasks.try_emplace(action.task_id, i);
      if (!is_new) {
        Violate(now_us_, "task-open",
                fmt::format("{}: the task is in action {} too", name, first->second));
      }
      const std::int8_t status = task_status_[static_cast<std::size_t>(action.task_id)];
      if (status != TaskStatus::kOpen) {
        Violate(now_us_, "task-open", fmt::format("{}: the task is {}", name, TaskWords(status)));
      }
    }
    if (action.charge_id >= 0) {
      const auto site = static_cast<std::size_t>(action.charge_id);
      if (++load[site] > scenario_->charges[site].capacity) {
        Violate(now_us_, "capacity",
                fmt::format("{}: {} at or on the way to a charging point of capacity {}", name,
                            load[site], scenario_->charges[site].capacity));
      }
    }
    if (usable) CheckAction(action, name);
  }
  if (!(std::abs(weight - schedule.weight) <= 1e-9 * std::max(1.0, std::abs(weight)))) {
    Violate(now_us_, "weight",
            fmt::format("decision {} says weight {:.17g}, its actions sum to "
                        "{:.17g}",
                        schedule.decision, schedule.weight, weight));
  }
  if (schedule.bound < weight - 1e-6 * std::max(1.0, std::abs(weight))) {
    Violate(now_us_, "weight",
            fmt::format("decision {} weighs {:.17g}, more than its bound {:.17g}",
                        schedule.decision, weight, schedule.bound));
  }
}

bool Auditor::CheckShape(const action_t& a, const std::string& name) {
  struct Shape {
    bool uav, worker, vehicle, task, charge;
  };
  constexpr Shape kShapes[] = {
      {true, false, false, false, false}, {false, true, false, false, false},
      {false, false, true, false, false}, {true, false, false, true, false},
      {false, true, false, true, false},  {true, false, false, false, true},
      {false, false, true, false, true},  {true, true, false, true, false},
      {true, false, true, false, true}};
  const auto wrong = [&](const std::string& what) {
    Violate(now_us_, "decision", fmt::format("{}: {}", name, what));
    return false;
  };
  if (!IsWord<ActionKind>(a.kind)) return wrong("no such kind");
  const auto fits = [](int id, std::size_t n) { return id < static_cast<int>(n) && id >= -1; };
  if (!fits(a.uav_id, models_[kUav].size()) || !fits(a.worker_id, models_[kWorker].size()) ||
      !fits(a.vehicle_id, models_[kVehicle].size()) || !fits(a.task_id, scenario_->tasks.size()) ||
      !fits(a.charge_id, scenario_->charges.size())) {
    return wrong("names what the scenario does not have");
  }
  if (a.kind == ActionKind::kGoTo) {
    const int n_agents = (a.uav_id >= 0) + (a.worker_id >= 0) + (a.vehicle_id >= 0);
    if (n_agents != 1 || a.task_id >= 0 || a.charge_id >= 0) return wrong("names not one agent");
    return true;
  }
  const Shape& s = kShapes[a.kind];
  if ((a.uav_id >= 0) != s.uav || (a.worker_id >= 0) != s.worker ||
      (a.vehicle_id >= 0) != s.vehicle || (a.task_id >= 0) != s.task ||
      (a.charge_id >= 0) != s.charge) {
    return wrong("has not the ids of its kind");
  }
  return true;
}

void Auditor::CheckAction(const action_t& a, const std::string& name) {
  std::vector<AgentModel*> members;
  if (a.uav_id >= 0) members.push_back(&Model(kUav, a.uav_id));
  if (a.worker_id >= 0) members.push_back(&Model(kWorker, a.worker_id));
  if (a.vehicle_id >= 0) members.push_back(&Model(kVehicle, a.vehicle_id));
  const Place to{a.x_m, a.y_m};
  const Scenario::Task* task =
      a.task_id >= 0 ? &scenario_->tasks[static_cast<std::size_t>(a.task_id)] : nullptr;
  const Place expected = task != nullptr ? task->at
                         : a.charge_id >= 0
                             ? scenario_->charges[static_cast<std::size_t>(a.charge_id)].at
                         : a.kind == ActionKind::kGoTo ? to
                                                       : members[0]->to;
  const bool outside =
      a.kind == ActionKind::kGoTo &&
      (a.x_m < 0 || a.y_m < 0 || a.x_m > scenario_->width_m || a.y_m > scenario_->height_m);
  if (Apart(to, expected) > kTolerance_m || outside) {
    Violate(now_us_, "decision",
            fmt::format("{}: leads to ({:.3f}, {:.3f}) m, expected {}", name, a.x_m, a.y_m,
                        outside ? "a place inside the area"
                                : fmt::format("({:.3f}, {:.3f}) m", expected.x_m, expected.y_m)));
  }
  if (a.kind <= NumberOf(ActionKind::kVehicleStays)) {
    for (AgentModel* member : members) member->decision = schedules_.at(due_).decision;
    return;
  }
  std::int64_t end = now_us_;
  std::int64_t latest = kForever;
  for (const AgentModel* member : members) {
    end =
        std::max(end, now_us_ + DurationUs(member->WayM(member->to, to), member->spec->speed_m_s));
    latest = std::min(latest, LatestEnd(*member));
  }
  if (task != nullptr && end >= task->expires_us) {
    Violate(
        now_us_, "expiry",
        fmt::format("{}: there at {} us, the task expires at {} us", name, end, task->expires_us));
  }
  if (a.uav_id >= 0) {
    const AgentModel& uav = *members[0];
    const double range = uav.RangeAt(now_us_);
    const double way = uav.WayM(uav.to, to);
    if (task != nullptr && way + task->cost_m + task->to_charge_m > range + kTolerance_m) {
      Violate(
          now_us_, "constraint-6",
          fmt::format("{}: {:.3f} m of way, {:.3f} m to sense, {:.3f} m to the nearest charging "
                      "point, {:.3f} m of range",
                      name, way, task->cost_m, task->to_charge_m, range));
    }
    if (task == nullptr && way > range + kTolerance_m) {
      Violate(now_us_, "constraint-5",
              fmt::format("{}: {:.3f} m of way, {:.3f} m of range", name, way, range));
    }
    if (a.kind == ActionKind::kSense) end += DurationUs(task->cost_m, uav.spec->speed_m_s);
    if (a.kind == ActionKind::kCharge) {
      const double missing = uav.spec->range_full_m - std::max(0.0, range - way);
      end += DurationUs(missing, members[1]->spec->charge_rate_m_s);
    }
  }
  if (latest != kForever && end > latest + kToleranceUs) {
    Violate(now_us_, "availability",
            fmt::format("{}: ends at {} us, its agents must be free at {} us", name, end, latest));
  }
  for (const AgentModel* member : members) {
    commands_[{member->kind, member->id}] = {a, schedules_.at(due_).decision, now_us_};
  }
}

}  // namespace muster::tools::audit
