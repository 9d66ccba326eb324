#pragma once

#include <cmath>
#include <cstdint>

#include "base/units.h"

namespace muster {

/// By how much UAVs are kept apart, and between which altitudes above the ground they fly: the key
/// air.separation of a scenario.
struct Separation {
  double horizontal_m = 50;
  double vertical_m = 10;
  double lowest_m = 30;
  double ceiling_m = 120;

  /// Altitudes that are flown: the lowest, and those above it in steps of the vertical minimum.
  int layers() const {
    return 1 + static_cast<int>(std::floor((ceiling_m - lowest_m) / vertical_m + 1e-9));
  }
  double AltitudeOf(int layer) const { return lowest_m + layer * vertical_m; }
  bool operator==(const Separation&) const = default;
};

/// How fast UAVs change altitude, m/s. Source: the defaults of ArduCopter (WPNAV_SPEED_UP,
/// WPNAV_SPEED_DN).
inline constexpr double kClimb_m_s = 2.5;
inline constexpr double kDescent_m_s = 1.5;
/// A UAV waits for a free altitude in such steps, and at most so long.
inline constexpr TimeUs kHoldStepUs = 5 * kSecondUs;
inline constexpr TimeUs kMostHoldUs = 2 * kMinuteUs;

/// The altitude that a decision gives a UAV. It holds until the next one for that UAV.
struct Clearance {
  std::int32_t uav = -1;
  std::int32_t decision = -1;  ///< that gave it; -1: none, the UAV stands on the ground
  double from_m = 0;           ///< altitude before
  double to_m = 0;             ///< altitude to be flown
  TimeUs begin_us = 0;         ///< when it begins to climb or descend, and sets out if it is sent

  bool operator==(const Clearance&) const = default;
};

/// Metres above the ground at t of a UAV that does not land.
inline double LevelAt(const Clearance& clearance, TimeUs t) {
  if (t <= clearance.begin_us) return clearance.from_m;
  const double seconds = ToSeconds(t - clearance.begin_us);
  return clearance.to_m >= clearance.from_m
             ? std::fmin(clearance.to_m, clearance.from_m + kClimb_m_s * seconds)
             : std::fmax(clearance.to_m, clearance.from_m - kDescent_m_s * seconds);
}

/// When that altitude is reached, rounded up.
inline TimeUs LevelReachedUs(const Clearance& clearance) {
  const double change_m = clearance.to_m - clearance.from_m;
  const double seconds = change_m >= 0 ? change_m / kClimb_m_s : -change_m / kDescent_m_s;
  return clearance.begin_us + ToUs(seconds) + 1;
}

}  // namespace muster
