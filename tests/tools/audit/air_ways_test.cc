#include "tools/audit/air_ways.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/random.h"
#include "model/airspace.h"
#include "tools/audit/audit_scenario.h"

namespace muster::tools::audit {
namespace {

/// Star-shaped, with corners in whole millimetres.
Zone DrawnZone(Random* random, double width_m) {
  const double x_m = random->Uniform(0, width_m), y_m = random->Uniform(0, width_m);
  const int n = 3 + static_cast<int>(random->Uniform(0, 8));
  Zone zone{"drawn", {{}}};
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * std::numbers::pi * k / n, out_m = random->Uniform(100, 500);
    zone.rings[0].push_back({std::round((x_m + out_m * std::cos(angle)) * 1000) / 1000,
                             std::round((y_m + out_m * std::sin(angle)) * 1000) / 1000});
  }
  return zone;
}

// Two programs that share no line of code: the mission's flights and the audit's.
TEST(AirWaysOfTheAudit, AreTheMissions) {
  constexpr double kWidth_m = 4000;
  int n_bent = 0, n_out = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Random random(seed, Stream::kTest, 6);
    std::vector<Zone> zones;
    std::vector<Rings> rings;
    for (int z = 0; z < 6; ++z) {
      zones.push_back(DrawnZone(&random, kWidth_m));
      rings.emplace_back(1);
      for (const Point at : zones.back().rings[0]) rings.back()[0].push_back({at.x_m, at.y_m});
    }
    const double margin_m = random.Uniform(5, 90);
    const Airspace air(zones, margin_m, {kWidth_m, kWidth_m});
    const auto ways = FlyAround(rings, margin_m, kWidth_m, kWidth_m, DefaultWays());
    const auto place = [&] {
      return Point{std::round(random.Uniform(0, kWidth_m)),
                   std::round(random.Uniform(0, kWidth_m))};
    };
    for (int i = 0; i < 40; ++i) {
      const Point from = place(), to = place();
      SCOPED_TRACE(fmt::format("from ({}, {}) to ({}, {}), margin {}", from.x_m, from.y_m, to.x_m,
                               to.y_m, margin_m));
      const auto flight = air.FlightBetween(from, to);
      const Place a{from.x_m, from.y_m}, b{to.x_m, to.y_m};
      const double length_m = ways->Length(kUav, a, b);
      ASSERT_EQ(std::isinf(length_m), flight == nullptr);
      if (flight == nullptr) continue;
      ASSERT_NEAR(length_m, flight->reached_m.back(), 1e-5);
      n_bent += flight->corners.size() > 2 ? 1 : 0;
      n_out += air.IsFree(from) ? 0 : 1;
      for (std::size_t k = 1; k < flight->corners.size(); ++k) {
        const Place at = ways->After(kUav, a, b, flight->reached_m[k] / length_m);
        EXPECT_NEAR(at.x_m, flight->corners[k].x_m, 1e-3);
        EXPECT_NEAR(at.y_m, flight->corners[k].y_m, 1e-3);
      }
    }
  }
  EXPECT_GT(n_bent, 500);
  EXPECT_GT(n_out, 100);
}

}  // namespace
}  // namespace muster::tools::audit
