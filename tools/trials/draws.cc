#include "tools/trials/draws.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "model/made_up.h"
#include "model/order.h"

namespace muster::tools {
namespace {

/// The last minute at which anything of these is drawn, so that it may still matter.
std::uint32_t LastMinute(const Scenario& scenario) {
  return static_cast<std::uint32_t>(std::max<TimeUs>(scenario.rules.limit_us / kMinuteUs - 5, 1));
}

world::PlannedOrder Planned(const std::string& json) { return {ParseOrder(json, "order"), json}; }

/// The id of any road.
std::int64_t IdOf(const Roads& roads, Random* random) {
  return roads.roads[random->Below(static_cast<std::uint32_t>(roads.roads.size()))].id;
}

/// Roads that there are.
RoadArea DrawArea(const Roads& roads, double extent_m, Random* random) {
  const auto m = [&] { return extent_m * random->Uniform(); };
  for (;;) {
    RoadArea area;
    switch (random->Below(4)) {
      case 0:
        area.of = RoadArea::Circle{{m(), m()}, 0.18 * extent_m * random->Uniform()};
        break;
      case 1:
        area.of = RoadArea::Polygon{{{m(), m()}, {m(), m()}, {m(), m()}, {m(), m()}}};
        break;
      case 2:
        area.of = RoadArea::Ids{{IdOf(roads, random), IdOf(roads, random)}};
        break;
      default:
        area.of = RoadArea::Nearest{{m(), m()}};
    }
    if (!RoadsIn(roads, area).empty()) return area;
  }
}

}  // namespace

std::vector<world::PlannedOrder> DrawTaskOrders(const Scenario& scenario, Random* random) {
  std::vector<world::PlannedOrder> orders;
  // Some there may be after orders, some never.
  const auto n_tasks =
      static_cast<std::uint32_t>(2 * (scenario.tasks.size() - scenario.room.tasks));
  const auto n_agents = static_cast<std::uint32_t>(2 + scenario.n_agents(AgentKind::kUav));
  const std::uint32_t n = 10 + random->Below(40);
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto place = [&] {
      return fmt::format(R"("x_km": {:.3f}, "y_km": {:.3f})",
                         random->Uniform() * 1.017 * scenario.width_m / 1000,
                         random->Uniform() * scenario.height_m / 1000);
    };
    const std::uint32_t task = random->Below(n_tasks);
    const char* const kinds[] = {"uav", "worker", "vehicle"};
    const std::string kind = kinds[random->Below(3)];
    std::string body;
    switch (random->Below(8)) {
      case 0:
      case 1:
      case 2:
        body =
            fmt::format(R"("order": "task_add", "task": {{{}, "priority": {}, "cost_km": {:.1f})",
                        place(), random->Below(4), 1 + 2 * random->Uniform());
        if (random->Below(2) == 0) body += fmt::format(R"(, "due_in_min": {})", random->Below(40));
        if (random->Below(3) == 0) {
          body += fmt::format(R"(, "expires_in_min": {})", 40 + random->Below(30));
        }
        if (random->Below(3) == 0)
          body += fmt::format(R"(, "reported_min": {})", random->Below(90));
        body += "}";
        break;
      case 3:
        body = fmt::format(R"("order": "task_cancel", "task": {})", task);
        break;
      case 4:
        body = fmt::format(R"("order": "task_{}", "task": {})",
                           random->Below(2) == 0 ? "hold" : "resume", task);
        break;
      case 5:
        body = fmt::format(
            R"("order": "task_change", "task": {}, "priority": {}{})", task, random->Below(4),
            random->Below(2) == 0 ? fmt::format(R"(, "expires_in_min": {})", 1 + random->Below(30))
                                  : "");
        break;
      case 6:
        body = fmt::format(
            R"("order": "agent_join", "class": "{}", "agent": {{{}, "speed_km_per_min": 0.8{}}})",
            kind, place(),
            kind == "uav"       ? R"(, "full_range_km": 20)"
            : kind == "vehicle" ? R"(, "charge_km_per_min": 8)"
                                : "");
        break;
      default:
        body =
            fmt::format(R"("order": "agent_{}", "agent": "{}:{}")",
                        random->Below(2) == 0 ? "leave" : "recall", kind, random->Below(n_agents));
    }
    const TimeUs at_us = kMinuteUs * TimeUs{random->Below(LastMinute(scenario) + 5)};
    const std::string json = fmt::format(R"({{"at_min": {}, {}}})", at_us / kMinuteUs, body);
    world::PlannedOrder planned{ParseOrder(json, "order"), json};
    planned.order.id = fmt::format("o{}", i);
    planned.order.issuer = "drawn";
    orders.push_back(std::move(planned));
  }
  return orders;
}

