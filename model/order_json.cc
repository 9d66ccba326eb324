#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <initializer_list>
#include <tuple>

#include "base/check.h"
#include "base/object_reader.h"
#include "base/text.h"
#include "model/order.h"
#include "model/task_reader.h"

namespace muster {
namespace {

/// What a task takes whose cost nobody gave: the usual one of the paper's Table 1.
constexpr double kUsualCost_m = 3000;

constexpr std::size_t kMostBytes = 16'000;
constexpr std::size_t kMostName = 200;

OrderKind ReadKind(const ObjectReader& top) {
  const std::string name = top.String("order");
  std::string names;
  for (const OrderRow& row : kOrderRows) {
    if (name == row.name) return row.kind;
    if (row.kind == OrderKind::kPerson) continue;  // the launcher's alone
    names += fmt::format("{}{}", names.empty() ? "one of " : ", ", row.name);
  }
  top.Fail("order", *top.Optional("order"), names);
}

std::optional<TimeUs> OptionalTime(const ObjectReader& object, std::string_view key) {
  if (!object.Has(key)) return {};
  return object.Time(key, kMinute);
}

Point ReadPlace(const ObjectReader& object) {
  return {object.Number("x_km", kKm), object.Number("y_km", kKm)};
}

void ReadTask(const ObjectReader& object, Order* order) {
  object.AllowOnly({"x_km", "y_km", "cost_km", "reported_min", "due_min", "due_in_min",
                    "expires_min", "expires_in_min", "revisit_min", "priority", "name",
                    "external_id", "source", "note"});
  order->task.at = ReadPlace(object);
  order->task.cost_m = !object.Has("cost_km") ? kUsualCost_m : object.Number("cost_km", kKm);
  ReadTaskTimes(object, &order->task);
  order->due_in_us = OptionalTime(object, "due_in_min");
  order->expires_in_us = OptionalTime(object, "expires_in_min");
}

void ReadChange(const ObjectReader& top, Order* order) {
  Task task;
  ReadTaskTimes(top, &task);
  if (top.Has("priority")) order->priority = task.priority;
  if (top.Has("name")) order->name = task.name;
  if (top.Has("note")) order->note = task.note;
  order->due_us = OptionalTime(top, "due_min");
  order->expires_us = OptionalTime(top, "expires_min");
  order->due_in_us = OptionalTime(top, "due_in_min");
  order->expires_in_us = OptionalTime(top, "expires_in_min");
}

void ReadAgent(const ObjectReader& object, Order* order) {
  AgentSpec& agent = order->agent;
  switch (order->agent_kind) {
    case AgentKind::kUav:
      object.AllowOnly({"x_km", "y_km", "speed_km_per_min", "full_range_km", "range_km",
                        "online_from_min", "online_until_min"});
      agent.range_full_m = object.Number("full_range_km", kKm);
      agent.range_m = !object.Has("range_km") ? agent.range_full_m : object.Number("range_km", kKm);
      break;
    case AgentKind::kWorker:
      object.AllowOnly({"x_km", "y_km", "speed_km_per_min", "online_from_min", "online_until_min"});
      break;
    case AgentKind::kVehicle:
      object.AllowOnly({"x_km", "y_km", "speed_km_per_min", "charge_km_per_min", "online_from_min",
                        "online_until_min"});
      agent.charge_rate_m_s = object.Number("charge_km_per_min", kKmPerMin);
      break;
  }
  agent.at = ReadPlace(object);
  agent.speed_m_s = object.Number("speed_km_per_min", kKmPerMin);
  agent.online_from_us = OptionalTime(object, "online_from_min").value_or(0);
  agent.online_until_us = OptionalTime(object, "online_until_min").value_or(kNever);
}

/// As messages carry it.
constexpr std::string_view kBeginningsOfWorld[] = {
    "closure:", "decide:", "fault:", "lift:", "open:", "release:", "revisit:", "zone:"};

std::string ReadName(const ObjectReader& top, std::string_view key) {
  std::string name = top.String(key);
  if (name.size() > kMostName || HasControls(name)) {
    top.Fail(key, name.size() > kMostName ? fmt::format("{} bytes", name.size()) : Printable(name),
             fmt::format("at most {} bytes without control characters", kMostName));
  }
  return name;
}

/// "uav:3", which stands at `key`.
std::pair<AgentKind, std::int32_t> AgentNamed(const ObjectReader& top, std::string_view key,
                                              const std::string& name) {
  const std::size_t colon = name.find(':');
  const auto kind = FromString<AgentKind>(std::string_view(name).substr(0, colon));
  const std::string digits = colon == std::string::npos ? "" : name.substr(colon + 1);
  const bool is_id = !digits.empty() && digits.size() < 10 &&
                     digits.find_first_not_of("0123456789") == std::string::npos;
  if (!kind || !is_id) {
    top.Fail(key, *top.Optional(key), "an agent, as \"uav:3\"");
  }
  return {*kind, std::stoi(digits)};
}

void ReadAgentName(const ObjectReader& top, Order* order) {
  std::tie(order->agent_kind, order->agent_id) = AgentNamed(top, "agent", top.String("agent"));
}

/// ["uav:3", "worker:7"]: at most one of each class, of these classes.
void ReadAgents(const ObjectReader& top, std::initializer_list<AgentKind> classes,
                Directive* directive) {
  const JsonValue& list = top.Required("agents", "a list of agents, as [\"uav:3\"]");
  if (list.type != JsonValue::Type::kArray || list.items.empty()) {
    top.Fail("agents", list, "a list of agents, as [\"uav:3\"]");
  }
  for (const JsonValue& item : list.items) {
    if (item.type != JsonValue::Type::kString) top.Fail("agents", item, "an agent, as \"uav:3\"");
    const auto [kind, id] = AgentNamed(top, "agents", item.text);
    if (std::find(classes.begin(), classes.end(), kind) == classes.end()) {
      top.Fail("agents", item.text, "an agent of a class that takes part in it");
    }
    if (directive->agents[kind] >= 0) {
      top.Fail("agents", item.text, fmt::format("one {}", ToString(kind)));
    }
    directive->agents[kind] = id;
  }
}

std::int32_t ReadId(const ObjectReader& top, std::string_view key) {
  return static_cast<std::int32_t>(top.Integer(key, 0, INT32_MAX));
}

void ReadOneAgent(const ObjectReader& top, Directive* directive) {
  const auto [kind, id] = AgentNamed(top, "agent", top.String("agent"));
  directive->agents[kind] = id;
}

void ReadForbid(const ObjectReader& top, Directive* directive) {
  if (top.Has("class")) {
    top.AllowOnly({"id", "issuer", "at_min", "order", "class", "area_km", "circle_km"});
    const auto kind = FromString<AgentKind>(top.String("class"));
    if (!kind) top.Fail("class", *top.Optional("class"), "uav, worker or vehicle");
    directive->of_class = *kind;
    directive->area = std::make_shared<const Zone>(ReadZone(top));
    return;
  }
  top.AllowOnly({"id", "issuer", "at_min", "order", "agent", "task"});
  ReadOneAgent(top, directive);
  directive->task = ReadId(top, "task");
  if (directive->agents.vehicles >= 0) {
    top.Fail("agent", *top.Optional("agent"), "a UAV or a worker: vehicles do no tasks");
  }
}

void ReadDirective(const ObjectReader& top, Order* order) {
  Directive directive;
  switch (order->kind) {
    case OrderKind::kPin:
      top.AllowOnly({"id", "issuer", "at_min", "order", "agents", "task"});
      directive.kind = Directive::Kind::kPin;
      ReadAgents(top, {AgentKind::kUav, AgentKind::kWorker}, &directive);
      directive.task = ReadId(top, "task");
      break;
    case OrderKind::kForbid:
      directive.kind = Directive::Kind::kForbid;
      ReadForbid(top, &directive);
      break;
    case OrderKind::kChargeNow:
      top.AllowOnly({"id", "issuer", "at_min", "order", "agents", "charge"});
      directive.kind = Directive::Kind::kChargeNow;
      ReadAgents(top, {AgentKind::kUav, AgentKind::kVehicle}, &directive);
      if (directive.agents.uavs < 0) top.Fail("agents", "no UAV", "the UAV to be charged");
      if (top.Has("charge")) directive.charge = ReadId(top, "charge");
      break;
    case OrderKind::kGoTo:
      top.AllowOnly({"id", "issuer", "at_min", "order", "agent", "x_km", "y_km"});
      directive.kind = Directive::Kind::kGoTo;
      ReadOneAgent(top, &directive);
      directive.place = ReadPlace(top);
      break;
    case OrderKind::kUnpin:
      top.AllowOnly({"id", "issuer", "at_min", "order", "task"});
      order->task_id = ReadId(top, "task");
      return;
    default:
      top.AllowOnly({"id", "issuer", "at_min", "order", "directive"});
      order->closure = ReadName(top, "directive");
      return;
  }
  order->task_id = directive.task;
  order->directive = std::move(directive);
}

void ReadPerson(const ObjectReader& top, Order* order) {
  top.AllowOnly({"id", "issuer", "at_min", "order", "name", "role", "key", "why"});
  Person person;
  person.name = ReadName(top, "name");
  if (person.name.empty()) top.Fail("name", "nothing", "a name");
  const auto role = RoleOf(top.String("role"));
  if (!role) top.Fail("role", *top.Optional("role"), "none, watch, order or control");
  person.role = *role;
  if (top.Has("key")) person.key = top.String("key");
  const bool is_key = person.key.size() == 64 &&
                      person.key.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (!person.key.empty() && !is_key) {
    top.Fail("key", *top.Optional("key"), "a public key of 64 hexadecimal digits");
  }
  if (top.Has("why")) person.why = ReadName(top, "why");
  order->person = std::move(person);
}

void ReadUntil(const ObjectReader& top, Order* order) {
  order->until_us = OptionalTime(top, "until_min");
  order->until_in_us = OptionalTime(top, "until_in_min");
  if (order->until_us && order->until_in_us) {
    top.Fail("until_in_min", *top.Optional("until_in_min"), "nothing beside until_min");
  }
}

void ReadRoadOrder(const ObjectReader& top, Order* order) {
  if (order->kind == OrderKind::kRoadOpen) {
    top.AllowOnly(
        {"id", "issuer", "at_min", "order", "area_km", "circle_km", "roads", "near_km", "closure"});
    if (top.Has("closure")) {
      order->closure = ReadName(top, "closure");
      for (const std::string_view key : kRoadAreaKeys) {
        if (top.Has(key)) top.Fail(key, *top.Optional(key), "nothing beside closure");
      }
      return;
    }
  } else {
    top.AllowOnly({"id", "issuer", "at_min", "order", "area_km", "circle_km", "roads", "near_km",
                   "name", "since_min", "until_min", "until_in_min"});
    if (top.Has("name")) order->name = ReadName(top, "name");
    order->since_us = OptionalTime(top, "since_min");
    ReadUntil(top, order);
  }
  order->area = ReadRoadArea(top);
}

void ReadZoneOrder(const ObjectReader& top, Order* order) {
  if (order->kind == OrderKind::kZoneLift) {
    top.AllowOnly({"id", "issuer", "at_min", "order", "zone"});
    order->closure = ReadName(top, "zone");
    return;
  }
  top.AllowOnly({"id", "issuer", "at_min", "order", "area_km", "circle_km", "holes_km", "name",
                 "until_min", "until_in_min"});
  order->zone = ReadZone(top);
  if (top.Has("name")) order->zone->name = ReadName(top, "name");
  ReadUntil(top, order);
}

}  // namespace

bool IsIdOfWorld(std::string_view id) {
  return std::any_of(std::begin(kBeginningsOfWorld), std::end(kBeginningsOfWorld),
                     [&](std::string_view begin) { return id.starts_with(begin); });
}

Order ParseOrder(std::string_view json, const std::string& where) {
  if (json.size() > kMostBytes) {
    throw InputError(where, "order", fmt::format("{} bytes", json.size()),
                     fmt::format("at most {}", kMostBytes));
  }
  const SignedOrder parts = SplitSignature(json, where);
  const JsonValue tree = ParseJson(parts.order, where);
  const ObjectReader top(tree, "", where);
  Order order;
  order.kind = ReadKind(top);
  order.signed_by = parts.by;
  if (top.Has("id")) order.id = ReadName(top, "id");
  if (IsIdOfWorld(order.id)) {
    top.Fail("id", order.id,
             fmt::format("an id that does not begin with {}", fmt::join(kBeginningsOfWorld, ", ")));
  }
  if (top.Has("issuer")) order.issuer = ReadName(top, "issuer");
  order.not_before_us = OptionalTime(top, "at_min").value_or(0);
  switch (RowOf(order.kind).subject) {
    case OrderSubject::kNewTask:
      top.AllowOnly({"id", "issuer", "at_min", "order", "task"});
      ReadTask(top.Child("task"), &order);
      return order;
    case OrderSubject::kNewAgent: {
      top.AllowOnly({"id", "issuer", "at_min", "order", "class", "agent"});
      const auto kind = FromString<AgentKind>(top.String("class"));
      if (!kind) top.Fail("class", *top.Optional("class"), "uav, worker or vehicle");
      order.agent_kind = *kind;
      ReadAgent(top.Child("agent"), &order);
      return order;
    }
    case OrderSubject::kAgent:
      top.AllowOnly({"id", "issuer", "at_min", "order", "agent"});
      ReadAgentName(top, &order);
      return order;
    case OrderSubject::kRoads:
      ReadRoadOrder(top, &order);
      return order;
    case OrderSubject::kAir:
      ReadZoneOrder(top, &order);
      return order;
    case OrderSubject::kDirective:
      ReadDirective(top, &order);
      return order;
    case OrderSubject::kPerson:
      ReadPerson(top, &order);
      return order;
    case OrderSubject::kOrder:
      top.AllowOnly({"id", "issuer", "at_min", "order", "withdraws"});
      order.closure = ReadName(top, "withdraws");
      return order;
    case OrderSubject::kDecision:
      top.AllowOnly({"id", "issuer", "at_min", "order"});
      return order;
    case OrderSubject::kTask:
      if (order.kind != OrderKind::kTaskChange) {
        top.AllowOnly({"id", "issuer", "at_min", "order", "task"});
        break;
      }
      top.AllowOnly({"id", "issuer", "at_min", "order", "task", "priority", "due_min", "due_in_min",
                     "expires_min", "expires_in_min", "name", "note"});
      ReadChange(top, &order);
      break;
  }
  order.task_id = static_cast<std::int32_t>(top.Integer("task", 0, INT32_MAX));
  return order;
}

}  // namespace muster
