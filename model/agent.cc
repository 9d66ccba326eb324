#include "model/agent.h"

#include <algorithm>
#include <functional>
#include <tuple>

#include "base/check.h"
#include "base/random.h"
#include "model/feasibility.h"
#include "model/measured.h"

namespace muster {
namespace {

ActionKind ActionOf(Activity::Kind kind) {
  return kind == Activity::Kind::kSensing ? ActionKind::kSense : ActionKind::kCharge;
}

double RangeOnArrival(const AgentState& uav) {
  const double spent = uav.range_per_m * uav.LegM();
  return std::max(0.0, uav.range_at_departure_m - spent);
}

/// Share of its leg that the agent has behind it at t, 0 to 1.
double ShareAt(const AgentState& agent, TimeUs t) {
  if (t >= agent.arrive_us) return 1;
  const TimeUs set_out_us = agent.depart_us + HoldUs(agent);
  if (t <= set_out_us) return 0;
  return static_cast<double>(t - set_out_us) / static_cast<double>(agent.arrive_us - set_out_us);
}

/// The agent stands where it is at `t`, free, from then on.
void StopAt(AgentState* agent, TimeUs t, std::span<const Task> tasks) {
  const Point here = PositionAt(*agent, t);
  const double range = RangeAt(*agent, t, tasks);
  agent->from = agent->to = here;
  agent->depart_us = agent->arrive_us = agent->busy_until_us = t;
  agent->range_at_departure_m = range;
  agent->range_per_m = 1;
  agent->action = ActionKind::kNone;
  agent->target = agent->partner = -1;
  agent->activity.reset();
  if (!agent->measured) return;
  // What it has said since does not count: it is ruled to have stopped before.
  Measured::Seen& seen = agent->measured->seen;
  if (t < seen.at_us) seen = {here, t, range};
  NoteLeg(agent);
}

/// When the present leg began: that of a measured agent is told anew as it goes.
TimeUs SetOutAt(const AgentState& agent) {
  return agent.measured ? agent.measured->set_out_us : agent.depart_us;
}

/// Whether a release, which the verdict on t tells, is one from the present leg. A leg that begins
/// at t goes on round a road or a zone that is closed since then.
bool EndsLeg(const Ruling& release, const AgentState& agent, TimeUs t) {
  return release.at_us >= SetOutAt(agent) || SetOutAt(agent) == t;
}

/// Whether it is the sensing or charging that the agent was sent to.
bool IsOf(const AgentState& agent, const Activity& activity) {
  const std::int32_t other = agent.kind == AgentKind::kUav ? activity.partner : activity.uav.value;
  return agent.action == ActionOf(activity.kind) && other == agent.partner &&
         activity.site == agent.target;
}

/// Whether the activity is the agent's own, which was expected earlier: the verdict no longer has
/// it end when the agent was told it would.
bool ComesToBe(const AgentState& agent, const Activity& activity, const Verdict& verdict) {
  if (!IsOf(agent, activity)) return false;
  bool ends = false;
  verdict.ForEachActivityOf(agent.kind, agent.id, [&](const Activity& listed) {
    ends |= IsOf(agent, listed) && listed.end_us == agent.busy_until_us;
  });
  return !ends;
}

/// Whether the agent takes part in an activity that lists it, and not in an earlier one like it.
bool Takes(const AgentState& agent, const Activity& activity) {
  if (activity.start_us < SetOutAt(agent)) return false;
  if (agent.action == ActionKind::kNone) {
    // A meeting (Rules::start_on_meeting) begins without a command, at once.
    return activity.start_us != kNever && activity.end_us > agent.busy_until_us;
  }
  return IsOf(agent, activity);
}

/// The agent takes its part in an activity.
void Take(AgentState* agent, const Activity& activity) {
  agent->activity = activity;
  agent->action = ActionOf(activity.kind);
  agent->target = activity.site;
  agent->partner = agent->kind == AgentKind::kUav ? activity.partner : activity.uav.value;
  agent->busy_until_us = activity.end_us;
}

/// The meeting (Rules::start_on_meeting) that begins at t, as the agent is released from its leg:
/// no part of what it was sent to.
std::optional<Activity> NextMeeting(const AgentState& agent, const Verdict& verdict, TimeUs t) {
  std::optional<Activity> meeting;
  verdict.ForEachActivityOf(agent.kind, agent.id, [&](const Activity& activity) {
    if (activity.start_us == t && !IsOf(agent, activity)) meeting = activity;
  });
  return meeting;
}

/// What was used of the range on a leg that is over does not depend on the ways of the present.
void EndLeg(AgentState* agent, double range_m) {
  if (agent->kind != AgentKind::kUav || RangeOnArrival(*agent) == range_m) return;
  agent->from = agent->to;
  agent->depart_us = agent->arrive_us;
  agent->range_at_departure_m = range_m;
}

}  // namespace

AgentState StartOf(AgentKind kind, std::int32_t id, const AgentSpec& spec, const Ways& ways) {
  AgentState agent;
  agent.ways = agent.leg_ways = &ways;
  agent.kind = kind;
  agent.id = id;
  agent.speed_m_s = spec.speed_m_s;
  agent.range_full_m = spec.range_full_m;
  agent.charge_rate_m_s = spec.charge_rate_m_s;
  agent.online_from_us = spec.online_from_us;
  agent.online_until_us = spec.online_until_us;
  agent.from = agent.to = spec.at;
  agent.range_at_departure_m = spec.range_m;
  if (spec.measured) {
    agent.measured.emplace();
    agent.measured->seen = {spec.at, 0, spec.range_m};
    NoteLeg(&agent);
  }
  return agent;
}

TimeUs HoldUs(const AgentState& agent) {
  if (agent.kind != AgentKind::kUav || agent.measured || !agent.leg_ways->ruled(agent.kind) ||
      agent.arrive_us <= agent.depart_us) {
    return 0;
  }
  const TimeUs travel_us = TravelUs(agent.LegM(), agent.speed_m_s);
  const TimeUs hold_us = agent.arrive_us - agent.depart_us - std::min(travel_us, agent.arrive_us);
  return std::max<TimeUs>(hold_us, 0);
}

std::optional<TimeUs> BarredAt(const AgentState& agent, TimeUs since_us, const Ways& now) {
  const auto share =
      agent.leg_ways->BarredAt(agent.kind, agent.from, agent.to, ShareAt(agent, since_us), now);
  if (!share) return {};
  const TimeUs set_out_us = agent.depart_us + HoldUs(agent);
  const auto way_us = static_cast<double>(agent.arrive_us - set_out_us);
  return set_out_us + static_cast<TimeUs>(std::ceil(*share * way_us));
}

void GoRound(AgentState* agent, TimeUs since_us, TimeUs t, const Ways& now) {
  const Ways& before = *agent->leg_ways;
  agent->ways = &now;
  const bool under_way = agent->action != ActionKind::kNone && !agent->failed;
  const bool measured = agent->measured.has_value();
  // Where a measured agent is it says itself, so its leg is always one by the ways of the present.
  if (!under_way || measured) agent->leg_ways = &now;
  if (!under_way) return;
  AgentState moved = *agent;
  moved.leg_ways = &before;
  if (measured && (agent->measured->arrived || agent->arrive_us <= t)) {
    EndLeg(agent, RangeOnArrival(moved));
    return;
  }
  const auto barred_us = BarredAt(moved, measured ? t : since_us, now);
  if (!barred_us && !measured) return;
  agent->from = PositionAt(moved, measured ? t : std::min(*barred_us, t));
  if (agent->kind == AgentKind::kUav) agent->range_at_departure_m = RangeOnWayAt(moved, t);
  agent->depart_us = t;
  if (!barred_us) return;  // the rest of its leg, from where it is
  const TimeUs rest_of_hold_us = std::max<TimeUs>(0, moved.depart_us + HoldUs(moved) - t);
  const Point here = agent->from;
  agent->leg_ways = &now;
  agent->activity.reset();
  const double way_m = now.Length(agent->kind, here, agent->to);
  if (std::isinf(way_m)) {
    agent->to = here;
    agent->arrive_us = t;
    agent->action = ActionKind::kNone;
    agent->target = agent->partner = -1;
  } else {
    agent->arrive_us = t + rest_of_hold_us + TravelUs(way_m, agent->speed_m_s);
  }
  agent->busy_until_us = IsPair(agent->action) ? kNever : agent->arrive_us;
  if (agent->measured) NoteLeg(agent);
}

Point PositionAt(const AgentState& agent, TimeUs t) {
  if (t >= agent.arrive_us) return agent.to;
  const double share = ShareAt(agent, t);
  if (share <= 0) return agent.from;
  return agent.leg_ways->PlaceAfter(agent.kind, agent.from, agent.to, share);
}

double RangeOnWayAt(const AgentState& agent, TimeUs t) {
  const double way_m =
      agent.leg_ways->LengthAfter(agent.kind, agent.from, agent.to, ShareAt(agent, t));
  return std::max(0.0, agent.range_at_departure_m - agent.range_per_m * way_m);
}

double RangeAt(const AgentState& agent, TimeUs t, std::span<const Task> tasks) {
  if (agent.kind != AgentKind::kUav) return 0;
  if (t < agent.arrive_us) return RangeOnWayAt(agent, t);
  const double on_arrival = RangeOnArrival(agent);
  if (!agent.activity || t <= agent.activity->start_us) return on_arrival;
  const Activity& activity = *agent.activity;
  // An agent that has said that it is done is done, though its partner may go on.
  const bool done = t >= activity.end_us || (agent.measured && agent.measured->done);
  if (done && agent.measured && agent.measured->range_after_m) {
    return *agent.measured->range_after_m;
  }
  const double fraction = done ? 1.0
                               : static_cast<double>(t - activity.start_us) /
                                     static_cast<double>(activity.end_us - activity.start_us);
  if (activity.kind == Activity::Kind::kSensing) {
    const double cost = tasks[static_cast<std::size_t>(activity.site)].cost_m;
    return std::max(0.0, on_arrival - cost * fraction);
  }
  return fraction == 1.0 ? agent.range_full_m
                         : on_arrival + (agent.range_full_m - on_arrival) * fraction;
}

AgentStatus StatusAt(const AgentState& agent, TimeUs t) {
  if (agent.failed) return AgentStatus::kFailed;
  if (agent.busy_until_us <= t) {
    return agent.online(t) ? AgentStatus::kIdle : AgentStatus::kOffline;
  }
  if (agent.not_ready()) return AgentStatus::kNotReady;
  if (t < agent.arrive_us) return AgentStatus::kMoving;
  if (!agent.activity || t < agent.activity->start_us) return AgentStatus::kWaiting;
  return agent.activity->kind == Activity::Kind::kSensing ? AgentStatus::kSensing
                                                          : AgentStatus::kCharging;
}

std::optional<TimeUs> RunsDryAt(const AgentState& uav) {
  const double way = uav.range_per_m * uav.LegM();
  if (uav.kind != AgentKind::kUav || uav.measured ||
      way <= uav.range_at_departure_m + kRangeSlack_m)
    return {};
  const double fraction = uav.range_at_departure_m / way;
  const TimeUs set_out_us = uav.depart_us + HoldUs(uav);
  const auto duration = static_cast<double>(uav.arrive_us - set_out_us);
  return set_out_us + static_cast<TimeUs>(std::floor(duration * fraction));
}

std::optional<TimeUs> RunsDryAt(const AgentState& uav, const Activity& sensing,
                                std::span<const Task> tasks) {
  MUSTER_CHECK(sensing.kind == Activity::Kind::kSensing, "uav:{}", uav.id);
  const double cost = tasks[static_cast<std::size_t>(sensing.site)].cost_m;
  const double on_arrival = RangeOnArrival(uav);
  if (uav.measured || sensing.start_us == kNever || cost <= on_arrival + kRangeSlack_m) return {};
  const auto duration = static_cast<double>(sensing.end_us - sensing.start_us);
  return sensing.start_us + static_cast<TimeUs>(std::floor(duration * (on_arrival / cost)));
}

Activity PlanActivity(const AgentState& uav, const AgentState& partner,
                      std::span<const Task> tasks) {
  MUSTER_CHECK(uav.kind == AgentKind::kUav && IsPair(uav.action), "uav:{}", uav.id);
  Activity activity;
  activity.uav = UavId(uav.id);
  activity.partner = partner.id;
  activity.site = uav.target;
  activity.start_us = std::max(uav.arrive_us, partner.arrive_us);
  TimeUs duration = 0;
  if (uav.action == ActionKind::kSense) {
    activity.kind = Activity::Kind::kSensing;
    duration = SensingUs(tasks[static_cast<std::size_t>(uav.target)].cost_m, uav.speed_m_s);
  } else {
    activity.kind = Activity::Kind::kCharging;
    duration = ChargingUs(uav.range_full_m, RangeOnArrival(uav), partner.charge_rate_m_s);
  }
  activity.end_us = activity.start_us + duration;
  return activity;
}

Verdict::Verdict(std::vector<Activity> activities, std::vector<Ruling> rulings)
    : activities_(std::move(activities)), rulings_(std::move(rulings)) {
  std::sort(activities_.begin(), activities_.end(), [](const Activity& a, const Activity& b) {
    return std::tie(a.uav, a.start_us, a.kind) < std::tie(b.uav, b.start_us, b.kind);
  });
  // Of two releases the first counts: a pair that has ended, and an order that frees its members.
  std::sort(rulings_.begin(), rulings_.end(), [](const Ruling& a, const Ruling& b) {
    return std::tuple(a.agent_kind, a.agent, !a.fails(), a.at_us) <
           std::tuple(b.agent_kind, b.agent, !b.fails(), b.at_us);
  });
  for (const AgentKind kind : kAgentKinds) {
    auto& order = orders_[kind];
    for (std::uint32_t i = 0; i < activities_.size(); ++i) {
      if (Member(activities_[i], kind) >= 0) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(Member(activities_[a], kind), activities_[a].start_us) <
             std::pair(Member(activities_[b], kind), activities_[b].start_us);
    });
  }
}

