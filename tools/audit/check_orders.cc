// Orders as the world says it took them, and what follows from them.
#include <fmt/format.h>

#include <algorithm>

#include "tools/audit/checks.h"

namespace muster::tools::audit {
namespace {

int NumberOfClass(std::int8_t kind) {
  return kind == AgentKind::kUav ? kUav : kind == AgentKind::kWorker ? kWorker : kVehicle;
}

/// Why an order cannot have been taken; "": it can.
std::string WrongOf(const View& view, const AuditOrder& order) {
  const auto n_tasks = static_cast<int>(view.scenario.tasks.size());
  if (order.is_add()) {
    const Place at = order.new_task.at;
    if (order.task != view.n_tasks) {
      return fmt::format("adds task {}, the next is {}", order.task, view.n_tasks);
    }
    return order.task >= n_tasks ? "there is no room for a task"
           : !view.IsInside(at)  ? "its task is outside the area"
                                 : "";
  }
  if (order.is_zone()) {
    const auto& in_force = view.scenario.closed;
    if (order.what == "zone_add") {
      return order.until_us > view.now_us ? ""
                                          : fmt::format("adds a zone until {} us", order.until_us);
    }
    return std::any_of(
               in_force.begin(), in_force.end(),
               [&](const auto& one) { return !one.zone.empty() && one.order == order.closure; })
               ? ""
               : fmt::format("there is no zone of {}", order.closure);
  }
  if (order.is_roads()) {
    const std::set<int> closed = view.scenario.ClosedRoads();
    const auto is_closed = [&](int road) { return closed.contains(road); };
    if (!order.closure.empty()) {
      const auto& in_force = view.scenario.closed;
      const bool known = std::any_of(in_force.begin(), in_force.end(),
                                     [&](const auto& one) { return one.order == order.closure; });
      return known ? "" : fmt::format("no roads are closed by {}", order.closure);
    }
    if (order.what == "road_open") {
      return std::any_of(order.roads.begin(), order.roads.end(), is_closed)
                 ? ""
                 : "none of these roads is closed";
    }
    if (order.since_us < view.now_us - view.scenario.tick_us || order.until_us <= view.now_us) {
      return fmt::format("closes roads in [{}, {}) us", order.since_us, order.until_us);
    }
    return std::all_of(order.roads.begin(), order.roads.end(), is_closed)
               ? "these roads are closed already"
               : "";
  }
  if (order.is_person()) return "";  // SignatureCheck
  if (order.asks_for_decision()) return view.due < 0 ? "no decision is due" : "";
  if (order.is_directive()) return WrongDirective(view, order);
  const int n_agents = view.n_agents[order.kind];
  if (order.is_join()) {
    if (order.agent != n_agents) {
      return fmt::format("adds agent {}, the next is {}", order.agent, n_agents);
    }
    const bool has_room = static_cast<std::size_t>(order.agent) < view.agents[order.kind].size();
    return has_room ? "" : "there is no room for an agent";
  }
  if (order.is_agents()) {
    return order.agent >= 0 && order.agent < n_agents
               ? ""
               : fmt::format("there is no agent {}", order.agent);
  }
  if (order.task < 0 || order.task >= view.n_tasks) {
    return fmt::format("there is no task {}", order.task);
  }
  return view.IsOver(order.task) ? fmt::format("task {} is over", order.task) : "";
}

void TakeOrder(View& view, const AuditOrder& order) {
  if (order.is_add()) {
    view.scenario.tasks[static_cast<std::size_t>(order.task)] = order.new_task;
    view.task_status[static_cast<std::size_t>(order.task)] = NumberOf(TaskStatus::kUnreported);
    ++view.n_tasks;
  }
  if (order.what == "task_change" && order.expires_us) {
    view.scenario.tasks[static_cast<std::size_t>(order.task)].expires_us = *order.expires_us;
  }
  if (order.what == "task_change" && order.priority) {
    view.scenario.tasks[static_cast<std::size_t>(order.task)].priority = *order.priority;
  }
  if (order.is_join()) {
    view.scenario.agents[order.kind][static_cast<std::size_t>(order.agent)] = order.new_agent;
    ++view.n_agents[order.kind];
  }
}

void Join(View& view, const AuditOrder& order) {
  AgentModel& model = view.Model(order.kind, order.agent);
  model.from = model.to = model.was = model.spec->at;
  // Its process may have been lost, and come back, while nobody had its place.
  if (!model.failed) model.depart_us = model.arrive_us = model.busy_until_us = 0;
  model.joined_unheard = model.failed;
  model.range_at_departure_m = model.spec->range_m;
  model.was_us = view.now_us;
  if (order.kind == kUav) view.flown[static_cast<std::size_t>(order.agent)].seen.reset();
  view.Expect(view.now_us, EventKind::kAgentJoined, AgentKey{order.kind, order.agent});
  view.ExpectPresence(model);
}

/// At once, or when what is under way has ended.
void Leave(View& view, const AuditOrder& order) {
  const AgentKey agent{order.kind, order.agent};
  const AgentModel& model = view.Model(order.kind, order.agent);
  Scenario::Agent& spec = view.scenario.agents[order.kind][static_cast<std::size_t>(order.agent)];
  view.Expect(view.now_us, EventKind::kAgentLeaves, agent);
  const bool busy = model.busy_until_us != kForever && model.busy_until_us > view.now_us;
  const std::int64_t until = busy ? model.busy_until_us : view.now_us;
  if (until >= spec.online_until_us) return;
  view.expected.erase(KeyOf(spec.online_until_us, EventKind::kAgentOffline, agent));
  spec.online_until_us = until;
  if (spec.online_from_us >= until) {
    view.expected.erase(KeyOf(spec.online_from_us, EventKind::kAgentOnline, agent));
  } else if (until <= view.scenario.limit_us) {
    view.Expect(until, EventKind::kAgentOffline, agent);
  }
}

void ChangeTask(View& view, const AuditOrder& order) {
  const auto task = static_cast<std::size_t>(order.task);
  std::int8_t& status = view.task_status[task];
  const auto becomes = [&](TaskStatus next, EventKind event) {
    status = NumberOf(next);
    view.ExpectOfTask(view.now_us, event, task);
  };
  if (order.what == "task_change") {
    view.ExpectOfTask(view.now_us, EventKind::kTaskChanged, task);
  }
  if (order.what == "task_resume" && status == TaskStatus::kHeld) {
    becomes(TaskStatus::kOpen, EventKind::kTaskResumed);
  }
  const bool is_open = status == TaskStatus::kOpen || status == TaskStatus::kHeld;
  if (order.what == "task_cancel" && (is_open || status == TaskStatus::kUnreported)) {
    becomes(TaskStatus::kCancelled, EventKind::kTaskCancelled);
  }
  if (order.what == "task_hold" && status == TaskStatus::kOpen) {
    becomes(TaskStatus::kHeld, EventKind::kTaskHeld);
  }
}

}  // namespace

void TakeWayOrder(View& view, const AuditOrder& order) {
  Scenario& scenario = view.scenario;
  if (order.is_zone()) {
    if (order.what == "zone_add") {
      scenario.closed.push_back({order.id, order.until_us, {}, order.zone});
    } else {
      std::erase_if(scenario.closed, [&](const Scenario::Closed& one) {
        return !one.zone.empty() && one.order == order.closure;
      });
    }
    view.ways_since_us = view.ways_since_us.value_or(view.now_us);
  } else if (order.what == "road_close") {
    scenario.closed.push_back({order.id, order.until_us, order.roads});
    view.ways_since_us = std::min(order.since_us, view.ways_since_us.value_or(view.now_us));
  } else {
    for (Scenario::Closed& one : scenario.closed) {
      if (one.zone.empty() && one.order == order.closure) one.roads.clear();
      for (const int road : order.roads) one.roads.erase(road);
    }
    std::erase_if(scenario.closed, [](const Scenario::Closed& one) {
      return one.zone.empty() && one.roads.empty();
    });
    view.ways_since_us = view.ways_since_us.value_or(view.now_us);
  }
}

/// What the scenario or an earlier order has planned comes at its tick.
void CheckPlanned(const View& view, const std::set<std::string>& answered) {
  const auto check = [&](const std::vector<Scenario::Planned>& planned, std::string_view what) {
    for (std::size_t i = 0; i < planned.size(); ++i) {
      if (planned[i].from_us > view.now_us || answered.contains(fmt::format("{}:{}", what, i))) {
        continue;
      }
      view.Violate("orders", "the scenario's {} {} has not been made", what, i);
    }
  };
  check(view.scenario.closures, "closure");
  check(view.scenario.zones, "zone");
  for (const Scenario::Closed& one : view.scenario.closed) {
    if (one.until_us > view.now_us) continue;
    view.Violate("orders", "what {} closed until {} us is still closed", one.order, one.until_us);
  }
}

/// Where the scenario wants it, an emergency that opens is decided on in its tick.
void CheckEmergencies(const View& view) {
  if (!view.scenario.emergencies_at_once || view.due >= 0 ||
      view.now_us >= view.scenario.limit_us) {
    return;
  }
  const auto check = [&](int id, bool opens) {
    const auto i = static_cast<std::size_t>(id);
    if (!opens || !view.scenario.tasks[i].is_emergency()) return;
    view.Violate("orders", "task {}, an emergency, opens without a decision", id);
  };
  for (int id = 0; id < view.n_tasks; ++id) {
    const auto i = static_cast<std::size_t>(id);
    check(id, view.task_status[i] == TaskStatus::kUnreported &&
                  view.scenario.tasks[i].reported_us <= view.now_us);
  }
  for (const AuditOrder& order : view.orders) {
    if (order.what != "task_change" && order.what != "task_resume") continue;
    const std::int8_t status = view.task_status[static_cast<std::size_t>(order.task)];
    check(order.task, order.what == "task_resume" || status == TaskStatus::kOpen);
  }
}

void OrderCheck::CheckWays(View& view) {
  view.ways_since_us.reset();
  if (!view.said->orders) return;
  for (const taken_order_t& taken : view.said->orders->taken) {
    try {
      AuditOrder order = ParseAuditOrder(taken.json, view.now_us, view.scenario);
      order.id = taken.id;
      if (!order.changes_ways()) continue;
      if (const std::string wrong = WrongOf(view, order); !wrong.empty()) {
        view.Violate("orders", "order {}: {}", taken.id, wrong);
        continue;
      }
      TakeWayOrder(view, order);
    } catch (const std::exception&) {  // Check() says so
    }
  }
  if (!view.ways_since_us) return;
  Scenario& scenario = view.scenario;
  if (scenario.changes.empty()) {
    scenario.changes.emplace_back(std::numeric_limits<std::int64_t>::min(), scenario.ways);
  }
  scenario.TakeWays();
  scenario.changes.emplace_back(view.now_us, scenario.ways);
}

void OrderCheck::CheckWithdrawal(const View& view, const AuditOrder& order, bool is_of_world) {
  if (order.is_withdrawal()) {
    const auto& refused = view.said->orders->refused;
    const bool is_now = std::any_of(refused.begin(), refused.end(),
                                    [&](const auto& one) { return one.id == order.closure; });
    if (answered_.contains(order.closure) && !is_now) {
      view.Violate("orders", "order {}: withdraws {}, which was answered before", order.id,
                   order.closure);
    }
    withdrawn_[order.closure].insert(order.by);
    return;
  }
  const auto found = withdrawn_.find(order.id);
  if (is_of_world || found == withdrawn_.end() || !found->second.contains(order.by)) return;
  view.Violate("orders", "order {}: was withdrawn and is taken", order.id);
}

void OrderCheck::Check(View& view) {
  if (!view.said->orders) return;
  const orders_t& orders = *view.said->orders;
  if (orders.before != static_cast<std::int64_t>(answered_.size())) {
    view.Violate("orders", "{} orders are said to have come before, {} have", orders.before,
                 answered_.size());
  }
  const auto answer = [&](const std::string& id) {
    if (!answered_.insert(id).second) view.Violate("orders", "order {}: was answered before", id);
  };
  for (const refused_order_t& order : orders.refused) answer(order.id);
  for (const taken_order_t& taken : orders.taken) {
    answer(taken.id);
    AuditOrder order;
    try {
      order = ParseAuditOrder(taken.json, view.now_us, view.scenario);
    } catch (const std::exception& error) {
      view.Violate("orders", "order {}: cannot be read: {}", taken.id, error.what());
      continue;
    }
    order.id = taken.id;
    CheckWithdrawal(view, order, taken.issuer == kWorld);
    if (order.is_withdrawal() || order.changes_ways()) continue;  // CheckWays has the latter
    order.task = taken.task_id;
    order.kind = NumberOfClass(taken.agent_kind);
    order.agent = taken.agent_id;
    if (const std::string wrong = WrongOf(view, order); !wrong.empty()) {
      view.Violate("orders", "order {}: {}", taken.id, wrong);
      continue;
    }
    if (order.is_person() || order.asks_for_decision()) continue;
    if (order.is_directive()) {
      TakeDirective(order, &view.scenario);
      continue;
    }
    TakeOrder(view, order);
    view.orders.push_back(order);
  }
  CheckPlanned(view, answered_);
  CheckEmergencies(view);
}

std::int64_t OrderedEnd(const View& view, const Activity& activity) {
  for (const AuditOrder& order : view.orders) {
    const bool of_task = activity.senses() && order.task == activity.site && !order.is_agents();
    const bool cancels = of_task && order.what == "task_cancel" && activity.end_us > view.now_us;
    const bool holds = of_task && order.what == "task_hold" && activity.start_us > view.now_us;
    const bool recalls = order.what == "agent_recall" && activity.end_us > view.now_us &&
                         activity.involves(order.kind, order.agent);
    if (cancels || holds || recalls) return view.now_us;
  }
  return kForever;
}

bool IsRecalled(const View& view, int kind, int id) {
  return std::any_of(view.orders.begin(), view.orders.end(), [&](const AuditOrder& order) {
    return order.what == "agent_recall" && order.kind == kind && order.agent == id;
  });
}

void FollowOrders(View& view) {
  for (const AuditOrder& order : std::exchange(view.orders, {})) {
    if (order.is_join()) {
      Join(view, order);
    } else if (order.is_agents()) {
      Leave(view, order);
    } else if (!order.is_add()) {
      ChangeTask(view, order);
    }
  }
}

}  // namespace muster::tools::audit
