#include "tools/log/log_orders.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/check.h"
#include "base/number_text.h"
#include "model/scenario_json.h"
#include "protocol/mission_reader.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

/// Without the vacant ends of its lists, but for one place where a list would be empty: no scenario
/// has those.
Scenario WithoutRoom(Scenario scenario) {
  scenario.tasks.resize(scenario.n_tasks());
  scenario.uavs.resize(scenario.n_agents(AgentKind::kUav));
  scenario.workers.resize(scenario.n_agents(AgentKind::kWorker));
  scenario.vehicles.resize(scenario.n_agents(AgentKind::kVehicle));
  scenario.room = {};
  scenario.had_room = false;
  AddRoom({scenario.tasks.empty() ? 1U : 0U,
           {scenario.uavs.empty() ? 1U : 0U, scenario.workers.empty() ? 1U : 0U,
            scenario.vehicles.empty() ? 1U : 0U}},
          &scenario);
  return scenario;
}

std::string Line(const taken_order_t& order, TimeUs at_us) {
  // Its time is written as the scenario's times are, digit for digit.
  Json json = Json::parse(order.json);
  for (const char* key : {"id", "issuer", "at_min", "signed"}) json.erase(key);
  std::string body = json.dump();
  return fmt::format("{{\"id\":{},\"issuer\":{},\"at_min\":{},{}\n", Json(order.id).dump(),
                     Json(order.issuer).dump(), TimeToText(at_us, kMinute), body.substr(1));
}

}  // namespace

CapturedOrders CaptureOrders(MessageSource* source) {
  source->Rewind();
  MissionReader reader;
  CapturedOrders captured;
  const auto visit = [&](const Message& message, const Packet&) {
    if (std::holds_alternative<scenario_t>(message) && !captured.scenario) {
      captured.scenario = WithoutRoom(*reader.scenario());
    }
  };
  while (const auto event = source->NextEvent()) reader.Add(event->packet, visit);
  if (!reader.scenario()) throw InputError(source->name() + ": the log has no scenario");
  const OrderBook& book = reader.orders();
  for (const auto& [tick, orders] : book.said()) {
    if (tick > book.tick()) break;
    for (const taken_order_t& order : orders.taken) {
      // What is done again follows from its task.
      if (order.issuer == process_name::kWorld) continue;
      // Who may order belongs to a run, as signatures do.
      if (ParseOrder(order.json, "order").kind == OrderKind::kPerson) continue;
      ++captured.taken;
      captured.lines += Line(order, book.scenario()->rules.TimeOf(tick));
      const OrderKind kind = ParseOrder(order.json, "order").kind;
      captured.left_out += kind != OrderKind::kTaskAdd && kind != OrderKind::kTaskChange &&
                           kind != OrderKind::kAgentJoin;
    }
  }
  captured.with = WithoutRoom(*book.scenario());
  return captured;
}

}  // namespace muster::tools