std::vector<world::PlannedOrder> DrawDirectives(const Scenario& scenario, Random* random) {
  std::vector<world::PlannedOrder> orders;
  const auto agent = [&](AgentKind kind) {
    const auto n = static_cast<std::uint32_t>(scenario.agents(kind).size());
    return fmt::format("{}:{}", ToString(kind), random->Below(n));
  };
  const auto any = [&] { return kAgentKinds[random->Below(3)]; };
  const auto km = [&](double metres) { return random->Uniform(0, metres / 1000); };
  const auto task = [&] {
    return random->Below(static_cast<std::uint32_t>(scenario.tasks.size()));
  };
  const auto add = [&](std::uint32_t minute, const std::string& id, const std::string& rest) {
    orders.push_back(
        Planned(fmt::format("{{\"id\": \"{}\", \"at_min\": {}, {}}}", id, minute, rest)));
  };
  const std::uint32_t n = 5 + random->Below(20);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t minute = random->Below(LastMinute(scenario));
    const std::string id = fmt::format("d{}", i);
    switch (random->Below(6)) {
      case 0:
      case 1: {
        std::string names;
        const std::uint32_t who = random->Below(3);
        if (who != 1) names += fmt::format("\"{}\"", agent(AgentKind::kUav));
        if (who == 2) names += ", ";
        if (who != 0) names += fmt::format("\"{}\"", agent(AgentKind::kWorker));
        add(minute, id,
            fmt::format("\"order\": \"pin\", \"task\": {}, \"agents\": [{}]", task(), names));
        break;
      }
      case 2:
        add(minute, id,
            fmt::format("\"order\": \"forbid\", \"task\": {}, \"agent\": \"{}\"", task(),
                        agent(random->Below(2) == 0 ? AgentKind::kUav : AgentKind::kWorker)));
        break;
      case 3:
        add(minute, id,
            fmt::format(
                "\"order\": \"charge_now\", \"agents\": [\"{}\"{}]", agent(AgentKind::kUav),
                random->Below(2) == 0 ? fmt::format(", \"{}\"", agent(AgentKind::kVehicle)) : ""));
        break;
      case 4:
        add(minute, id,
            fmt::format(
                "\"order\": \"go_to\", \"agent\": \"{}\", \"x_km\": {:.3f}, \"y_km\": {:.3f}",
                agent(any()), km(scenario.width_m), km(scenario.height_m)));
        break;
      default:
        add(minute, id,
            fmt::format(
                "\"order\": \"forbid\", \"class\": \"{}\", \"circle_km\": [{:.3f}, {:.3f}, 2]",
                ToString(any()), km(scenario.width_m), km(scenario.height_m)));
    }
    if (random->Below(3) == 0) {
      add(minute + random->Below(40), "r" + id,
          fmt::format("\"order\": \"release\", \"directive\": \"{}\"", id));
    }
  }
  return orders;
}

void DrawClosures(Random* random, VirtualMission* mission) {
  const double extent_m = std::min(mission->scenario.width_m, mission->scenario.height_m);
  const Roads& network = *mission->scenario.roads->network;
  const auto km = static_cast<std::uint32_t>(std::max(extent_m / 1000, 1.0));
  const auto minute = [&] { return random->Below(LastMinute(mission->scenario)) * kMinuteUs; };
  ScenarioRoads roads = *mission->scenario.roads;
  for (std::uint32_t n = random->Below(4); n > 0; --n) {
    PlannedClosure& closure = roads.closures.emplace_back();
    closure.area = DrawArea(network, extent_m, random);
    closure.name = "flood \"north\"";
    closure.from_us = minute();
    if (random->Below(2) == 0) closure.until_us = closure.from_us + minute() + kSecondUs;
  }
  const std::string file = roads.file;
  UseRoads(std::move(roads), file, &mission->scenario);
  for (std::uint32_t n = random->Below(6); n > 0; --n) {
    const TimeUs at_us = minute();
    const bool opens = random->Below(3) == 0;
    std::string json = fmt::format("{{\"order\": \"{}\", \"id\": \"road{}\", \"at_min\": {}, {}",
                                   opens ? "road_open" : "road_close", n, at_us / kMinuteUs,
                                   RoadAreaToJson(DrawArea(network, extent_m, random)));
    if (!opens && random->Below(2) == 0) json += ", \"until_in_min\": 12.5";
    json += "}";
    mission->orders.push_back(Planned(json));
  }
  for (std::uint32_t n = random->Below(4); n > 0; --n) {
    const std::string target =
        fmt::format("{}/{}/{}", random->Below(km), random->Below(km), 0.5 + 0.5 * random->Below(4));
    if (RoadsIn(network, *CircleFrom(target)).empty()) continue;
    PlannedFault& fault = mission->faults.emplace_back();
    fault.id = fmt::format("road{}", n);
    fault.kind = FaultKind::kRoadClosed;
    fault.target = target;
    fault.at_us = minute() + random->Below(60) * kSecondUs;
    if (random->Below(2) == 0) fault.for_us = 5 * kMinuteUs + minute();
  }
}

