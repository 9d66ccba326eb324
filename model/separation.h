#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include "base/geometry.h"
#include "base/point_hash.h"
#include "base/units.h"
#include "model/agent.h"
#include "model/clearance.h"

namespace muster {

// UAVs that are kept apart in the air (docs/reference/separation.md). The auditor has its own.

/// Where UAVs stand on the ground: those that are free, and those that charge.
class LandingPlaces {
 public:
  explicit LandingPlaces(std::span<const ChargingPoint> points);
  /// To the millimetre: one that is stopped right after it was sent has not taken off.
  bool Contains(Point place) const { return places_.contains(Rounded(place)); }

 private:
  static Point Rounded(Point place) {
    return {std::round(place.x_m * 1e3) / 1e3, std::round(place.y_m * 1e3) / 1e3};
  }

  std::unordered_set<Point, PointHash> places_;
};

/// Metres above the ground at t. 0: on the ground, failed or offline.
double AltitudeAt(const AgentState& uav, const Clearance& clearance, TimeUs t,
                  const LandingPlaces& landing);

/// Where a UAV is from a time on, as far as it is known: between two knots place and altitude
/// change evenly, and after the last one it stays.
struct Trajectory {
  struct Knot {
    double t_s = 0;  ///< seconds since that time
    Point at;
    double up_m = 0;
  };
  std::vector<Knot> knots;  ///< by time; none: it is not there
  Point low, high;          ///< corners of the box around all places

  bool IsEverAirborne() const;
};

/// The trajectory from `now` on, if it gets no further command.
Trajectory TrajectoryOf(const AgentState& uav, const Clearance& clearance, TimeUs now,
                        const LandingPlaces& landing);

/// Whether all places of one are farther than that from all of the other, by their boxes.
bool AreFarApart(const Trajectory& a, const Trajectory& b, double metres);

/// Whether both are in the air at some time and closer than both minima.
bool AreInConflict(const Trajectory& a, const Trajectory& b, const Separation& minima);

/// How close two come: where the larger of horizontal and vertical distance, each in shares of its
/// minimum, is least.
struct Approach {
  double share = std::numeric_limits<double>::infinity();  ///< below 1: a conflict
  double horizontal_m = 0, vertical_m = 0;
  double t_s = 0;  ///< seconds since the time from which the trajectories are
};
/// None: they are never in the air together.
std::optional<Approach> ClosestApproach(const Trajectory& a, const Trajectory& b,
                                        const Separation& minima);

}  // namespace muster
