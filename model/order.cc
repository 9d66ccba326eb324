#include "model/order.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/check.h"
#include "base/number_text.h"
#include "model/scenario_json.h"

namespace muster {
namespace {

static_assert(std::all_of(std::begin(kOrderRows), std::end(kOrderRows),
                          [](const OrderRow& row) { return &row == &RowOf(row.kind); }));

/// As the one item of a scenario, so that the file's rules are the order's.
template <class Item>
void CheckItem(const Scenario& scenario, std::vector<Item> Scenario::*list, Item item) {
  Scenario one;
  one.name = scenario.name;
  one.width_m = scenario.width_m;
  one.height_m = scenario.height_m;
  one.rules = scenario.rules;
  one.uavs = {scenario.uavs.front()};
  one.workers = {scenario.workers.front()};
  one.vehicles = {scenario.vehicles.front()};
  one.charging_points = {scenario.charging_points.front()};
  one.*list = {std::move(item)};
  ValidateScenario(one, "order", true);
}

[[noreturn]] void NoRoom(std::string_view what) {
  throw InputError(
      fmt::format("no room for another {}: the mission was started without more", what));
}

void CheckTimes(const Task& task, TimeUs t) {
  if (task.expires_us <= t) {
    throw InputError("order", "expires_min", TimeToText(task.expires_us, kMinute),
                     fmt::format("later than now ({})", TimeToText(t, kMinute)));
  }
}

/// Counts from when it is taken.
void FixTimes(const Order& order, TimeUs t, Task* task) {
  if (order.due_us) task->due_us = *order.due_us;
  if (order.expires_us) task->expires_us = *order.expires_us;
  if (order.due_in_us) task->due_us = t + *order.due_in_us;
  if (order.expires_in_us) task->expires_us = t + *order.expires_in_us;
}

std::int32_t AddTask(const Order& order, TimeUs t, Scenario* scenario) {
  if (scenario->room.tasks == 0) NoRoom("task");
  Task task = order.task;
  task.reported_us = std::max(task.reported_us, t);
  FixTimes(order, t, &task);
  // A report that comes late of what was due already.
  if (task.due_us != kNever) task.due_us = std::max(task.due_us, task.reported_us);
  CheckItem(*scenario, &Scenario::tasks, task);
  CheckTimes(task, t);
  const std::size_t id = scenario->n_tasks();
  scenario->tasks[id] = std::move(task);
  --scenario->room.tasks;
  return static_cast<std::int32_t>(id);
}

void ChangeTask(const Order& order, TimeUs t, Task* task, const Scenario& scenario) {
  Task changed = *task;
  FixTimes(order, t, &changed);
  if (order.priority) changed.priority = *order.priority;
  if (order.name) changed.name = *order.name;
  if (order.note) changed.note = *order.note;
  CheckItem(scenario, &Scenario::tasks, changed);
  CheckTimes(changed, t);
  *task = std::move(changed);
}

std::int32_t AddAgent(const Order& order, TimeUs t, Scenario* scenario) {
  const AgentKind kind = order.agent_kind;
  std::size_t& room = scenario->room.agents[kind];
  if (room == 0) NoRoom(ToString(kind));
  constexpr PerKind<std::vector<AgentSpec> Scenario::*> kLists = {
      &Scenario::uavs, &Scenario::workers, &Scenario::vehicles};
  const auto list = kLists[kind];
  AgentSpec agent = order.agent;
  agent.online_from_us = std::max(agent.online_from_us, t);
  if (agent.online_until_us == kNever) agent.online_until_us = scenario->rules.limit_us;
  CheckItem(*scenario, list, agent);
  const std::size_t id = scenario->n_agents(kind);
  (scenario->*list)[id] = agent;
  --room;
  return static_cast<std::int32_t>(id);
}

/// Roads that the order names, ascending.
std::vector<std::int32_t> RoadsOf(const Order& order, const Scenario& scenario) {
  std::vector<std::int32_t> roads = RoadsIn(*scenario.roads->network, *order.area);
  if (roads.empty()) {
    throw InputError("order", "roads", RoadAreaToJson(*order.area), "a place where roads are");
  }
  return roads;
}

void CheckUntil(const Order& order, TimeUs t) {
  const TimeUs until_us = order.UntilUs(t);
  if (until_us > t) return;
  throw InputError("order", "until_min", TimeToText(until_us, kMinute),
                   fmt::format("later than now ({})", TimeToText(t, kMinute)));
}

void CloseRoads(const Order& order, TimeUs t, Scenario* scenario) {
  CheckUntil(order, t);
  // What has been reported of earlier ticks stands.
  const TimeUs tick_us = scenario->rules.tick_us;
  if (order.since_us && (*order.since_us > t || *order.since_us < t - tick_us)) {
    throw InputError("order", "since_min", TimeToText(*order.since_us, kMinute),
                     fmt::format("a time in the last tick ({} to {})",
                                 TimeToText(t - tick_us, kMinute), TimeToText(t, kMinute)));
  }
  std::vector<std::int32_t> roads = RoadsOf(order, *scenario);
  const bool any_open = std::any_of(roads.begin(), roads.end(), [&](std::int32_t road) {
    return std::none_of(
        scenario->closures.begin(), scenario->closures.end(), [&](const Closure& closure) {
          return std::binary_search(closure.roads.begin(), closure.roads.end(), road);
        });
  });
  if (!any_open) throw InputError("all of these roads are closed already");
  scenario->closures.push_back({order.id, order.name.value_or(""), t, std::move(roads)});
  ChangeWays(t, scenario);
}

void AddZone(const Order& order, TimeUs t, Scenario* scenario) {
  CheckUntil(order, t);
  scenario->closures.push_back(
      {order.id, order.zone->name, t, {}, std::make_shared<const Zone>(*order.zone)});
  ChangeWays(t, scenario);
}

void LiftZone(const Order& order, TimeUs t, Scenario* scenario) {
  const auto n = std::erase_if(scenario->closures, [&](const Closure& closure) {
    return closure.zone && closure.order == order.closure;
  });
  if (n == 0) throw InputError(fmt::format("there is no zone of an order {}", order.closure));
  ChangeWays(t, scenario);
}

void OpenRoads(const Order& order, TimeUs t, Scenario* scenario) {
  std::vector<Closure>& closures = scenario->closures;
  if (!order.area) {
    const auto n = std::erase_if(
        closures, [&](const Closure& c) { return !c.zone && c.order == order.closure; });
    if (n == 0) throw InputError(fmt::format("no roads are closed by an order {}", order.closure));
    return ChangeWays(t, scenario);
  }
  const std::vector<std::int32_t> opened = RoadsOf(order, *scenario);
  std::size_t n = 0;
  for (Closure& closure : closures) {
    n += std::erase_if(closure.roads, [&](std::int32_t road) {
      return std::binary_search(opened.begin(), opened.end(), road);
    });
  }
  if (n == 0) throw InputError("none of these roads is closed");
  std::erase_if(closures, [](const Closure& c) { return !c.zone && c.roads.empty(); });
  ChangeWays(t, scenario);
}

void RequireAgent(const Scenario& scenario, AgentKind kind, std::int32_t id) {
  if (id >= 0 && static_cast<std::size_t>(id) < scenario.n_agents(kind)) return;
  throw InputError(fmt::format("there is no {}:{}: the last is {}", ToString(kind), id,
                               scenario.n_agents(kind) - 1));
}

void RequireTask(const Scenario& scenario, std::int32_t id) {
  if (id >= 0 && static_cast<std::size_t>(id) < scenario.n_tasks()) return;
  throw InputError(fmt::format("there is no task {}: there are {}", id, scenario.n_tasks()));
}

bool IsPinOf(const Directive& directive, std::int32_t task) {
  return directive.kind == Directive::Kind::kPin && directive.task == task;
}

void AddDirective(const Order& order, Scenario* scenario) {
  Directive directive = *order.directive;
  directive.order = order.id;
  directive.issuer = order.issuer;
  for (const AgentKind kind : kAgentKinds) {
    if (directive.agents[kind] >= 0) RequireAgent(*scenario, kind, directive.agents[kind]);
  }
  if (directive.task >= 0) RequireTask(*scenario, directive.task);
  if (directive.charge >= 0 &&
      static_cast<std::size_t>(directive.charge) >= scenario->charging_points.size()) {
    throw InputError(fmt::format("there is no charging point {}: there are {}", directive.charge,
                                 scenario->charging_points.size()));
  }
  auto& all = scenario->directives;
  using What = Directive::Kind;
  if (directive.kind == What::kPin) {
    const auto other = std::find_if(
        all.begin(), all.end(), [&](const Directive& one) { return IsPinOf(one, directive.task); });
    if (other != all.end()) {
      throw InputError(fmt::format("task {} is pinned already by order {}: unpin it first",
                                   directive.task, other->order));
    }
  }
  if (directive.kind == What::kGoTo) {
    const Point at = directive.place;
    if (!(at.x_m >= 0 && at.y_m >= 0 && at.x_m <= scenario->width_m &&
          at.y_m <= scenario->height_m)) {
      throw InputError(fmt::format(
          "({}, {}) km is outside the area of {} x {} km", ToText(at.x_m, kKm), ToText(at.y_m, kKm),
          ToText(scenario->width_m, kKm), ToText(scenario->height_m, kKm)));
    }
  }
  // The later word of its kind about an agent stands.
  if (directive.kind == What::kGoTo || directive.kind == What::kChargeNow) {
    const AgentKind kind = directive.agent_kind();
    std::erase_if(all, [&](const Directive& one) {
      return one.kind == directive.kind && one.agents[kind] == directive.agents[kind];
    });
  }
  all.push_back(std::move(directive));
}

void EndDirective(const Order& order, Scenario* scenario) {
  const bool unpins = order.kind == OrderKind::kUnpin;
  const auto n = std::erase_if(scenario->directives, [&](const Directive& one) {
    return unpins ? IsPinOf(one, order.task_id) : one.order == order.closure;
  });
  if (n > 0) return;
  throw InputError(unpins ? fmt::format("task {} is not pinned", order.task_id)
                          : fmt::format("no directive of an order {} is in force", order.closure));
}

void TakePerson(const Person& person, Scenario* scenario) {
  constexpr std::size_t kMostPersons = 10'000;
  std::vector<Person>& persons = scenario->persons;
  const auto known = std::find_if(persons.begin(), persons.end(),
                                  [&](const Person& other) { return other.name == person.name; });
  if (known != persons.end()) {
    *known = person;
  } else if (persons.size() < kMostPersons) {
    persons.push_back(person);
  } else {
    throw InputError(fmt::format("there are {} persons already", persons.size()));
  }
}

}  // namespace

TakenOrder TakeInto(Scenario* scenario, const Order& order, TimeUs t) {
  TakenOrder taken{order, order.task_id, order.agent_id};
  switch (RowOf(order.kind).subject) {
    case OrderSubject::kNewTask:
      taken.task_id = AddTask(order, t, scenario);
      return taken;
    case OrderSubject::kNewAgent:
      taken.agent_id = AddAgent(order, t, scenario);
      return taken;
    case OrderSubject::kAgent:
      RequireAgent(*scenario, order.agent_kind, order.agent_id);
      return taken;
    case OrderSubject::kRoads:
      if (scenario->roads == nullptr) throw InputError("the scenario has no roads");
      order.kind == OrderKind::kRoadClose ? CloseRoads(order, t, scenario)
                                          : OpenRoads(order, t, scenario);
      return taken;
    case OrderSubject::kAir:
      if (scenario->air == nullptr) throw InputError("the scenario has no key air");
      order.kind == OrderKind::kZoneAdd ? AddZone(order, t, scenario)
                                        : LiftZone(order, t, scenario);
      return taken;
    case OrderSubject::kDirective:
      order.directive ? AddDirective(order, scenario) : EndDirective(order, scenario);
      return taken;
    case OrderSubject::kPerson:
      TakePerson(*order.person, scenario);
      return taken;
    case OrderSubject::kOrder:
      return taken;
    case OrderSubject::kDecision:
      if (t >= scenario->rules.limit_us) throw InputError("the mission is over");
      scenario->rules.DecideAt(scenario->rules.TickOf(t));
      return taken;
    case OrderSubject::kTask:
      break;
  }
  RequireTask(*scenario, order.task_id);
  if (order.kind == OrderKind::kTaskChange) {
    ChangeTask(order, t, &scenario->tasks[static_cast<std::size_t>(order.task_id)], *scenario);
  }
  return taken;
}

void FollowWays(AgentState* agent, std::span<const TakenOrder> taken, TimeUs t,
                const Scenario& scenario) {
  TimeUs since_us = kNever;
  for (const TakenOrder& one : taken) {
    if (!ChangesWays(one.order.kind)) continue;
    // A road may be closed since before; an agent in the air hears of zones alone, now.
    const bool flies = agent->kind == AgentKind::kUav;
    since_us = std::min({since_us, t, flies ? t : one.order.since_us.value_or(t)});
  }
  if (since_us != kNever) GoRound(agent, since_us, t, scenario.WaysAt(t));
}

void Obey(AgentState* agent, const TakenOrder& taken, TimeUs t, const Scenario& scenario) {
  const Order& order = taken.order;
  if (agent->kind != order.agent_kind || agent->id != taken.agent_id) return;
  const OrderSubject subject = RowOf(order.kind).subject;
  if (subject == OrderSubject::kNewAgent) {
    const AgentSpec& spec = scenario.agents(agent->kind)[static_cast<std::size_t>(agent->id)];
    // The scenario may hold the orders of the next tick, too.
    *agent = StartOf(agent->kind, agent->id, spec, scenario.WaysAt(t));
  }
  if (subject == OrderSubject::kAgent) {
    const bool busy = agent->busy_until_us != kNever && agent->busy_until_us > t;
    agent->online_until_us = std::min(agent->online_until_us, busy ? agent->busy_until_us : t);
  }
}

}  // namespace muster
