// What the world rules and what follows: failures, releases, ends, tasks, events.
#include <fmt/format.h>

#include <algorithm>

#include "tools/audit/auditor.h"
#include "tools/audit/values.h"

namespace muster::tools::audit {

void Auditor::ReadRulings(const rulings_t& rulings) {
  std::map<AgentKey, Failure> failed;
  released_.clear();
  for (const ruling_t& r : rulings.rulings) {
    if (!IsWord<AgentKind>(r.agent_kind) || r.agent_id < 0 ||
        static_cast<std::size_t>(r.agent_id) >= models_[r.agent_kind].size()) {
      Violate(now_us_, "rulings",
              fmt::format("a ruling names agent {} of class {}", r.agent_id, r.agent_kind));
      continue;
    }
    const AgentKey agent{r.agent_kind, r.agent_id};
    const std::string name = Model(r.agent_kind, r.agent_id).name();
    if (r.kind == RulingKind::kReleased) {
      released_[agent] = r.at_us;
      continue;
    }
    const auto known = failed_.find(agent);
    // Back with its process, and failed by itself in the same tick.
    const bool again = known != failed_.end() && known->second.lost &&
                       r.kind == RulingKind::kFailed && known->second.at_us != r.at_us;
    const bool is_new = known == failed_.end() || again;
    failed[agent] = {r.at_us, is_new, r.kind == RulingKind::kLost};
    if (again) expected_back_.emplace_back(agent, before_us_, now_us_);
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
    Expect(r.at_us, EventKind::kAgentFailed, agent);
  }
  for (const auto& [agent, failure] : failed_) {
    if (!failed.contains(agent)) expected_back_.emplace_back(agent, before_us_, now_us_);
  }
  failed_ = std::move(failed);
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
      if (release != released_.end() && model.action != ActionKind::kNone &&
          release->second >= (model.spec->measured ? model.set_out_us : model.depart_us)) {
        const bool cause =
            model.pair() &&
            std::any_of(activities_.begin(), activities_.end(), [&](const Tracked& t) {
              const Activity& a = t.activity;
              return t.aborted &&
                     (kind == kUav ? a.uav == model.id
                                   : a.partner_class() == kind && a.partner == model.id);
            });
        if (!cause && !(model.pair() && !model.activity) && !IsRecalled(kind, model.id)) {
          Violate(now_us_, "rulings",
                  fmt::format("{} is released at {} us without its partner "
                              "having failed",
                              model.name(), release->second));
        }
        model.StopAt(release->second);
      }
      model.failed = fails;
      if (model.busy_until_us < now_us_ && model.action == ActionKind::kNone) {
        was_[kind][static_cast<std::size_t>(model.id)].first = model.to;
      }
      CheckRangeLeft(model);
      if (model.action != ActionKind::kNone && model.busy_until_us <= now_us_) {
        model.StopAt(model.busy_until_us);
      }
    }
  }
}

void Auditor::CheckRangeLeft(const AgentModel& model) {
  if (model.kind != kUav || model.failed || model.spec->measured) return;
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
  for (std::size_t x = 0; x < task_status_.size(); ++x) {
    std::int8_t& status = task_status_[x];
    if (status == TaskStatus::kDone || status == TaskStatus::kExpired ||
        status == TaskStatus::kCancelled || status == TaskStatus::kHeld) {
      continue;
    }
    status = NumberOf(scenario_->tasks[x].reported_us > now_us_ ? TaskStatus::kUnreported
                                                                : TaskStatus::kOpen);
  }
  for (const Tracked& tracked : activities_) {
    const Activity& a = tracked.activity;
    if (!a.senses() || tracked.aborted) continue;
    std::int8_t& status = task_status_[static_cast<std::size_t>(a.site)];
    if (status != TaskStatus::kOpen) {
      Violate(now_us_, "task-twice",
              fmt::format("{}: the task is {} already", Name(a), TaskWords(status)));
    }
    status = NumberOf(a.end_us <= now_us_     ? TaskStatus::kDone
                      : a.start_us <= now_us_ ? TaskStatus::kSensing
                                              : TaskStatus::kReserved);
  }
  ExpireTasks();
  FollowOrders();
  std::int32_t done = 0;
  for (std::size_t x = 0; x < task_status_.size(); ++x) {
    done += task_status_[x] == TaskStatus::kDone ? 1 : 0;
    const std::int8_t said = world.task_status[x];
    if (said == task_status_[x]) continue;
    Violate(now_us_, "task-status",
            fmt::format("task:{} is said to be {}, it is {}", x, TaskWords(said),
                        TaskWords(task_status_[x])));
  }
  if (world.done != done) {
    Violate(now_us_, "task-status",
            fmt::format("{} tasks are said to be done, {} are", world.done, done));
  }
}

void Auditor::ExpireTasks() {
  for (std::size_t x = 0; x < task_status_.size(); ++x) {
    const Scenario::Task& task = scenario_->tasks[x];
    const auto expect = [&](std::int64_t at_us, EventKind kind) {
      expected_.insert({at_us, NumberOf(kind), -1, -1, -1, static_cast<std::int32_t>(x), -1});
    };
    if (task_status_[x] != TaskStatus::kCancelled && task.reported_us > 0 &&
        before_us_ < task.reported_us && task.reported_us <= now_us_) {
      expect(task.reported_us, EventKind::kTaskReported);
    }
    const bool may_expire =
        task_status_[x] == TaskStatus::kOpen || task_status_[x] == TaskStatus::kHeld;
    if (task.expires_us > now_us_ || !may_expire) continue;
    // Sensing that had begun in time may have been aborted since.
    std::int64_t at_us = task.expires_us;
    for (const Tracked& tracked : activities_) {
      const Activity& a = tracked.activity;
      if (tracked.aborted && a.senses() && a.site == static_cast<std::int32_t>(x)) {
        at_us = std::max(at_us, tracked.aborted_us);
      }
    }
    task_status_[x] = NumberOf(TaskStatus::kExpired);
    expect(at_us, EventKind::kTaskExpired);
  }
}

void Auditor::Expect(std::int64_t at_us, EventKind kind, const Activity& a) {
  const bool sensing = a.senses();
  expected_.insert({at_us, NumberOf(kind), a.uav, sensing ? a.partner : -1,
                    sensing ? -1 : a.partner, sensing ? a.site : -1, sensing ? -1 : a.site});
}

void Auditor::Expect(std::int64_t at_us, EventKind kind, AgentKey agent) {
  const auto [of, id] = agent;
  expected_.insert({at_us, NumberOf(kind), of == kUav ? id : -1, of == kWorker ? id : -1,
                    of == kVehicle ? id : -1, -1, -1});
}

void Auditor::ExpectEvents() {
  for (const Tracked& tracked : activities_) {
    if (tracked.aborted) continue;
    const Activity& a = tracked.activity;
    if (a.start_us <= now_us_ && (tracked.is_new || a.start_us > before_us_)) {
      Expect(a.start_us, a.senses() ? EventKind::kSensingStarted : EventKind::kChargingStarted, a);
    }
    if (a.end_us <= now_us_)
      Expect(a.end_us, a.senses() ? EventKind::kSensingDone : EventKind::kChargingDone, a);
  }
}

}  // namespace muster::tools::audit
