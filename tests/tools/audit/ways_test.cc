// The mission's ways and the audit's, which share no line of code, are the same.
#include "tools/audit/ways.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "base/random.h"
#include "model/air_ways.h"
#include "model/made_up.h"
#include "model/road_ways.h"
#include "tools/audit/air_ways.h"
#include "tools/audit/audit_scenario.h"
#include "tools/audit/road_ways.h"

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

Place Same(Point at) { return {at.x_m, at.y_m}; }

Point InMillimetres(Point at) {
  return {std::round(at.x_m * 1000) / 1000, std::round(at.y_m * 1000) / 1000};
}

/// Where an agent that has made that part of its way meets what is closed or added: both say none,
/// or the same metres. Returns whether it meets something.
bool ExpectSameBar(const std::optional<double>& mission_m, const std::optional<double>& audit_m) {
  EXPECT_EQ(mission_m.has_value(), audit_m.has_value());
  if (!mission_m || !audit_m) return false;
  EXPECT_NEAR(*mission_m, *audit_m, 0.02);
  return true;
}

/// Zones, and around them the ways of both.
struct Air {
  Air(std::vector<Zone> its, double margin_m, double width_m)
      : zones(std::move(its)), mission(zones, margin_m, {width_m, width_m}) {
    std::vector<Rings> rings;
    for (const Zone& zone : zones) {
      rings.emplace_back(1);
      for (const Point at : zone.rings[0]) rings.back()[0].push_back(Same(at));
    }
    audit = FlyAround(std::move(rings), margin_m, width_m, width_m, DefaultWays());
  }
  std::vector<Zone> zones;
  Airspace mission;
  std::shared_ptr<const Ways> audit;
};

TEST(AuditWays, FlightsAroundZonesAreTheMissions) {
  constexpr double kWidth_m = 4000;
  int n_bent = 0, n_out = 0, n_barred = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed, Stream::kTest, 6);
    std::vector<Zone> zones;
    for (int z = 0; z < 6; ++z) zones.push_back(DrawnZone(&random, kWidth_m));
    const double margin_m = random.Uniform(5, 90);
    const Air now(zones, margin_m, kWidth_m);
    zones.resize(3);
    const Air before(zones, margin_m, kWidth_m);
    const auto place = [&] {
      return Point{std::round(random.Uniform(0, kWidth_m)),
                   std::round(random.Uniform(0, kWidth_m))};
    };
    for (int i = 0; i < 40; ++i) {
      const Point from = place(), to = place();
      SCOPED_TRACE(fmt::format("seed {}: from ({}, {}) to ({}, {}), margin {}", seed, from.x_m,
                               from.y_m, to.x_m, to.y_m, margin_m));
      const auto flight = now.mission.FlightBetween(from, to);
      const double length_m = now.audit->Length(kUav, Same(from), Same(to));
      ASSERT_EQ(std::isinf(length_m), flight == nullptr);
      if (flight == nullptr) continue;
      ASSERT_NEAR(length_m, flight->reached_m.back(), 1e-5);
      n_bent += flight->corners.size() > 2 ? 1 : 0;
      n_out += now.mission.IsFree(from) ? 0 : 1;
      for (std::size_t k = 1; k < flight->corners.size(); ++k) {
        const Place at =
            now.audit->After(kUav, Same(from), Same(to), flight->reached_m[k] / length_m);
        EXPECT_NEAR(at.x_m, flight->corners[k].x_m, 1e-3);
        EXPECT_NEAR(at.y_m, flight->corners[k].y_m, 1e-3);
      }
      const auto under_way = before.mission.FlightBetween(from, to);
      if (under_way == nullptr) continue;
      const double metres = under_way->reached_m.back(), part = random.Uniform(0, 1);
      std::optional<double> met =
          before.audit->MeetsAt(kUav, Same(from), Same(to), part, {}, *now.audit);
      if (met) *met *= metres;
      n_barred += ExpectSameBar(now.mission.EntersAt(*under_way, part * metres), met) ? 1 : 0;
    }
  }
  EXPECT_GT(n_bent, 500);
  EXPECT_GT(n_out, 100);
  EXPECT_GT(n_barred, 100);
}

TEST(AuditWays, WaysByRoadAreTheMissions) {
  constexpr PerKind<muster::OpenGround> kFields = {{}, {50, 400}, {25, 300}};
  constexpr OpenGround kSame[3] = {{}, {50, 400}, {25, 300}};
  int n_ways = 0, n_barred = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed, Stream::kTest, 8);
    const auto roads = std::make_shared<const Roads>(StreetGrid(6, 300, seed));
    const auto place = [&] {
      return InMillimetres({random.Uniform(-300, 2100), random.Uniform(-300, 2100)});
    };
    std::vector<Point> places;
    std::vector<Place> sites;
    for (int i = 0; i < 12; ++i) places.push_back(place());
    for (int i = 0; i < 5; ++i) sites.push_back(Same(places[static_cast<std::size_t>(i)]));
    std::set<int> closed;
    for (int i = 0; i < 4; ++i) {
      closed.insert(static_cast<int>(random.Uniform(0, static_cast<double>(roads->roads.size()))));
    }
    const auto mission = std::make_shared<const muster::RoadWays>(
        roads, kFields, std::vector<Point>(places.begin(), places.begin() + 5));
    const auto mission_now = mission->Without({closed.begin(), closed.end()});
    const auto audit = ReadRoadWays(RoadsToJson(*roads), kSame, sites);
    const auto audit_now = audit->Without(closed);
    for (const AgentKind kind : {AgentKind::kWorker, AgentKind::kVehicle}) {
      const int number = static_cast<int>(kind);
      std::vector<Point> all = places;  // and places on the way
      for (std::size_t i = 1; i < places.size(); ++i) {
        if (std::isinf(mission->Length(kind, places[i - 1], places[i]))) continue;
        all.push_back(InMillimetres(
            mission->PlaceAfter(kind, places[i - 1], places[i], random.Uniform(0, 1))));
      }
      for (const Point from : all) {
        EXPECT_EQ(mission_now->StopNear(kind, from).number,
                  audit_now->StopNear(number, Same(from)).second);
        for (const Point to : all) {
          SCOPED_TRACE(fmt::format("seed {}: class {} from ({}, {}) to ({}, {})", seed, number,
                                   from.x_m, from.y_m, to.x_m, to.y_m));
          const double length_m = mission_now->Length(kind, from, to);
          ASSERT_EQ(length_m, audit_now->Length(number, Same(from), Same(to)));
          if (std::isinf(length_m)) continue;
          ++n_ways;
          const double part = random.Uniform(0, 1);
          const Point at = mission_now->PlaceAfter(kind, from, to, part);
          EXPECT_LE(Apart(Same(at), audit_now->After(number, Same(from), Same(to), part)), 0.01);
          const double before_m = mission->Length(kind, from, to);
          if (std::isinf(before_m)) continue;
          std::optional<double> bar = mission->BarredAt(kind, from, to, part, *mission_now);
          std::optional<double> met =
              audit->MeetsAt(number, Same(from), Same(to), part, closed, *audit_now);
          if (bar) *bar *= before_m;
          if (met) *met *= before_m;
          n_barred += ExpectSameBar(bar, met) ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(n_ways, 3000);
  EXPECT_GT(n_barred, 200);
}

}  // namespace
}  // namespace muster::tools::audit
