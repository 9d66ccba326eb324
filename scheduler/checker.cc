#include "scheduler/checker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "model/agent.h"
#include "model/feasibility.h"

namespace muster::scheduler {
namespace {

std::string Name(TaskStatus status) {
  return status == TaskStatus::kSensing ? "being sensed" : std::string(ToString(status));
}

/// As ToString, but for any number in `kind`.
std::string Describe(const Action& action) {
  const bool known = ShapeOf(action.kind) || action.kind == ActionKind::kGoTo;
  return known ? muster::ToString(action) : fmt::format("kind {}", static_cast<int>(action.kind));
}

class Checker {
 public:
  explicit Checker(const Situation& situation) : s_(situation), site_(*situation.site) {}

  std::vector<Violation> Check(std::span<const Action> actions) {
    for (index_ = 0; index_ < actions.size(); ++index_) {
      action_ = &actions[index_];
      CheckOne(*action_);
    }
    return std::move(violations_);
  }

 private:
  void Broken(Rule rule, const std::string& detail) {
    violations_.push_back({rule, index_,
                           fmt::format("action {} ({}): {}: {}", index_, Describe(*action_),
                                       ToString(rule), detail)});
  }

  void CheckOne(const Action& a) {
    if (!std::isfinite(a.weight)) Broken(Rule::kWeight, fmt::format("{}", a.weight));
    if (!std::isfinite(a.to.x_m) || !std::isfinite(a.to.y_m)) {
      Broken(Rule::kDestination, fmt::format("({}, {})", a.to.x_m, a.to.y_m));
      return;
    }
    if (!CheckIds(a)) return;
    std::vector<const AgentState*> agents;
    if (a.uav.valid()) agents.push_back(FindIdle(AgentKind::kUav, a.uav.value));
    if (a.worker.valid()) agents.push_back(FindIdle(AgentKind::kWorker, a.worker.value));
    if (a.vehicle.valid()) agents.push_back(FindIdle(AgentKind::kVehicle, a.vehicle.value));
    if (a.task.valid()) CheckTask(a.task);
    if (a.charge.valid()) CheckCapacity(a.charge);
    if (std::find(agents.begin(), agents.end(), nullptr) != agents.end()) return;
    CheckDestination(a, *agents.front());
    if (IsStay(a.kind)) return;
    if (a.uav.valid()) CheckRange(a, *agents.front());
    if (a.task.valid()) CheckExpiry(a, agents);
    if (a.task.valid()) CheckForbidden(a, agents);
    CheckAvailability(a, agents);
  }

  bool CheckIds(const Action& a) {
    const std::size_t before = violations_.size();
    const auto shape = ShapeOf(a.kind);
    const auto expect = [this](const char* name, std::int32_t id, bool wanted) {
      if (wanted && id < 0) Broken(Rule::kIds, fmt::format("no {} given", name));
      if (!wanted && id != -1) Broken(Rule::kIds, fmt::format("superfluous {} {}", name, id));
    };
    if (a.kind == ActionKind::kGoTo) {
      if (a.uav.valid() + a.worker.valid() + a.vehicle.valid() != 1) {
        Broken(Rule::kIds, "expected exactly one agent");
      }
      expect("task", a.task.value, false);
      expect("charging point", a.charge.value, false);
    } else if (!shape) {
      Broken(Rule::kIds, fmt::format("no such kind: {}", static_cast<int>(a.kind)));
    } else {
      expect("uav", a.uav.value, shape->uav);
      expect("worker", a.worker.value, shape->worker);
      expect("vehicle", a.vehicle.value, shape->vehicle);
      expect("task", a.task.value, shape->task);
      expect("charging point", a.charge.value, shape->charge);
    }
    const auto within = [this](const char* name, std::int32_t id, std::size_t n) {
      if (id >= 0 && static_cast<std::size_t>(id) >= n) {
        Broken(Rule::kIds, fmt::format("{} {} of {}", name, id, n));
      }
    };
    within("task", a.task.value, site_.tasks.size());
    within("charging point", a.charge.value, site_.charging_points.size());
    return violations_.size() == before;
  }

