// Orders as the world says it took them, and what follows from them.
#include <fmt/format.h>

#include <algorithm>

#include "tools/audit/auditor.h"

namespace muster::tools::audit {

void Auditor::TakeOrders(orders_t orders) {
  TickData* data = DataOf(orders.tick);
  if (data == nullptr) return;
  if (!data->orders || data->orders->header.boot_id < orders.header.boot_id) {
    data->orders = std::move(orders);
  }
}

namespace {

int NumberOfClass(std::int8_t kind) {
  return kind == AgentKind::kUav ? kUav : kind == AgentKind::kWorker ? kWorker : kVehicle;
}

}  // namespace

void Auditor::CheckOrders(const orders_t& orders) {
  const auto wrong = [&](const std::string& id, const std::string& what) {
    Violate(now_us_, "orders", fmt::format("order {}: {}", id, what));
  };
  if (orders.before != static_cast<std::int64_t>(order_ids_.size())) {
    Violate(now_us_, "orders",
            fmt::format("{} orders are said to have come before, {} have", orders.before,
                        order_ids_.size()));
  }
  for (const refused_order_t& order : orders.refused) {
    if (!order_ids_.insert(order.id).second) wrong(order.id, "was answered before");
  }
  for (const taken_order_t& taken : orders.taken) {
    if (!order_ids_.insert(taken.id).second) wrong(taken.id, "was answered before");
    AuditOrder order;
    try {
      order = ParseAuditOrder(taken.json, now_us_, *scenario_);
    } catch (const std::exception& error) {
      wrong(taken.id, fmt::format("cannot be read: {}", error.what()));
      continue;
    }
    order.task = taken.task_id;
    order.kind = NumberOfClass(taken.agent_kind);
    order.agent = taken.agent_id;
    if (!CheckOrder(taken, order)) continue;
    TakeOrder(order);
    taken_.push_back(order);
  }
}

bool Auditor::CheckOrder(const taken_order_t& taken, const AuditOrder& order) {
  const auto wrong = [&](const std::string& what) {
    Violate(now_us_, "orders", fmt::format("order {}: {}", taken.id, what));
    return false;
  };
  const auto n_tasks = static_cast<int>(scenario_->tasks.size());
  if (order.is_add()) {
    if (order.task != n_tasks_) {
      return wrong(fmt::format("adds task {}, the next is {}", order.task, n_tasks_));
    }
    if (order.task >= n_tasks) return wrong("there is no room for a task");
    const Place at = order.new_task.at;
    if (at.x_m < 0 || at.x_m > scenario_->width_m || at.y_m < 0 || at.y_m > scenario_->height_m) {
      return wrong("its task is outside the area");
    }
    return true;
  }
  if (order.is_join()) {
    if (order.agent != n_agents_[order.kind]) {
      return wrong(
          fmt::format("adds agent {}, the next is {}", order.agent, n_agents_[order.kind]));
    }
    return static_cast<std::size_t>(order.agent) < models_[order.kind].size() ||
           wrong("there is no room for an agent");
  }
  if (order.is_agents()) {
    return (order.agent >= 0 && order.agent < n_agents_[order.kind]) ||
           wrong(fmt::format("there is no agent {}", order.agent));
  }
  if (order.task < 0 || order.task >= n_tasks_) {
    return wrong(fmt::format("there is no task {}", order.task));
  }
  const std::int8_t status = task_status_[static_cast<std::size_t>(order.task)];
  const bool is_over = status == TaskStatus::kDone || status == TaskStatus::kExpired ||
                       status == TaskStatus::kCancelled;
  return !is_over || wrong(fmt::format("task {} is over", order.task));
}

void Auditor::TakeOrder(const AuditOrder& order) {
  if (order.is_add()) {
    scenario_->tasks[static_cast<std::size_t>(order.task)] = order.new_task;
    task_status_[static_cast<std::size_t>(order.task)] = NumberOf(TaskStatus::kUnreported);
    ++n_tasks_;
  }
  if (order.what == "task_change" && order.expires_us) {
    scenario_->tasks[static_cast<std::size_t>(order.task)].expires_us = *order.expires_us;
  }
  if (order.is_join()) {
    scenario_->agents[order.kind][static_cast<std::size_t>(order.agent)] = order.new_agent;
    ++n_agents_[order.kind];
  }
}

std::int64_t Auditor::OrderedEnd(const Activity& activity) const {
  for (const AuditOrder& order : taken_) {
    const bool of_task = activity.senses() && order.task == activity.site && !order.is_agents();
    const bool cancels = of_task && order.what == "task_cancel" && activity.end_us > now_us_;
    const bool holds = of_task && order.what == "task_hold" && activity.start_us > now_us_;
    const bool recalls = order.what == "agent_recall" && activity.end_us > now_us_ &&
                         (order.kind == kUav ? activity.uav == order.agent
                                             : activity.partner_class() == order.kind &&
                                                   activity.partner == order.agent);
    if (cancels || holds || recalls) return now_us_;
  }
  return kForever;
}

bool Auditor::IsRecalled(int kind, int id) const {
  return std::any_of(taken_.begin(), taken_.end(), [&](const AuditOrder& order) {
    return order.what == "agent_recall" && order.kind == kind && order.agent == id;
  });
}

void Auditor::FollowOrders() {
  const auto expect_of_task = [&](int task, EventKind kind) {
    expected_.insert({now_us_, NumberOf(kind), -1, -1, -1, task, -1});
  };
  for (const AuditOrder& order : std::exchange(taken_, {})) {
    if (order.is_join()) {
      AgentModel& model = Model(order.kind, order.agent);
      const auto id = static_cast<std::size_t>(order.agent);
      const Scenario::Agent& spec = *model.spec;
      model.from = model.to = spec.at;
      model.range_at_departure_m = spec.range_m;
      was_[order.kind][id] = {spec.at, now_us_};
      last_seen_[order.kind][id].reset();
      Expect(now_us_, EventKind::kAgentJoined, AgentKey{order.kind, order.agent});
      ExpectPresence(model);
      continue;
    }
    if (order.is_agents()) {
      AgentModel& model = Model(order.kind, order.agent);
      const auto id = static_cast<std::size_t>(order.agent);
      Scenario::Agent& spec = scenario_->agents[order.kind][id];
      Expect(now_us_, EventKind::kAgentLeaves, AgentKey{order.kind, order.agent});
      const bool busy = model.busy_until_us != kForever && model.busy_until_us > now_us_;
      const std::int64_t until = busy ? model.busy_until_us : now_us_;
      if (until >= spec.online_until_us) continue;
      const auto event = [&](EventKind what, std::int64_t at) {
        return EventKey{at,
                        NumberOf(what),
                        order.kind == kUav ? order.agent : -1,
                        order.kind == kWorker ? order.agent : -1,
                        order.kind == kVehicle ? order.agent : -1,
                        -1,
                        -1};
      };
      expected_.erase(event(EventKind::kAgentOffline, spec.online_until_us));
      spec.online_until_us = until;
      if (spec.online_from_us >= until) {
        expected_.erase(event(EventKind::kAgentOnline, spec.online_from_us));
      } else if (until <= scenario_->limit_us) {
        expected_.insert(event(EventKind::kAgentOffline, until));
      }
      continue;
    }
    if (order.is_add()) continue;
    std::int8_t& status = task_status_[static_cast<std::size_t>(order.task)];
    if (order.what == "task_change") expect_of_task(order.task, EventKind::kTaskChanged);
    if (order.what == "task_resume" && status == TaskStatus::kHeld) {
      status = NumberOf(TaskStatus::kOpen);
      expect_of_task(order.task, EventKind::kTaskResumed);
    }
    const bool is_open = status == TaskStatus::kOpen || status == TaskStatus::kHeld;
    if (order.what == "task_cancel" && (is_open || status == TaskStatus::kUnreported)) {
      status = NumberOf(TaskStatus::kCancelled);
      expect_of_task(order.task, EventKind::kTaskCancelled);
    }
    if (order.what == "task_hold" && status == TaskStatus::kOpen) {
      status = NumberOf(TaskStatus::kHeld);
      expect_of_task(order.task, EventKind::kTaskHeld);
    }
  }
}

}  // namespace muster::tools::audit
