// Measured agents (docs/reference/mission.md): what they report is told, not computed. It must be
// possible, and the activities that they take part in must begin and end as they say.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/audit/auditor.h"
#include "tools/audit/values.h"

namespace muster::tools::audit {
namespace {

/// Places and times are told to the way of a second, and to a second.
constexpr double kSlack_s = 1;

double Seconds(std::int64_t us) { return static_cast<double>(us) * 1e-6; }

}  // namespace

std::int64_t Auditor::NextTickUs() const {
  return now_us_ < scenario_->limit_us ? scenario_->TimeOf(next_tick_ + 1)
                                       : now_us_ + scenario_->tick_us;
}

agent_t Auditor::SeeTold(AgentModel* model, agent_t a) {
  model->says_arrived = a.action != ActionKind::kNone && a.arrive_us <= now_us_;
  model->says_done = model->pair() && model->says_arrived && a.busy_until_us <= now_us_;
  if (a.status == AgentStatus::kFailed && !model->failed) {
    said_failed_.insert({model->kind, model->id});
  }
  SeeEnd(model, a);
  if (model->action == ActionKind::kNone) {
    SeeStanding(model, a);
  } else if (!model->activity || model->activity->start_us > before_us_) {
    SeeLeg(model, a);
  }
  if (said_failed_.contains({model->kind, model->id})) {
    a.status = static_cast<std::int8_t>(model->StatusAt(now_us_));
  }
  return a;
}

void Auditor::CheckWay(const AgentModel& model, Place from, Place to, double seconds) {
  const double way = model.WayM(from, to);
  const double most = model.spec->speed_m_s * (std::max(0.0, seconds) + kSlack_s) + kTolerance_m;
  if (way <= most) return;
  Violate(now_us_, "speed",
          fmt::format("{} says to make {:.3f} m in {:.6g} s, at {:.6g} m/s it is at most {:.3f} m",
                      model.name(), way, seconds, model.spec->speed_m_s, most));
}

void Auditor::CheckRangeTold(const AgentModel& model, double range_m, double most_m) {
  if (model.kind != kUav) return;
  if (range_m <= most_m + model.spec->speed_m_s * kSlack_s + kTolerance_m) return;
  Violate(now_us_, "range",
          fmt::format("{} says to have {:.6g} m of range left, it can be {:.6g} m", model.name(),
                      range_m, most_m));
}

void Auditor::CheckFromAnchor(const AgentModel& model, Place at, std::int64_t at_us,
                              double range_m) {
  CheckWay(model, model.anchor, at, Seconds(at_us - model.anchor_us));
  CheckRangeTold(model, range_m,
                 std::max(0.0, model.anchor_range_m - model.WayM(model.anchor, at)));
}

void Auditor::SeeStanding(AgentModel* model, const agent_t& a) {
  const Place here{a.x_m, a.y_m};
  const bool as_computed =
      Apart(model->to, here) <= kTolerance_m &&
      (model->kind != kUav || Near(a.range_left_m, std::max(0.0, model->RangeAt(now_us_))));
  if (as_computed && model->says_arrived) {
    if (!model->way_seen) Arrive(model, a);
    return;
  }
  if (as_computed && !model->goes_on_anew) return;
  CheckFromAnchor(*model, here, now_us_, a.range_left_m);
  model->Anchor(here, now_us_, a.range_left_m);
  model->from = model->to = here;
  model->depart_us = model->arrive_us = a.depart_us;
  model->busy_until_us = a.busy_until_us;
  model->range_at_departure_m = a.range_left_m;
}

void Auditor::SeeLeg(AgentModel* model, const agent_t& a) {
  const Place here{a.x_m, a.y_m};
  bool as_computed =
      NearUs(a.arrive_us, model->arrive_us) && Apart(model->At(now_us_), here) <= kTolerance_m;
  if (as_computed && model->kind == kUav) {
    SeeWind(model, a);
    as_computed = !model->way_seen || model->says_done ||
                  Near(a.range_left_m, std::max(0.0, model->RangeAt(now_us_)));
  }
  if (as_computed && model->says_arrived) {
    if (!model->way_seen) Arrive(model, a);
    return;
  }
  if (as_computed && !model->goes_on_anew) return;
  if (!model->says_arrived) {
    CheckFromAnchor(*model, here, now_us_, a.range_left_m);
    CheckWay(*model, here, model->to, Seconds(a.arrive_us - now_us_));
  }
  model->arrive_us = a.arrive_us;
  if (!model->pair()) model->busy_until_us = a.arrive_us;
  if (model->says_arrived) return Arrive(model, a);
  model->goes_on_anew = true;
  model->from = here;
  model->depart_us = now_us_;
  model->range_at_departure_m = a.range_left_m;
}

void Auditor::Arrive(AgentModel* model, const agent_t& a) {
  model->from = model->to = {a.x_m, a.y_m};
  model->depart_us = model->arrive_us;
  model->range_per_m = 1;
  model->way_seen = true;
  double range_m = a.range_left_m;
  if (model->activity && model->activity->start_us < now_us_ && now_us_ < model->activity->end_us) {
    const Activity& activity = *model->activity;
    const double part = model->says_done ? 1
                                         : Seconds(now_us_ - activity.start_us) /
                                               Seconds(activity.end_us - activity.start_us);
    const double full_m = model->spec->range_full_m;
    range_m = activity.senses() ? range_m + part * model->cost_m
              : part < 1        ? (range_m - part * full_m) / (1 - part)
                                : model->RangeOnArrival();
  }
  CheckFromAnchor(*model, model->to, model->arrive_us, range_m);
  model->range_at_departure_m = std::max(0.0, range_m);
}

void Auditor::SeeWind(AgentModel* model, const agent_t& a) {
  const double moved = model->MovedAt(now_us_);
  if (model->way_seen || model->cost_is_hidden || moved <= 0 || a.range_left_m <= 0) return;
  const double factor = (model->range_at_departure_m - a.range_left_m) / moved;
  if (!Within(factor, {1 + scenario_->wind.low, 1 + scenario_->wind.high}, kTolerance_m / moved)) {
    return;  // its own word, not the wind's
  }
  model->range_per_m = factor;
  model->way_seen = true;
}

void Auditor::SeeEnd(AgentModel* model, const agent_t& a) {
  if (!model->activity || model->activity->start_us > now_us_) return;
  if (a.busy_until_us != model->busy_until_us) {
    const bool is_done = a.busy_until_us == now_us_ && now_us_ < model->busy_until_us;
    const bool goes_on = a.busy_until_us == NextTickUs() && model->busy_until_us <= now_us_;
    if (!is_done && !goes_on) return;  // CheckMotion says so
    model->overdue = model->overdue || goes_on;
    if (is_done && !model->activity->senses() && !model->overdue) {
      CheckRangeTold(*model, a.range_left_m, model->RangeAt(now_us_));
    }
    model->activity->end_us = model->busy_until_us = a.busy_until_us;
  }
  model->range_after_m.reset();
  if (!model->says_done || model->kind != kUav) return;
  const Activity& activity = *model->activity;
  CheckRangeTold(*model, a.range_left_m,
                 activity.senses() ? model->RangeOnArrival() : model->spec->range_full_m);
  model->range_after_m = a.range_left_m;
}

bool Auditor::IsMeasured(const Activity& activity) {
  return Model(kUav, activity.uav).spec->measured ||
         Model(activity.partner_class(), activity.partner).spec->measured;
}

void Auditor::CheckMoved(Tracked* tracked, const Activity& listed) {
  const Activity before = std::exchange(tracked->activity, listed);
  AgentModel& uav = Model(kUav, listed.uav);
  AgentModel& partner = Model(listed.partner_class(), listed.partner);
  const bool begun = before.start_us <= before_us_;
  Activity expected = before;
  if (!begun) {
    expected.start_us = std::max(uav.arrive_us, partner.arrive_us);
    expected.end_us =
        expected.start_us +
        (listed.senses()
             ? DurationUs(scenario_->tasks[static_cast<std::size_t>(listed.site)].cost_m,
                          uav.spec->speed_m_s)
             : DurationUs(uav.spec->range_full_m - std::max(0.0, uav.RangeOnArrival()),
                          partner.spec->charge_rate_m_s));
  }
  if (listed.start_us == kForever && (uav.RangeOnArrival() < -1e-6 || !uav.way_seen)) {
    expected.start_us = expected.end_us = kForever;  // a UAV that is computed does not get there
  }
  if (expected.start_us <= now_us_) {
    const auto says_done = [](const AgentModel& m) { return !m.spec->measured || m.says_done; };
    if (says_done(uav) && says_done(partner)) {
      expected.end_us = std::min(expected.end_us, now_us_);
    } else if (expected.end_us <= now_us_) {
      expected.end_us = NextTickUs();
    }
  }
  // Without a look at the wind it is not known how full the UAV arrives.
  const bool end_is_known = begun || listed.senses() || uav.way_seen;
  if (!NearUs(listed.start_us, expected.start_us) ||
      (end_is_known && !NearUs(listed.end_us, expected.end_us))) {
    Violate(now_us_, std::string(ToString(listed.kind)),
            fmt::format("{}: expected in [{}, {}] us, as its agents say", Name(listed),
                        expected.start_us, expected.end_us));
  }
  for (AgentModel* member : {&uav, &partner}) {
    // It is told so with this verdict.
    if (!member->activity || member->activity->site != listed.site) continue;
    member->activity = listed;
    member->busy_until_us = listed.end_us;
    if (listed.start_us > now_us_) member->range_after_m.reset();  // it has not begun after all
  }
}

std::int64_t Auditor::GivenUpAt(const Activity& activity) {
  if (!IsMeasured(activity) || activity.start_us <= now_us_) return kForever;
  std::int64_t planned_us = 0;
  for (const AgentModel* member :
       {&Model(kUav, activity.uav), &Model(activity.partner_class(), activity.partner)}) {
    const bool is_late = member->spec->measured && !member->says_arrived;
    planned_us = std::max(planned_us, is_late ? member->planned_us : member->arrive_us);
  }
  const std::int64_t at = std::max(planned_us + scenario_->patience_us, before_us_ + 1);
  return at <= now_us_ ? at : kForever;
}

void Auditor::CheckSaidFailed() {
  for (const AgentKey& agent : said_failed_) {
    if (failed_.contains(agent)) continue;
    Violate(now_us_, "rulings",
            fmt::format("{} says that it cannot go on, and is not ruled to have failed",
                        Model(agent.first, agent.second).name()));
  }
  said_failed_.clear();
}

}  // namespace muster::tools::audit