  /// The agent when it may be scheduled; else notes why not.
  const AgentState* FindIdle(AgentKind kind, std::int32_t id) {
    const auto [earlier, is_new] = agent_used_.try_emplace({kind, id}, index_);
    if (!is_new) {
      Broken(Rule::kAgentTwice,
             fmt::format("{}:{} is in action {} too", ToString(kind), id, earlier->second));
    }
    const auto& agents = s_.agents(kind);
    const auto found = std::find_if(agents.begin(), agents.end(),
                                    [id](const AgentState& agent) { return agent.id == id; });
    if (found == agents.end()) {
      Broken(Rule::kUnknownAgent, fmt::format("{}:{}", ToString(kind), id));
      return nullptr;
    }
    if (found->failed || !found->online(s_.now_us) || found->busy_until_us > s_.now_us) {
      Broken(Rule::kNotIdle,
             fmt::format("{}:{} is {} at {} us (online [{}, {}) us, busy until {} us)",
                         ToString(kind), id, ToString(StatusAt(*found, s_.now_us)), s_.now_us,
                         found->online_from_us, found->online_until_us, found->busy_until_us));
      return nullptr;
    }
    return &*found;
  }

  void CheckTask(TaskId task) {
    const auto [earlier, is_new] = task_used_.try_emplace(task.value, index_);
    if (!is_new) {
      Broken(Rule::kTaskTwice,
             fmt::format("task {} is in action {} too", task.value, earlier->second));
    }
    const TaskStatus status = s_.task_status[task.index()];
    if (status != TaskStatus::kOpen) {
      Broken(Rule::kTaskNotOpen, fmt::format("task {} is {}", task.value, Name(status)));
    }
  }

  /// `agents`: those who must be there when sensing begins, or one who goes there alone.
  void CheckExpiry(const Action& a, const std::vector<const AgentState*>& agents) {
    const Task& task = site_.tasks[a.task.index()];
    TimeUs start_us = s_.now_us;
    for (const AgentState* agent : agents) {
      const TimeUs travel_us = TravelUs(agent->WayM(agent->to, task.at), agent->speed_m_s);
      start_us = travel_us == kNever ? kNever : std::max(start_us, s_.now_us + travel_us);
    }
    if (start_us >= task.expires_us) {
      Broken(Rule::kExpiry, fmt::format("there at {} us, task {} expires at {} us", start_us,
                                        a.task.value, task.expires_us));
    }
  }

  void CheckForbidden(const Action& a, const std::vector<const AgentState*>& agents) {
    for (const AgentState* agent : agents) {
      if (!site_.Forbids(*agent, a.task.value)) continue;
      Broken(Rule::kForbidden,
             fmt::format("{}:{} task {}", ToString(agent->kind), agent->id, a.task.value));
    }
  }

  void CheckCapacity(ChargeId charge) {
    const auto& capacity = site_.charging_points[charge.index()].capacity;
    if (!capacity) return;
    const int used = ++charge_used_[charge.value];
    const int there = s_.charging_load[charge.index()];
    if (there + used > *capacity) {
      Broken(Rule::kCapacity,
             fmt::format("charging point {}: {} there already, {} in this list, {} places",
                         charge.value, there, used, *capacity));
    }
  }

