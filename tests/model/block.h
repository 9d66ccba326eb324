#pragma once

#include <cstdint>
#include <utility>

#include "model/scenario.h"

namespace muster::testing {

/// Two streets from west to east, 300 m apart, and two that connect them:
///
///   3 -- 20 -- 2        (0, 300) (400, 300)
///   |          |
///   23         21
///   |          |
///   0 -- 10 -- 1 -- 11 -- 4      (0, 0) (400, 0) (1000, 0)
inline Roads Block() {
  Roads roads;
  roads.classes = {{"street", {0, 100, 100}, false}};
  roads.points = {{0, 0}, {400'000, 0}, {400'000, 300'000}, {0, 300'000}, {1'000'000, 0}};
  roads.roads = {
      {10, 0, {0, 1}}, {11, 0, {1, 4}}, {21, 0, {1, 2}}, {20, 0, {2, 3}}, {23, 0, {3, 0}}};
  return roads;
}

inline Scenario OnTheBlock(std::int32_t open_percent = 50) {
  Scenario scenario;
  scenario.width_m = scenario.height_m = 2000;
  scenario.uavs = {{.at = {0, 0}, .speed_m_s = 10, .range_full_m = 9000, .range_m = 9000}};
  scenario.workers = {{.at = {0, 0}, .speed_m_s = 1}};
  scenario.vehicles = {{.at = {0, 0}, .speed_m_s = 1, .charge_rate_m_s = 1}};
  scenario.tasks = {{.at = {1000, 0}, .cost_m = 100}};
  scenario.charging_points = {{.at = {0, 300}}};
  ScenarioRoads roads;
  roads.file = "block.roads.json";
  roads.text = RoadsToJson(Block());
  roads.open_ground = {{}, {open_percent, 400}, {open_percent, 400}};
  UseRoads(std::move(roads), "block.roads.json", &scenario);
  return scenario;
}

}  // namespace muster::testing
