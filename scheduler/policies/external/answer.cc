#include "scheduler/policies/external/answer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/text.h"

namespace muster::scheduler {
namespace {

using Type = JsonValue::Type;

/// What the messages call it.
constexpr std::string_view kLine = "its line";

[[noreturn]] void Refuse(const std::string& key, const JsonValue& found,
                         const std::string& expected) {
  throw InputError(kLine, key, found.Shown(), expected);
}

/// An object of that type with no keys but these.
JsonValue ReadObject(std::string_view line, std::string_view type,
                     const std::vector<std::string_view>& keys) {
  JsonValue root = ParseJson(line, kLine);
  if (root.type != Type::kObject) Refuse("all of it", root, "an object");
  const JsonValue* said = root.Find("type");
  const std::string expected = fmt::format("\"{}\"", type);
  if (said == nullptr) throw InputError(kLine, "type", "nothing", expected);
  if (said->type != Type::kString || said->text != type) Refuse("type", *said, expected);
  for (const auto& [name, value] : root.members) {
    if (name == "type" || std::find(keys.begin(), keys.end(), name) != keys.end()) continue;
    Refuse(name, value, fmt::format("no such key, only type, {}", fmt::join(keys, ", ")));
  }
  return root;
}

std::int64_t ReadInteger(const std::string& key, const JsonValue& value, std::int64_t high) {
  const auto number = value.type == Type::kNumber ? ToInteger(value.text, 0, high) : std::nullopt;
  if (!number) Refuse(key, value, fmt::format("an integer from 0 to {}", high));
  return *number;
}

double ReadNumber(const std::string& key, const JsonValue& value) {
  const auto number = value.type == Type::kNumber ? ToNumber(value.text) : std::nullopt;
  if (!number) Refuse(key, value, "a number");
  return *number;
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

Action ReadAction(const std::string& where, const JsonValue& value, const Situation& situation) {
  if (value.type != Type::kObject) Refuse(where, value, "an object");
  Action action;
  bool has_x = false, has_y = false;
  for (const auto& member : value.members) {
    const auto& [name, value_of_it] = member;
    const JsonValue& field = value_of_it;
    const std::string key = fmt::format("{}.{}", where, name);
    const auto id = [&] {
      return static_cast<std::int32_t>(
          ReadInteger(key, field, std::numeric_limits<std::int32_t>::max()));
    };
    if (name == "kind") {
      const auto kind =
          field.type == Type::kString ? FromString<ActionKind>(field.text) : std::nullopt;
      if (!kind) Refuse(key, field, fmt::format("one of {}", fmt::join(kNames<ActionKind>, ", ")));
      action.kind = *kind;
    } else if (name == "uav") {
      action.uav = UavId(id());
    } else if (name == "worker") {
      action.worker = WorkerId(id());
    } else if (name == "vehicle") {
      action.vehicle = VehicleId(id());
    } else if (name == "task") {
      action.task = TaskId(id());
    } else if (name == "charge") {
      action.charge = ChargeId(id());
    } else if (name == "x_m" || name == "y_m") {
      (name == "x_m" ? action.to.x_m : action.to.y_m) = ReadNumber(key, field);
      (name == "x_m" ? has_x : has_y) = true;
    } else {
      Refuse(key, field, "no such key, only kind, uav, worker, vehicle, task, charge, x_m, y_m");
    }
  }
  if (action.kind == ActionKind::kNone)
    throw InputError(kLine, where + ".kind", "nothing", "a kind");
  const bool goes = action.kind == ActionKind::kGoTo;
  if (has_x != goes || has_y != goes) {
    throw InputError(kLine, where, has_x || has_y ? "a place" : "no place",
                     "x_m and y_m for kind go, and for no other");
  }
  if (!goes) action.to = DestinationOf(action, situation);
  return action;
}

}  // namespace

Greeting ReadGreeting(std::string_view line) {
  const JsonValue root = ReadObject(line, "hello", {"version", "name", "want", "deadline_s"});
  const JsonValue* version = root.Find("version");
  const std::string expected = fmt::to_string(kExternalVersion);
  if (version == nullptr) throw InputError(kLine, "version", "nothing", expected);
  if (version->type != Type::kNumber || version->text != expected) {
    Refuse("version", *version, expected);
  }
  const JsonValue* name = root.Find("name");
  if (name != nullptr && name->type != Type::kString) Refuse("name", *name, "a string");
  Greeting greeting;
  if (const JsonValue* want = root.Find("want")) {
    if (want->type != Type::kArray) Refuse("want", *want, "an array");
    for (const JsonValue& item : want->items) {
      const bool edges = item.type == Type::kString && item.text == "edges";
      if (!edges && !(item.type == Type::kString && item.text == "nodes")) {
        Refuse("want", item, "\"nodes\" or \"edges\"");
      }
      greeting.wishes.nodes = true;
      greeting.wishes.edges = greeting.wishes.edges || edges;
    }
  }
  if (const JsonValue* deadline = root.Find("deadline_s")) {
    greeting.deadline_s = ReadNumber("deadline_s", *deadline);
    if (!(*greeting.deadline_s > 0 && *greeting.deadline_s <= kMostDeadlineS)) {
      Refuse("deadline_s", *deadline, fmt::format("above 0, up to {}", kMostDeadlineS));
    }
  }
  return greeting;
}

Answer ReadAnswer(std::string_view line, const Situation& situation) {
  const JsonValue root = ReadObject(line, "decision", {"id", "actions", "nodes"});
  Answer answer;
  const JsonValue* id = root.Find("id");
  if (id == nullptr) throw InputError(kLine, "id", "nothing", "the situation's");
  answer.id = ReadInteger("id", *id, std::numeric_limits<std::int64_t>::max());
  const JsonValue* actions = root.Find("actions");
  const JsonValue* nodes = root.Find("nodes");
  if ((actions == nullptr) == (nodes == nullptr)) {
    throw InputError(kLine, "actions, nodes", actions == nullptr ? "none" : "both",
                     "one of the two");
  }
  answer.by_node = nodes != nullptr;
  const JsonValue& list = answer.by_node ? *nodes : *actions;
  const std::string name = answer.by_node ? "nodes" : "actions";
  if (list.type != Type::kArray) Refuse(name, list, "an array");
  // What could not be checked in reasonable time need not be.
  const std::size_t agents =
      situation.uavs.size() + situation.workers.size() + situation.vehicles.size();
  if (list.items.size() > agents) {
    Refuse(name, list, fmt::format("at most {}, one an agent", agents));
  }
  for (std::size_t i = 0; i < list.items.size(); ++i) {
    const std::string where = fmt::format("{}[{}]", name, i);
    if (answer.by_node) {
      answer.nodes.push_back(ReadInteger(where, list.items[i], kMostNodes - 1));
    } else {
      answer.actions.push_back(ReadAction(where, list.items[i], situation));
    }
  }
  return answer;
}

}  // namespace muster::scheduler
