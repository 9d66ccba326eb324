// The commander's directives against the decisions that must keep them. What a directive leaves
// open (a partner that is not named, a charging point) is not checked for the best choice.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/audit/checks.h"

namespace muster::tools::audit {
namespace {

using Directive = Scenario::Directive;

constexpr double kFull_m = 2;
constexpr double kNarrow_m = 0.01;  // the auditor's own rounding decides nothing
constexpr std::int64_t kNarrow_us = 10'000;

bool Contains(const Rings& rings, Place at) {
  bool inside = false;
  for (const auto& ring : rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Place a = ring[i], b = ring[(i + 1) % ring.size()];
      if ((a.y_m > at.y_m) == (b.y_m > at.y_m)) continue;
      const double x = a.x_m + (at.y_m - a.y_m) / (b.y_m - a.y_m) * (b.x_m - a.x_m);
      if (at.x_m < x) inside = !inside;
    }
  }
  return inside;
}

class Check {
 public:
  explicit Check(View& view) : view_(view), all_(view.scenario.directives) {}

  void Run() {
    for (const action_t& action : view_.schedule->actions) CheckForbidden(action);
    for (const Directive& one : all_) {
      if (one.what == "pin") CheckPin(one);
      if (one.what == "charge_now") CheckCharge(one);
      if (one.what == "go_to") CheckGoTo(one);
    }
  }

 private:
  AgentModel& Model(const Directive& one, int kind) { return view_.Model(kind, one.agents[kind]); }
  bool IsIdle(const AgentModel& model) const {
    return model.StatusAt(view_.now_us) == AgentStatus::kIdle;
  }
  bool IsThere(const AgentModel& model) const {
    const AgentStatus status = model.StatusAt(view_.now_us);
    return status != AgentStatus::kFailed && status != AgentStatus::kOffline;
  }
  const action_t* ActionOf(int kind, int id) const {
    for (const action_t& a : view_.schedule->actions) {
      if ((kind == kUav ? a.uav_id : kind == kWorker ? a.worker_id : a.vehicle_id) == id) return &a;
    }
    return nullptr;
  }
  static std::string NameOf(const Directive& one) {
    return fmt::format("{} of order {}", one.what, one.order);
  }
  bool OffLimits(int kind, Place at) const {
    return std::any_of(all_.begin(), all_.end(), [&](const Directive& one) {
      return one.of_class == kind && Contains(one.area, at);
    });
  }
  bool Forbids(int kind, int id, int task) const {
    return std::any_of(all_.begin(), all_.end(), [&](const Directive& one) {
      return one.what == "forbid" && one.of_class < 0 && one.task == task && one.agents[kind] == id;
    });
  }

  void CheckForbidden(const action_t& a) {
    const int ids[] = {a.uav_id, a.worker_id, a.vehicle_id};
    for (const int kind : kClasses) {
      if (ids[kind] < 0) continue;
      if (a.task_id >= 0 && Forbids(kind, ids[kind], a.task_id)) {
        view_.Violate("directives", "{} is sent to task {}, which is forbidden",
                      view_.Model(kind, ids[kind]).name(), a.task_id);
      }
      const bool stays = a.kind <= NumberOf(ActionKind::kVehicleStays);
      if (!stays && OffLimits(kind, {a.x_m, a.y_m})) {
        view_.Violate("directives", "{} is sent into an area that is forbidden to its class",
                      view_.Model(kind, ids[kind]).name());
      }
    }
  }

  /// Whether an agent that comes earlier in the order of directives may need one of these.
  bool IsTaken(const Directive& pin) const {
    for (const Directive& other : all_) {
      if (&other == &pin) break;
      if (other.what == "pin" && !view_.IsOver(other.task) && Shares(other, pin)) return true;
    }
    return std::any_of(all_.begin(), all_.end(), [&](const Directive& other) {
      return other.what == "charge_now" && Shares(other, pin);
    });
  }
  static bool Shares(const Directive& a, const Directive& b) {
    for (const int kind : kClasses) {
      if (a.agents[kind] >= 0 && a.agents[kind] == b.agents[kind]) return true;
    }
    // Whoever is not named there may be the partner that was taken.
    return a.agents[kUav] < 0 || a.agents[kWorker] < 0;
  }

