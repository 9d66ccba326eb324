#include "tools/tiles/degree_box.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace muster::tools {
namespace {

constexpr double kMetresPerLatitude = 111'000;  ///< roughly

}  // namespace

DegreeBox BoxAround(const Scenario& scenario, double around_m) {
  const double south = scenario.origin->latitude_deg, west = scenario.origin->longitude_deg;
  const double squeeze = std::max(0.01, std::cos(south * std::numbers::pi / 180));
  const auto up = [](double metres) { return metres / kMetresPerLatitude; };
  const auto right = [&](double metres) { return up(metres) / squeeze; };
  return {std::max(-90.0, south - up(around_m)), west - right(around_m),
          std::min(90.0, south + up(scenario.height_m + around_m)),
          west + right(scenario.width_m + around_m)};
}

}  // namespace muster::tools
