// What the world rules and what follows: failures, releases, ends, tasks, events.
#include <fmt/format.h>

#include <algorithm>

#include "tools/audit/checks.h"

namespace muster::tools::audit {
namespace {

void CheckRangeLeft(const View& view, const AgentModel& model) {
  if (model.kind != kUav || model.failed || model.spec->measured) return;
  const double range = model.RangeAt(view.now_us);
  if (range < -kTolerance_m) {
    view.Violate("range", "{} has flown and sensed {:.3f} m further than its range", model.name(),
                 -range);
  }
}

void ExpireTasks(View& view) {
  for (std::size_t x = 0; x < view.task_status.size(); ++x) {
    const Scenario::Task& task = view.scenario.tasks[x];
    if (view.task_status[x] != TaskStatus::kCancelled && task.reported_us > 0 &&
        view.before_us < task.reported_us && task.reported_us <= view.now_us) {
      view.ExpectOfTask(task.reported_us, EventKind::kTaskReported, x);
    }
    const bool may_expire =
        view.task_status[x] == TaskStatus::kOpen || view.task_status[x] == TaskStatus::kHeld;
    if (task.expires_us > view.now_us || !may_expire) continue;
    // Sensing that had begun in time may have been aborted since.
    std::int64_t at_us = task.expires_us;
    for (const Tracked& tracked : view.activities) {
      const Activity& a = tracked.activity;
      if (tracked.aborted && a.senses() && a.site == static_cast<std::int32_t>(x)) {
        at_us = std::max(at_us, tracked.aborted_us);
      }
    }
    view.task_status[x] = NumberOf(TaskStatus::kExpired);
    view.ExpectOfTask(at_us, EventKind::kTaskExpired, x);
  }
}

/// A vacant place fails with its process, and nobody is told.
bool IsVacant(const View& view, const AgentKey& agent) {
  return view.agents[agent.first].at(agent.second).spec->online_until_us == 0;
}

}  // namespace

void ReadRulings(View& view) {
  std::map<AgentKey, Failure> failed;
  view.released.clear();
  for (const ruling_t& r : view.said->rulings->rulings) {
    if (!IsWord<AgentKind>(r.agent_kind) || r.agent_id < 0 ||
        static_cast<std::size_t>(r.agent_id) >= view.agents[r.agent_kind].size()) {
      view.Violate("rulings", "a ruling names agent {} of class {}", r.agent_id, r.agent_kind);
      continue;
    }
    const AgentKey agent{r.agent_kind, r.agent_id};
    const std::string name = view.Model(r.agent_kind, r.agent_id).name();
    const bool silent = r.kind == RulingKind::kLost && IsVacant(view, agent);
    if (r.kind == RulingKind::kReleased) {
      // A pair may have ended before an order frees its members: the first counts.
      const auto first = view.released.try_emplace(agent, r.at_us).first;
      first->second = std::min(first->second, r.at_us);
      continue;
    }
    const auto known = view.failed.find(agent);
    // Back with its process, and failed by itself in the same tick.
    const bool again = known != view.failed.end() && known->second.lost &&
                       r.kind == RulingKind::kFailed && known->second.at_us != r.at_us;
    const bool is_new = known == view.failed.end() || again;
    failed[agent] = {r.at_us, is_new, r.kind == RulingKind::kLost};
    if (again && !IsVacant(view, agent))
      view.expected_back.emplace_back(agent, view.before_us, view.now_us);
    if (!is_new && known->second.at_us != r.at_us) {
      view.Violate("rulings", "{} failed at {} us, earlier it was {} us", name, r.at_us,
                   known->second.at_us);
    }
    if (!is_new) continue;
    if (r.at_us < view.before_us || r.at_us > view.now_us) {
      view.Violate("rulings", "{} is said to have failed at {} us, after {} us", name, r.at_us,
                   view.before_us);
    }
    if (!silent) view.Expect(r.at_us, EventKind::kAgentFailed, agent);
  }
  for (const auto& [agent, failure] : view.failed) {
    const bool silent = failure.lost && IsVacant(view, agent);
    if (!failed.contains(agent) && !silent)
      view.expected_back.emplace_back(agent, view.before_us, view.now_us);
  }
  view.failed = std::move(failed);
}

void SettleAgents(View& view) {
  for (const int kind : kClasses) {
    for (AgentModel& model : view.agents[kind]) {
      const AgentKey agent{kind, model.id};
      const auto failure = view.failed.find(agent);
      const bool fails = failure != view.failed.end();
      if (fails && !model.failed) {
        const std::int64_t at = failure->second.at_us;
        if (model.unheard && at < model.depart_us) {
          // It had failed when its way was closed.
          const Ways* const ways = model.ways;
          model = AgentModel(*model.unheard);
          model.ways = ways;
        }
        model.unheard.reset();
        if (!model.way_seen && kind == kUav && model.MovedAt(at) > 0) {
          // It ran dry before its first report: that tells the wind.
          model.range_per_m = model.range_at_departure_m / model.MovedAt(at);
        }
        model.StopAt(at);
      }
      const auto release = view.released.find(agent);
      const std::int64_t set_out_us = model.spec->measured ? model.set_out_us : model.depart_us;
      // What sets out now goes round a road or a zone that is closed since now.
      if (release != view.released.end() && model.action != ActionKind::kNone &&
          (release->second >= set_out_us || set_out_us == view.now_us)) {
        const bool cause =
            model.pair() &&
            std::any_of(view.activities.begin(), view.activities.end(), [&](const Tracked& t) {
              return t.aborted && t.activity.involves(kind, model.id);
            });
        if (!cause && !(model.pair() && !model.activity) && !IsRecalled(view, kind, model.id)) {
          view.Violate("rulings",
                       "{} is released at {} us without its partner "
                       "having failed",
                       model.name(), release->second);
        }
        // A measured one has gone on until it is told.
        model.StopAt(model.spec->measured ? view.now_us
                                          : std::max(release->second, model.depart_us));
      }
      model.failed = fails;
      if (model.busy_until_us < view.now_us && model.action == ActionKind::kNone) {
        model.was = model.to;
      }
      CheckRangeLeft(view, model);
      if (model.action != ActionKind::kNone && model.busy_until_us <= view.now_us) {
        model.StopAt(model.busy_until_us);
      }
    }
  }
}

void CheckTasks(View& view) {
  const world_state_t& world = *view.said->world;
  if (world.task_status.size() != view.task_status.size()) {
    view.Violate("task-status", "{} tasks are listed, the scenario has {}",
                 world.task_status.size(), view.task_status.size());
    return;
  }
  for (std::size_t x = 0; x < view.task_status.size(); ++x) {
    std::int8_t& status = view.task_status[x];
    if (view.IsOver(static_cast<int>(x)) || status == TaskStatus::kHeld) continue;
    status = NumberOf(view.scenario.tasks[x].reported_us > view.now_us ? TaskStatus::kUnreported
                                                                       : TaskStatus::kOpen);
  }
  for (const Tracked& tracked : view.activities) {
    const Activity& a = tracked.activity;
    if (!a.senses() || tracked.aborted) continue;
    std::int8_t& status = view.task_status[static_cast<std::size_t>(a.site)];
    if (status != TaskStatus::kOpen) {
      view.Violate("task-twice", "{}: the task is {} already", Name(a), TaskWords(status));
    }
    status = NumberOf(a.end_us <= view.now_us     ? TaskStatus::kDone
                      : a.start_us <= view.now_us ? TaskStatus::kSensing
                                                  : TaskStatus::kReserved);
  }
  ExpireTasks(view);
  FollowOrders(view);
  std::int32_t done = 0;
  for (std::size_t x = 0; x < view.task_status.size(); ++x) {
    done += view.task_status[x] == TaskStatus::kDone ? 1 : 0;
    const std::int8_t said = world.task_status[x];
    if (said == view.task_status[x]) continue;
    view.Violate("task-status", "task:{} is said to be {}, it is {}", x, TaskWords(said),
                 TaskWords(view.task_status[x]));
  }
  if (world.done != done) {
    view.Violate("task-status", "{} tasks are said to be done, {} are", world.done, done);
  }
}

void ExpectEvents(View& view) {
  for (const Tracked& tracked : view.activities) {
    if (tracked.aborted) continue;
    const Activity& a = tracked.activity;
    if (a.start_us <= view.now_us && (tracked.is_new || a.start_us > view.before_us)) {
      view.Expect(a.start_us, a.senses() ? EventKind::kSensingStarted : EventKind::kChargingStarted,
                  a);
    }
    if (a.end_us <= view.now_us)
      view.Expect(a.end_us, a.senses() ? EventKind::kSensingDone : EventKind::kChargingDone, a);
  }
}

}  // namespace muster::tools::audit