  void CheckPin(const Directive& one) {
    const auto task = static_cast<std::size_t>(one.task);
    if (view_.task_status[task] != TaskStatus::kOpen || IsTaken(one)) return;
    const Place at = view_.TaskOf(one.task).at;
    if (OffLimits(kUav, at) || OffLimits(kWorker, at)) return;
    bool all_idle = true;
    for (const int kind : {kUav, kWorker}) {
      if (one.agents[kind] < 0) continue;
      const AgentModel& model = Model(one, kind);
      if (!IsThere(model) || Forbids(kind, one.agents[kind], one.task)) return;
      if (!InTime(model, one.task)) return;
      all_idle = all_idle && IsIdle(model);
    }
    const bool both = one.agents[kUav] >= 0 && one.agents[kWorker] >= 0;
    const bool possible = both && all_idle && CanSense(one) && !view_.withheld.contains(one.task);
    const action_t* sent = nullptr;
    for (const action_t& a : view_.schedule->actions) {
      if (a.task_id == one.task) sent = &a;
    }
    if (possible && (sent == nullptr || sent->kind != ActionKind::kSense)) {
      view_.Violate("directives", "{} could be kept, and nobody is sent to task {}", NameOf(one),
                    one.task);
    }
    // Of one who is named alone and free, the others may lack range or time to be the partner.
    if (sent == nullptr || (all_idle && !possible)) return;
    const int ids[] = {sent->uav_id, sent->worker_id};
    for (const int kind : {kUav, kWorker}) {
      if (one.agents[kind] < 0 || ids[kind] < 0 || ids[kind] == one.agents[kind]) continue;
      view_.Violate("directives", "{} is at task {} instead of those whom {} names",
                    view_.Model(kind, ids[kind]).name(), one.task, NameOf(one));
    }
  }

  /// Once it is free, before the task expires and before it must be free again.
  bool InTime(const AgentModel& model, int task_id) const {
    const Scenario::Task& task = view_.TaskOf(task_id);
    const std::int64_t from = model.busy_until_us == kForever
                                  ? view_.now_us
                                  : std::max(view_.now_us, model.busy_until_us);
    const std::int64_t travel = DurationUs(model.WayM(model.to, task.at), model.spec->speed_m_s);
    return travel != kForever && from + travel + kNarrow_us < task.expires_us &&
           from + travel + kNarrow_us < view_.LatestEnd(model);
  }

  bool HasRange(const Directive& one) {
    if (one.agents[kUav] < 0 || !IsIdle(Model(one, kUav))) return one.agents[kUav] < 0;
    const AgentModel& uav = Model(one, kUav);
    const Scenario::Task& task = view_.TaskOf(one.task);
    return uav.WayM(uav.to, task.at) + task.cost_m + task.to_charge_m + kNarrow_m <=
           uav.RangeAt(view_.now_us);
  }

  bool CanSense(const Directive& one) {
    if (!HasRange(one)) return false;
    const AgentModel& uav = Model(one, kUav);
    const AgentModel& worker = Model(one, kWorker);
    const Scenario::Task& task = view_.TaskOf(one.task);
    const auto arrives = [&](const AgentModel& model) {
      return view_.now_us + DurationUs(model.WayM(model.to, task.at), model.spec->speed_m_s);
    };
    const std::int64_t start = std::max(arrives(uav), arrives(worker));
    const std::int64_t end = start + DurationUs(task.cost_m, uav.spec->speed_m_s) + kNarrow_us;
    return start + kNarrow_us < task.expires_us && end < view_.LatestEnd(uav) &&
           end < view_.LatestEnd(worker);
  }

  void CheckCharge(const Directive& one) {
    const AgentModel& uav = Model(one, kUav);
    if (!IsIdle(uav) || uav.RangeAt(view_.now_us) >= uav.spec->range_full_m - kFull_m) return;
    const action_t* const a = ActionOf(kUav, one.agents[kUav]);
    const bool charges = a == nullptr || a->kind == ActionKind::kCharge ||
                         a->kind == ActionKind::kUavToCharge || a->kind == ActionKind::kUavStays;
    if (charges || !HasPoint(one, uav)) return;
    view_.Violate("directives", "{}: {} is sent elsewhere", NameOf(one), uav.name());
  }

