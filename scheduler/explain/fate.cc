#include "scheduler/explain/fate.h"

#include <algorithm>

#include "base/index.h"
#include "scheduler/explain/explain.h"

namespace muster::scheduler {
namespace {

bool ServesPlace(const PairPlan& pair, const Action& action) {
  if (!IsPair(action.kind)) return false;
  return pair.charging ? action.charge.value == pair.site && action.uav == pair.uav
                       : action.task.value == pair.site;
}

bool SamePair(const PairPlan& pair, UavId uav, std::int32_t partner) {
  return uav == pair.uav && partner == pair.partner;
}

/// One later decision, and what it says of the pair.
class Page {
 public:
  Page(const PairPlan& pair, std::int32_t planned_at, const Scenario& scenario,
       const HorizonDecision& decision, Fate* fate)
      : pair_(pair),
        planned_at_(planned_at),
        scenario_(scenario),
        decision_(decision),
        situation_(decision.situation),
        plans_(PairsOf(decision.situation, decision.deciding.plan)),
        fate_(fate) {}

  bool Settles() {
    fate_->decision = situation_.decision;
    fate_->at_us = situation_.now_us;
    for (const Action& action : decision_.commanded) {
      if (ServesPlace(pair_, action)) fate_->taken_by = action;
    }
    if (IsUnderWay()) return true;
    if (MemberIsGone(AgentKind::kUav, pair_.uav.value)) return true;
    if (MemberIsGone(pair_.partner_kind(), pair_.partner)) return true;
    if (HasExpired()) return IsImpossible();
    if (fate_->taken_by) {
      const Action& action = *fate_->taken_by;
      if (SamePair(pair_, action.uav, MemberOf(action, pair_.partner_kind()))) {
        return Settle(FateKind::kCameAbout);
      }
    }
    if (StillPlanned()) {
      ++fate_->kept;
      return false;
    }
    TakeRivals();
    if (PlaceIsOthers()) return Settle(FateKind::kOthers);
    if (fate_->rivals.empty()) {
      // A member may be busy for longer than a matching looks ahead, with what it did then.
      if (IsPending(AgentKind::kUav, pair_.uav.value) ||
          IsPending(pair_.partner_kind(), pair_.partner)) {
        return false;
      }
      if (IsImpossible()) return true;
    }
    return Settle(FateKind::kOutbid);
  }

 private:
  bool Settle(FateKind kind) {
    fate_->kind = kind;
    return true;
  }

  bool HasExpired() const {
    return !pair_.charging && situation_.task_status[At(pair_.site)] == TaskStatus::kExpired;
  }

  bool IsImpossible() {
    const HorizonLook look(situation_, decision_.deciding.how.settings);
    PlaceLook place = pair_.charging
                          ? look.AtCharge(ChargeId(pair_.site), pair_.uav, VehicleId(pair_.partner))
                          : look.AtTask(TaskId(pair_.site), pair_.uav, WorkerId(pair_.partner));
    if (place.obstacle == Obstacle::kNone) return false;
    fate_->look = std::move(place);
    return Settle(FateKind::kImpossible);
  }

  /// Pairs may meet without a command (Rules::start_on_meeting).
  bool IsUnderWay() {
    if (pair_.charging) return false;
    const TaskId task(pair_.site);
    if (situation_.task_status[task.index()] == TaskStatus::kOpen || HasExpired()) return false;
    const auto activity = UnderWayAt(situation_, task);
    const bool ours = activity && SamePair(pair_, activity->uav, activity->partner);
    if (activity && !ours) {
      Action action;
      action.kind = ActionKind::kSense;
      action.uav = activity->uav;
      action.worker = WorkerId(activity->partner);
      action.task = task;
      fate_->taken_by = action;
    }
    return Settle(ours ? FateKind::kCameAbout : FateKind::kOthers);
  }

  bool MemberIsGone(AgentKind kind, std::int32_t id) {
    const AgentState* agent = FindAgent(situation_, kind, id);
    if (agent != nullptr && !agent->failed) return false;
    fate_->member_kind = kind;
    fate_->member = id;
    const bool offline =
        agent == nullptr && scenario_.agents(kind)[At(id)].online_until_us <= situation_.now_us;
    return Settle(offline ? FateKind::kOffline : FateKind::kFailed);
  }

  bool StillPlanned() const {
    return std::any_of(plans_.begin(), plans_.end(), [&](const PairPlan& other) {
      return other.charging == pair_.charging && other.site == pair_.site &&
             SamePair(pair_, other.uav, other.partner);
    });
  }

  void TakeRivals() {
    for (const PairPlan& other : plans_) {
      const bool place = !pair_.charging && !other.charging && other.site == pair_.site;
      const bool member = other.uav == pair_.uav || other.has(pair_.partner_kind(), pair_.partner);
      // The second matching comes after the first one: it takes nothing from a pair of that.
      if (place || (member && !other.second)) fate_->rivals.push_back(other);
    }
  }

  bool PlaceIsOthers() const {
    return fate_->taken_by ||
           std::any_of(fate_->rivals.begin(), fate_->rivals.end(), [&](const PairPlan& other) {
             return !pair_.charging && !other.charging && other.site == pair_.site;
           });
  }

  bool IsPending(AgentKind kind, std::int32_t id) const {
    const AgentState* agent = FindAgent(situation_, kind, id);
    const auto& takes_part = decision_.deciding.plan.now[kind];
    const bool absent =
        std::none_of(takes_part.begin(), takes_part.end(),
                     [id](const Participant& participant) { return participant.agent->id == id; });
    return absent && agent != nullptr && agent->decision <= planned_at_;
  }

  const PairPlan& pair_;
  std::int32_t planned_at_;
  const Scenario& scenario_;
  const HorizonDecision& decision_;
  const Situation& situation_;
  const std::vector<PairPlan> plans_;
  Fate* fate_;
};

}  // namespace

std::string_view ToString(FateKind kind) {
  constexpr std::string_view kNames[] = {"came about", "other pair", "failed",       "offline",
                                         "impossible", "outbid",     "still planned"};
  return kNames[static_cast<int>(kind)];
}

Fate FateOf(const PairPlan& pair, std::int32_t decision, const Scenario& scenario,
            const std::function<const HorizonDecision*(std::int32_t)>& decision_at) {
  Fate fate;
  for (std::int32_t next = decision + 1; next < scenario.decisions(); ++next) {
    const HorizonDecision* page = decision_at(next);
    if (page != nullptr && Page(pair, decision, scenario, *page, &fate).Settles()) return fate;
  }
  return fate;
}

}  // namespace muster::scheduler