std::int32_t Verdict::Member(const Activity& activity, AgentKind kind) {
  if (kind == AgentKind::kUav) return activity.uav.value;
  return kind == PartnerKind(activity.kind) ? activity.partner : -1;
}

std::size_t Verdict::LowerBound(AgentKind kind, std::int32_t id) const {
  const auto& order = orders_[kind];
  const auto first = std::lower_bound(
      order.begin(), order.end(), id,
      [&](std::uint32_t i, std::int32_t value) { return Member(activities_[i], kind) < value; });
  return static_cast<std::size_t>(first - order.begin());
}

std::span<const Ruling> Verdict::rulings_of(AgentKind kind, std::int32_t id) const {
  const auto [first, last] =
      std::equal_range(rulings_.begin(), rulings_.end(), Ruling{kind, id, Ruling::Kind::kFailed, 0},
                       [](const Ruling& a, const Ruling& b) {
                         return std::tie(a.agent_kind, a.agent) < std::tie(b.agent_kind, b.agent);
                       });
  return {first, last};
}

void Settle(AgentState* agent, const Verdict& verdict, TimeUs t, std::span<const Task> tasks) {
  const auto rulings = verdict.rulings_of(agent->kind, agent->id);
  // The activity that its failure aborted is listed once more.
  if (agent->failed && std::any_of(rulings.begin(), rulings.end(), std::mem_fn(&Ruling::fails)))
    return;
  verdict.ForEachActivityOf(agent->kind, agent->id, [&](const Activity& activity) {
    // What ended before a meeting began is over, though the agent may learn of both at once.
    // Its own activity may be of no length, a full UAV's charging, or come to be later.
    if (agent->action != ActionKind::kNone && agent->busy_until_us <= activity.start_us &&
        agent->busy_until_us < activity.end_us && activity.start_us <= t &&
        !ComesToBe(*agent, activity, verdict)) {
      StopAt(agent, agent->busy_until_us, tasks);
    }
    if (!Takes(*agent, activity)) return;
    if (agent->measured && agent->action == ActionKind::kNone) agent->measured->arrived = true;
    if (agent->measured && !agent->measured->arrived && activity.start_us <= t) {
      // Its process was started again, and says that it is on its way: too late.
      HasArrived(agent, activity.start_us);
    }
    if (agent->measured && agent->measured->done && agent->busy_until_us < activity.start_us) {
      HasNotBegun(agent);  // what it said to be done with: its partner is late
    }
    Take(agent, activity);
  });
  bool failed = false;
  std::optional<Activity> meeting;
  for (const Ruling& ruling : rulings) {
    if (ruling.fails()) {
      failed = true;
      if (!agent->failed) StopAt(agent, ruling.at_us, tasks);
    } else if (agent->action != ActionKind::kNone && EndsLeg(ruling, *agent, t)) {
      meeting = NextMeeting(*agent, verdict, t);
      // A measured one has gone on until it is told.
      StopAt(agent, agent->measured ? t : std::max(ruling.at_us, agent->depart_us), tasks);
    }
  }
  agent->failed = failed;
  if (meeting && !failed) {
    if (agent->measured) agent->measured->arrived = true;
    Take(agent, *meeting);
  }
  if (agent->action != ActionKind::kNone && agent->busy_until_us <= t) {
    StopAt(agent, agent->busy_until_us, tasks);
  }
}

