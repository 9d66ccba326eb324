// What each agent reports of a tick, against its command and its own arithmetic.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/audit/auditor.h"
#include "tools/audit/unlisted.h"
#include "tools/audit/values.h"

namespace muster::tools::audit {

bool Auditor::CanReport(int said, int kind, std::int64_t tick, TickData** data) {
  if (said != kind) {
    Violate(scenario_->TimeOf(std::clamp<std::int64_t>(tick, 0, 1 << 30)), "lockstep",
            fmt::format("agents of class {} on the channel of {}s, tick {}", said,
                        ToString<AgentKind>(kind), tick));
    return false;
  }
  *data = DataOf(tick);
  const bool is_late = tick >= 0 && tick < next_tick_;
  return *data != nullptr || is_late;
}

void Auditor::TakeStates(const agent_states_t& message, int kind) {
  TickData* data = nullptr;
  if (!CanReport(message.kind, kind, message.tick, &data)) return;
  for (const agent_t& agent : message.agents) {
    TakeReport(message.tick, kind,
               {agent, -1, message.applied_decision, message.header.sender, message.header.boot_id},
               data);
  }
}

void Auditor::TakeChanges(const agent_changes_t& message, int kind) {
  TickData* data = nullptr;
  if (!CanReport(message.kind, kind, message.tick, &data)) return;
  const header_t& header = message.header;
  if (scenario_->DecisionAt(message.tick) >= 0) {
    Violate(now_us_, "lockstep",
            fmt::format("{} says only what has changed at tick {}, where a decision rests on it",
                        header.sender, message.tick));
    return;
  }
  // A range that no scenario has is told of once.
  const auto last =
      std::min<std::int64_t>(message.last_id, static_cast<std::int64_t>(models_[kind].size()));
  auto listed = message.agents.begin();
  for (auto id = message.first_id; id <= last; ++id) {
    Report report{{}, message.base_tick, message.applied_decision, header.sender, header.boot_id};
    report.agent.id = id;
    if (listed != message.agents.end() && listed->id == id) {
      report.agent = *listed++;
      report.base_tick = -1;
    }
    TakeReport(message.tick, kind, report, data);
  }
}

void Auditor::TakeReport(std::int64_t tick, int kind, const Report& report, TickData* data) {
  const std::int64_t t = scenario_->TimeOf(tick);
  const std::int32_t id = report.agent.id;
  if (id < 0 || static_cast<std::size_t>(id) >= models_[kind].size()) {
    Violate(t, "lockstep",
            fmt::format("{} reports {}:{}, which the scenario does not have", report.sender,
                        ToString<AgentKind>(kind), id));
    return;
  }
  if (data == nullptr) {
    // A lost process that is back says where it stands at a tick that went by without it.
    const std::optional<agent_t> said = Read(kind, report, tick);
    if (said && kind == kUav) NoteUav(tick, *said);
    return;
  }
  auto& known = data->reports[kind][static_cast<std::size_t>(id)];
  if (!known) {
    known = report;
    return;
  }
  // A restarted process may say its last tick again.
  if (known->sender == report.sender && known->boot_id != report.boot_id) return;
  Violate(t, "lockstep",
          fmt::format("{}:{} is reported twice for tick {}, by {} (start {}) and {} (start {})",
                      ToString<AgentKind>(kind), id, tick, known->sender, known->boot_id,
                      report.sender, report.boot_id));
}

std::optional<agent_t> Auditor::Read(int kind, const Report& report, std::int64_t tick) {
  Told& told = told_[kind][static_cast<std::size_t>(report.agent.id)];
  const std::int64_t t = scenario_->TimeOf(tick);
  if (report.base_tick < 0) {
    if (tick > told.tick) told = {report.agent, t, tick};
    return report.agent;
  }
  if (told.tick < report.base_tick || told.tick > tick) return {};
  told.tick = tick;
  return Unlisted(told.agent, kind, told.at_us, t, *scenario_);
}

void Auditor::CheckReports(const TickData& data) {
  // What a process says of the tick in which it is lost never reached the world.
  std::set<AgentKey> unheard;
  for (const ruling_t& r : data.rulings->rulings) {
    if (r.kind == RulingKind::kLost && r.at_us > before_us_) {
      unheard.insert({r.agent_kind, r.agent_id});
    }
    if (r.agent_kind == kUav && r.kind != RulingKind::kReleased && r.at_us > before_us_) {
      failing_.insert({next_tick_, r.agent_id});
    }
  }
  for (const int kind : {kUav, kWorker, kVehicle}) {
    for (AgentModel& model : models_[kind]) {
      const auto id = static_cast<std::size_t>(model.id);
      const auto& report = data.reports[kind][id];
      const std::optional<agent_t> said =
          report ? Read(kind, *report, next_tick_) : std::optional<agent_t>();
      if (report && !said) {
        Violate(now_us_, "lockstep",
                fmt::format("{} has not changed since tick {}, says {}, which has not been told",
                            model.name(), report->base_tick, report->sender));
      } else if (report && !unheard.contains({kind, model.id})) {
        CheckReport(&model, *said, report->applied_decision);
      } else {
        commands_.erase({kind, model.id});  // of a lost process: what it did is not known
      }
    }
  }
}

void Auditor::CheckReport(AgentModel* model, const agent_t& a, std::int32_t applied_decision) {
  const auto kind = static_cast<std::size_t>(model->kind);
  const auto id = static_cast<std::size_t>(model->id);
  const std::size_t before = n_violations_;
  if (applied_decision != in_force_) {
    Violate(now_us_, "lockstep",
            fmt::format("{} applied decision {}, in force is {}", model->name(), applied_decision,
                        in_force_));
  }
  CheckSpec(*model, a);

  const Place here{a.x_m, a.y_m};
  // A report runs ahead of what the world rules afterwards: the agent may have stopped before it.
  auto& [was, was_us] = was_[kind][id];
  const double moved = model->WayM(was, here);
  const double seconds = static_cast<double>(now_us_ - was_us) * 1e-6;
  const double most = model->spec->speed_m_s * seconds;
  if (moved > most + kTolerance_m && !model->spec->measured) {
    Violate(now_us_, "speed",
            fmt::format("{} moved {:.3f} m in {:.6g} s, at {:.6g} m/s it moves at most {:.3f} m",
                        model->name(), moved, seconds, model->spec->speed_m_s, most));
  }
  was = here;
  was_us = now_us_;
  if (model->kind == kUav) {
    NoteUav(next_tick_, a);
    if (a.range_left_m < 0 || a.range_left_m > model->spec->range_full_m + kTolerance_m) {
      Violate(now_us_, "range",
              fmt::format("{} has {:.6g} m of range left, full is {:.6g} m", model->name(),
                          a.range_left_m, model->spec->range_full_m));
    }
  }
  if (n_violations_ != before) return;

  ResolveCommand(model, a);
  if (!model->spec->measured) {
    SeeWay(model, a);
    if (n_violations_ == before) CheckMotion(*model, a);
    return;
  }
  const agent_t told = SeeTold(model, a);
  if (n_violations_ == before) CheckMotion(*model, told);
}

void Auditor::NoteUav(std::int64_t tick, const agent_t& a) {
  const auto id = static_cast<std::size_t>(a.id);
  // The report of the tick at which it is ruled to have failed runs ahead of its failure.
  if (failing_.contains({tick, a.id}) || tick <= final_range_tick_[id]) return;
  const Place here{a.x_m, a.y_m};
  std::optional<Place>& seen = last_seen_[kUav][id];
  if (seen) flown_m_[id] += scenario_->ways->Length(kUav, *seen, here);
  seen = here;
  final_range_m_[id] = a.range_left_m;
  final_range_tick_[id] = tick;
}

void Auditor::CheckSpec(const AgentModel& model, const agent_t& a) {
  const auto expect = [&](const char* field, double found, double expected) {
    if (std::abs(found - expected) <= 1e-12 * std::abs(expected)) return;
    Violate(now_us_, "scenario",
            fmt::format("{} reports {} {:.17g}, the scenario says {:.17g}", model.name(), field,
                        found, expected));
  };
  expect("speed_m_s", a.speed_m_s, model.spec->speed_m_s);
  expect("range_full_m", a.range_full_m, model.spec->range_full_m);
  expect("charge_rate_m_s", a.charge_rate_m_s, model.spec->charge_rate_m_s);
  const auto expect_us = [&](const char* field, std::int64_t found, std::int64_t expected) {
    if (found == expected) return;
    Violate(now_us_, "scenario",
            fmt::format("{} reports {} {}, the scenario says {}", model.name(), field, found,
                        expected));
  };
  expect_us("online_from_us", a.online_from_us, model.spec->online_from_us);
  expect_us("online_until_us", a.online_until_us, model.spec->online_until_us);
}

void Auditor::ResolveCommand(AgentModel* model, const agent_t& a) {
  const auto found = commands_.find({model->kind, model->id});
  if (found == commands_.end()) return;
  const Command command = found->second;
  commands_.erase(found);
  const action_t& action = command.action;
  const bool pair = action.kind == ActionKind::kSense || action.kind == ActionKind::kCharge;
  const bool begins =
      model->spec->measured ? a.decision == command.decision : a.depart_us == command.at_us;
  const bool obeys = a.action == action.kind && begins;
  if (!obeys && pair && scenario_->match_failure.high > 0) {
    // The match failed; its event is looked for at the end.
    const bool sense = action.kind == ActionKind::kSense;
    Expect(command.at_us, EventKind::kMatchFailed,
           Activity{sense ? ActivityKind::kSensing : ActivityKind::kCharging, action.uav_id,
                    sense ? action.worker_id : action.vehicle_id,
                    sense ? action.task_id : action.charge_id, 0, 0});
    return;
  }
  if (!obeys) {
    Violate(now_us_, "obedience",
            fmt::format("{} did not begin {} of decision {}", model->name(), Name(action),
                        command.decision));
    return;
  }
  double range_m = model->range_at_departure_m;
  const bool tells_departure = a.depart_us == command.at_us;
  model->cost_is_hidden = scenario_->communication_m.high > 0 && !tells_departure;
  if (model->kind == kUav && scenario_->communication_m.high > 0 && tells_departure) {
    const double cost_m = range_m - a.range_at_departure_m;
    if (!model->spec->measured && a.range_at_departure_m > 0 &&
        !Within(cost_m, scenario_->communication_m, kTolerance_m)) {
      Violate(
          now_us_, "range",
          fmt::format("{} paid {:.6g} m to communicate, expected {:.6g} to {:.6g} m", model->name(),
                      cost_m, scenario_->communication_m.low, scenario_->communication_m.high));
    }
    range_m = std::min(range_m, a.range_at_departure_m);
  }
  model->from = model->to;
  model->to = {action.x_m, action.y_m};
  model->depart_us = command.at_us;
  model->arrive_us =
      command.at_us + DurationUs(model->WayM(model->from, model->to), model->spec->speed_m_s);
  // Which of two roundings is right does not matter; what follows rests on the reported one.
  if (NearUs(model->arrive_us, a.arrive_us)) model->arrive_us = a.arrive_us;
  model->range_at_departure_m = range_m;
  model->range_per_m = 1;
  model->way_seen = model->kind != kUav || scenario_->wind.high <= 0;
  model->action = static_cast<ActionKind>(action.kind);
  model->target = action.task_id >= 0 ? action.task_id : action.charge_id;
  model->partner = !pair                               ? -1
                   : model->kind != kUav               ? action.uav_id
                   : action.kind == ActionKind::kSense ? action.worker_id
                                                       : action.vehicle_id;
  model->decision = command.decision;
  model->activity.reset();
  model->busy_until_us = pair ? kForever : model->arrive_us;
  model->set_out_us = model->depart_us;
  model->planned_us = model->arrive_us;
  model->range_after_m.reset();
  model->goes_on_anew = false;
}

void Auditor::SeeWay(AgentModel* model, const agent_t& a) {
  const double moved = model->MovedAt(now_us_);
  if (model->way_seen || moved <= 0 || a.range_left_m <= 0) return;
  const double spent = model->range_at_departure_m - a.range_left_m;
  model->range_per_m = spent / moved;
  model->way_seen = true;
  if (!Within(model->range_per_m, {1 + scenario_->wind.low, 1 + scenario_->wind.high},
              kTolerance_m / moved)) {
    Violate(now_us_, "range",
            fmt::format("{} spent {:.6g} m of range on {:.6g} m of way, wind allows a factor of "
                        "{:.6g} to {:.6g}",
                        model->name(), spent, moved, 1 + scenario_->wind.low,
                        1 + scenario_->wind.high));
  }
}

void Auditor::CheckMotion(const AgentModel& model, const agent_t& a) {
  const auto differs = [&](const char* invariant, const std::string& what) {
    Violate(now_us_, invariant,
            fmt::format("{} ({} since decision {}): {}", model.name(),
                        model.action == ActionKind::kNone ? "free" : ToString(model.action),
                        model.decision, what));
  };
  const Place expected = model.At(now_us_);
  if (Apart(expected, {a.x_m, a.y_m}) > kTolerance_m) {
    differs("motion",
            fmt::format("is at ({:.3f}, {:.3f}) m, its way leads it to ({:.3f}, {:.3f}) m", a.x_m,
                        a.y_m, expected.x_m, expected.y_m));
    return;
  }
  if (a.action != model.action) {
    differs("motion", fmt::format("reports action {}, expected {}", ToString<ActionKind>(a.action),
                                  ToString(model.action)));
  }
  if (a.action != ActionKind::kNone &&
      (a.target_id != model.target || a.partner_id != model.partner)) {
    differs("motion", fmt::format("reports target {} and partner {}, expected {} and {}",
                                  a.target_id, a.partner_id, model.target, model.partner));
  }
  // A measured agent's leg is told as it began, or as it goes on.
  const bool departs = model.spec->measured || NearUs(a.depart_us, model.depart_us);
  if (!departs || !NearUs(a.arrive_us, model.arrive_us)) {
    differs("speed",
            fmt::format("reports a way of {:.3f} m in [{}, {}] us, at {:.6g} m/s it is [{}, {}] us",
                        model.WayM(model.from, model.to), a.depart_us, a.arrive_us,
                        model.spec->speed_m_s, model.depart_us, model.arrive_us));
  }
  if (!NearUs(a.busy_until_us, model.busy_until_us)) {
    differs("motion", fmt::format("reports to be busy until {} us, expected {} us", a.busy_until_us,
                                  model.busy_until_us));
  }
  const AgentStatus status = model.StatusAt(now_us_);
  if (a.status != status) {
    differs("motion", fmt::format("reports to be {}, expected {}", ToString<AgentStatus>(a.status),
                                  ToString(status)));
  }
  if (model.kind != kUav) return;
  if (model.way_seen && !Near(a.range_left_m, std::max(0.0, model.RangeAt(now_us_)))) {
    differs("range", fmt::format("reports {:.6f} m of range left, expected {:.6f} m",
                                 a.range_left_m, model.RangeAt(now_us_)));
  }
}

}  // namespace muster::tools::audit
