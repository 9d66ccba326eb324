#include "scheduler/policies/external/answer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>

#include "base/check.h"
#include "base/object_reader.h"

namespace muster::scheduler {
namespace {

using Type = JsonValue::Type;

/// What the messages call it.
constexpr std::string_view kLine = "its line";

/// An object of that type.
ObjectReader ReadObject(const JsonValue& root, std::string_view type) {
  ObjectReader object(root, "", kLine);
  const std::string expected = fmt::format("\"{}\"", type);
  const JsonValue& said = object.Required("type", expected);
  if (said.type != Type::kString || said.text != type) object.Fail("type", said, expected);
  return object;
}

/// Where an action leads; anywhere when its ids are none of the situation's, which the checker
/// tells better.
Point DestinationOf(const Action& action, const Situation& situation) {
  const Site& site = *situation.site;
  if (action.task.valid()) {
    return action.task.index() < site.tasks.size() ? site.tasks[action.task.index()].at : Point();
  }
  if (action.charge.valid()) {
    const auto& points = site.charging_points;
    return action.charge.index() < points.size() ? points[action.charge.index()].at : Point();
  }
  for (const AgentKind kind : kAgentKinds) {
    for (const AgentState& agent : situation.agents(kind)) {
      if (agent.id == MemberOf(action, kind)) return agent.to;
    }
  }
  return {};
}

Action ReadAction(const ObjectReader& object, const Situation& situation) {
  object.AllowOnly({"kind", "uav", "worker", "vehicle", "task", "charge", "x_m", "y_m"});
  Action action;
  const JsonValue& name = object.Required("kind", "a kind");
  const auto kind = name.type == Type::kString ? FromString<ActionKind>(name.text) : std::nullopt;
  if (!kind) {
    object.Fail("kind", name, fmt::format("one of {}", fmt::join(kNames<ActionKind>, ", ")));
  }
  action.kind = *kind;
  const auto id = [&](std::string_view key) {
    return object.Has(key) ? static_cast<std::int32_t>(object.Integer(key, 0, INT32_MAX)) : -1;
  };
  action.uav = UavId(id("uav"));
  action.worker = WorkerId(id("worker"));
  action.vehicle = VehicleId(id("vehicle"));
  action.task = TaskId(id("task"));
  action.charge = ChargeId(id("charge"));
  const bool goes = action.kind == ActionKind::kGoTo;
  const bool has_x = object.Has("x_m"), has_y = object.Has("y_m");
  if (has_x != goes || has_y != goes) {
    object.Fail("", has_x || has_y ? "a place" : "no place",
                "x_m and y_m for kind go, and for no other");
  }
  action.to =
      goes ? Point{object.Number("x_m"), object.Number("y_m")} : DestinationOf(action, situation);
  return action;
}

}  // namespace

Greeting ReadGreeting(std::string_view line) {
  const JsonValue root = ParseJson(line, kLine);
  const ObjectReader object = ReadObject(root, "hello");
  object.AllowOnly({"type", "version", "name", "want", "deadline_s"});
  object.Expect("version", kExternalVersion);
  if (object.Has("name")) static_cast<void>(object.String("name"));
  Greeting greeting;
  if (object.Has("want")) {
    for (const JsonValue& item : object.Array("want")) {
      const bool edges = item.type == Type::kString && item.text == "edges";
      if (!edges && !(item.type == Type::kString && item.text == "nodes")) {
        object.Fail("want", item, "\"nodes\" or \"edges\"");
      }
      greeting.wishes.nodes = true;
      greeting.wishes.edges = greeting.wishes.edges || edges;
    }
  }
  if (object.Has("deadline_s")) {
    greeting.deadline_s = object.Number("deadline_s");
    if (!(*greeting.deadline_s > 0 && *greeting.deadline_s <= kMostDeadlineS)) {
      object.Fail("deadline_s", *object.Optional("deadline_s"),
                  fmt::format("above 0, up to {}", kMostDeadlineS));
    }
  }
  return greeting;
}

Answer ReadAnswer(std::string_view line, const Situation& situation) {
  const JsonValue root = ParseJson(line, kLine);
  const ObjectReader object = ReadObject(root, "decision");
  object.AllowOnly({"type", "id", "actions", "nodes"});
  Answer answer;
  answer.id = object.Integer("id", 0, std::int64_t{1} << 53);
  answer.by_node = object.Has("nodes");
  if (object.Has("actions") == answer.by_node) {
    object.Fail("actions, nodes", answer.by_node ? "both" : "none", "one of the two");
  }
  const std::string name = answer.by_node ? "nodes" : "actions";
  const std::vector<JsonValue>& list = object.Array(name);
  // What could not be checked in reasonable time need not be.
  const std::size_t agents =
      situation.uavs.size() + situation.workers.size() + situation.vehicles.size();
  if (list.size() > agents) {
    object.Fail(name, *object.Optional(name), fmt::format("at most {}, one an agent", agents));
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (answer.by_node) {
      const std::string where = fmt::format("{}[{}]", name, i);
      answer.nodes.push_back(object.ReadInteger(where, list[i], 0, kMostNodes - 1));
    } else {
      answer.actions.push_back(ReadAction(object.Element(name, list[i], i), situation));
    }
  }
  return answer;
}

}  // namespace muster::scheduler
