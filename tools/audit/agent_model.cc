#include "tools/audit/agent_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/audit/values.h"

namespace muster::tools::audit {

std::string AgentModel::name() const { return fmt::format("{}:{}", ToString<AgentKind>(kind), id); }

std::int64_t AgentModel::RoundingUs() const {
  return kToleranceUs + static_cast<std::int64_t>(ways->rounding_m(kind) / spec->speed_m_s * 1e6);
}

double AgentModel::PartAt(std::int64_t t) const {
  const std::int64_t begin_us = depart_us + hold_us;
  if (t >= arrive_us) return 1;
  if (t <= begin_us) return 0;
  return static_cast<double>(t - begin_us) / static_cast<double>(arrive_us - begin_us);
}

Place AgentModel::At(std::int64_t t) const {
  if (t >= arrive_us) return to;
  if (t <= depart_us + hold_us) return from;
  return leg_ways->After(kind, from, to, PartAt(t));
}

double AgentModel::RangeAt(std::int64_t t) const {
  if (kind != kUav) return 0;
  if (t < arrive_us) return range_at_departure_m - range_per_m * MovedAt(t);
  const double arrived = RangeOnArrival();
  if (!activity || t <= activity->start_us) return arrived;
  if (range_after_m) return *range_after_m;
  const double part = t >= activity->end_us
                          ? 1.0
                          : static_cast<double>(t - activity->start_us) /
                                static_cast<double>(activity->end_us - activity->start_us);
  return activity->senses() ? arrived - part * cost_m
                            : arrived + part * (spec->range_full_m - arrived);
}

AgentStatus AgentModel::StatusAt(std::int64_t t) const {
  if (failed) return AgentStatus::kFailed;
  if (busy_until_us <= t) {
    const bool online = spec->online_from_us <= t && t < spec->online_until_us;
    return online ? AgentStatus::kIdle : AgentStatus::kOffline;
  }
  if (action == ActionKind::kNone && busy_until_us == kForever) return AgentStatus::kNotReady;
  if (t < arrive_us) return AgentStatus::kMoving;
  if (!activity || t < activity->start_us) return AgentStatus::kWaiting;
  return activity->senses() ? AgentStatus::kSensing : AgentStatus::kCharging;
}

void AgentModel::StopAt(std::int64_t t) {
  const double range = std::max(0.0, RangeAt(t));
  // Ruled to have stopped before it came: where that was follows from where it came from.
  if (says_arrived && arrive_us <= t) {
    // Its battery is charged on until it is told to stop.
    const bool charges = activity && !activity->senses() && activity->start_us < t;
    Anchor(At(t), t, charges ? std::max(range, RangeAt(activity->end_us)) : range);
  }
  from = to = At(t);
  depart_us = arrive_us = busy_until_us = t;
  hold_us = 0;
  range_at_departure_m = range;
  range_per_m = 1;
  way_seen = true;
  action = ActionKind::kNone;
  target = partner = -1;
  activity.reset();
  range_after_m.reset();
  origin = from;
  set_out_us = planned_us = t;
  goes_on_anew = overdue = false;
}

void AgentModel::GoRound(const Ways& now, Place here, std::int64_t t) {
  ways = leg_ways = &now;
  from = here;
  hold_us = std::max<std::int64_t>(0, depart_us + hold_us - t);
  depart_us = t;
  const double way_m = WayM(here, to);
  if (std::isinf(way_m)) {
    to = here;
    arrive_us = t;
    return StopAt(t);
  }
  arrive_us = planned_us = t + hold_us + DurationUs(way_m, spec->speed_m_s);
  origin = from;
  set_out_us = t;
  busy_until_us = pair() ? kForever : arrive_us;
}

std::int64_t DurationUs(double amount, double rate) {
  const double us = amount / rate * 1e6;
  return us < 9e18 ? std::llround(us) : kForever;
}

}  // namespace muster::tools::audit
