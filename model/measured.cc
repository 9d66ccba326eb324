#include "model/measured.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/feasibility.h"

namespace muster {
namespace {

using Kind = MeasuredReport::Kind;

/// Later than any mission lasts; sums of such times do not overflow.
constexpr TimeUs kLatestUs = TimeUs{100} * 366 * 24 * 60 * kMinuteUs;

/// Places in messages differ by rounding.
constexpr double kSamePlace_m = 1e-6;

/// The rest of the leg begins there and then.
void RestFrom(Point here, double range_m, TimeUs t, AgentState* agent) {
  agent->from = here;
  agent->depart_us = t;
  if (agent->kind == AgentKind::kUav) agent->range_at_departure_m = range_m;
}

/// The range that it has there, without a word of its own. It has flown the way from the place of
/// its last word, and not the way that it was computed to be ahead of that place.
double RangeThere(const AgentState& agent, Point at) {
  const Measured::Seen& seen = agent.measured->seen;
  double range = agent.range_at_departure_m, ahead = 0;
  if (agent.depart_us > seen.at_us) {
    ahead = agent.GoneM(seen.at, agent.from);
  } else {
    range = RangeOnWayAt(agent, seen.at_us);
    const Point computed = PositionAt(agent, seen.at_us);
    ahead = agent.GoneM(seen.at, agent.to) - agent.GoneM(computed, agent.to);
  }
  const double way = agent.GoneM(seen.at, at) - ahead;
  // Ways may have changed in between. It has flown at least the straight line.
  const double most = seen.range_m - Distance(seen.at, at);
  return std::max(0.0, std::min(range - agent.range_per_m * way, most));
}

double SlackM(const AgentState& agent) { return agent.speed_m_s * ToSeconds(kMeasuredSlackUs); }

/// The way that it can have made in that time at most.
double MostWayM(const AgentState& agent, TimeUs duration_us) {
  return agent.speed_m_s * ToSeconds(std::max<TimeUs>(duration_us, 0)) + SlackM(agent);
}

bool IsOnItsWay(const AgentState& agent) {
  return agent.action != ActionKind::kNone && !agent.measured->arrived;
}

/// Metres that it still has to go from there; in a straight line where no way of the mission leads:
/// its driver knows one.
double RestM(const AgentState& agent, Point from) { return agent.GoneM(from, agent.to); }

/// Whether it can be there then, from where it has said to be last and when its leg began: small
/// errors of many reports do not add up. Where it was computed to be tells nothing. By the straight
/// line: a place that is measured to ten metres is beside the road now and then.
std::string CheckSpeed(const AgentState& agent, Point at, TimeUs at_us) {
  for (const Measured::Seen& seen : {agent.measured->seen, agent.measured->anchor}) {
    const double way = Distance(seen.at, at);
    if (way <= MostWayM(agent, at_us - seen.at_us)) continue;
    return fmt::format("{:.0f} m in {:.0f} s are faster than its {:g} m/s", way,
                       ToSeconds(at_us - seen.at_us), agent.speed_m_s);
  }
  return {};
}

/// Range cannot have come from nowhere: at most what it had less the way, or full while it charges.
std::string CheckRange(const AgentState& agent, double range_m, Point at, bool charges) {
  if (agent.kind != AgentKind::kUav) return "only a UAV has a range";
  if (!std::isfinite(range_m) || range_m < 0) return fmt::format("a range of {:g} m", range_m);
  double most = agent.range_full_m;
  if (!charges) {
    for (const Measured::Seen& seen : {agent.measured->seen, agent.measured->anchor}) {
      most = std::min(most, std::max(0.0, seen.range_m - Distance(seen.at, at)));
    }
  }
  if (range_m <= most + SlackM(agent)) return {};
  return fmt::format("a range of {:.0f} m, at most {:.0f} m can be left", range_m, most);
}

std::string CheckTime(const AgentState& agent, const MeasuredReport& report, TimeUs t) {
  if (report.at_us > t) {
    return fmt::format("a report about {:.1f} s, which comes at {:.1f} s", ToSeconds(report.at_us),
                       ToSeconds(t));
  }
  if (IsOld(agent, report)) {
    return fmt::format("a report about {:.1f} s, older than what is known",
                       ToSeconds(report.at_us));
  }
  return {};
}

/// A place on the way: the rest of the leg begins there and then.
std::string OnTheWay(AgentState* agent, const MeasuredReport& report, TimeUs t,
                     std::span<const Task> tasks) {
  const TimeUs soonest = report.at_us + TravelUs(Distance(report.at, agent->to), agent->speed_m_s);
  const TimeUs usual = report.at_us + TravelUs(RestM(*agent, report.at), agent->speed_m_s);
  const double slack = SlackM(*agent);
  // Where it was to be by then: it may have been there for long.
  const bool is_there = agent->arrive_us <= report.at_us && Distance(report.at, agent->to) <= slack;
  const TimeUs expected = report.expected_us.value_or(is_there ? agent->arrive_us : usual);
  if (!is_there && expected < soonest - kMeasuredSlackUs) {
    return fmt::format("expects to arrive at {:.0f} s, at {:g} m/s not before {:.0f} s",
                       ToSeconds(expected), agent->speed_m_s, ToSeconds(soonest));
  }
  if (expected > kLatestUs) return "expects to arrive in more than a hundred years";
  const bool as_expected =
      std::abs(expected - agent->arrive_us) <= kMeasuredSlackUs &&
      Distance(report.at, PositionAt(*agent, report.at_us)) <= slack &&
      (!report.range_m ||
       std::abs(*report.range_m - RangeAt(*agent, report.at_us, tasks)) <= slack);
  if (as_expected) return {};
  RestFrom(report.at, report.range_m.value_or(RangeThere(*agent, report.at)), report.at_us, agent);
  agent->arrive_us = std::max(expected, t);  // it would have said so
  if (!IsPair(agent->action)) agent->busy_until_us = agent->arrive_us;
  return {};
}

/// The reported place of a free agent: it stands there.
void Stands(AgentState* agent, const MeasuredReport& report, std::span<const Task> tasks) {
  const double slack = SlackM(*agent), range = RangeAt(*agent, report.at_us, tasks);
  const double way = agent->GoneM(agent->to, report.at);
  if (way <= slack && (!report.range_m || std::abs(*report.range_m - range) <= slack)) return;
  if (agent->kind == AgentKind::kUav) {
    agent->range_at_departure_m = report.range_m.value_or(std::max(0.0, range - way));
  }
  agent->from = agent->to = report.at;
  agent->depart_us = agent->arrive_us = report.at_us;
  if (!agent->not_ready()) agent->busy_until_us = report.at_us;
}

/// A report of an agent that is where it was sent: only the range counts, until sensing or charging
/// begins.
void Waits(AgentState* agent, const MeasuredReport& report, std::span<const Task> tasks) {
  if (!report.range_m || !IsPair(agent->action)) return;
  if (agent->activity && agent->activity->start_us <= report.at_us) return;
  const double range = RangeAt(*agent, agent->arrive_us, tasks);
  if (std::abs(*report.range_m - range) <= SlackM(*agent)) return;
  agent->from = agent->to;
  agent->depart_us = agent->arrive_us;
  agent->range_at_departure_m = *report.range_m;
}

std::string ApplyPlace(AgentState* agent, const MeasuredReport& report, TimeUs t,
                       std::span<const Task> tasks) {
  if (!std::isfinite(report.at.x_m) || !std::isfinite(report.at.y_m)) return "no place";
  const bool is_there = agent->action != ActionKind::kNone && agent->measured->arrived;
  const bool is_busy = is_there && agent->activity && agent->activity->start_us <= report.at_us;
  std::string problem = CheckTime(*agent, report, t);
  if (problem.empty()) problem = CheckSpeed(*agent, report.at, report.at_us);
  if (problem.empty() && report.range_m) {
    // Where a UAV senses it may fly about; its place is that of its task.
    const Point at = is_there ? agent->to : report.at;
    problem = CheckRange(*agent, *report.range_m, at,
                         is_busy && agent->activity->kind == Activity::Kind::kCharging);
  }
  if (!problem.empty()) return problem;
  const Measured::Seen before = agent->measured->seen;
  if (is_there) {
    Waits(agent, report, tasks);
  } else if (IsOnItsWay(*agent)) {
    problem = OnTheWay(agent, report, t, tasks);
  } else {
    Stands(agent, report, tasks);
  }
  if (!problem.empty()) return problem;
  // Without a word range falls by the way at least.
  const double most = std::max(0.0, before.range_m - agent->GoneM(before.at, report.at));
  agent->measured->seen = {report.at, report.at_us, report.range_m.value_or(most)};
  return {};
}

std::string CheckCommand(const AgentState& agent, const MeasuredReport& report) {
  if (agent.action == ActionKind::kNone) return "it has not been sent anywhere";
  if (report.decision == agent.decision) return {};
  return fmt::format("of the command of decision {}, under way is that of {}", report.decision,
                     agent.decision);
}

std::string ApplyArrived(AgentState* agent, const MeasuredReport& report, TimeUs t) {
  t = std::min(t, std::max(report.at_us, agent->measured->seen.at_us));
  std::string problem = CheckCommand(*agent, report);
  if (!problem.empty() || agent->measured->arrived) return problem;
  problem = CheckSpeed(*agent, agent->to, t);
  if (!problem.empty()) return problem;
  HasArrived(agent, t);
  if (!IsPair(agent->action)) agent->busy_until_us = agent->arrive_us;
  return {};
}

std::string ApplyDone(AgentState* agent, const MeasuredReport& report, TimeUs t,
                      std::span<const Task> tasks) {
  std::string problem = CheckCommand(*agent, report);
  if (!problem.empty() || agent->measured->done) return problem;
  if (!agent->measured->arrived || !agent->activity || agent->activity->start_us > t) {
    return "neither sensing nor charging has begun";
  }
  const bool charges = agent->activity->kind == Activity::Kind::kCharging;
  const TimeUs end = std::min(agent->activity->end_us, t);
  // Sensing is done when it is said to be; charging is as full as the time allows.
  const bool is_full = charges && agent->measured->overdue;
  const double computed = is_full ? agent->range_full_m
                                  : RangeAt(*agent, charges ? end : agent->activity->end_us, tasks);
  if (report.range_m) {
    problem = CheckRange(*agent, *report.range_m, agent->to, charges);
    if (problem.empty() && charges && *report.range_m > computed + SlackM(*agent)) {
      problem =
          fmt::format("a range of {:.0f} m, charged can be {:.0f} m", *report.range_m, computed);
    }
    if (!problem.empty()) return problem;
  }
  agent->measured->done = true;
  if (agent->kind != AgentKind::kUav) return {};
  double range = report.range_m.value_or(computed);
  agent->measured->seen.range_m = range;
  // On its way it may have been computed to have less than it said; sensing brings nothing back.
  if (!charges) range = std::min(range, RangeAt(*agent, agent->arrive_us, tasks));
  const bool as_expected = std::abs(range - computed) <= SlackM(*agent);
  if (!as_expected || (charges && end < agent->activity->end_us && !is_full)) {
    agent->measured->range_after_m = range;
  }
  return {};
}

}  // namespace

std::string ApplyReport(AgentState* agent, const MeasuredReport& report, TimeUs t,
                        std::span<const Task> tasks) {
  if (agent->failed) return "it has failed";
  if (!agent->measured) return "it is computed, not measured";
  switch (report.kind) {
    case Kind::kPlace:
      return ApplyPlace(agent, report, t, tasks);
    case Kind::kArrived:
      return ApplyArrived(agent, report, t);
    case Kind::kDone:
      return ApplyDone(agent, report, t, tasks);
    case Kind::kNotReady:
      if (agent->idle(t)) agent->busy_until_us = kNever;
      return {};
    case Kind::kReady:
      if (agent->not_ready()) agent->busy_until_us = t;
      return {};
    case Kind::kFailed:
      return {};
  }
  return {};
}

void HasArrived(AgentState* agent, TimeUs at_us) {
  agent->arrive_us = std::min(agent->arrive_us, at_us);
  Measured::Seen& seen = agent->measured->seen;
  seen = {agent->to, at_us, std::max(0.0, seen.range_m - agent->GoneM(seen.at, agent->to))};
  agent->measured->arrived = true;
  if (at_us >= agent->depart_us) return;
  // What it has told of its way since, and goes on from, does not count.
  agent->from = agent->to;
  agent->depart_us = at_us;
  agent->range_at_departure_m = seen.range_m;
}

void HasNotBegun(AgentState* agent) {
  agent->measured->done = agent->measured->overdue = false;
  agent->measured->range_after_m.reset();
}

void ExpectOnward(AgentState* agent, TimeUs t, TimeUs next_tick_us) {
  if (!agent->measured || agent->failed) return;
  // When its time is over it is not waited for any more.
  if (agent->not_ready() && !agent->online(t)) agent->busy_until_us = t;
  if (agent->action == ActionKind::kNone) return;
  if (IsOnItsWay(*agent)) {
    if (agent->arrive_us <= t) {
      // It is not behind the place that it has told last.
      if (const Measured::Seen& seen = agent->measured->seen; seen.at_us > agent->depart_us) {
        const double range_m = std::min(seen.range_m, RangeOnWayAt(*agent, seen.at_us));
        RestFrom(seen.at, range_m, seen.at_us, agent);
      }
      agent->arrive_us = next_tick_us;
      if (!IsPair(agent->action)) agent->busy_until_us = next_tick_us;
    }
    if (agent->depart_us != agent->measured->set_out_us ||
        agent->arrive_us != agent->measured->planned_us) {
      RestFrom(PositionAt(*agent, t), RangeOnWayAt(*agent, t), t, agent);
    }
    return;
  }
  if (!IsPair(agent->action) || !agent->activity) return;
  if (agent->activity->start_us > t) return HasNotBegun(agent);
  TimeUs& end = agent->activity->end_us;
  if (agent->measured->done) {
    end = std::min(end, t);
  } else if (end <= t) {
    end = next_tick_us;
    agent->measured->overdue = true;
  }
  agent->busy_until_us = end;
}

void SayAsComputed(AgentState* agent, TimeUs t) {
  if (!agent->measured) return;
  if (agent->not_ready()) agent->busy_until_us = t;
  if (agent->action == ActionKind::kNone) return;
  agent->measured->arrived = agent->arrive_us <= t;
  agent->measured->done = IsPair(agent->action) && agent->activity && agent->busy_until_us <= t;
}

bool TellsWholeLeg(const AgentState& agent, TimeUs t) {
  return agent.measured && IsPair(agent.action) && t < agent.arrive_us;
}

void ReadMeasured(Point here, double range_left_m, TimeUs t, const Rules& rules,
                  AgentState* reported) {
  reported->measured.emplace();
  Measured& told = *reported->measured;
  told.seen = told.anchor = {here, t, range_left_m};
  told.origin = reported->from;
  told.set_out_us = reported->depart_us;
  told.planned_us = reported->arrive_us;
  if (reported->action == ActionKind::kNone) return;
  if (!TellsWholeLeg(*reported, t)) {
    told.set_out_us = std::min(reported->depart_us, rules.TimeOfDecision(reported->decision));
    told.arrived = reported->arrive_us <= t;
    told.done = IsPair(reported->action) && told.arrived && reported->busy_until_us <= t;
    if (told.done) told.range_after_m = range_left_m;
    return;
  }
  told.planned_us = reported->depart_us +
                    TravelUs(reported->GoneM(reported->from, reported->to), reported->speed_m_s);
  const bool has_way = !std::isinf(reported->LegM());
  if (!has_way || reported->arrive_us != told.planned_us ||
      Distance(PositionAt(*reported, t), here) > kSamePlace_m) {
    RestFrom(here, range_left_m, t, reported);
  }
}

void NoteLeg(AgentState* agent) {
  Measured::Seen seen = agent->measured->seen;
  seen.range_m = std::max(seen.range_m, agent->range_at_departure_m);  // it may have been charged
  agent->measured = Measured{.seen = seen,
                             .anchor = seen,
                             .origin = agent->from,
                             .set_out_us = agent->depart_us,
                             .planned_us = agent->arrive_us};
}

bool IsOld(const AgentState& agent, const MeasuredReport& report) {
  return report.at_us < std::max(agent.measured->set_out_us, agent.measured->seen.at_us);
}

}  // namespace muster
