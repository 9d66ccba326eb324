#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "model/scenario.h"

namespace muster::agents {

/// The protocol's version (docs/guide/drivers.md).
inline constexpr int kDriverVersion = 1;
/// A line's length, in either direction.
inline constexpr std::size_t kLongestDriverLine = 64 << 10;

/// Places as drivers are told them, and tell them: metres in the scenario's area, and degrees where
/// it has an origin.
class DriverPlaces {
 public:
  /// The scenario is not needed any more.
  explicit DriverPlaces(const Scenario& scenario);
  ~DriverPlaces();

  nlohmann::ordered_json ToJson(Point at) const;
  /// Of the place of such degrees; none: the scenario has no origin.
  std::optional<Point> FromDegrees(double latitude_deg, double longitude_deg) const;
  /// To 10 m, the error of places.
  bool IsInside(Point at) const;
  double width_m() const { return width_m_; }
  double height_m() const { return height_m_; }
  const std::optional<Origin>& origin() const { return origin_; }

 private:
  struct Projection;
  double width_m_, height_m_;
  std::optional<Origin> origin_;
  std::unique_ptr<Projection> projection_;
};

/// What a driver has said in one line.
struct DriverLine {
  enum class Type : std::int8_t {
    kHello,
    kState,
    kArrived,
    kDone,
    kFailed,
    kNotReady,
    kReady,
    kMessage
  };
  Type type = Type::kState;
  std::string name;                   ///< kHello
  std::optional<std::int64_t> id;     ///< kArrived, kDone; perhaps kFailed
  Point at;                           ///< kState
  std::optional<double> range_m;      ///< perhaps kState, kDone
  std::optional<TimeUs> expected_us;  ///< perhaps kState: arrival
  std::optional<TimeUs> mission_us;   ///< perhaps kState: when it was there
  /// kFailed; kNotReady: what it waits for; kHello: the same, "": it is ready
  std::string reason;
  std::string text;         ///< kMessage
  bool calls_help = false;  ///< kMessage
};

/// Reads such a line. Throws InputError that says what is wrong with it.
DriverLine ReadDriverLine(std::string_view line, const DriverPlaces& places);

}  // namespace muster::agents
