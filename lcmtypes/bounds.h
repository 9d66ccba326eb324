#pragma once

namespace muster {

// The largest numbers of a mission: of its scenario, of orders and of messages. Within them every
// time of it is far from the end of int64 microseconds: the longest way at the slowest takes 19,000
// years, and a sum of ten such ways fits.

/// No two places on Earth are farther apart.
inline constexpr double kFarthest_m = 2e7;
/// Of an altitude above the ground.
inline constexpr double kHighest_m = 1e5;
/// Of a range, of sensing, of a call: twice around the Earth.
inline constexpr double kLongestWay_m = 1e8;
/// Of agents, and of charging. An agent that shall stay in place has the slowest speed.
inline constexpr double kSlowest_km_min = 1e-5;
inline constexpr double kFastest_km_min = 1e6;
inline constexpr double kSlowest_m_s = 1.0 / 6000;
inline constexpr double kFastest_m_s = 1e8 / 6;
/// Extra range per unit of way.
inline constexpr double kMostWind = 1000;

}  // namespace muster