  /// Whether a point that it may use is in range and has a place that nobody takes now.
  bool HasPoint(const Directive& one, const AgentModel& uav) const {
    for (std::size_t y = 0; y < view_.scenario.charges.size(); ++y) {
      if (one.charge >= 0 && static_cast<std::size_t>(one.charge) != y) continue;
      const auto& point = view_.scenario.charges[y];
      if (OffLimits(kUav, point.at) || OffLimits(kVehicle, point.at)) continue;
      std::int64_t load = 0;
      for (const AgentModel& other : view_.agents[kUav]) {
        load += other.action == ActionKind::kCharge && other.target == static_cast<int>(y) ? 1 : 0;
      }
      for (const action_t& a : view_.schedule->actions) {
        load += a.charge_id == static_cast<int>(y) ? 1 : 0;
      }
      if (load < point.capacity &&
          uav.WayM(uav.to, point.at) + kNarrow_m <= uav.RangeAt(view_.now_us)) {
        return true;
      }
    }
    return false;
  }

  void CheckGoTo(const Directive& one) {
    for (const int kind : kClasses) {
      if (one.agents[kind] < 0) continue;
      const AgentModel& model = Model(one, kind);
      const bool wanted = std::any_of(all_.begin(), all_.end(), [&](const Directive& other) {
        const bool may_take =
            other.what == "charge_now" || (other.what == "pin" && !view_.IsOver(other.task));
        return may_take && (other.agents[kind] == one.agents[kind] || other.agents[kind] < 0);
      });
      const action_t* const a = ActionOf(kind, one.agents[kind]);
      if (!IsIdle(model) || wanted || a == nullptr || a->kind == ActionKind::kGoTo ||
          a->kind <= NumberOf(ActionKind::kVehicleStays)) {
        continue;
      }
      // By road it goes to a stop near the place, which may lie in the area.
      const bool has_area = std::any_of(
          all_.begin(), all_.end(), [&](const Directive& other) { return other.of_class == kind; });
      if (has_area) continue;
      const double way_m = model.WayM(model.to, model.ways->StopNear(kind, one.place).first);
      const std::int64_t travel = DurationUs(way_m, model.spec->speed_m_s);
      if (!std::isfinite(way_m) || view_.now_us + travel + kNarrow_us > view_.LatestEnd(model) ||
          (kind == kUav && way_m + kNarrow_m > model.RangeAt(view_.now_us))) {
        continue;
      }
      view_.Violate("directives", "{}: {} is sent elsewhere", NameOf(one), model.name());
    }
  }

  View& view_;
  const std::vector<Directive>& all_;
};

}  // namespace

std::string WrongDirective(const View& view, const AuditOrder& order) {
  const auto& all = view.scenario.directives;
  const Directive& given = order.directive;
  if (order.ends_directive()) {
    const bool known = std::any_of(all.begin(), all.end(), [&](const Directive& one) {
      return order.what == "unpin" ? one.what == "pin" && one.task == given.task
                                   : one.order == order.closure;
    });
    return known ? "" : "ends no directive that is in force";
  }
  if (given.task >= view.n_tasks) return fmt::format("there is no task {}", given.task);
  for (const int kind : kClasses) {
    if (given.agents[kind] >= view.n_agents[kind]) {
      return fmt::format("there is no agent {}", given.agents[kind]);
    }
  }
  const bool pinned = std::any_of(all.begin(), all.end(), [&](const Directive& one) {
    return one.what == "pin" && one.task == given.task;
  });
  if (order.what == "pin" && pinned) return fmt::format("task {} is pinned already", given.task);
  return order.what == "go_to" && !view.IsInside(given.place) ? "leads out of the area" : "";
}

void TakeDirective(const AuditOrder& order, Scenario* scenario) {
  auto& all = scenario->directives;
  const Directive& given = order.directive;
  std::erase_if(all, [&](const Directive& one) {
    if (order.what == "unpin") return one.what == "pin" && one.task == given.task;
    if (order.what == "release") return one.order == order.closure;
    if (order.what == "charge_now") {
      return one.what == order.what && one.agents[kUav] == given.agents[kUav];
    }
    return order.what == "go_to" && one.what == order.what &&
           std::equal(std::begin(one.agents), std::end(one.agents), std::begin(given.agents));
  });
  if (order.ends_directive()) return;
  all.push_back(given);
  all.back().order = order.id;
}

void CheckDirectives(View& view) {
  if (!view.scenario.directives.empty()) Check(view).Run();
}

}  // namespace muster::tools::audit
