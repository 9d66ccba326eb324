// The referee's part in pairs of which a partner is measured (docs/reference/mission.md).
#include <fmt/format.h>

#include <algorithm>

#include "model/measured.h"
#include "world/referee.h"

namespace muster::world {
namespace {

/// Whether these two are the pair of that activity, and still at it.
bool AreAt(const Activity& activity, const AgentState& uav, const AgentState& partner) {
  const ActionKind action =
      activity.kind == Activity::Kind::kSensing ? ActionKind::kSense : ActionKind::kCharge;
  const auto is_at = [&](const AgentState& agent, std::int32_t other) {
    return agent.action == action && agent.target == activity.site && agent.partner == other &&
           !agent.failed;
  };
  return is_at(uav, partner.id) && is_at(partner, uav.id);
}

/// When it is there, or was to be.
TimeUs PlannedArrival(const AgentState& agent) {
  const bool is_late = agent.measured && !agent.measured->arrived;
  return is_late ? agent.measured->planned_us : agent.arrive_us;
}

std::string NameOf(const AgentState& agent) {
  return fmt::format("{}:{}", ToString(agent.kind), agent.id);
}

}  // namespace

Activity ActivityOf(const AgentState& uav, const AgentState& partner, const Scenario& scenario) {
  Activity activity = PlanActivity(uav, partner, scenario.tasks);
  if (RunsDryAt(uav)) activity.start_us = activity.end_us = kNever;
  return activity;
}

void Referee::MoveActivities(TimeUs t, Agents* agents) {
  for (Known& known : activities_) {
    Activity& activity = known.activity;
    const AgentState& uav = agents->uavs[activity.uav.index()];
    const AgentState& partner = agents->at(PartnerKind(activity.kind), activity.partner);
    if (known.is_aborted || (!uav.measured && !partner.measured)) continue;
    if (!AreAt(activity, uav, partner)) continue;
    if (activity.start_us > previous_us_) activity = ActivityOf(uav, partner, scenario_);
    if (activity.start_us > t) continue;
    if (SaysDone(uav) && SaysDone(partner)) {
      activity.end_us = std::min(activity.end_us, t);
    } else if (activity.end_us <= t) {
      activity.end_us = scenario_.rules.TickAfter(t);
    }
  }
}

void Referee::FindLate(TimeUs t, Agents* agents) {
  late_.clear();
  for (std::size_t i = 0; i < activities_.size(); ++i) {
    const Activity& activity = activities_[i].activity;
    const AgentState& uav = agents->uavs[activity.uav.index()];
    const AgentState& partner = agents->at(PartnerKind(activity.kind), activity.partner);
    if (activities_[i].is_aborted || activity.start_us <= t ||
        (!uav.measured && !partner.measured) || !AreAt(activity, uav, partner)) {
      continue;
    }
    const TimeUs planned = std::max(PlannedArrival(uav), PlannedArrival(partner));
    const TimeUs at = std::max(planned + scenario_.rules.patience_us, previous_us_ + 1);
    if (at > t) continue;
    const bool both = !SaysArrived(uav) && !SaysArrived(partner);
    late_.push_back({at, i,
                     both ? fmt::format("{} and {} are", NameOf(uav), NameOf(partner))
                          : fmt::format("{} is", NameOf(SaysArrived(uav) ? partner : uav))});
  }
  std::stable_sort(late_.begin(), late_.end(),
                   [](const Late& a, const Late& b) { return a.at_us > b.at_us; });
}

void Referee::GiveUpUntil(TimeUs t) {
  for (; !late_.empty() && late_.back().at_us <= t; late_.pop_back()) {
    const Late& late = late_.back();
    ExpireUntil(late.at_us);
    Known& known = activities_[late.activity];
    if (known.is_aborted) continue;
    known.is_aborted = true;
    const Activity& activity = known.activity;
    const AgentKind partner = PartnerKind(activity.kind);
    released_.push_back({AgentKind::kUav, activity.uav.value, Ruling::Kind::kReleased, late.at_us});
    released_.push_back({partner, activity.partner, Ruling::Kind::kReleased, late.at_us});
    const bool sensing = activity.kind == Activity::Kind::kSensing;
    Emit(sensing ? Event::Kind::kSensingAborted : Event::Kind::kChargingAborted, late.at_us,
         activity, fmt::format("before its start: {} late", late.who));
    if (sensing) ExpireIfLate(static_cast<std::size_t>(activity.site), late.at_us);
  }
}

}  // namespace muster::world
