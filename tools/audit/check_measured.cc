// Measured agents (docs/reference/mission.md): what they report is told, not computed. It must be
// possible, and the activities that they take part in must begin and end as they say.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/audit/checks.h"

namespace muster::tools::audit {
namespace {

/// Places and times are told to the way of a second, and to a second.
constexpr double kSlack_s = 1;

/// By the straight line: a place that is measured is beside the road now and then.
void CheckWay(const View& view, const AgentModel& model, Place from, Place to, double seconds) {
  const double way = Apart(from, to);
  const double most = model.spec->speed_m_s * (std::max(0.0, seconds) + kSlack_s) + kTolerance_m;
  if (way <= most) return;
  view.Violate("speed",
               "{} says to make {:.3f} m in {:.6g} s, at {:.6g} m/s it is at most {:.3f} m",
               model.name(), way, seconds, model.spec->speed_m_s, most);
}

void CheckRangeTold(const View& view, const AgentModel& model, double range_m, double most_m) {
  if (model.kind != kUav) return;
  if (range_m <= most_m + model.spec->speed_m_s * kSlack_s + kTolerance_m) return;
  view.Violate("range", "{} says to have {:.6g} m of range left, it can be {:.6g} m", model.name(),
               range_m, most_m);
}

/// Between two words of its driver a measured agent is where its way would have it by then. By the
/// driver's word it may arrive sooner than by that way, as the driver may know a shorter one. So
/// where ways bend a place between two words says nothing of its speed.
bool IsBent(const AgentModel& model) { return model.ways->rounding_m(model.kind) > 0; }

void CheckFromAnchor(const View& view, const AgentModel& model, Place at, std::int64_t at_us,
                     double range_m) {
  CheckWay(view, model, model.anchor, at, ToSeconds(at_us - model.anchor_us));
  CheckRangeTold(view, model, range_m,
                 std::max(0.0, model.anchor_range_m - Apart(model.anchor, at)));
}

void Arrive(const View& view, AgentModel* model, const agent_t& a) {
  model->from = model->to = {a.x_m, a.y_m};
  model->depart_us = model->arrive_us;
  model->range_per_m = 1;
  model->way_seen = true;
  double range_m = a.range_left_m;
  if (model->activity && model->activity->start_us < view.now_us &&
      (view.now_us < model->activity->end_us || model->says_done)) {
    const Activity& activity = *model->activity;
    const double part = model->says_done ? 1
                                         : ToSeconds(view.now_us - activity.start_us) /
                                               ToSeconds(activity.end_us - activity.start_us);
    const double full_m = model->spec->range_full_m;
    range_m = activity.senses() ? range_m + part * model->cost_m
              : part < 1        ? (range_m - part * full_m) / (1 - part)
                                : model->RangeOnArrival();
  }
  CheckFromAnchor(view, *model, model->to, model->arrive_us, range_m);
  model->range_at_departure_m = std::max(0.0, range_m);
}

void SeeStanding(const View& view, AgentModel* model, const agent_t& a) {
  const Place here{a.x_m, a.y_m};
  const bool as_computed =
      Apart(model->to, here) <= kTolerance_m &&
      (model->kind != kUav || Near(a.range_left_m, std::max(0.0, model->RangeAt(view.now_us))));
  if (as_computed && model->says_arrived) {
    if (!model->way_seen) Arrive(view, model, a);
    return;
  }
  if (as_computed && !model->goes_on_anew) return;
  // It was there then, and may have moved since. What is no newer than what is known tells no time.
  const bool is_known = model->anchor_us < a.depart_us && a.depart_us <= view.now_us;
  const std::int64_t at_us = is_known ? a.depart_us : view.now_us;
  // Where it was ruled to stop its place is computed: it may have come by another way, with less.
  const bool is_ruled = a.depart_us == model->depart_us;
  if (!is_ruled || !IsBent(*model)) CheckFromAnchor(view, *model, here, at_us, a.range_left_m);
  if (!is_ruled) model->Anchor(here, at_us, a.range_left_m);
  model->from = model->to = here;
  model->depart_us = model->arrive_us = a.depart_us;
  model->busy_until_us = a.busy_until_us;
  model->range_at_departure_m = a.range_left_m;
}

void SeeWind(const View& view, AgentModel* model, const agent_t& a) {
  const double moved = model->MovedAt(view.now_us);
  if (model->way_seen || model->cost_is_hidden || moved <= 0 || a.range_left_m <= 0) return;
  const double factor = (model->range_at_departure_m - a.range_left_m) / moved;
  if (!Within(factor, {1 + view.scenario.wind.low, 1 + view.scenario.wind.high},
              kTolerance_m / moved)) {
    return;  // its own word, not the wind's
  }
  model->range_per_m = factor;
  model->way_seen = true;
}

/// Only what was told bounds its speed where ways bend (IsBent), with the slack of two words.
void CheckRestOfLeg(const View& view, const AgentModel& model, Place here, const agent_t& a) {
  if (!IsBent(model)) {
    CheckFromAnchor(view, model, here, view.now_us, a.range_left_m);
    CheckWay(view, model, here, model.to, ToSeconds(a.arrive_us - view.now_us));
    return;
  }
  CheckWay(view, model, model.anchor, model.to,
           ToSeconds(a.arrive_us - model.anchor_us) + kSlack_s);
}

void SeeLeg(const View& view, AgentModel* model, const agent_t& a) {
  const Place here{a.x_m, a.y_m};
  bool as_computed =
      NearUs(a.arrive_us, model->arrive_us) && Apart(model->At(view.now_us), here) <= kTolerance_m;
  if (as_computed && model->kind == kUav) {
    SeeWind(view, model, a);
    as_computed = !model->way_seen || model->says_done ||
                  Near(a.range_left_m, std::max(0.0, model->RangeAt(view.now_us)));
  }
  if (as_computed && model->says_arrived) {
    // Its word may be a microsecond before what is computed.
    model->arrive_us = a.arrive_us;
    if (!model->pair()) model->busy_until_us = a.arrive_us;
    if (!model->way_seen) Arrive(view, model, a);
    return;
  }
  if (as_computed && !model->goes_on_anew) return;
  if (!model->says_arrived) CheckRestOfLeg(view, *model, here, a);
  model->arrive_us = a.arrive_us;
  if (!model->pair()) model->busy_until_us = a.arrive_us;
  if (model->says_arrived) return Arrive(view, model, a);
  model->goes_on_anew = true;
  model->from = here;
  model->depart_us = view.now_us;
  model->range_at_departure_m = a.range_left_m;
}

void SeeEnd(const View& view, AgentModel* model, const agent_t& a) {
  if (!model->activity || model->activity->start_us > view.now_us) return;
  if (a.busy_until_us != model->busy_until_us) {
    const bool is_done = a.busy_until_us == view.now_us && view.now_us < model->busy_until_us;
    const bool goes_on =
        a.busy_until_us == view.NextTickUs() && model->busy_until_us <= view.now_us;
    if (!is_done && !goes_on) return;  // CheckMotion says so
    model->overdue = model->overdue || goes_on;
    if (is_done && !model->activity->senses() && !model->overdue) {
      CheckRangeTold(view, *model, a.range_left_m, model->RangeAt(view.now_us));
    }
    model->activity->end_us = model->busy_until_us = a.busy_until_us;
  }
  model->range_after_m.reset();
  if (!model->says_done || model->kind != kUav) return;
  const Activity& activity = *model->activity;
  CheckRangeTold(view, *model, a.range_left_m,
                 activity.senses() ? model->RangeOnArrival() : model->spec->range_full_m);
  model->range_after_m = a.range_left_m;
}

/// An agent without anything to do may say that it cannot set out yet, and that it can.
void SeeReadiness(const View& view, AgentModel* model, const agent_t& a) {
  if (model->failed || model->action != ActionKind::kNone || a.action != ActionKind::kNone) return;
  const bool was_ready = model->busy_until_us != kForever;
  const bool is_ready = a.busy_until_us != kForever;
  if (was_ready == is_ready || (is_ready && a.busy_until_us > view.now_us)) return;
  model->busy_until_us = a.busy_until_us;
}

}  // namespace

agent_t SeeTold(View& view, AgentModel* model, agent_t a) {
  model->says_arrived = a.action != ActionKind::kNone && a.arrive_us <= view.now_us;
  model->says_done = model->pair() && model->says_arrived && a.busy_until_us <= view.now_us;
  if (a.status == AgentStatus::kFailed && !model->failed) {
    view.said_failed.insert({model->kind, model->id});
  }
  SeeEnd(view, model, a);
  SeeReadiness(view, model, a);
  if (model->action == ActionKind::kNone) {
    SeeStanding(view, model, a);
  } else if (!model->activity || model->activity->start_us > view.before_us) {
    SeeLeg(view, model, a);
  }
  if (view.said_failed.contains({model->kind, model->id})) {
    a.status = static_cast<std::int8_t>(model->StatusAt(view.now_us));
  }
  return a;
}

const Report* TakenReport(View& view, int kind, int id) {
  const auto candidates = [&](int of_kind, int of) {
    std::vector<const Report*> all;
    const auto& first = view.said->reports[of_kind][static_cast<std::size_t>(of)];
    if (first) all.push_back(&*first);
    const auto again = view.said->again.find({of_kind, of});
    if (again == view.said->again.end()) return all;
    for (const Report& report : again->second) all.push_back(&report);
    return all;
  };
  const std::vector<const Report*> all = candidates(kind, id);
  if (all.size() < 2 || !view.Model(kind, id).spec->measured) {
    return all.empty() ? nullptr : all.front();
  }
  const auto arrives_us = [&](const Report& report) {
    return report.base_tick < 0 ? report.agent.arrive_us
                                : view.Model(report.kind, report.agent.id).arrive_us;
  };
  // One that is not done yet is busy until the next tick, which the world takes for the end.
  const auto ends_us = [&](const Report& report) {
    return report.base_tick < 0 ? report.agent.busy_until_us
                                : view.Model(report.kind, report.agent.id).busy_until_us;
  };
  for (const activity_t& wire : view.said->world->activities) {
    const Activity activity = FromWire(wire);
    if (!activity.involves(kind, id)) continue;
    const int other = kind == kUav ? activity.partner : activity.uav;
    // The newest that fits the start, and if there is one, the end too.
    const Report* fits = nullptr;
    for (auto word = all.rbegin(); word != all.rend(); ++word) {
      const Report* const report = *word;
      for (const Report* of_other :
           candidates(kind == kUav ? activity.partner_class() : kUav, other)) {
        const std::int64_t start_us = std::max(arrives_us(*report), arrives_us(*of_other));
        const std::int64_t end_us = std::max(ends_us(*report), ends_us(*of_other));
        if (!NearUs(start_us, activity.start_us)) continue;
        if (NearUs(end_us, activity.end_us)) return report;
        if (fits == nullptr) fits = report;
      }
    }
    if (fits != nullptr) return fits;
  }
  // A restarted process asks the world: had that heard its first word, it would have said it again.
  return all.back();
}

void FollowWaysAsTold(const View& view, AgentModel* model, const agent_t& a) {
  const bool arrives = a.action != ActionKind::kNone && a.arrive_us <= view.now_us;
  if (model->says_arrived || arrives) return;
  const Place here{a.x_m, a.y_m};
  const bool stops = a.action == ActionKind::kNone;
  if (!stops && !(model->pair() && a.depart_us == view.now_us)) {
    // It goes on, by the ways of the present as far as it is computed.
    model->goes_on_anew = true;
    const double planned_m = model->ways->Gone(model->kind, model->origin, model->to);
    model->planned_us = model->set_out_us + DurationUs(planned_m, model->spec->speed_m_s);
    return;
  }
  if (!IsBent(*model)) CheckFromAnchor(view, *model, here, view.now_us, a.range_left_m);
  model->range_at_departure_m = a.range_left_m;
  model->from = here;
  const double rest_m = model->WayM(here, model->to);
  if (stops && std::isfinite(rest_m)) {
    view.Violate("motion", "{} stops, though {:.3f} m of way lead it to its place", model->name(),
                 rest_m);
  }
  model->arrive_us = model->depart_us = view.now_us;
  model->GoRound(*model->ways, here, view.now_us);
}

void CheckMoved(View& view, Tracked* tracked, const Activity& listed) {
  const Activity before = std::exchange(tracked->activity, listed);
  const auto members = view.MembersOf(listed);
  const AgentModel &uav = *members[0], &partner = *members[1];
  const bool begun = before.start_us <= view.before_us;
  Activity expected = before;
  const auto has_stopped = [](const AgentModel& m) { return m.action == ActionKind::kNone; };
  // The world has not heard that it stopped: its process is lost.
  const auto unheard = [&](const AgentModel& m) { return has_stopped(m) && m.unheard != nullptr; };
  // Nor that it goes round.
  const auto as_heard = [](const AgentModel& m) -> const AgentModel& {
    return m.unheard != nullptr ? *m.unheard : m;
  };
  if (begun || unheard(uav) || unheard(partner)) {
    // As it was.
  } else if (has_stopped(uav) || has_stopped(partner)) {
    expected.start_us = expected.end_us = kForever;
  } else {
    const double range_m = std::max(0.0, as_heard(uav).RangeOnArrival());
    expected.start_us = std::max(as_heard(uav).arrive_us, as_heard(partner).arrive_us);
    expected.end_us = expected.start_us + view.DurationOf(listed, range_m);
  }
  if (listed.start_us == kForever && (uav.RangeOnArrival() < -1e-6 || !uav.way_seen)) {
    expected.start_us = expected.end_us = kForever;  // a UAV that is computed does not get there
  }
  if (expected.start_us <= view.now_us) {
    const auto says_done = [](const AgentModel& m) { return !m.spec->measured || m.says_done; };
    if (says_done(uav) && says_done(partner)) {
      expected.end_us = std::min(expected.end_us, view.now_us);
    } else if (expected.end_us <= view.now_us) {
      expected.end_us = view.NextTickUs();
    }
  }
  // Without a look at the wind it is not known how full the UAV arrives.
  const bool end_is_known = begun || listed.senses() || uav.way_seen;
  if (!NearUs(listed.start_us, expected.start_us) ||
      (end_is_known && !NearUs(listed.end_us, expected.end_us))) {
    view.Violate(std::string(ToString(listed.kind)),
                 "{}: expected in [{}, {}] us, as its agents say", Name(listed), expected.start_us,
                 expected.end_us);
  }
  for (AgentModel* member : members) {
    // It is told so with this verdict.
    if (!member->activity || member->activity->site != listed.site) continue;
    member->activity = listed;
    member->busy_until_us = listed.end_us;
    if (listed.start_us > view.now_us) member->range_after_m.reset();  // it has not begun after all
  }
}

/// Whether a UAV that has just set out anew can make its way, its work and the way on to charge. As
/// long as no report has told the wind, and the wind decides, that is as the world says.
bool HasRangeFor(const View& view, const Activity& activity, const AgentModel& uav) {
  const double way_m = uav.leg_ways->Length(kUav, uav.from, uav.to);
  const auto& tasks = view.scenario.tasks;
  const double more_m = !activity.senses()
                            ? 0
                            : tasks[static_cast<std::size_t>(activity.site)].cost_m +
                                  tasks[static_cast<std::size_t>(activity.site)].to_charge_m;
  const auto suffices = [&](double range_per_m) {
    return range_per_m * way_m + more_m <= uav.range_at_departure_m + kTolerance_m;
  };
  const auto& wind = view.scenario.wind;
  if (uav.way_seen || suffices(1 + wind.low) == suffices(1 + wind.high)) {
    return suffices(uav.way_seen ? uav.range_per_m : 1 + wind.low);
  }
  return !view.released.contains({kUav, activity.uav});
}

/// Whether what the tick's orders close keeps one of the pair from its place, or lets it come too
/// late or with too little range.
bool IsBarred(View& view, const Activity& activity) {
  if (!view.ways_since_us || activity.start_us <= view.now_us) return false;
  const auto [uav, partner] = view.MembersOf(activity);
  if (uav->failed || partner->failed) return false;
  const bool runs_dry = activity.start_us == kForever;
  if (partner->action == ActionKind::kNone || uav->action == ActionKind::kNone) return true;
  const bool partner_anew = partner->set_out_us == view.now_us;
  const bool uav_anew = uav->set_out_us == view.now_us;
  if (uav_anew && !HasRangeFor(view, activity, *uav)) return true;
  return !runs_dry && (partner_anew || uav_anew) &&
         activity.end_us > std::min(view.LatestEnd(*uav), view.LatestEnd(*partner));
}

std::int64_t GivenUpAt(View& view, const Activity& activity) {
  if (IsBarred(view, activity)) return view.now_us;
  if (!view.IsMeasured(activity) || activity.start_us <= view.now_us) return kForever;
  std::int64_t planned_us = 0;
  for (const AgentModel* member : view.MembersOf(activity)) {
    const bool is_late = member->spec->measured && !member->says_arrived;
    planned_us = std::max(planned_us, is_late ? member->planned_us : member->arrive_us);
  }
  const std::int64_t at = std::max(planned_us + view.scenario.patience_us, view.before_us + 1);
  // Of two roundings of a way the world's.
  const auto released = view.released.find({kUav, activity.uav});
  if (released != view.released.end()) {
    const AgentModel& uav = view.Model(kUav, activity.uav);
    const AgentModel& partner = view.Model(activity.partner_class(), activity.partner);
    if (std::abs(released->second - at) <= std::max(uav.RoundingUs(), partner.RoundingUs())) {
      return released->second;
    }
  }
  return at <= view.now_us ? at : kForever;
}

void CheckSaidFailed(View& view) {
  for (const AgentKey& agent : view.said_failed) {
    if (view.failed.contains(agent)) continue;
    view.Violate("rulings", "{} says that it cannot go on, and is not ruled to have failed",
                 view.Model(agent.first, agent.second).name());
  }
  view.said_failed.clear();
}

}  // namespace muster::tools::audit
