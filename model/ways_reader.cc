#include "model/ways_reader.h"

#include <fmt/format.h>

#include <utility>

namespace muster {
namespace {

constexpr double kFarthestOffRoad_km = 100;

OpenGround ReadOpenGround(const ObjectReader& object) {
  object.AllowOnly({"percent", "reach_km"});
  return {static_cast<std::int32_t>(object.Integer("percent", 0, 100)),
          object.Number("reach_km", kKm, 0, kFarthestOffRoad_km)};
}

void ReadFromUntil(const ObjectReader& object, TimeUs* from_us, TimeUs* until_us) {
  if (object.Has("from_min")) *from_us = object.Time("from_min", kMinute);
  if (object.Has("until_min")) *until_us = object.Time("until_min", kMinute);
  if (*until_us <= *from_us) {
    object.Fail("until_min", *object.Optional("until_min"), "later than from_min");
  }
}

PlannedClosure ReadClosure(const ObjectReader& object) {
  object.AllowOnly({"area_km", "circle_km", "roads", "near_km", "name", "from_min", "until_min"});
  PlannedClosure closure;
  closure.area = ReadRoadArea(object);
  if (object.Has("name")) closure.name = object.String("name");
  ReadFromUntil(object, &closure.from_us, &closure.until_us);
  return closure;
}

constexpr double kWidestMargin_km = 10;

}  // namespace

std::string ReadRoadFileName(const ObjectReader& object) {
  std::string name = object.String("file");
  if (!name.ends_with(kRoadFileEnd) || name.find('/') != std::string::npos) {
    object.Fail("file", *object.Optional("file"),
                fmt::format("the name of a file *{} in the scenario's folder", kRoadFileEnd));
  }
  return name;
}

ScenarioRoads ReadRoadsKey(const ObjectReader& object) {
  object.AllowOnly({"file", "sha256", "open_ground", "closures"});
  ScenarioRoads roads;
  roads.file = ReadRoadFileName(object);
  if (object.Has("closures")) {
    const std::vector<JsonValue>& closures = object.Array("closures");
    for (std::size_t i = 0; i < closures.size(); ++i) {
      roads.closures.push_back(ReadClosure(object.Element("closures", closures[i], i)));
    }
  }
  if (!object.Has("open_ground")) return roads;
  const ObjectReader ground = object.Child("open_ground");
  ground.AllowOnly({"workers", "vehicles"});
  if (ground.Has("workers")) roads.open_ground.workers = ReadOpenGround(ground.Child("workers"));
  if (ground.Has("vehicles")) roads.open_ground.vehicles = ReadOpenGround(ground.Child("vehicles"));
  return roads;
}

namespace {

std::optional<Separation> ReadSeparation(const ObjectReader& air) {
  const JsonValue& value = *air.Optional("separation");
  if (value.type == JsonValue::Type::kBoolean && !value.boolean) return {};
  const ObjectReader object = air.Child("separation");
  object.AllowOnly({"horizontal_m", "vertical_m", "lowest_m", "ceiling_m"});
  Separation s;
  const auto read = [&](const char* key, double low, double high, double* metres) {
    if (object.Has(key)) *metres = object.Number(key, kOne, low, high);
  };
  read("horizontal_m", 1, 10'000, &s.horizontal_m);
  read("vertical_m", 1, 1'000, &s.vertical_m);
  read("lowest_m", 1, 10'000, &s.lowest_m);
  read("ceiling_m", 1, 10'000, &s.ceiling_m);
  if (s.ceiling_m < s.lowest_m) {
    object.Fail("ceiling_m", fmt::format("{:g}", s.ceiling_m),
                fmt::format("at least lowest_m, {:g}", s.lowest_m));
  }
  return s;
}

}  // namespace

ScenarioAir ReadAir(const ObjectReader& object) {
  object.AllowOnly({"margin_km", "separation", "zones"});
  ScenarioAir air;
  if (object.Has("separation")) air.separation = ReadSeparation(object);
  if (object.Has("margin_km")) {
    air.margin_m = object.Number("margin_km", kKm, 0.001, kWidestMargin_km);
  }
  if (!object.Has("zones")) return air;
  const std::vector<JsonValue>& zones = object.Array("zones");
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const ObjectReader one = object.Element("zones", zones[i], i);
    one.AllowOnly({"area_km", "circle_km", "holes_km", "name", "from_min", "until_min", "lower_m"});
    PlannedZone planned;
    planned.zone = ReadZone(one);
    if (one.Has("name")) planned.zone.name = one.String("name");
    ReadFromUntil(one, &planned.from_us, &planned.until_us);
    if (one.Has("lower_m")) planned.lower_m = one.Number("lower_m", kOne, 0, 10'000);
    air.zones.push_back(std::move(planned));
  }
  return air;
}

}  // namespace muster
