#include "agents/driver/driver_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/text.h"

namespace muster::agents {
namespace {

using Type = DriverLine::Type;

constexpr std::string_view kItsLine = "its line";
constexpr double kPlaceError_m = 10;
constexpr std::size_t kLongestText = 500;
/// A hundred years; and sums of such times are no trouble.
constexpr double kMostSeconds = 100.0 * 366 * 24 * 3600;

/// Reads the members of one object.
class MemberReader {
 public:
  explicit MemberReader(const JsonValue& object) : object_(object) {}

  void AllowOnly(const std::vector<std::string_view>& keys) const {
    for (const auto& [name, value] : object_.members) {
      if (name == "type" || std::find(keys.begin(), keys.end(), name) != keys.end()) continue;
      Refuse(name, value, fmt::format("no such key, only type, {}", fmt::join(keys, ", ")));
    }
  }
  std::optional<double> Number(std::string_view key, double low, double high) const {
    const JsonValue* value = object_.Find(key);
    if (value == nullptr) return {};
    const auto number =
        value->type == JsonValue::Type::kNumber ? ToNumber(value->text) : std::nullopt;
    if (!number || *number < low || *number > high) {
      Refuse(key, *value, fmt::format("a number in [{:g}, {:g}]", low, high));
    }
    return number;
  }
  std::optional<TimeUs> Time(std::string_view key) const {
    const auto seconds = Number(key, 0, kMostSeconds);
    return seconds ? std::optional(ToUs(*seconds)) : std::nullopt;
  }
  std::optional<std::int64_t> Id(bool required) const {
    const JsonValue* value = object_.Find("id");
    if (value == nullptr && required) Miss("id", "the number of what it was told");
    if (value == nullptr || (value->type == JsonValue::Type::kNull && !required)) return {};
    const auto id =
        value->type == JsonValue::Type::kNumber ? ToInteger(value->text, 1) : std::nullopt;
    if (!id) Refuse("id", *value, "an integer above 0");
    return id;
  }
  std::string Text(std::string_view key, bool required) const {
    const JsonValue* value = object_.Find(key);
    if (value == nullptr && required) Miss(key, "a string");
    if (value == nullptr) return {};
    if (value->type != JsonValue::Type::kString || value->text.size() > kLongestText) {
      Refuse(key, *value, fmt::format("a string of up to {} bytes", kLongestText));
    }
    return value->text;
  }
  const JsonValue& Required(std::string_view key, std::string_view expected) const {
    const JsonValue* value = object_.Find(key);
    if (value == nullptr) Miss(key, expected);
    return *value;
  }

  [[noreturn]] static void Refuse(std::string_view key, const JsonValue& found,
                                  std::string_view expected) {
    throw InputError(kItsLine, key, found.Shown(), expected);
  }
  [[noreturn]] static void Miss(std::string_view key, std::string_view expected) {
    throw InputError(kItsLine, key, "nothing", expected);
  }

 private:
  const JsonValue& object_;
};

Point ReadPlace(const JsonValue& value, const DriverPlaces& places) {
  if (value.type != JsonValue::Type::kObject) {
    MemberReader::Refuse("at", value, "an object with x_m and y_m");
  }
  const MemberReader object(value);
  object.AllowOnly({"x_m", "y_m", "latitude_deg", "longitude_deg"});
  const double most = std::numeric_limits<double>::max();
  const auto x = object.Number("x_m", -most, most), y = object.Number("y_m", -most, most);
  const auto latitude = object.Number("latitude_deg", -90, 90);
  const auto longitude = object.Number("longitude_deg", -180, 180);
  std::optional<Point> at;
  if (x && y) at = Point{*x, *y};
  if (!at && !x && !y && latitude && longitude) at = places.FromDegrees(*latitude, *longitude);
  if (!at) {
    throw InputError(kItsLine, "at", "no place",
                     places.origin() ? "x_m and y_m, or latitude_deg and longitude_deg"
                                     : "x_m and y_m, as this mission has no origin");
  }
  if (!places.IsInside(*at)) {
    throw InputError(
        kItsLine, "at", fmt::format("({:.1f}, {:.1f}) m", at->x_m, at->y_m),
        fmt::format("a place in the area, {:g} m x {:g} m", places.width_m(), places.height_m()));
  }
  return *at;
}

Type ReadType(const JsonValue& root) {
  constexpr std::string_view kNames[] = {"hello", "state", "arrived", "done", "failed"};
  const std::string expected = fmt::format("one of {}", fmt::join(kNames, ", "));
  const JsonValue& type = MemberReader(root).Required("type", expected);
  const auto* const found = std::find(std::begin(kNames), std::end(kNames), type.text);
  if (type.type != JsonValue::Type::kString || found == std::end(kNames)) {
    MemberReader::Refuse("type", type, expected);
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
  if (root.type != JsonValue::Type::kObject) MemberReader::Refuse("all of it", root, "an object");
  const MemberReader object(root);
  DriverLine said;
  said.type = ReadType(root);
  const double most = std::numeric_limits<double>::max();
  switch (said.type) {
    case Type::kHello: {
      object.AllowOnly({"version", "name"});
      const std::string expected = fmt::to_string(kDriverVersion);
      const JsonValue& version = object.Required("version", expected);
      if (version.type != JsonValue::Type::kNumber || version.text != expected) {
        MemberReader::Refuse("version", version, expected);
      }
      said.name = object.Text("name", false);
      break;
    }
    case Type::kState:
      object.AllowOnly({"at", "range_m", "expected_s", "mission_s"});
      said.at = ReadPlace(object.Required("at", "an object with x_m and y_m"), places);
      said.range_m = object.Number("range_m", 0, most);
      said.expected_us = object.Time("expected_s");
      said.mission_us = object.Time("mission_s");
      break;
    case Type::kArrived:
      object.AllowOnly({"id"});
      said.id = object.Id(true);
      break;
    case Type::kDone:
      object.AllowOnly({"id", "range_m"});
      said.id = object.Id(true);
      said.range_m = object.Number("range_m", 0, most);
      break;
    case Type::kFailed:
      object.AllowOnly({"id", "reason"});
      said.id = object.Id(false);
      said.reason = object.Text("reason", true);
      break;
  }
  return said;
}

}  // namespace muster::agents
