#include "tools/scenario/order_text.h"

#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>
#include <utility>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/text_file.h"
#include "model/order.h"
#include "tools/scenario/window.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

/// latitude_deg and longitude_deg of a task, an agent or an order itself, as x_km and y_km.
void PutOnMap(Json* item, const std::string& where, const std::string& key,
              const std::optional<Origin>& origin) {
  if (!item->is_object() || !(item->contains("latitude_deg") || item->contains("longitude_deg"))) {
    return;
  }
  if (!origin) {
    throw InputError(where, key + ".latitude_deg", "a place on Earth",
                     "x_km and y_km: this scenario has no origin");
  }
  const auto degrees = [&](const char* name, double most) {
    const auto value = item->find(name);
    if (value == item->end() || !value->is_number() || !(std::abs(value->get<double>()) <= most)) {
      throw InputError(where, fmt::format("{}.{}", key, name),
                       value == item->end() ? "no such key" : value->dump(),
                       fmt::format("a number in [-{}, {}]", most, most));
    }
    return value->get<double>();
  };
  const Origin place{degrees("latitude_deg", 90), degrees("longitude_deg", 180)};
  const Point at = Project({place}, *origin).front();
  item->erase("latitude_deg");
  item->erase("longitude_deg");
  (*item)["x_km"] = at.x_m / 1000;
  (*item)["y_km"] = at.y_m / 1000;
}

/// area_deg, circle_deg or near_deg of an order about roads or zones, as area_km, circle_km or
/// near_km.
void PutAreaOnMap(Json* order, const std::string& where, const std::optional<Origin>& origin) {
  for (const std::string name : {"area", "circle", "near"}) {
    const std::string key = name + "_deg";
    if (!order->contains(key)) continue;
    if (!origin) {
      throw InputError(where, key, "a place on Earth",
                       fmt::format("{}_km: this scenario has no origin", name));
    }
    Json area = std::exchange((*order)[key], nullptr);
    order->erase(key);
    const auto put = [&](Json* place, std::size_t n) {
      if (!place->is_array() || place->size() != n || !(*place)[0].is_number() ||
          !(*place)[1].is_number() || !(std::abs((*place)[0].get<double>()) <= 90) ||
          !(std::abs((*place)[1].get<double>()) <= 180)) {
        throw InputError(where, key, place->dump(), "latitude and longitude in degrees");
      }
      const Point at =
          Project({{(*place)[0].get<double>(), (*place)[1].get<double>()}}, *origin).front();
      (*place)[0] = at.x_m / 1000;
      (*place)[1] = at.y_m / 1000;
    };
    if (name == "area" && area.is_array()) {
      for (Json& corner : area) put(&corner, 2);
    } else {
      put(&area, name == "circle" ? 3 : 2);
    }
    (*order)[name + "_km"] = std::move(area);
  }
}

}  // namespace

std::string FreshOrderId() {
  std::random_device device;
  return fmt::format("{:08x}{:08x}", device(), device());
}

world::PlannedOrder ReadOrder(std::string_view text, const std::string& where,
                              const std::optional<Origin>& origin) {
  // For its own errors, which name line and column, and for what another parser would let pass.
  ParseJson(text, where);
  Json json = Json::parse(text);
  if (!json.is_object()) throw InputError(where, "top level", "no object", "an object");
  if (json.contains("task")) PutOnMap(&json["task"], where, "task", origin);
  if (json.contains("agent")) PutOnMap(&json["agent"], where, "agent", origin);
  PutOnMap(&json, where, "order", origin);
  PutAreaOnMap(&json, where, origin);
  world::PlannedOrder planned;
  planned.order = ParseOrder(json.dump(), where);
  if (planned.order.kind == OrderKind::kPerson) {
    throw InputError(where, "order", "person", "another order: the launcher gives it (--persons)");
  }
  if (planned.order.id.empty()) planned.order.id = FreshOrderId();
  json.erase("id");
  json.erase("issuer");
  planned.json = json.dump();
  return planned;
}

std::vector<world::PlannedOrder> ReadOrderFile(const std::string& file,
                                               const std::optional<Origin>& origin) {
  std::istringstream opened(file == "-" ? "" : ReadTextFile(file, "orders"));
  std::istream& in = file == "-" ? std::cin : opened;
  std::vector<world::PlannedOrder> orders;
  std::set<std::string> ids;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string where = fmt::format("{}: line {}", file == "-" ? "stdin" : file, number);
    orders.push_back(ReadOrder(line, where, origin));
    if (!ids.insert(orders.back().order.id).second) {
      throw InputError(where, "id", orders.back().order.id, "an id that no earlier order has");
    }
  }
  return orders;
}

std::string OrderLines(const std::vector<world::PlannedOrder>& orders) {
  std::string lines;
  for (const world::PlannedOrder& planned : orders) {
    Json json = {{"id", planned.order.id}, {"issuer", planned.order.issuer}};
    json.update(Json::parse(planned.json));
    lines += json.dump() + "\n";
  }
  return lines;
}

Room RoomFor(const std::vector<world::PlannedOrder>& orders) {
  Room room;
  for (const world::PlannedOrder& planned : orders) {
    if (planned.order.kind == OrderKind::kTaskAdd) ++room.tasks;
    if (planned.order.kind == OrderKind::kAgentJoin) ++room.agents[planned.order.agent_kind];
  }
  return room;
}

}  // namespace muster::tools
