// What Auditor checks of one tick: auditor.cc gathers the tick's messages.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/audit/auditor.h"

namespace muster::tools::audit {
namespace {

/// Rounding of arrival times to microseconds and of sums: far above both, far below what matters.
constexpr double kTolerance_m = 1e-3;
constexpr std::int64_t kToleranceUs = 2;
constexpr double kCellSide_m = 1000;

constexpr const char* kSymbols[] = {"Ui",   "Wj",   "Vk",     "UiTx",   "WjTx",
                                    "UiCy", "VkCy", "UiTxWj", "UiCyVk", "go"};
constexpr const char* kStatusNames[] = {"offline", "idle",     "moving", "waiting",
                                        "sensing", "charging", "failed"};
constexpr const char* kTaskNames[] = {"open", "reserved", "being sensed", "done"};

bool Near(double a, double b) { return std::abs(a - b) <= kTolerance_m; }
bool NearUs(std::int64_t a, std::int64_t b) {
  return a == b || (a != kForever && b != kForever && std::abs(a - b) <= kToleranceUs);
}
bool Within(double value, Interval range, double tolerance) {
  return range.low - tolerance <= value && value <= range.high + tolerance;
}
bool SameCell(Place a, Place b) {
  return std::floor(a.x_m / kCellSide_m) == std::floor(b.x_m / kCellSide_m) &&
         std::floor(a.y_m / kCellSide_m) == std::floor(b.y_m / kCellSide_m);
}

std::string Name(const action_t& a) {
  std::string text = a.kind >= 0 && a.kind <= 9 ? kSymbols[a.kind] : fmt::format("kind {}", a.kind);
  const auto add = [&text](const char* name, int id) {
    if (id >= 0) text += fmt::format(" {}:{}", name, id);
  };
  add("uav", a.uav_id);
  add("worker", a.worker_id);
  add("vehicle", a.vehicle_id);
  add("task", a.task_id);
  add("charge", a.charge_id);
  return text;
}

std::string Name(const Activity& a) {
  return fmt::format("{} of uav:{} and {}:{} at {}:{} in [{}, {}] us",
                     a.kind == 0 ? "sensing" : "charging", a.uav, kClassNames[a.partner_class()],
                     a.partner, a.kind == 0 ? "task" : "charge", a.site, a.start_us, a.end_us);
}

Activity FromWire(const activity_t& a) {
  return {a.kind, a.uav_id, a.partner_id, a.site_id, a.start_us, a.end_us};
}

}  // namespace

std::int64_t Auditor::LatestEnd(const AgentModel& model) const {
  return scenario_->strict ? std::min(model.spec->online_until_us, scenario_->limit_us) : kForever;
}

void Auditor::CheckTick(std::int64_t tick, const TickData& data) {
  before_us_ = tick == 0 ? -1 : now_us_;
  now_us_ = scenario_->TimeOf(tick);
  due_ = scenario_->DecisionAt(tick);
  CheckClock(*data.clock);
  CheckReports(data);
  if (!TickHolds()) return;
  ReadRulings(*data.rulings);
  CheckActivities(*data.world);
  if (!TickHolds()) return;
  AbortActivities();
  SettleAgents();
  for (const Tracked& tracked : activities_) {
    if (tracked.is_new && tracked.meeting) CheckMeeting(tracked.activity);
  }
  CheckTasks(*data.world);
  ExpectEvents();
  if (due_ < 0) return;
  if (TickHolds()) CheckDecision(schedules_.at(due_));
  in_force_ = due_;
}

void Auditor::CheckClock(const clock_t& clock) {
  const auto expect = [&](const char* field, std::int64_t found, std::int64_t expected) {
    if (found == expected) return;
    Violate(now_us_, "clock",
            fmt::format("clock_t of tick {}: {} is {}, expected {}", clock.tick, field, found,
                        expected));
  };
  expect("tick_us", clock.tick_us, now_us_);
  expect("limit_us", clock.limit_us, scenario_->limit_us);
  expect("decision", clock.decision, due_);
  expect("required_decision", clock.required_decision, in_force_);
}

void Auditor::CheckReports(const TickData& data) {
  for (const int kind : {kUav, kWorker, kVehicle}) {
    for (AgentModel& model : models_[kind]) {
      const auto id = static_cast<std::size_t>(model.id);
      if (const auto& report = data.reports[kind][id]) {
        CheckReport(&model, *report);
      } else {
        commands_.erase({kind, model.id});  // of a lost process: what it did is not known
      }
    }
  }
}

void Auditor::CheckReport(AgentModel* model, const Report& report) {
  const agent_t& a = report.agent;
  const auto kind = static_cast<std::size_t>(model->kind);
  const auto id = static_cast<std::size_t>(model->id);
  const std::size_t before = n_violations_;
  if (report.applied_decision != in_force_) {
    Violate(now_us_, "lockstep",
            fmt::format("{} applied decision {}, in force is {}", model->name(),
                        report.applied_decision, in_force_));
  }
  CheckSpec(*model, a);

  const Place here{a.x_m, a.y_m};
  // A report runs ahead of what the world rules afterwards: the agent may have stopped before it.
  auto& [was, was_us] = was_[kind][id];
  const double moved = Way(was, here);
  const double seconds = static_cast<double>(now_us_ - was_us) * 1e-6;
  const double most = model->spec->speed_m_s * seconds;
  if (moved > most + kTolerance_m) {
    Violate(now_us_, "speed",
            fmt::format("{} moved {:.3f} m in {:.6g} s, at {:.6g} m/s it moves at most {:.3f} m",
                        model->name(), moved, seconds, model->spec->speed_m_s, most));
  }
  was = here;
  was_us = now_us_;
  std::optional<Place>& seen = last_seen_[kind][id];
  if (seen && model->kind == kUav) flown_m_[id] += Way(*seen, here);
  seen = here;
  if (model->kind == kUav) {
    final_range_m_[id] = a.range_left_m;
    if (a.range_left_m < 0 || a.range_left_m > model->spec->range_full_m + kTolerance_m) {
      Violate(now_us_, "range",
              fmt::format("{} has {:.6g} m of range left, full is {:.6g} m", model->name(),
                          a.range_left_m, model->spec->range_full_m));
    }
  }
  if (n_violations_ != before) return;

  ResolveCommand(model, a);
  SeeWay(model, a);
  if (n_violations_ == before) CheckMotion(*model, a);
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
  const bool pair = action.kind == kSense || action.kind == kChargeUp;
  const bool obeys = a.action == action.kind && a.depart_us == command.at_us;
  if (!obeys && pair && scenario_->match_failure.high > 0) {
    // The match failed; its event is looked for at the end.
    const bool sense = action.kind == kSense;
    Expect(command.at_us, 10,
           Activity{sense ? 0 : 1, action.uav_id, sense ? action.worker_id : action.vehicle_id,
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
  if (model->kind == kUav && scenario_->communication_m.high > 0) {
    const double cost_m = range_m - a.range_at_departure_m;
    if (a.range_at_departure_m > 0 && !Within(cost_m, scenario_->communication_m, kTolerance_m)) {
      Violate(
          now_us_, "range",
          fmt::format("{} paid {:.6g} m to communicate, expected {:.6g} to {:.6g} m", model->name(),
                      cost_m, scenario_->communication_m.low, scenario_->communication_m.high));
    }
    range_m = a.range_at_departure_m;
  }
  model->from = model->to;
  model->to = {action.x_m, action.y_m};
  model->depart_us = command.at_us;
  model->arrive_us =
      command.at_us + DurationUs(Way(model->from, model->to), model->spec->speed_m_s);
  // Which of two roundings is right does not matter; what follows rests on the reported one.
  if (NearUs(model->arrive_us, a.arrive_us)) model->arrive_us = a.arrive_us;
  model->range_at_departure_m = range_m;
  model->range_per_m = 1;
  model->way_seen = model->kind != kUav || scenario_->wind.high <= 0;
  model->action = action.kind;
  model->target = action.task_id >= 0 ? action.task_id : action.charge_id;
  model->partner = !pair                   ? -1
                   : model->kind != kUav   ? action.uav_id
                   : action.kind == kSense ? action.worker_id
                                           : action.vehicle_id;
  model->decision = command.decision;
  model->activity.reset();
  model->busy_until_us = pair ? kForever : model->arrive_us;
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
                        model.action < 0 ? "free" : kSymbols[model.action], model.decision, what));
  };
  const Place expected = model.At(now_us_);
  if (Way(expected, {a.x_m, a.y_m}) > kTolerance_m) {
    differs("motion",
            fmt::format("is at ({:.3f}, {:.3f}) m, its way leads it to ({:.3f}, {:.3f}) m", a.x_m,
                        a.y_m, expected.x_m, expected.y_m));
    return;
  }
  if (a.action != model.action) {
    differs("motion", fmt::format("reports action {}, expected {}", a.action, model.action));
  }
  if (a.action != kNoAction && (a.target_id != model.target || a.partner_id != model.partner)) {
    differs("motion", fmt::format("reports target {} and partner {}, expected {} and {}",
                                  a.target_id, a.partner_id, model.target, model.partner));
  }
  if (!NearUs(a.depart_us, model.depart_us) || !NearUs(a.arrive_us, model.arrive_us)) {
    differs("speed",
            fmt::format("reports a way of {:.3f} m in [{}, {}] us, at {:.6g} m/s it is [{}, {}] us",
                        Way(model.from, model.to), a.depart_us, a.arrive_us, model.spec->speed_m_s,
                        model.depart_us, model.arrive_us));
  }
  if (!NearUs(a.busy_until_us, model.busy_until_us)) {
    differs("motion", fmt::format("reports to be busy until {} us, expected {} us", a.busy_until_us,
                                  model.busy_until_us));
  }
  const int status = model.StatusAt(now_us_);
  if (a.status != status) {
    const char* said = a.status >= 0 && a.status <= 6 ? kStatusNames[a.status] : "unknown";
    differs("motion", fmt::format("reports to be {}, expected {}", said, kStatusNames[status]));
  }
  if (model.kind != kUav) return;
  if (model.way_seen && !Near(a.range_left_m, std::max(0.0, model.RangeAt(now_us_)))) {
    differs("range", fmt::format("reports {:.6f} m of range left, expected {:.6f} m",
                                 a.range_left_m, model.RangeAt(now_us_)));
  }
}

void Auditor::ReadRulings(const rulings_t& rulings) {
  std::map<AgentKey, Failure> failed;
  released_.clear();
  for (const ruling_t& r : rulings.rulings) {
    if (r.agent_kind < 0 || r.agent_kind > 2 || r.agent_id < 0 ||
        static_cast<std::size_t>(r.agent_id) >= models_[r.agent_kind].size()) {
      Violate(now_us_, "rulings",
              fmt::format("a ruling names agent {} of class {}", r.agent_id, r.agent_kind));
      continue;
    }
    const AgentKey agent{r.agent_kind, r.agent_id};
    const std::string name = Model(r.agent_kind, r.agent_id).name();
    if (r.kind == 1) {
      released_[agent] = r.at_us;
      continue;
    }
    const auto known = failed_.find(agent);
    const bool is_new = known == failed_.end();
    failed[agent] = {r.at_us, is_new};
    if (!is_new && known->second.at_us != r.at_us) {
      Violate(now_us_, "rulings",
              fmt::format("{} failed at {} us, earlier it was {} us", name, r.at_us,
                          known->second.at_us));
    }
    if (!is_new) continue;
    if (r.at_us < before_us_ || r.at_us > now_us_) {
      Violate(now_us_, "rulings",
              fmt::format("{} is said to have failed at {} us, after {} us", name, r.at_us,
                          before_us_));
    }
    Expect(r.at_us, 2, agent);
  }
  for (const auto& [agent, failure] : failed_) {
    if (!failed.contains(agent)) expected_back_.emplace_back(agent, before_us_, now_us_);
  }
  failed_ = std::move(failed);
}

void Auditor::CheckActivities(const world_state_t& world) {
  std::erase_if(activities_, [&](const Tracked& tracked) {
    return tracked.aborted || tracked.activity.end_us <= before_us_;
  });
  for (Tracked& tracked : activities_) tracked.is_new = false;
  std::vector<Activity> listed;
  for (const activity_t& wire : world.activities) listed.push_back(FromWire(wire));
  for (const Tracked& tracked : activities_) {
    const auto it = std::find(listed.begin(), listed.end(), tracked.activity);
    if (it == listed.end()) {
      Violate(now_us_, "activities",
              fmt::format("no longer listed or changed: {}", Name(tracked.activity)));
    } else {
      listed.erase(it);
    }
  }
  for (const Activity& activity : listed) {
    const bool meeting = CheckNewActivity(activity);
    if (!TickHolds()) return;
    activities_.push_back({activity, true, false, meeting});
    ++n_activities_;
  }
  for (const int kind : {kUav, kWorker, kVehicle}) {
    for (const AgentModel& model : models_[kind]) {
      const AgentKey agent{kind, model.id};
      if (!model.pair() || model.activity || failed_.contains(agent) || released_.contains(agent)) {
        continue;
      }
      Violate(now_us_, "activities",
              fmt::format("{} of decision {} has neither an activity nor a release for {}",
                          kSymbols[model.action], model.decision, model.name()));
    }
  }
}

bool Auditor::CheckNewActivity(const Activity& activity) {
  const char* invariant = activity.kind == 0 ? "sensing" : "charging";
  const auto wrong = [&](const std::string& what) {
    Violate(now_us_, invariant, fmt::format("{}: {}", Name(activity), what));
  };
  const int partner_class = activity.partner_class();
  const std::size_t n_sites =
      activity.kind == 0 ? scenario_->tasks.size() : scenario_->charges.size();
  if (activity.uav < 0 || static_cast<std::size_t>(activity.uav) >= models_[kUav].size() ||
      activity.partner < 0 ||
      static_cast<std::size_t>(activity.partner) >= models_[partner_class].size() ||
      activity.site < 0 || static_cast<std::size_t>(activity.site) >= n_sites) {
    wrong("names what the scenario does not have");
    return false;
  }
  AgentModel& uav = Model(kUav, activity.uav);
  AgentModel& partner = Model(partner_class, activity.partner);
  const Scenario::Task* task =
      activity.kind == 0 ? &scenario_->tasks[static_cast<std::size_t>(activity.site)] : nullptr;
  if (task != nullptr && task_status_[static_cast<std::size_t>(activity.site)] == 3) {
    Violate(now_us_, "task-twice", fmt::format("{}: the task is done", Name(activity)));
    return false;
  }
  const bool meeting = scenario_->start_on_meeting && due_ >= 0 && activity.start_us == now_us_ &&
                       !uav.pair() && !partner.pair();
  if (meeting) return true;  // checked when the agents are settled
  if (uav.action != activity.action() || partner.action != activity.action() ||
      uav.partner != partner.id || partner.partner != uav.id || uav.target != activity.site ||
      partner.target != activity.site || uav.decision != partner.decision || uav.activity ||
      partner.activity) {
    wrong("no decision in force commands it");
    return false;
  }
  const Place site =
      task != nullptr ? task->at : scenario_->charges[static_cast<std::size_t>(activity.site)].at;
  for (const AgentModel* member : {&uav, &partner}) {
    if (Way(member->to, site) > kTolerance_m) {
      wrong(fmt::format("{} goes to ({:.3f}, {:.3f}) m, the place is ({:.3f}, {:.3f}) m",
                        member->name(), member->to.x_m, member->to.y_m, site.x_m, site.y_m));
    }
  }
  std::int64_t start = std::max(uav.arrive_us, partner.arrive_us);
  const double on_arrival = uav.RangeOnArrival();
  const bool dry = on_arrival < -1e-6;
  const std::int64_t duration = task != nullptr
                                    ? DurationUs(task->cost_m, uav.spec->speed_m_s)
                                    : DurationUs(uav.spec->range_full_m - std::max(0.0, on_arrival),
                                                 partner.spec->charge_rate_m_s);
  std::int64_t end = duration == kForever ? kForever : start + duration;
  if (activity.start_us == kForever && (dry || !uav.way_seen)) {
    // The UAV does not get there: listed until it is seen to fail.
    start = end = kForever;
  }
  if (!NearUs(activity.start_us, start)) {
    wrong(fmt::format("starts at {} us; {} arrives at {} us, {} at {} us", activity.start_us,
                      uav.name(), uav.arrive_us, partner.name(), partner.arrive_us));
  }
  if (!NearUs(activity.end_us, end) && (uav.way_seen || task != nullptr)) {
    wrong(fmt::format("ends at {} us, expected {} us: it takes {} us", activity.end_us, end,
                      duration));
  }
  for (AgentModel* member : {&uav, &partner}) {
    member->activity = activity;
    member->busy_until_us = activity.end_us;
  }
  if (task != nullptr) uav.cost_m = task->cost_m;
  return false;
}

void Auditor::CheckMeeting(const Activity& activity) {
  AgentModel& uav = Model(kUav, activity.uav);
  AgentModel& partner = Model(activity.partner_class(), activity.partner);
  const auto wrong = [&](const std::string& what) {
    Violate(now_us_, "meeting", fmt::format("{}: {}", Name(activity), what));
  };
  const auto site_id = static_cast<std::size_t>(activity.site);
  const Place site =
      activity.kind == 0 ? scenario_->tasks[site_id].at : scenario_->charges[site_id].at;
  for (const AgentModel* member : {&uav, &partner}) {
    if (member->StatusAt(now_us_) != 1) {
      wrong(fmt::format("{} is {}", member->name(), kStatusNames[member->StatusAt(now_us_)]));
    }
    if (!SameCell(member->At(now_us_), site)) {
      wrong(fmt::format("{} is in another cell", member->name()));
    }
    if (activity.end_us > LatestEnd(*member)) {
      wrong(fmt::format("ends after {} us, when {} must be free", LatestEnd(*member),
                        member->name()));
    }
  }
  const double range = uav.RangeAt(now_us_);
  std::int64_t duration = 0;
  if (activity.kind == 0) {
    const Scenario::Task& task = scenario_->tasks[site_id];
    duration = DurationUs(task.cost_m, uav.spec->speed_m_s);
    if (task.cost_m + task.to_charge_m > range + kTolerance_m) {
      Violate(now_us_, "constraint-6",
              fmt::format("{}: takes {:.3f} m and {:.3f} m to the nearest charging point, {:.3f} m "
                          "are left",
                          Name(activity), task.cost_m, task.to_charge_m, range));
    }
    uav.cost_m = task.cost_m;
  } else {
    duration = DurationUs(uav.spec->range_full_m - range, partner.spec->charge_rate_m_s);
    const std::int64_t load =
        std::count_if(models_[kUav].begin(), models_[kUav].end(), [&](const AgentModel& other) {
          return other.action == kChargeUp && other.target == activity.site && !other.failed;
        });
    if (load >= scenario_->charges[site_id].capacity) {
      Violate(now_us_, "capacity",
              fmt::format("{}: {} charge there already, the capacity is {}", Name(activity), load,
                          scenario_->charges[site_id].capacity));
    }
  }
  if (!NearUs(activity.end_us, now_us_ + duration)) {
    wrong(fmt::format("should take {} us", duration));
  }
  for (AgentModel* member : {&uav, &partner}) {
    member->activity = activity;
    member->action = activity.action();
    member->target = activity.site;
    member->partner = member->kind == kUav ? activity.partner : activity.uav;
    member->busy_until_us = activity.end_us;
  }
}

void Auditor::AbortActivities() {
  for (Tracked& tracked : activities_) {
    const Activity& a = tracked.activity;
    std::int64_t at = kForever;
    for (const AgentKey& member : {AgentKey{kUav, a.uav}, AgentKey{a.partner_class(), a.partner}}) {
      const auto failure = failed_.find(member);
      if (failure == failed_.end() || !failure->second.is_new) continue;
      if (failure->second.at_us < a.end_us) at = std::min(at, failure->second.at_us);
    }
    if (at == kForever) continue;
    tracked.aborted = true;
    const bool sensing = a.kind == 0;
    if (a.start_us <= at && (tracked.is_new || a.start_us > before_us_)) {
      Expect(a.start_us, sensing ? 4 : 7, a);
    }
    Expect(at, sensing ? 6 : 9, a);
  }
}

void Auditor::SettleAgents() {
  for (const int kind : {kUav, kWorker, kVehicle}) {
    for (AgentModel& model : models_[kind]) {
      const AgentKey agent{kind, model.id};
      const auto failure = failed_.find(agent);
      const bool fails = failure != failed_.end();
      if (fails && !model.failed) {
        const std::int64_t at = failure->second.at_us;
        if (!model.way_seen && kind == kUav && model.MovedAt(at) > 0) {
          // It ran dry before its first report: that tells the wind.
          model.range_per_m = model.range_at_departure_m / model.MovedAt(at);
        }
        model.StopAt(at);
      }
      const auto release = released_.find(agent);
      if (release != released_.end() && model.action != kNoAction &&
          release->second >= model.depart_us) {
        const bool cause =
            model.pair() &&
            std::any_of(activities_.begin(), activities_.end(), [&](const Tracked& t) {
              const Activity& a = t.activity;
              return t.aborted &&
                     (kind == kUav ? a.uav == model.id
                                   : a.partner_class() == kind && a.partner == model.id);
            });
        if (!cause && !(model.pair() && !model.activity)) {
          Violate(now_us_, "rulings",
                  fmt::format("{} is released at {} us without its partner "
                              "having failed",
                              model.name(), release->second));
        }
        model.StopAt(release->second);
      }
      model.failed = fails;
      if (model.busy_until_us < now_us_ && model.action == kNoAction) {
        was_[kind][static_cast<std::size_t>(model.id)].first = model.to;
      }
      CheckRangeLeft(model);
      if (model.action != kNoAction && model.busy_until_us <= now_us_) {
        model.StopAt(model.busy_until_us);
      }
    }
  }
}

void Auditor::CheckRangeLeft(const AgentModel& model) {
  if (model.kind != kUav || model.failed) return;
  const double range = model.RangeAt(now_us_);
  if (range < -kTolerance_m) {
    Violate(now_us_, "range",
            fmt::format("{} has flown and sensed {:.3f} m further than its range", model.name(),
                        -range));
  }
}

void Auditor::CheckTasks(const world_state_t& world) {
  if (world.task_status.size() != task_status_.size()) {
    Violate(now_us_, "task-status",
            fmt::format("{} tasks are listed, the scenario has {}", world.task_status.size(),
                        task_status_.size()));
    return;
  }
  for (std::int8_t& status : task_status_) status = status == 3 ? 3 : 0;
  for (const Tracked& tracked : activities_) {
    const Activity& a = tracked.activity;
    if (a.kind != 0 || tracked.aborted) continue;
    std::int8_t& status = task_status_[static_cast<std::size_t>(a.site)];
    if (status != 0) {
      Violate(now_us_, "task-twice",
              fmt::format("{}: the task is {} already", Name(a), kTaskNames[status]));
    }
    status = a.end_us <= now_us_ ? 3 : a.start_us <= now_us_ ? 2 : 1;
  }
  std::int32_t done = 0;
  for (std::size_t x = 0; x < task_status_.size(); ++x) {
    done += task_status_[x] == 3 ? 1 : 0;
    const int said = world.task_status[x];
    if (said == task_status_[x]) continue;
    Violate(now_us_, "task-status",
            fmt::format("task:{} is said to be {}, it is {}", x,
                        said >= 0 && said <= 3 ? kTaskNames[said] : "unknown",
                        kTaskNames[task_status_[x]]));
  }
  if (world.done != done) {
    Violate(now_us_, "task-status",
            fmt::format("{} tasks are said to be done, {} are", world.done, done));
  }
}

void Auditor::Expect(std::int64_t at_us, int kind, const Activity& a) {
  const bool sensing = a.kind == 0;
  expected_.insert({at_us, kind, a.uav, sensing ? a.partner : -1, sensing ? -1 : a.partner,
                    sensing ? a.site : -1, sensing ? -1 : a.site});
}

void Auditor::Expect(std::int64_t at_us, int kind, AgentKey agent) {
  const auto [of, id] = agent;
  expected_.insert({at_us, kind, of == kUav ? id : -1, of == kWorker ? id : -1,
                    of == kVehicle ? id : -1, -1, -1});
}

void Auditor::ExpectEvents() {
  for (const Tracked& tracked : activities_) {
    if (tracked.aborted) continue;
    const Activity& a = tracked.activity;
    if (a.start_us <= now_us_ && (tracked.is_new || a.start_us > before_us_)) {
      Expect(a.start_us, a.kind == 0 ? 4 : 7, a);
    }
    if (a.end_us <= now_us_) Expect(a.end_us, a.kind == 0 ? 5 : 8, a);
  }
}

void Auditor::CheckDecision(const schedule_t& schedule) {
  std::map<AgentKey, std::size_t> used;
  std::map<std::int32_t, std::size_t> tasks;
  std::vector<std::int64_t> load(scenario_->charges.size(), 0);
  for (const AgentModel& uav : models_[kUav]) {
    if (uav.action == kChargeUp && !uav.failed) ++load[static_cast<std::size_t>(uav.target)];
  }
  double weight = 0;
  for (std::size_t i = 0; i < schedule.actions.size(); ++i) {
    const action_t& action = schedule.actions[i];
    const std::string name =
        fmt::format("decision {}, action {} ({})", schedule.decision, i, Name(action));
    weight += action.weight;
    if (!CheckShape(action, name)) continue;
    const int ids[] = {action.uav_id, action.worker_id, action.vehicle_id};
    bool usable = true;
    for (const int kind : {kUav, kWorker, kVehicle}) {
      if (ids[kind] < 0) continue;
      const AgentModel& model = Model(kind, ids[kind]);
      const auto [first, is_new] = used.try_emplace({kind, ids[kind]}, i);
      if (!is_new) {
        Violate(now_us_, "one-action-per-agent",
                fmt::format("{}: {} is in action {} too", name, model.name(), first->second));
      }
      if (model.StatusAt(now_us_) == 1) continue;
      usable = false;
      Violate(now_us_, "idle-agents-only",
              fmt::format("{}: {} is {}, busy until {} us, online in [{}, {}) us", name,
                          model.name(), kStatusNames[model.StatusAt(now_us_)], model.busy_until_us,
                          model.spec->online_from_us, model.spec->online_until_us));
    }
    if (action.task_id >= 0) {
      const auto [first, is_new] = tasks.try_emplace(action.task_id, i);
      if (!is_new) {
        Violate(now_us_, "task-open",
                fmt::format("{}: the task is in action {} too", name, first->second));
      }
      const int status = task_status_[static_cast<std::size_t>(action.task_id)];
      if (status != 0) {
        Violate(now_us_, "task-open", fmt::format("{}: the task is {}", name, kTaskNames[status]));
      }
    }
    if (action.charge_id >= 0) {
      const auto site = static_cast<std::size_t>(action.charge_id);
      if (++load[site] > scenario_->charges[site].capacity) {
        Violate(now_us_, "capacity",
                fmt::format("{}: {} at or on the way to a charging point of capacity {}", name,
                            load[site], scenario_->charges[site].capacity));
      }
    }
    if (usable) CheckAction(action, name);
  }
  if (!(std::abs(weight - schedule.weight) <= 1e-9 * std::max(1.0, std::abs(weight)))) {
    Violate(now_us_, "weight",
            fmt::format("decision {} says weight {:.17g}, its actions sum to "
                        "{:.17g}",
                        schedule.decision, schedule.weight, weight));
  }
  if (schedule.bound < weight - 1e-6 * std::max(1.0, std::abs(weight))) {
    Violate(now_us_, "weight",
            fmt::format("decision {} weighs {:.17g}, more than its bound {:.17g}",
                        schedule.decision, weight, schedule.bound));
  }
}

bool Auditor::CheckShape(const action_t& a, const std::string& name) {
  struct Shape {
    bool uav, worker, vehicle, task, charge;
  };
  constexpr Shape kShapes[] = {
      {true, false, false, false, false}, {false, true, false, false, false},
      {false, false, true, false, false}, {true, false, false, true, false},
      {false, true, false, true, false},  {true, false, false, false, true},
      {false, false, true, false, true},  {true, true, false, true, false},
      {true, false, true, false, true}};
  const auto wrong = [&](const std::string& what) {
    Violate(now_us_, "decision", fmt::format("{}: {}", name, what));
    return false;
  };
  if (a.kind < 0 || a.kind > 9) return wrong("no such kind");
  const auto fits = [](int id, std::size_t n) { return id < static_cast<int>(n) && id >= -1; };
  if (!fits(a.uav_id, models_[kUav].size()) || !fits(a.worker_id, models_[kWorker].size()) ||
      !fits(a.vehicle_id, models_[kVehicle].size()) || !fits(a.task_id, scenario_->tasks.size()) ||
      !fits(a.charge_id, scenario_->charges.size())) {
    return wrong("names what the scenario does not have");
  }
  if (a.kind == kGoTo) {
    const int n_agents = (a.uav_id >= 0) + (a.worker_id >= 0) + (a.vehicle_id >= 0);
    if (n_agents != 1 || a.task_id >= 0 || a.charge_id >= 0) return wrong("names not one agent");
    return true;
  }
  const Shape& s = kShapes[a.kind];
  if ((a.uav_id >= 0) != s.uav || (a.worker_id >= 0) != s.worker ||
      (a.vehicle_id >= 0) != s.vehicle || (a.task_id >= 0) != s.task ||
      (a.charge_id >= 0) != s.charge) {
    return wrong("has not the ids of its kind");
  }
  return true;
}

void Auditor::CheckAction(const action_t& a, const std::string& name) {
  std::vector<AgentModel*> members;
  if (a.uav_id >= 0) members.push_back(&Model(kUav, a.uav_id));
  if (a.worker_id >= 0) members.push_back(&Model(kWorker, a.worker_id));
  if (a.vehicle_id >= 0) members.push_back(&Model(kVehicle, a.vehicle_id));
  const Place to{a.x_m, a.y_m};
  const Scenario::Task* task =
      a.task_id >= 0 ? &scenario_->tasks[static_cast<std::size_t>(a.task_id)] : nullptr;
  const Place expected = task != nullptr ? task->at
                         : a.charge_id >= 0
                             ? scenario_->charges[static_cast<std::size_t>(a.charge_id)].at
                         : a.kind == kGoTo ? to
                                           : members[0]->to;
  const bool outside = a.kind == kGoTo && (a.x_m < 0 || a.y_m < 0 || a.x_m > scenario_->width_m ||
                                           a.y_m > scenario_->height_m);
  if (Way(to, expected) > kTolerance_m || outside) {
    Violate(now_us_, "decision",
            fmt::format("{}: leads to ({:.3f}, {:.3f}) m, expected {}", name, a.x_m, a.y_m,
                        outside ? "a place inside the area"
                                : fmt::format("({:.3f}, {:.3f}) m", expected.x_m, expected.y_m)));
  }
  if (a.kind <= kVehicleStays) {
    for (AgentModel* member : members) member->decision = schedules_.at(due_).decision;
    return;
  }
  std::int64_t end = now_us_;
  std::int64_t latest = kForever;
  for (const AgentModel* member : members) {
    end = std::max(end, now_us_ + DurationUs(Way(member->to, to), member->spec->speed_m_s));
    latest = std::min(latest, LatestEnd(*member));
  }
  if (a.uav_id >= 0) {
    const AgentModel& uav = *members[0];
    const double range = uav.RangeAt(now_us_);
    const double way = Way(uav.to, to);
    if (task != nullptr && way + task->cost_m + task->to_charge_m > range + kTolerance_m) {
      Violate(
          now_us_, "constraint-6",
          fmt::format("{}: {:.3f} m of way, {:.3f} m to sense, {:.3f} m to the nearest charging "
                      "point, {:.3f} m of range",
                      name, way, task->cost_m, task->to_charge_m, range));
    }
    if (task == nullptr && way > range + kTolerance_m) {
      Violate(now_us_, "constraint-5",
              fmt::format("{}: {:.3f} m of way, {:.3f} m of range", name, way, range));
    }
    if (a.kind == kSense) end += DurationUs(task->cost_m, uav.spec->speed_m_s);
    if (a.kind == kChargeUp) {
      const double missing = uav.spec->range_full_m - std::max(0.0, range - way);
      end += DurationUs(missing, members[1]->spec->charge_rate_m_s);
    }
  }
  if (latest != kForever && end > latest + kToleranceUs) {
    Violate(now_us_, "availability",
            fmt::format("{}: ends at {} us, its agents must be free at {} us", name, end, latest));
  }
  for (const AgentModel* member : members) {
    commands_[{member->kind, member->id}] = {a, schedules_.at(due_).decision, now_us_};
  }
}

}  // namespace muster::tools::audit
