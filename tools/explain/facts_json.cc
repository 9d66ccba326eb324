#include "tools/explain/facts_json.h"

#include "protocol/convert.h"
#include "tools/explain/words.h"

namespace muster::tools {

using Json = nlohmann::ordered_json;
using scheduler::AgentAnswer;
using scheduler::PairLook;
using scheduler::PlaceLook;
using scheduler::RangeNeed;

Json Seconds(TimeUs t) { return t == kNever ? Json() : Json(ToSeconds(t)); }

Json ActionsJson(const std::vector<Action>& actions) {
  Json list = Json::array();
  for (const Action& action : actions) list.push_back(ActionJson(ToWire(action)));
  return list;
}

std::string PartnerName(bool charging, std::int32_t id) {
  return AgentName(charging ? AgentKind::kVehicle : AgentKind::kWorker, id);
}

namespace {

Json NeedJson(const RangeNeed& need) {
  Json json = {{"uav", need.uav.value},     {"range_m", need.range_m},
               {"needs_m", need.needs_m()}, {"way_m", need.way_m},
               {"sensing_m", need.cost_m},  {"to_charge_m", need.to_charge_m}};
  if (need.free_us) json["free_s"] = Seconds(*need.free_us);
  return json;
}

}  // namespace

Json FactJson(const PairLook& pair, bool charging) {
  Json json = {{"uav", pair.uav.value},
               {charging ? "vehicle" : "worker", pair.partner},
               {"end_s", Seconds(pair.end_us)},
               {"latest_s", Seconds(pair.latest_us)}};
  if (pair.obstacle == scheduler::Obstacle::kNone) {
    json["weight"] = pair.weight;
  } else {
    json["obstacle"] = ToString(pair.obstacle);
  }
  if (pair.uav_free_us) json["uav_free_s"] = Seconds(*pair.uav_free_us);
  if (pair.partner_free_us) {
    json[charging ? "vehicle_free_s" : "worker_free_s"] = Seconds(*pair.partner_free_us);
  }
  if (pair.window_of) {
    json["window_of"] = *pair.window_of == AgentKind::kUav
                            ? AgentName(AgentKind::kUav, pair.uav.value)
                            : PartnerName(charging, pair.partner);
  }
  return json;
}

Json FactJson(const PlaceLook& look) {
  Json json = {{"obstacle", ToString(look.obstacle)},
               {"idle_uavs", look.idle_uavs},
               {"busy_uavs", look.busy_uavs},
               {look.charging ? "idle_vehicles" : "idle_workers", look.idle_partners},
               {look.charging ? "busy_vehicles" : "busy_workers", look.busy_partners},
               {"uavs_in_range", look.uavs_in_range},
               {"pairs_in_range", look.pairs},
               {"pairs_feasible", look.pairs_feasible},
               {"pairs_after_online_window", look.pairs_after_window},
               {"pairs_after_time_limit", look.pairs_after_limit}};
  if (look.pairs_after_expiry > 0) json["pairs_after_expiry"] = look.pairs_after_expiry;
  if (look.soon_decisions > 0) {
    json["soon_decisions"] = look.soon_decisions;
    json["soon_uavs"] = look.soon_uavs;
    json[look.charging ? "soon_vehicles" : "soon_workers"] = look.soon_partners;
  }
  json["nearest_by_range"] = look.nearest_range ? NeedJson(*look.nearest_range) : Json();
  json["nearest_by_time"] =
      look.nearest_time ? FactJson(*look.nearest_time, look.charging) : Json();
  return json;
}

Json FactJson(const std::vector<AgentAnswer::Blocked>& blocked) {
  Json list = Json::array();
  for (const AgentAnswer::Blocked& group : blocked) {
    list.push_back({{"obstacle", ToString(group.obstacle)},
                    {group.charging ? "charging_points" : "tasks", group.places},
                    {group.charging ? "nearest_charge" : "nearest_task", group.nearest.site},
                    {"nearest", FactJson(group.nearest)}});
  }
  return list;
}

Json FactJson(const Activity& activity) {
  return {{"uav", activity.uav.value},
          {"worker", activity.partner},
          {"start_s", Seconds(activity.start_us)},
          {"end_s", Seconds(activity.end_us)}};
}

Json FactJson(const AgentState& state) {
  return {{"kind", static_cast<int>(state.action)},
          {"symbol", ToString(state.action)},
          {"target", state.target},
          {"partner", state.partner},
          {"since_decision", state.decision},
          {"until_s", Seconds(state.busy_until_us)}};
}

}  // namespace muster::tools