double RangePerMetre(UavId uav, std::int32_t decision, const Disturbances& disturbances,
                     std::uint64_t seed) {
  if (!disturbances.wind.on()) return 1;
  Random random(seed, Stream::kWind, uav.index(), static_cast<std::uint32_t>(decision));
  return 1 + random.Uniform(disturbances.wind.low, disturbances.wind.high);
}

void Begin(AgentState* agent, const Action& action, std::int32_t decision, TimeUs now,
           const Disturbances& disturbances, std::uint64_t seed, TimeUs hold_us) {
  MUSTER_CHECK(agent->idle(now), "{}:{} at {}", ToString(agent->kind), agent->id, now);
  agent->decision = decision;
  if (IsStay(action.kind)) return;
  const Ways::Stop goal = action.kind == ActionKind::kGoTo
                              ? agent->ways->StopNear(agent->kind, action.to)
                              : Ways::Stop{action.to};
  const double way_m = agent->WayM(agent->to, goal.at);
  if (std::isinf(way_m)) return;  // where no way leads it is not sent
  agent->from = agent->to;
  agent->to = goal.at;
  agent->leg_ways = agent->ways;
  agent->depart_us = now;
  agent->arrive_us = now + (agent->measured ? 0 : hold_us) + TravelUs(way_m, agent->speed_m_s);
  agent->action = action.kind;
  agent->activity.reset();
  agent->busy_until_us = IsPair(action.kind) ? kNever : agent->arrive_us;
  agent->target = action.task.valid()     ? action.task.value
                  : action.charge.valid() ? action.charge.value
                                          : goal.number;
  if (IsPair(action.kind)) {
    agent->partner = agent->kind != AgentKind::kUav      ? action.uav.value
                     : action.kind == ActionKind::kSense ? action.worker.value
                                                         : action.vehicle.value;
  }
  if (agent->kind != AgentKind::kUav) {
    if (agent->measured) NoteLeg(agent);
    return;
  }
  agent->range_per_m = RangePerMetre(UavId(agent->id), decision, disturbances, seed);
  if (disturbances.communication_m.on()) {
    Random random(seed, Stream::kCommunication, static_cast<std::uint64_t>(agent->id),
                  static_cast<std::uint32_t>(decision));
    agent->range_at_departure_m = std::max(
        0.0, agent->range_at_departure_m - random.Uniform(disturbances.communication_m.low,
                                                          disturbances.communication_m.high));
  }
  if (agent->measured) NoteLeg(agent);
}

bool MatchFails(const Action& action, std::int32_t decision, const Disturbances& disturbances,
                std::uint64_t seed) {
  if (!disturbances.match_failure.on()) return false;
  const double p = Random(seed, Stream::kMatchFailure)
                       .Uniform(disturbances.match_failure.low, disturbances.match_failure.high);
  return Random(seed, Stream::kMatchFailure, action.uav.index() + 1,
                static_cast<std::uint32_t>(decision))
             .Uniform() < p;
}

bool SuddenlyFails(AgentKind kind, std::int32_t id, std::int32_t decision,
                   const Disturbances& disturbances, std::uint64_t seed) {
  if (!disturbances.agent_failure.on()) return false;
  const auto entity = static_cast<std::uint64_t>(kind) << 32 | static_cast<std::uint64_t>(id);
  const double p = Random(seed, Stream::kAgentFailure, entity)
                       .Uniform(disturbances.agent_failure.low, disturbances.agent_failure.high);
  return Random(seed, Stream::kAgentFailure, entity, static_cast<std::uint32_t>(decision) + 1)
             .Uniform() < p;
}

}  // namespace muster
