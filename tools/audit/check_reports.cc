// What each agent reports of a tick, against its command and its own arithmetic.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/audit/checks.h"
#include "tools/audit/unlisted.h"

namespace muster::tools::audit {
namespace {

void CheckSpec(const View& view, const AgentModel& model, const agent_t& a) {
  const auto expect = [&](const char* field, double found, double expected) {
    if (std::abs(found - expected) <= 1e-12 * std::abs(expected)) return;
    view.Violate("scenario", "{} reports {} {:.17g}, the scenario says {:.17g}", model.name(),
                 field, found, expected);
  };
  expect("speed_m_s", a.speed_m_s, model.spec->speed_m_s);
  expect("range_full_m", a.range_full_m, model.spec->range_full_m);
  expect("charge_rate_m_s", a.charge_rate_m_s, model.spec->charge_rate_m_s);
  const auto expect_us = [&](const char* field, std::int64_t found, std::int64_t expected) {
    if (found == expected) return;
    view.Violate("scenario", "{} reports {} {}, the scenario says {}", model.name(), field, found,
                 expected);
  };
  expect_us("online_from_us", a.online_from_us, model.spec->online_from_us);
  expect_us("online_until_us", a.online_until_us, model.spec->online_until_us);
}

/// Which of two roundings is right does not matter; what follows rests on the reported one.
void TakeRoundedArrival(AgentModel* model, const agent_t& a) {
  if (std::abs(model->arrive_us - a.arrive_us) <= model->RoundingUs()) {
    model->arrive_us = a.arrive_us;
  }
}

void CheckCommunication(const View& view, const AgentModel& model, double cost_m) {
  if (model.spec->measured || Within(cost_m, view.scenario.communication_m, kTolerance_m)) return;
  view.Violate("range", "{} paid {:.6g} m to communicate, expected {:.6g} to {:.6g} m",
               model.name(), cost_m, view.scenario.communication_m.low,
               view.scenario.communication_m.high);
}

void ResolveCommand(View& view, AgentModel* model, const agent_t& a) {
  const auto found = view.commands.find({model->kind, model->id});
  if (found == view.commands.end()) return;
  const Command command = found->second;
  view.commands.erase(found);
  const action_t& action = command.action;
  const bool pair = action.kind == ActionKind::kSense || action.kind == ActionKind::kCharge;
  const bool begins =
      model->spec->measured ? a.decision == command.decision : a.depart_us == command.at_us;
  // Roads or zones that are new right after it may have sent it round, or stopped it.
  const bool goes_round = view.ways_since_us && a.depart_us == view.now_us;
  const bool obeys = (a.action == action.kind && begins) || goes_round;
  if (!obeys && command.by_itself) return;
  if (!obeys && pair && view.scenario.match_failure.high > 0) {
    // The match failed; its event is looked for at the end.
    const bool sense = action.kind == ActionKind::kSense;
    view.Expect(command.at_us, EventKind::kMatchFailed,
                Activity{sense ? ActivityKind::kSensing : ActivityKind::kCharging, action.uav_id,
                         sense ? action.worker_id : action.vehicle_id,
                         sense ? action.task_id : action.charge_id, 0, 0});
    return;
  }
  const auto [goal, stop] = action.kind == ActionKind::kGoTo
                                ? model->ways->StopNear(model->kind, {action.x_m, action.y_m})
                                : std::pair(Place{action.x_m, action.y_m}, -1);
  const double way_m = model->WayM(model->to, goal);
  if (!obeys && std::isinf(way_m)) return;  // no way leads there
  if (!obeys) {
    view.Violate("obedience", "{} did not begin {} of decision {}", model->name(), Name(action),
                 command.decision);
    return;
  }
  double range_m = model->range_at_departure_m;
  const bool tells_departure = a.depart_us == command.at_us;
  model->cost_is_hidden = view.scenario.communication_m.high > 0 && !tells_departure;
  if (model->kind == kUav && view.scenario.communication_m.high > 0 && tells_departure) {
    if (a.range_at_departure_m > 0) {
      CheckCommunication(view, *model, range_m - a.range_at_departure_m);
    }
    range_m = std::min(range_m, a.range_at_departure_m);
  }
  // Of two roundings the reported one: what follows is computed from it.
  if (model->kind == kUav && tells_departure && Near(range_m, a.range_at_departure_m)) {
    range_m = a.range_at_departure_m;
  }
  model->from = model->to;
  model->to = goal;
  model->leg_ways = model->ways;
  model->depart_us = command.at_us;
  // A measured agent says itself when it arrives.
  const auto cleared = view.cleared.find(model->id);
  const bool holds = model->kind == kUav && !model->spec->measured && cleared != view.cleared.end();
  model->hold_us = holds ? std::max<std::int64_t>(0, cleared->second.begin_us - command.at_us) : 0;
  model->arrive_us = command.at_us + model->hold_us + DurationUs(way_m, model->spec->speed_m_s);
  TakeRoundedArrival(model, a);
  model->range_at_departure_m = range_m;
  model->range_per_m = 1;
  model->way_seen = model->kind != kUav || view.scenario.wind.high <= 0;
  model->action = static_cast<ActionKind>(action.kind);
  model->target = action.task_id >= 0     ? action.task_id
                  : action.charge_id >= 0 ? action.charge_id
                                          : stop;
  model->partner = !pair                               ? -1
                   : model->kind != kUav               ? action.uav_id
                   : action.kind == ActionKind::kSense ? action.worker_id
                                                       : action.vehicle_id;
  model->decision = command.decision;
  model->activity.reset();
  model->busy_until_us = pair ? kForever : model->arrive_us;
  model->origin = model->from;
  model->set_out_us = model->depart_us;
  model->planned_us = model->arrive_us;
  model->range_after_m.reset();
  model->goes_on_anew = model->says_arrived = model->says_done = false;
}

/// The wind on a leg is known from the first report of it.
void SeeFactor(const View& view, AgentModel* model, double spent_m, double moved_m) {
  if (model->way_seen || moved_m <= 0) return;
  model->range_per_m = spent_m / moved_m;
  model->way_seen = true;
  if (!Within(model->range_per_m, {1 + view.scenario.wind.low, 1 + view.scenario.wind.high},
              kTolerance_m / moved_m)) {
    view.Violate("range",
                 "{} spent {:.6g} m of range on {:.6g} m of way, wind allows a factor of "
                 "{:.6g} to {:.6g}",
                 model->name(), spent_m, moved_m, 1 + view.scenario.wind.low,
                 1 + view.scenario.wind.high);
  }
}

void SeeWay(const View& view, AgentModel* model, const agent_t& a) {
  if (a.range_left_m <= 0) return;
  SeeFactor(view, model, model->range_at_departure_m - a.range_left_m, model->MovedAt(view.now_us));
}

/// Roads are closed or opened, or zones added or lifted, at this tick, before the agent reports it.
/// `report`: null: it has none.
void FollowWays(const View& view, AgentModel* model, const agent_t* report) {
  if (!view.ways_since_us) return;
  const Ways& now = *view.scenario.ways;
  const bool under_way = model->action != ActionKind::kNone && !model->failed;
  if (model->spec->measured && report != nullptr) {
    const double on_arrival_m = model->RangeOnArrival();
    model->ways = model->leg_ways = &now;
    if (under_way && model->says_arrived) {
      // What it used on its way does not depend on the ways of the present.
      model->from = model->to;
      model->range_at_departure_m = on_arrival_m;
    }
    if (under_way) FollowWaysAsTold(view, model, *report);
    return;
  }
  const Ways& before =
      *std::exchange(model->leg_ways, under_way && !model->spec->measured ? model->leg_ways : &now);
  model->ways = &now;
  // A road may be closed since before, a zone is not.
  const std::int64_t since_us = model->kind == kUav ? view.now_us : *view.ways_since_us;
  const bool has_arrived =
      model->spec->measured ? model->says_arrived : model->arrive_us <= since_us;
  if (!under_way || has_arrived || model->arrive_us <= model->depart_us) return;
  const std::int64_t begin_us = model->depart_us + model->hold_us;
  const auto duration = static_cast<double>(model->arrive_us - begin_us);
  const auto part = before.MeetsAt(model->kind, model->from, model->to, model->PartAt(since_us),
                                   view.scenario.ClosedRoads(), now);
  if (!part) return;
  const bool stands_before =
      !model->spec->measured &&
      static_cast<double>(begin_us) + *part * duration < static_cast<double>(view.now_us);
  const double here_part = stands_before ? *part : model->PartAt(view.now_us);
  Place here = before.After(model->kind, model->from, model->to, here_part);
  // Of two roundings the reported one.
  if (report != nullptr && Apart(here, {report->x_m, report->y_m}) <= now.rounding_m(model->kind)) {
    here = {report->x_m, report->y_m};
  }
  if (report == nullptr && model->unheard == nullptr) {
    model->unheard = std::make_shared<const AgentModel>(*model);
  }
  if (model->kind == kUav) {
    const double gone_m = before.Length(kUav, model->from, model->to) * here_part;
    double& range_m = model->range_at_departure_m;
    const bool is_told = report != nullptr && report->range_left_m > 0 &&
                         (!model->way_seen || model->cost_is_hidden);
    if (is_told && !model->cost_is_hidden) {
      SeeFactor(view, model, range_m - report->range_left_m, gone_m);
    }
    if (is_told && model->cost_is_hidden && model->way_seen) {
      CheckCommunication(view, *model,
                         range_m - model->range_per_m * gone_m - report->range_left_m);
    }
    range_m = is_told ? report->range_left_m : std::max(0.0, range_m - model->range_per_m * gone_m);
    if (is_told) model->cost_is_hidden = false;
  }
  model->GoRound(now, here, view.now_us);
  if (report != nullptr) TakeRoundedArrival(model, *report);
  model->planned_us = model->arrive_us;
  if (!model->pair()) model->busy_until_us = model->arrive_us;
}

void CheckMotion(const View& view, const AgentModel& model, const agent_t& a) {
  const auto differs = [&]<class... T>(const char* invariant, fmt::format_string<T...> what,
                                       T&&... values) {
    view.Violate(invariant, "{} ({} since decision {}): {}", model.name(),
                 model.action == ActionKind::kNone ? "free" : ToString(model.action),
                 model.decision, fmt::format(what, std::forward<T>(values)...));
  };
  const Place expected = model.At(view.now_us);
  if (Apart(expected, {a.x_m, a.y_m}) > kTolerance_m + model.ways->rounding_m(model.kind)) {
    differs("motion", "is at ({:.3f}, {:.3f}) m, its way leads it to ({:.3f}, {:.3f}) m", a.x_m,
            a.y_m, expected.x_m, expected.y_m);
    return;
  }
  if (a.action != model.action) {
    differs("motion", "reports action {}, expected {}", ToString<ActionKind>(a.action),
            ToString(model.action));
  }
  if (a.action != ActionKind::kNone &&
      (a.target_id != model.target || a.partner_id != model.partner)) {
    differs("motion", "reports target {} and partner {}, expected {} and {}", a.target_id,
            a.partner_id, model.target, model.partner);
  }
  // A measured agent's leg is told as it began, or as it goes on.
  const bool departs = model.spec->measured || NearUs(a.depart_us, model.depart_us);
  if (!departs || !NearUs(a.arrive_us, model.arrive_us)) {
    differs("speed", "reports a way of {:.3f} m in [{}, {}] us, at {:.6g} m/s it is [{}, {}] us",
            model.WayM(model.from, model.to), a.depart_us, a.arrive_us, model.spec->speed_m_s,
            model.depart_us, model.arrive_us);
  }
  if (!NearUs(a.busy_until_us, model.busy_until_us)) {
    differs("motion", "reports to be busy until {} us, expected {} us", a.busy_until_us,
            model.busy_until_us);
  }
  const AgentStatus status = model.StatusAt(view.now_us);
  if (a.status != status) {
    differs("motion", "reports to be {}, expected {}", ToString<AgentStatus>(a.status),
            ToString(status));
  }
  if (model.kind != kUav) return;
  if (model.way_seen && !Near(a.range_left_m, std::max(0.0, model.RangeAt(view.now_us)))) {
    differs("range", "reports {:.6f} m of range left, expected {:.6f} m", a.range_left_m,
            model.RangeAt(view.now_us));
  }
}

}  // namespace

ReportCheck::ReportCheck(const View& view) {
  for (const int kind : kClasses) told_[kind].resize(view.agents[kind].size());
}

void ReportCheck::TakeLate(View& view, const std::vector<Report>& reports) {
  for (const Report& report : reports) {
    const std::optional<agent_t> said = Read(view, report);
    if (said && report.kind == kUav) NoteUav(view, report.tick, *said);
  }
}

std::optional<agent_t> ReportCheck::Read(const View& view, const Report& report) {
  Told& told = told_[report.kind][static_cast<std::size_t>(report.agent.id)];
  const std::int64_t t = view.scenario.TimeOf(report.tick);
  if (report.base_tick < 0) {
    if (report.tick > told.tick) told = {report.agent, t, report.tick};
    return report.agent;
  }
  if (told.tick < report.base_tick || told.tick > report.tick) return {};
  told.tick = report.tick;
  return Unlisted(told.agent, report.kind, told.at_us, t, view.scenario);
}

void ReportCheck::NoteUav(View& view, std::int64_t tick, const agent_t& a) {
  Flown& uav = view.flown[static_cast<std::size_t>(a.id)];
  // The report of the tick at which it is ruled to have failed runs ahead of its failure.
  if (failing_.contains({tick, a.id}) || tick <= uav.tick) return;
  const Place here{a.x_m, a.y_m};
  if (uav.seen) {
    // It set out by the zones of that time, also where it has failed at once as one was added.
    const std::int64_t since_us = view.scenario.TimeOf(uav.tick);
    uav.flown_m += view.scenario.WaysAt(since_us).Gone(kUav, *uav.seen, here);
  }
  uav.seen = here;
  uav.range_m = a.range_left_m;
  uav.tick = tick;
}

void ReportCheck::Check(View& view) {
  const TickFacts& said = *view.said;
  // What a process says while it is lost does not count.
  std::set<AgentKey> unheard;
  for (const ruling_t& r : said.rulings->rulings) {
    if (r.kind == RulingKind::kLost) {
      unheard.insert({r.agent_kind, r.agent_id});
    }
    if (r.agent_kind == kUav && r.kind != RulingKind::kReleased && r.at_us > view.before_us) {
      failing_.insert({view.tick, r.agent_id});
    }
  }
  for (const int kind : kClasses) {
    for (AgentModel& model : view.agents[kind]) {
      const Report* const report = TakenReport(view, kind, model.id);
      const std::optional<agent_t> told =
          report != nullptr ? Read(view, *report) : std::optional<agent_t>();
      if (report != nullptr && !told) {
        view.Violate("lockstep",
                     "{} has not changed since tick {}, says {}, which has not been told",
                     model.name(), report->base_tick, report->sender);
      } else if (report != nullptr && !unheard.contains({kind, model.id})) {
        CheckReport(view, &model, *told, report->applied_decision);
      } else {
        // A UAV flew to where its lost process says, in time or late.
        if (told && kind == kUav) NoteUav(view, view.tick, *told);
        // Of a lost process: what it did is not known.
        const bool commanded = view.commands.erase({kind, model.id}) > 0;
        if (commanded && view.scenario.communication_m.high > 0) model.may_have_paid = true;
        FollowWays(view, &model, nullptr);
      }
    }
  }
}

void ReportCheck::CheckReport(View& view, AgentModel* model, const agent_t& a,
                              std::int32_t applied_decision) {
  const std::size_t before = view.findings->count();
  if (applied_decision != view.in_force) {
    view.Violate("lockstep", "{} applied decision {}, in force is {}", model->name(),
                 applied_decision, view.in_force);
  }
  CheckSpec(view, *model, a);
  const bool is_commanded = view.commands.contains({model->kind, model->id});

  const Place here{a.x_m, a.y_m};
  // By the straight line: CheckMotion compares it with its way. By road a place beside the road may
  // be near to another one, and far by the ways of both.
  const double moved = Apart(model->was, here);
  const double seconds = ToSeconds(view.now_us - model->was_us);
  const double most = model->spec->speed_m_s * seconds;
  const double rounding_m = model->ways->rounding_m(model->kind);
  if (moved > most + kTolerance_m + rounding_m && !model->spec->measured) {
    view.Violate("speed", "{} moved {:.3f} m in {:.6g} s, at {:.6g} m/s it moves at most {:.3f} m",
                 model->name(), moved, seconds, model->spec->speed_m_s, most);
  }
  model->was = here;
  model->was_us = view.now_us;
  model->unheard.reset();
  if (std::exchange(model->joined_unheard, false) && a.status != AgentStatus::kFailed) {
    // It has heard of its joining after its loss.
    model->failed = false;
    model->depart_us = model->arrive_us = model->busy_until_us = 0;
  }
  if (model->kind == kUav) {
    NoteUav(view, view.tick, a);
    if (a.range_left_m < 0 || a.range_left_m > model->spec->range_full_m + kTolerance_m) {
      view.Violate("range", "{} has {:.6g} m of range left, full is {:.6g} m", model->name(),
                   a.range_left_m, model->spec->range_full_m);
    }
  }
  if (view.findings->count() != before) return;

  if (model->may_have_paid && model->kind == kUav && !is_commanded) {
    model->may_have_paid = false;
    const double cost_m = model->RangeAt(view.now_us) - a.range_left_m;
    if (Within(cost_m, view.scenario.communication_m, kTolerance_m)) {
      model->range_at_departure_m -= cost_m;
    }
  }
  ResolveCommand(view, model, a);
  FollowWays(view, model, &a);
  if (!model->spec->measured) {
    SeeWay(view, model, a);
    if (view.findings->count() == before) CheckMotion(view, *model, a);
    return;
  }
  const agent_t told = SeeTold(view, model, a);
  if (view.findings->count() == before) CheckMotion(view, *model, told);
}

}  // namespace muster::tools::audit
