// Sensing and charging as the world lists them.
#include <fmt/format.h>

#include <algorithm>

#include "tools/audit/checks.h"

namespace muster::tools::audit {
namespace {

/// Whether it begins without a command.
bool CheckNewActivity(View& view, const Activity& activity) {
  const std::string invariant(ToString(activity.kind));
  const auto wrong = [&]<class... T>(fmt::format_string<T...> what, T&&... values) {
    view.Violate(invariant, "{}: {}", Name(activity),
                 fmt::format(what, std::forward<T>(values)...));
  };
  const int partner_class = activity.partner_class();
  const std::size_t n_sites =
      activity.senses() ? view.scenario.tasks.size() : view.scenario.charges.size();
  if (activity.uav < 0 || static_cast<std::size_t>(activity.uav) >= view.agents[kUav].size() ||
      activity.partner < 0 ||
      static_cast<std::size_t>(activity.partner) >= view.agents[partner_class].size() ||
      activity.site < 0 || static_cast<std::size_t>(activity.site) >= n_sites) {
    wrong("names what the scenario does not have");
    return false;
  }
  const auto members = view.MembersOf(activity);
  AgentModel &uav = *members[0], &partner = *members[1];
  const Scenario::Task* task = activity.senses() ? &view.TaskOf(activity.site) : nullptr;
  if (task != nullptr &&
      view.task_status[static_cast<std::size_t>(activity.site)] == TaskStatus::kDone) {
    view.Violate("task-twice", "{}: the task is done", Name(activity));
    return false;
  }
  // A pair that is over, or whose other member has failed, may not have been settled yet.
  const auto is_free = [&](const AgentModel& agent, std::int32_t other) {
    const bool is_over = agent.activity && agent.activity->end_us <= view.now_us;
    const bool is_parted = agent.partner != other && view.released.contains({agent.kind, agent.id});
    return !agent.pair() || is_over || is_parted;
  };
  const bool meeting = view.scenario.start_on_meeting && view.due >= 0 &&
                       activity.start_us == view.now_us && is_free(uav, activity.partner) &&
                       is_free(partner, activity.uav);
  if (meeting) return true;  // checked when the agents are settled
  if (uav.action != activity.action() || partner.action != activity.action() ||
      uav.partner != partner.id || partner.partner != uav.id || uav.target != activity.site ||
      partner.target != activity.site || uav.decision != partner.decision || uav.activity ||
      partner.activity) {
    wrong("no decision in force commands it");
    return false;
  }
  const Place site = view.SiteOf(activity);
  for (const AgentModel* member : members) {
    if (Apart(member->to, site) > kTolerance_m) {
      wrong("{} goes to ({:.3f}, {:.3f}) m, the place is ({:.3f}, {:.3f}) m", member->name(),
            member->to.x_m, member->to.y_m, site.x_m, site.y_m);
    }
  }
  std::int64_t start = std::max(uav.arrive_us, partner.arrive_us);
  const double on_arrival = uav.RangeOnArrival();
  const bool dry = on_arrival < -1e-6;
  const std::int64_t duration = view.DurationOf(activity, std::max(0.0, on_arrival));
  std::int64_t end = duration == kForever ? kForever : start + duration;
  if (activity.start_us == kForever && (dry || !uav.way_seen)) {
    // The UAV does not get there: listed until it is seen to fail.
    start = end = kForever;
  }
  if (!NearUs(activity.start_us, start)) {
    wrong("starts at {} us; {} arrives at {} us, {} at {} us", activity.start_us, uav.name(),
          uav.arrive_us, partner.name(), partner.arrive_us);
  }
  if (!NearUs(activity.end_us, end) && (uav.way_seen || task != nullptr)) {
    wrong("ends at {} us, expected {} us: it takes {} us", activity.end_us, end, duration);
  }
  for (AgentModel* member : members) {
    member->activity = activity;
    member->busy_until_us = activity.end_us;
  }
  if (task != nullptr) uav.cost_m = task->cost_m;
  return false;
}

void CheckMeeting(View& view, const Activity& activity) {
  const auto members = view.MembersOf(activity);
  AgentModel& uav = *members[0];
  const auto wrong = [&]<class... T>(fmt::format_string<T...> what, T&&... values) {
    view.Violate("meeting", "{}: {}", Name(activity),
                 fmt::format(what, std::forward<T>(values)...));
  };
  const auto site_id = static_cast<std::size_t>(activity.site);
  for (const AgentModel* member : members) {
    if (member->StatusAt(view.now_us) != AgentStatus::kIdle) {
      wrong("{} is {}", member->name(), ToString(member->StatusAt(view.now_us)));
    }
    if (!SameCell(member->At(view.now_us), view.SiteOf(activity))) {
      wrong("{} is in another cell", member->name());
    }
    if (activity.end_us > view.LatestEnd(*member)) {
      wrong("ends after {} us, when {} must be free", view.LatestEnd(*member), member->name());
    }
  }
  const double range = uav.RangeAt(view.now_us);
  const std::int64_t duration = view.DurationOf(activity, range);
  if (activity.senses()) {
    const Scenario::Task& task = view.scenario.tasks[site_id];
    if (task.cost_m + task.to_charge_m > range + kTolerance_m) {
      view.Violate("constraint-6",
                   "{}: takes {:.3f} m and {:.3f} m to the nearest charging point, {:.3f} m "
                   "are left",
                   Name(activity), task.cost_m, task.to_charge_m, range);
    }
    uav.cost_m = task.cost_m;
  } else {
    const std::int64_t load = std::count_if(view.agents[kUav].begin(), view.agents[kUav].end(),
                                            [&](const AgentModel& other) {
                                              return other.action == ActionKind::kCharge &&
                                                     other.target == activity.site && !other.failed;
                                            });
    if (load >= view.scenario.charges[site_id].capacity) {
      view.Violate("capacity", "{}: {} charge there already, the capacity is {}", Name(activity),
                   load, view.scenario.charges[site_id].capacity);
    }
  }
  if (!NearUs(activity.end_us, view.now_us + duration)) {
    wrong("should take {} us", duration);
  }
  for (AgentModel* member : members) {
    member->activity = activity;
    member->action = activity.action();
    member->target = activity.site;
    member->partner = member->kind == kUav ? activity.partner : activity.uav;
    member->busy_until_us = activity.end_us;
  }
}

}  // namespace

void CheckActivities(View& view) {
  std::erase_if(view.activities, [&](const Tracked& tracked) {
    return tracked.aborted || tracked.activity.end_us <= view.before_us;
  });
  for (Tracked& tracked : view.activities) tracked.is_new = false;
  std::vector<Activity> listed;
  for (const activity_t& wire : view.said->world->activities) listed.push_back(FromWire(wire));
  for (Tracked& tracked : view.activities) {
    // Of a pair of which one is measured, or goes round closed roads.
    const bool may_move = view.IsMeasured(tracked.activity) || view.GoesRound(tracked.activity);
    const auto it = std::find_if(listed.begin(), listed.end(), [&](const Activity& activity) {
      Activity moved = tracked.activity;
      if (may_move) moved.start_us = activity.start_us, moved.end_us = activity.end_us;
      return activity == moved;
    });
    if (it == listed.end()) {
      view.Violate("activities", "no longer listed or changed: {}", Name(tracked.activity));
    } else {
      if (may_move) CheckMoved(view, &tracked, *it);
      listed.erase(it);
    }
  }
  for (const Activity& activity : listed) {
    const bool meeting = CheckNewActivity(view, activity);
    if (!view.Holds()) return;
    view.activities.push_back({activity, true, false, meeting});
    ++view.n_activities;
  }
  for (const int kind : kClasses) {
    for (const AgentModel& model : view.agents[kind]) {
      const AgentKey agent{kind, model.id};
      if (!model.pair() || model.activity || view.failed.contains(agent) ||
          view.released.contains(agent)) {
        continue;
      }
      view.Violate("activities", "{} of decision {} has neither an activity nor a release for {}",
                   ToString(model.action), model.decision, model.name());
    }
  }
}

void AbortActivities(View& view) {
  for (Tracked& tracked : view.activities) {
    const Activity& a = tracked.activity;
    std::int64_t at = kForever;
    for (const AgentKey& member : {AgentKey{kUav, a.uav}, AgentKey{a.partner_class(), a.partner}}) {
      const auto failure = view.failed.find(member);
      if (failure == view.failed.end() || !failure->second.is_new) continue;
      if (failure->second.at_us < a.end_us) at = std::min(at, failure->second.at_us);
    }
    if (a.senses()) {
      const std::int64_t expires_us = view.TaskOf(a.site).expires_us;
      if (a.start_us >= expires_us && expires_us <= view.now_us) at = std::min(at, expires_us);
    }
    at = std::min({at, OrderedEnd(view, a), GivenUpAt(view, a)});
    if (at == kForever) continue;
    tracked.aborted = true;
    tracked.aborted_us = at;
    const bool sensing = a.senses();
    if (a.start_us <= at && (tracked.is_new || a.start_us > view.before_us)) {
      view.Expect(a.start_us, sensing ? EventKind::kSensingStarted : EventKind::kChargingStarted,
                  a);
    }
    view.Expect(at, sensing ? EventKind::kSensingAborted : EventKind::kChargingAborted, a);
  }
}

void CheckMeetings(View& view) {
  for (const Tracked& tracked : view.activities) {
    if (tracked.is_new && tracked.meeting) CheckMeeting(view, tracked.activity);
  }
}

}  // namespace muster::tools::audit
