// The referee's part in pairs whose legs change under way: a partner is measured, or roads are
// closed before one (docs/reference/mission.md).
#include <fmt/format.h>

#include <algorithm>

#include "model/feasibility.h"
#include "model/measured.h"
#include "model/place_index.h"
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
    const bool is_measured = uav.measured || partner.measured;
    if (known.is_aborted || (!is_measured && !WaysChange())) continue;
    if (IsCutOff(activity, uav) || IsCutOff(activity, partner)) {
      activity.start_us = activity.end_us = kNever;  // FindLate ends it
    }
    if (!AreAt(activity, uav, partner)) continue;
    if (activity.start_us > previous_us_) activity = ActivityOf(uav, partner, scenario_);
    if (activity.start_us > t || !is_measured) continue;
    if (SaysDone(uav) && SaysDone(partner)) {
      activity.end_us = std::min(activity.end_us, t);
    } else if (activity.end_us <= t) {
      activity.end_us = scenario_.rules.TickAfter(t);
    }
  }
}

bool Referee::WaysChange() const {
  return std::any_of(orders_.begin(), orders_.end(),
                     [](const TakenOrder& taken) { return ChangesWays(taken.order.kind); });
}

bool Referee::IsCutOff(const Activity& activity, const AgentState& member) const {
  return WaysChange() && activity.start_us > previous_us_ && !member.failed &&
         member.action == ActionKind::kNone;
}

std::string Referee::BarredPair(const Activity& activity, const AgentState& uav,
                                const AgentState& partner, TimeUs t) const {
  if (!WaysChange() || partner.failed || uav.failed) return "";
  for (const AgentState* member : {&partner, &uav}) {
    if (IsCutOff(activity, *member)) return NameOf(*member) + " is cut off";
  }
  const auto goes_round = [&](const AgentState& member) {
    const TimeUs set_out_us = member.measured ? member.measured->set_out_us : member.depart_us;
    return set_out_us == t && AreAt(activity, uav, partner);
  };
  if (goes_round(uav) && !HasRangeFor(activity, uav)) {
    return NameOf(uav) + " lacks the range to go round";
  }
  if (activity.start_us == kNever) return "";
  const TimeUs latest_us =
      std::min(LatestEnd(uav, scenario_.rules), LatestEnd(partner, scenario_.rules));
  for (const AgentState* member : {&partner, &uav}) {
    if (goes_round(*member) && activity.end_us > latest_us) {
      return NameOf(*member) + " has too far to go round";
    }
  }
  return "";
}

bool Referee::HasRangeFor(const Activity& activity, const AgentState& uav) const {
  double need_m = uav.range_per_m * uav.LegM();
  if (activity.kind == Activity::Kind::kSensing) {
    std::vector<Point> charging;
    for (const ChargingPoint& point : scenario_.charging_points) charging.push_back(point.at);
    const Task& task = scenario_.tasks[static_cast<std::size_t>(activity.site)];
    need_m += task.cost_m +
              PlaceIndex(charging, {scenario_.ways.get(), AgentKind::kUav}).NearestFrom(task.at);
  }
  return need_m <= uav.range_at_departure_m + kRangeSlack_m;
}

void Referee::FindLate(TimeUs t, Agents* agents) {
  late_.clear();
  for (std::size_t i = 0; i < activities_.size(); ++i) {
    const Activity& activity = activities_[i].activity;
    const AgentState& uav = agents->uavs[activity.uav.index()];
    const AgentState& partner = agents->at(PartnerKind(activity.kind), activity.partner);
    if (activities_[i].is_aborted || activity.start_us <= t) continue;
    if (const std::string why = BarredPair(activity, uav, partner, t); !why.empty()) {
      late_.push_back({t, i, why});
      continue;
    }
    if ((!uav.measured && !partner.measured) || !AreAt(activity, uav, partner)) continue;
    const TimeUs planned = std::max(PlannedArrival(uav), PlannedArrival(partner));
    const TimeUs at = std::max(planned + scenario_.rules.patience_us, previous_us_ + 1);
    if (at > t) continue;
    const bool both = !SaysArrived(uav) && !SaysArrived(partner);
    late_.push_back({at, i,
                     both ? fmt::format("{} and {} are late", NameOf(uav), NameOf(partner))
                          : fmt::format("{} is late", NameOf(SaysArrived(uav) ? partner : uav))});
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
         activity, "before its start: " + late.why);
    if (sensing) ExpireIfLate(static_cast<std::size_t>(activity.site), late.at_us);
  }
}

}  // namespace muster::world