void DrawZones(Random* random, VirtualMission* mission) {
  const double extent_m = std::min(mission->scenario.width_m, mission->scenario.height_m);
  const auto minute = [&] { return random->Below(LastMinute(mission->scenario)) * kMinuteUs; };
  ScenarioAir air;
  if (mission->scenario.air) {
    air = *mission->scenario.air;
  } else {
    air.margin_m = 5 + random->Below(80);
  }
  for (Zone& zone : DrawnZones(random, extent_m, static_cast<int>(random->Below(6)))) {
    PlannedZone& planned = air.zones.emplace_back();
    planned.zone = std::move(zone);
    planned.zone.name = "airfield \"north\"";
    if (air.zones.size() % 3 == 2) planned.lower_m = 60;
    if (random->Below(2) == 0) planned.from_us = minute();
    if (random->Below(2) == 0) planned.until_us = planned.from_us + minute() + kSecondUs;
  }
  UseAir(std::move(air), &mission->scenario);
  std::uint32_t n = 0;
  for (const Zone& zone : DrawnZones(random, extent_m, static_cast<int>(random->Below(5)))) {
    std::string json = fmt::format("{{\"order\": \"zone_add\", \"id\": \"z{}\", \"at_min\": {}, {}",
                                   ++n, minute() / kMinuteUs, ZoneToJson(zone));
    if (random->Below(2) == 0) json += ", \"until_in_min\": 12.5";
    json += "}";
    mission->orders.push_back(Planned(json));
    if (random->Below(2) > 0) continue;
    json = fmt::format(
        "{{\"order\": \"zone_lift\", \"id\": \"l{0}\", \"at_min\": {1}, \"zone\": \"z{0}\"}}", n,
        minute() / kMinuteUs);
    mission->orders.push_back(Planned(json));
  }
}

void DrawLateZones(std::uint64_t seed, VirtualMission* mission) {
  const Scenario& scenario = mission->scenario;
  if (scenario.air == nullptr) return;
  Random random(seed, Stream::kSoak, 11);
  const auto minute = [&] { return random.Below(LastMinute(scenario)) * kMinuteUs; };
  const double radius_km = std::min(scenario.width_m, scenario.height_m) / 1e4;
  for (std::uint32_t n = random.Below(4); n > 0; --n) {
    PlannedFault& fault = mission->faults.emplace_back();
    fault.id = fmt::format("zone{}", n);
    fault.kind = FaultKind::kZoneUnknown;
    fault.target = fmt::format("{:.3f}/{:.3f}/{:.3f}", random.Uniform() * scenario.width_m / 1000,
                               random.Uniform() * scenario.height_m / 1000,
                               0.01 + radius_km * random.Uniform());
    fault.at_us = minute() + random.Below(60) * kSecondUs;
    if (random.Below(2) == 0) fault.for_us = 5 * kMinuteUs + minute();
  }
}

void DrawStreets(std::uint64_t seed, Scenario* scenario) {
  const double extent_m = std::max(scenario->width_m, scenario->height_m);
  ScenarioRoads roads;
  roads.file = "drawn.roads.json";
  const int n = 4 + static_cast<int>(seed % 13);
  roads.text = RoadsToJson(StreetGrid(n, extent_m / n, seed, seed % 4 == 1));
  // Some agents never leave the road, others cross the fields as fast as they like.
  const auto percent = [&](std::uint64_t by) {
    return seed % by == 0 ? 0 : seed % by == 1 ? 100 : 35;
  };
  roads.open_ground = {{}, {percent(11), 700}, {percent(7), seed % 3 == 0 ? 5000.0 : 600.0}};
  UseRoads(std::move(roads), "drawn.roads.json", scenario);
}

}  // namespace muster::tools