  void CheckDestination(const Action& a, const AgentState& mover) {
    Point expected = mover.to;
    if (a.kind == ActionKind::kGoTo) {
      const bool is_inside =
          a.to.x_m >= 0 && a.to.y_m >= 0 && a.to.x_m <= site_.width_m && a.to.y_m <= site_.height_m;
      // Roads lead out of the area, and it can wait there.
      const Ways::Stop stop = mover.ways->StopNear(mover.kind, a.to);
      if (!is_inside && (stop.number < 0 || stop.at != a.to)) {
        Broken(Rule::kDestination, fmt::format("({}, {}) m is outside the area of {} m x {} m",
                                               a.to.x_m, a.to.y_m, site_.width_m, site_.height_m));
      }
      return;
    }
    if (a.task.valid()) expected = site_.tasks[a.task.index()].at;
    if (a.charge.valid()) expected = site_.charging_points[a.charge.index()].at;
    if (a.to != expected) {
      Broken(Rule::kDestination, fmt::format("({}, {}) m, expected ({}, {}) m", a.to.x_m, a.to.y_m,
                                             expected.x_m, expected.y_m));
    }
  }

  void CheckRange(const Action& a, const AgentState& uav) {
    const double range = RangeAt(uav, s_.now_us, site_.tasks);
    if (a.task.valid()) {
      const Task& task = site_.tasks[a.task.index()];
      const double way = uav.WayM(uav.to, task.at);
      const double home = NearestChargeM(*site_.ways, task.at, site_.charging_points);
      if (!(way + task.cost_m + home <= range)) {
        Broken(Rule::kConstraint6, fmt::format("way {} + sensing {} + to charging {} > range {} m",
                                               way, task.cost_m, home, range));
      }
      return;
    }
    const double way = uav.WayM(uav.to, a.to);
    if (!(way <= range)) {
      Broken(a.charge.valid() ? Rule::kConstraint5 : Rule::kRange,
             fmt::format("way {} > range {} m", way, range));
    }
  }

  void CheckAvailability(const Action& a, const std::vector<const AgentState*>& agents) {
    for (const AgentState* agent : agents) {
      if (std::isfinite(agent->WayM(agent->to, a.to))) continue;
      Broken(Rule::kAvailability,
             fmt::format("no way leads {}:{} there", ToString(agent->kind), agent->id));
      return;
    }
    if (site_.rules.availability == Availability::kOverrun) return;
    // The rule book carries the action out, undisturbed.
    std::vector<AgentState> acting;
    TimeUs latest = site_.rules.limit_us;
    for (const AgentState* agent : agents) {
      latest = std::min(latest, agent->online_until_us);
      acting.push_back(*agent);
      Begin(&acting.back(), a, s_.decision, s_.now_us, Disturbances{}, 0);
    }
    const TimeUs end = IsPair(a.kind) ? PlanActivity(acting[0], acting[1], site_.tasks).end_us
                                      : acting[0].arrive_us;
    if (end > latest) {
      Broken(Rule::kAvailability,
             fmt::format("ends at {} us, {} us after the last downtime or limit allows", end,
                         end - latest));
    }
  }

  const Situation& s_;
  const Site& site_;
  const Action* action_ = nullptr;
  std::size_t index_ = 0;
  std::map<std::pair<AgentKind, std::int32_t>, std::size_t> agent_used_;
  std::map<std::int32_t, std::size_t> task_used_;
  std::map<std::int32_t, int> charge_used_;
  std::vector<Violation> violations_;
};

}  // namespace

std::string_view ToString(Rule rule) {
  // In the order of Rule.
  constexpr std::string_view kNames[] = {"ids",
                                         "unknown agent",
                                         "agent not idle",
                                         "agent used twice",
                                         "task not open",
                                         "task expires before",
                                         "task used twice",
                                         "constraint (5)",
                                         "constraint (6)",
                                         "out of range",
                                         "charging point over capacity",
                                         "availability",
                                         "destination",
                                         "forbidden",
                                         "weight not finite"};
  static_assert(std::size(kNames) == static_cast<std::size_t>(Rule::kWeight) + 1);
  return kNames[static_cast<std::size_t>(rule)];
}

std::vector<Violation> CheckActions(const Situation& situation, std::span<const Action> actions) {
  return Checker(situation).Check(actions);
}

}  // namespace muster::scheduler
