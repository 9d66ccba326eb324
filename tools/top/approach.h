#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/report/timeline.h"

namespace muster::tools {

/// A UAV in the air, as it flies now.
struct Flying {
  double x_m = 0, y_m = 0, up_m = 0;  ///< `up_m`: above the ground, as planned
  double vx_m_s = 0, vy_m_s = 0;
};

struct Approach {
  double in_s = 0;  ///< time to the closest approach
  double across_m = 0, up_m = 0;
};

/// How close two UAVs come within two minutes if both fly on as they do now; none: one of the
/// minima is kept. Source: ours (relative motion at constant velocity). The page has the same rule
/// (`approachOf` in air.js); tests/tools/top/approaches.json holds both to the same cases.
std::optional<Approach> ApproachOf(const Flying& a, const Flying& b, const Separation& minima);

/// "40 m across and 0 m up from each other in 1:20"
std::string ToText(const Approach& approach);

struct NearPair {
  std::int32_t a = -1, b = -1;  ///< UAVs
  Approach approach;
};

/// The pairs of a measured UAV and any other that come too close: what is computed flies as it was
/// planned, one that is measured may have strayed. Empty where UAVs are not kept apart.
std::vector<NearPair> NearPairs(const Timeline& timeline);

/// Who is in the air where UAVs are kept apart, and which two are nearest to each other, each
/// distance as a share of its minimum.
struct AirPicture {
  std::size_t n = 0;  ///< UAVs in the air
  double lowest_m = 0, highest_m = 0;
  std::optional<NearPair> nearest;  ///< none: fewer than two, or more than kMostCompared
  static constexpr std::size_t kMostCompared = 1000;
};
/// None: UAVs are not kept apart. Time grows with the square of the UAVs in the air.
std::optional<AirPicture> AirPictureOf(const Timeline& timeline);

}  // namespace muster::tools
