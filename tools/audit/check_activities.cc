// Sensing and charging as the world lists them.
#include <fmt/format.h>

#include <algorithm>

#include "tools/audit/auditor.h"
#include "tools/audit/values.h"

namespace muster::tools::audit {

void Auditor::CheckActivities(const world_state_t& world) {
  std::erase_if(activities_, [&](const Tracked& tracked) {
    return tracked.aborted || tracked.activity.end_us <= before_us_;
  });
  for (Tracked& tracked : activities_) tracked.is_new = false;
  std::vector<Activity> listed;
  for (const activity_t& wire : world.activities) listed.push_back(FromWire(wire));
  for (Tracked& tracked : activities_) {
    const bool is_measured = IsMeasured(tracked.activity);
    const auto it = std::find_if(listed.begin(), listed.end(), [&](const Activity& activity) {
      Activity moved = tracked.activity;
      if (is_measured) moved.start_us = activity.start_us, moved.end_us = activity.end_us;
      return activity == moved;
    });
    if (it == listed.end()) {
      Violate(now_us_, "activities",
              fmt::format("no longer listed or changed: {}", Name(tracked.activity)));
    } else {
      if (is_measured) CheckMoved(&tracked, *it);
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
                          ToString(model.action), model.decision, model.name()));
    }
  }
}

bool Auditor::CheckNewActivity(const Activity& activity) {
  const std::string invariant(ToString(activity.kind));
  const auto wrong = [&](const std::string& what) {
    Violate(now_us_, invariant, fmt::format("{}: {}", Name(activity), what));
  };
  const int partner_class = activity.partner_class();
  const std::size_t n_sites =
      activity.senses() ? scenario_->tasks.size() : scenario_->charges.size();
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
      activity.senses() ? &scenario_->tasks[static_cast<std::size_t>(activity.site)] : nullptr;
  if (task != nullptr &&
      task_status_[static_cast<std::size_t>(activity.site)] == TaskStatus::kDone) {
    Violate(now_us_, "task-twice", fmt::format("{}: the task is done", Name(activity)));
    return false;
  }
  // A pair that is over may not have been settled yet.
  const auto is_free = [this](const AgentModel& agent) {
    return !agent.pair() || (agent.activity && agent.activity->end_us <= now_us_);
  };
  const bool meeting = scenario_->start_on_meeting && due_ >= 0 && activity.start_us == now_us_ &&
                       is_free(uav) && is_free(partner);
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
    if (Apart(member->to, site) > kTolerance_m) {
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
      activity.senses() ? scenario_->tasks[site_id].at : scenario_->charges[site_id].at;
  for (const AgentModel* member : {&uav, &partner}) {
    if (member->StatusAt(now_us_) != AgentStatus::kIdle) {
      wrong(fmt::format("{} is {}", member->name(), ToString(member->StatusAt(now_us_))));
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
  if (activity.senses()) {
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
          return other.action == ActionKind::kCharge && other.target == activity.site &&
                 !other.failed;
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
    if (a.senses()) {
      const std::int64_t expires_us = scenario_->tasks[static_cast<std::size_t>(a.site)].expires_us;
      if (a.start_us >= expires_us && expires_us <= now_us_) at = std::min(at, expires_us);
    }
    at = std::min({at, OrderedEnd(a), GivenUpAt(a)});
    if (at == kForever) continue;
    tracked.aborted = true;
    tracked.aborted_us = at;
    const bool sensing = a.senses();
    if (a.start_us <= at && (tracked.is_new || a.start_us > before_us_)) {
      Expect(a.start_us, sensing ? EventKind::kSensingStarted : EventKind::kChargingStarted, a);
    }
    Expect(at, sensing ? EventKind::kSensingAborted : EventKind::kChargingAborted, a);
  }
}

}  // namespace muster::tools::audit
