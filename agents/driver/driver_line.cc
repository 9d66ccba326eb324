#include "agents/driver/driver_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/check.h"
#include "base/object_reader.h"

namespace muster::agents {
namespace {

using Type = DriverLine::Type;

constexpr std::string_view kItsLine = "its line";
constexpr double kPlaceError_m = 10;
constexpr std::size_t kLongestText = 500;
/// A hundred years; and sums of such times are no trouble.
constexpr double kMostSeconds = 100.0 * 366 * 24 * 3600;

std::optional<double> Number(const ObjectReader& object, std::string_view key, double low,
                             double high) {
  return object.Has(key) ? std::optional(object.Number(key, kOne, low, high)) : std::nullopt;
}

std::optional<TimeUs> Time(const ObjectReader& object, std::string_view key) {
  const auto seconds = Number(object, key, 0, kMostSeconds);
  return seconds ? std::optional(ToUs(*seconds)) : std::nullopt;
}

/// The number of what it was told.
std::int64_t Id(const ObjectReader& object) {
  return object.Integer("id", 1, std::int64_t{1} << 53);
}

std::string Text(const ObjectReader& object, std::string_view key) {
  std::string text = object.String(key);
  if (text.size() > kLongestText) {
    object.Fail(key, *object.Optional(key),
                fmt::format("a string of up to {} bytes", kLongestText));
  }
  return text;
}

std::string Words(const ObjectReader& object, std::string_view key, std::string_view expected) {
  std::string words = Text(object, key);
  if (words.empty()) object.Fail(key, *object.Optional(key), std::string(expected));
  return words;
}

std::string Reason(const ObjectReader& object, std::string_view key) {
  return Words(object, key, "what it waits for");
}

Point ReadPlace(const ObjectReader& object, const DriverPlaces& places) {
  object.AllowOnly({"x_m", "y_m", "latitude_deg", "longitude_deg"});
  const double most = ObjectReader::kMost;
  const auto x = Number(object, "x_m", -most, most), y = Number(object, "y_m", -most, most);
  const auto latitude = Number(object, "latitude_deg", -90, 90);
  const auto longitude = Number(object, "longitude_deg", -180, 180);
  std::optional<Point> at;
  if (x && y) at = Point{*x, *y};
  if (!at && !x && !y && latitude && longitude) at = places.FromDegrees(*latitude, *longitude);
  if (!at) {
    object.Fail("", "no place",
                places.origin() ? "x_m and y_m, or latitude_deg and longitude_deg"
                                : "x_m and y_m, as this mission has no origin");
  }
  if (!places.IsInside(*at)) {
    object.Fail(
        "", fmt::format("({:.1f}, {:.1f}) m", at->x_m, at->y_m),
        fmt::format("a place in the area, {:g} m x {:g} m", places.width_m(), places.height_m()));
  }
  return *at;
}

Type ReadType(const ObjectReader& object) {
  constexpr std::string_view kNames[] = {"hello",  "state",     "arrived", "done",
                                         "failed", "not_ready", "ready",   "message"};
  const std::string expected = fmt::format("one of {}", fmt::join(kNames, ", "));
  const JsonValue& type = object.Required("type", expected);
  const auto* const found = std::find(std::begin(kNames), std::end(kNames), type.text);
  if (type.type != JsonValue::Type::kString || found == std::end(kNames)) {
    object.Fail("type", type, expected);
  }
  return static_cast<Type>(found - std::begin(kNames));
}

}  // namespace

struct DriverPlaces::Projection {
  GeographicLib::LocalCartesian local;
};

DriverPlaces::DriverPlaces(const Scenario& scenario)
    : width_m_(scenario.width_m), height_m_(scenario.height_m), origin_(scenario.origin) {
  if (!origin_) return;
  projection_ = std::make_unique<Projection>(
      Projection{GeographicLib::LocalCartesian(origin_->latitude_deg, origin_->longitude_deg)});
}

DriverPlaces::~DriverPlaces() = default;

nlohmann::ordered_json DriverPlaces::ToJson(Point at) const {
  nlohmann::ordered_json place = {{"x_m", at.x_m}, {"y_m", at.y_m}};
  if (projection_) {
    double latitude = 0, longitude = 0, height = 0;
    projection_->local.Reverse(at.x_m, at.y_m, 0, latitude, longitude, height);
    place["latitude_deg"] = latitude;
    place["longitude_deg"] = longitude;
  }
  return place;
}

std::optional<Point> DriverPlaces::FromDegrees(double latitude_deg, double longitude_deg) const {
  if (!projection_) return {};
  Point at;
  double height = 0;
  projection_->local.Forward(latitude_deg, longitude_deg, 0, at.x_m, at.y_m, height);
  return at;
}

bool DriverPlaces::IsInside(Point at) const {
  return at.x_m >= -kPlaceError_m && at.x_m <= width_m_ + kPlaceError_m &&
         at.y_m >= -kPlaceError_m && at.y_m <= height_m_ + kPlaceError_m;
}

DriverLine ReadDriverLine(std::string_view line, const DriverPlaces& places) {
  if (line.size() > kLongestDriverLine) {
    throw InputError(kItsLine, "length", fmt::format("{} bytes", line.size()),
                     fmt::format("at most {}", kLongestDriverLine));
  }
  const JsonValue root = ParseJson(line, kItsLine);
  const ObjectReader object(root, "", kItsLine);
  DriverLine said;
  said.type = ReadType(object);
  const double most = ObjectReader::kMost;
  switch (said.type) {
    case Type::kHello:
      object.AllowOnly({"type", "version", "name", "not_ready"});
      object.Expect("version", kDriverVersion);
      if (object.Has("not_ready")) said.reason = Reason(object, "not_ready");
      if (object.Has("name")) said.name = Text(object, "name");
      break;
    case Type::kState:
      object.AllowOnly({"type", "at", "range_m", "expected_s", "mission_s"});
      said.at = ReadPlace(object.Child("at"), places);
      said.range_m = Number(object, "range_m", 0, most);
      said.expected_us = Time(object, "expected_s");
      said.mission_us = Time(object, "mission_s");
      break;
    case Type::kArrived:
      object.AllowOnly({"type", "id"});
      said.id = Id(object);
      break;
    case Type::kDone:
      object.AllowOnly({"type", "id", "range_m"});
      said.id = Id(object);
      said.range_m = Number(object, "range_m", 0, most);
      break;
    case Type::kFailed: {
      object.AllowOnly({"type", "id", "reason"});
      const JsonValue* id = object.Optional("id");
      if (id != nullptr && id->type != JsonValue::Type::kNull) said.id = Id(object);
      said.reason = Text(object, "reason");
      break;
    }
    case Type::kNotReady:
      object.AllowOnly({"type", "reason"});
      said.reason = Reason(object, "reason");
      break;
    case Type::kReady:
      object.AllowOnly({"type"});
      break;
    case Type::kMessage:
      object.AllowOnly({"type", "text", "help"});
      said.text = Words(object, "text", "a message");
      said.calls_help = object.Boolean("help", false);
      break;
  }
  return said;
}

}  // namespace muster::agents
