// The referee on tasks in time and on orders: when tasks are reported, expire, are cancelled or
// held, and who joins, leaves or is recalled.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <tuple>
#include <utility>

#include "world/referee.h"

namespace muster::world {

void Referee::PlanTimes(TimeUs t) {
  to_report_.clear();
  to_expire_.clear();
  for (std::size_t x = 0; x < scenario_.n_tasks(); ++x) {
    const Task& task = scenario_.tasks[x];
    if (task.reported_us > t) to_report_.emplace_back(task.reported_us, x);
    if (task.expires_us > t && task.expires_us != kNever)
      to_expire_.emplace_back(task.expires_us, x);
  }
  std::sort(to_report_.rbegin(), to_report_.rend());
  std::sort(to_expire_.rbegin(), to_expire_.rend());
}

void Referee::PlanTimesOf(std::size_t x, TimeUs t) {
  const auto replan = [&](std::vector<std::pair<TimeUs, std::size_t>>* plan, TimeUs at_us) {
    std::erase_if(*plan, [&](const auto& entry) { return entry.second == x; });
    if (at_us == kNever || at_us < t) return;
    const std::pair entry(at_us, x);
    plan->insert(std::lower_bound(plan->begin(), plan->end(), entry, std::greater()), entry);
  };
  // A task that is known from the beginning is not reported.
  const TimeUs reported_us = scenario_.tasks[x].reported_us;
  if (reported_us == 0 && task_status_[x] == TaskStatus::kUnreported) {
    task_status_[x] = TaskStatus::kOpen;
  }
  if (task_status_[x] == TaskStatus::kUnreported) replan(&to_report_, reported_us);
  replan(&to_expire_, scenario_.tasks[x].expires_us);
}

void Referee::TakeIn(TimeUs t, Agents* agents) {
  for (const TakenOrder& taken : orders_) {
    const Order& order = taken.order;
    if (order.kind == OrderKind::kTaskAdd || order.kind == OrderKind::kTaskChange) {
      PlanTimesOf(static_cast<std::size_t>(taken.task_id), t);
    }
    if (order.kind == OrderKind::kAgentJoin) {
      muster::Obey(&agents->at(order.agent_kind, taken.agent_id), taken, t, scenario_);
    }
  }
}

void Referee::Obey(TimeUs t, Agents* agents) {
  for (const TakenOrder& taken : orders_) {
    const AgentKey agent{taken.order.agent_kind, taken.agent_id};
    switch (RowOf(taken.order.kind).subject) {
      case OrderSubject::kNewTask:
      case OrderSubject::kRoads:
      case OrderSubject::kAir:        // who is concerned follows before it reports
      case OrderSubject::kDirective:  // the scheduler keeps it
      case OrderSubject::kPerson:     // the desk knows them
      case OrderSubject::kOrder:      // it refuses what is withdrawn
      case OrderSubject::kDecision:   // the clock names it
        break;
      case OrderSubject::kTask:
        ObeyOfTask(taken, t);
        break;
      case OrderSubject::kNewAgent:
        EmitOrder(Event::Kind::kAgentJoined, t, agent, taken.order);
        break;
      case OrderSubject::kAgent:
        if (taken.order.kind == OrderKind::kAgentRecall) Recall(taken, t, agents);
        EmitOrder(Event::Kind::kAgentLeaves, t, agent, taken.order);
        break;
    }
  }
}

void Referee::ObeyOfTask(const TakenOrder& taken, TimeUs t) {
  const auto x = static_cast<std::size_t>(taken.task_id);
  TaskStatus& status = task_status_[x];
  const auto emit = [&](Event::Kind kind) {
    Emit(kind, t, TaskId(x), fmt::format("{} by {}", taken.order.id, taken.order.issuer));
    OnceATick();
  };
  if (taken.order.kind == OrderKind::kTaskChange) return emit(Event::Kind::kTaskChanged);
  if (taken.order.kind == OrderKind::kTaskResume) {
    if (status != TaskStatus::kHeld) return;
    status = TaskStatus::kOpen;
    return emit(Event::Kind::kTaskResumed);
  }
  // What is done or begun by now is not undone.
  const bool cancels = taken.order.kind == OrderKind::kTaskCancel;
  const bool too_late =
      std::any_of(activities_.begin(), activities_.end(), [&](const Known& known) {
        const Activity& activity = known.activity;
        return !known.is_aborted && activity.kind == Activity::Kind::kSensing &&
               activity.site == taken.task_id &&
               (cancels ? activity.end_us : activity.start_us) <= t;
      });
  if (too_late || status == TaskStatus::kDone || status == TaskStatus::kExpired ||
      status == TaskStatus::kCancelled) {
    return;
  }
  CallOff(x, t);
  if (status == TaskStatus::kExpired) return;
  status = cancels ? TaskStatus::kCancelled : TaskStatus::kHeld;
  if (cancels) std::erase_if(to_report_, [&](const auto& entry) { return entry.second == x; });
  emit(cancels ? Event::Kind::kTaskCancelled : Event::Kind::kTaskHeld);
}

void Referee::Recall(const TakenOrder& taken, TimeUs t, Agents* agents) {
  const AgentKey key{taken.order.agent_kind, taken.agent_id};
  if (failed_.contains(key)) return;
  if (AbortActivityOf(agents->at(key.first, key.second), t, false)) return;
  released_.push_back({key.first, key.second, Ruling::Kind::kReleased, t});
}

void Referee::ExpireUntil(TimeUs t) {
  for (; !to_expire_.empty() && to_expire_.back().first <= t; to_expire_.pop_back()) {
    const TimeUs expires_us = to_expire_.back().first;
    const std::size_t x = to_expire_.back().second;
    if (task_status_[x] == TaskStatus::kDone || task_status_[x] == TaskStatus::kCancelled) continue;
    const bool begun = std::any_of(activities_.begin(), activities_.end(), [&](const Known& known) {
      return !known.is_aborted && known.activity.kind == Activity::Kind::kSensing &&
             known.activity.site == static_cast<std::int32_t>(x) &&
             scenario_.tasks[x].AllowsStart(known.activity.start_us);
    });
    if (begun) continue;
    CallOff(x, expires_us);
    ExpireIfLate(x, expires_us);
  }
}

void Referee::ExpireIfLate(std::size_t task, TimeUs t) {
  if (scenario_.tasks[task].AllowsStart(t) || task_status_[task] == TaskStatus::kCancelled) return;
  task_status_[task] = TaskStatus::kExpired;
  Emit(Event::Kind::kTaskExpired, t, TaskId(task), "");
}

void Referee::CallOff(std::size_t task, TimeUs t) {
  for (Known& known : activities_) {
    const Activity& activity = known.activity;
    if (known.is_aborted || activity.kind != Activity::Kind::kSensing ||
        activity.site != static_cast<std::int32_t>(task)) {
      continue;
    }
    if (activity.end_us > t) Abort(&known, t);
  }
}

void Referee::EmitReports(TimeUs t) {
  for (; !to_report_.empty() && to_report_.back().first <= t; to_report_.pop_back()) {
    const auto [reported_us, x] = to_report_.back();
    if (task_status_[x] != TaskStatus::kUnreported) continue;
    task_status_[x] = TaskStatus::kOpen;
    Emit(Event::Kind::kTaskReported, reported_us, TaskId(x), "");
  }
}

void Referee::UpdateTasks(TimeUs t) {
  for (TaskStatus& status : task_status_) {
    if (status == TaskStatus::kReserved || status == TaskStatus::kSensing) {
      status = TaskStatus::kOpen;
    }
  }
  for (const Known& known : activities_) {
    const Activity& activity = known.activity;
    if (known.is_aborted || activity.kind != Activity::Kind::kSensing) continue;
    TaskStatus& status = task_status_[static_cast<std::size_t>(activity.site)];
    if (status == TaskStatus::kDone) continue;
    status = activity.end_us <= t     ? TaskStatus::kDone
             : activity.start_us <= t ? TaskStatus::kSensing
                                      : TaskStatus::kReserved;
  }
}

void Referee::OnceATick() {
  const auto key = [](const Event& e) {
    return std::tie(e.at_us, e.kind, e.uav, e.worker, e.vehicle, e.task);
  };
  const bool again =
      std::any_of(events_.begin(), std::prev(events_.end()),
                  [&](const Event& event) { return key(event) == key(events_.back()); });
  if (again) events_.pop_back();
}

void Referee::EmitOrder(Event::Kind kind, TimeUs at_us, AgentKey agent, const Order& order) {
  Emit(kind, at_us, agent);
  events_.back().detail = fmt::format("{} by {}", order.id, order.issuer);
  OnceATick();
}

}  // namespace muster::world
