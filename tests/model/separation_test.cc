// UAVs that are kept apart: altitudes and closest approaches against values computed by hand, and
// against many samples of drawn flights.
#include "model/separation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/check.h"
#include "base/random.h"
#include "model/generator.h"
#include "model/scenario_json.h"

namespace muster {
namespace {

constexpr Separation kMinima;

TEST(Clearance, ClimbsAndDescendsEvenly) {
  const Clearance up{0, 0, 0, 50, 10 * kSecondUs};
  EXPECT_EQ(LevelAt(up, 0), 0);
  EXPECT_EQ(LevelAt(up, 10 * kSecondUs), 0);
  EXPECT_DOUBLE_EQ(LevelAt(up, 14 * kSecondUs), 10);  // 4 s at 2.5 m/s
  EXPECT_DOUBLE_EQ(LevelAt(up, 30 * kSecondUs), 50);
  EXPECT_DOUBLE_EQ(LevelAt(up, 3000 * kSecondUs), 50);
  EXPECT_EQ(LevelReachedUs(up), 30 * kSecondUs + 1);
  const Clearance down{0, 0, 90, 60, 0};
  EXPECT_DOUBLE_EQ(LevelAt(down, 10 * kSecondUs), 75);  // 10 s at 1.5 m/s
  EXPECT_DOUBLE_EQ(LevelAt(down, 20 * kSecondUs), 60);
  EXPECT_DOUBLE_EQ(LevelAt(down, 21 * kSecondUs), 60);
}

TEST(Separation, LayersEndAtTheCeiling) {
  EXPECT_EQ(kMinima.layers(), 10);
  EXPECT_EQ(kMinima.AltitudeOf(9), 120);
  EXPECT_EQ((Separation{50, 20, 30, 120}.layers()), 5);
  EXPECT_EQ((Separation{50, 20, 30, 49}.layers()), 1);
}

/// Random_1 with that key `air`.
std::string With(const std::string& air) {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  UseAir({}, &scenario);
  std::string text = ScenarioToJson(scenario);
  const std::string usual = R"("air": {"margin_km": 0.03})";
  return text.replace(text.find(usual), usual.size(), "\"air\": " + air);
}

TEST(Separation, IsAKeyOfTheScenario) {
  const auto read = [](const std::string& air) {
    const Scenario scenario = ParseScenario(With(air), "a.json");
    const Scenario again = ParseScenario(ScenarioToJson(scenario), "again");
    EXPECT_EQ(again.air->separation, scenario.air->separation) << air;
    return scenario.air->separation;
  };
  EXPECT_EQ(read("{}"), Separation());
  EXPECT_EQ(read(R"({"separation": {}})"), Separation());
  EXPECT_EQ(read(R"({"separation": false})"), std::nullopt);
  EXPECT_EQ(
      read(
          R"({"separation": {"horizontal_m": 80.5, "vertical_m": 15, "lowest_m": 40, "ceiling_m": 100}})"),
      (Separation{80.5, 15, 40, 100}));
  const auto error = [](const std::string& air) -> std::string {
    try {
      ParseScenario(With(air), "a.json");
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(error(R"({"separation": true})").find("separation"), std::string::npos);
  EXPECT_NE(error(R"({"separation": {"horizontal": 5}})").find("horizontal"), std::string::npos);
  EXPECT_NE(error(R"({"separation": {"vertical_m": 0}})").find("vertical_m"), std::string::npos);
  EXPECT_NE(error(R"({"separation": {"ceiling_m": 20}})").find("at least lowest_m, 30"),
            std::string::npos);
}

/// A UAV at 10 m/s from one place to another, by ways that bend nowhere.
AgentState Flying(Point from, Point to, ActionKind action = ActionKind::kUavToTask) {
  AgentState uav;
  uav.online_until_us = kNever;
  uav.speed_m_s = 10;
  uav.from = from;
  uav.to = to;
  uav.arrive_us = TravelUs(Distance(from, to), 10);
  uav.action = action;
  uav.busy_until_us = uav.arrive_us;
  return uav;
}

TEST(Altitude, LandsToChargeAndHoversToSense) {
  const std::vector<ChargingPoint> points{{{1000, 0}, 1}};
  const LandingPlaces landing(points);
  const Clearance at_60{0, 0, 0, 60, 0};
  const AgentState charges = Flying({0, 0}, {1000, 0}, ActionKind::kCharge);
  EXPECT_DOUBLE_EQ(AltitudeAt(charges, at_60, 20 * kSecondUs, landing), 50);
  EXPECT_DOUBLE_EQ(AltitudeAt(charges, at_60, 100 * kSecondUs, landing), 60);
  EXPECT_DOUBLE_EQ(AltitudeAt(charges, at_60, 120 * kSecondUs, landing), 30);  // 20 s at 1.5 m/s
  EXPECT_EQ(AltitudeAt(charges, at_60, 141 * kSecondUs, landing), 0);
  AgentState free = charges;
  free.action = ActionKind::kNone;
  EXPECT_EQ(AltitudeAt(free, at_60, 101 * kSecondUs, landing), 0) << "it stands there";
  const AgentState senses = Flying({0, 0}, {1000, 0}, ActionKind::kSense);
  EXPECT_DOUBLE_EQ(AltitudeAt(senses, at_60, 500 * kSecondUs, landing), 60);
  AgentState failed = senses;
  failed.failed = true;
  EXPECT_EQ(AltitudeAt(failed, at_60, 500 * kSecondUs, landing), 0);
}

Trajectory Path(const AgentState& uav, double altitude_m) {
  static const LandingPlaces kNone{std::span<const ChargingPoint>()};
  return TrajectoryOf(uav, {0, 0, altitude_m, altitude_m, 0}, 0, kNone);
}

TEST(Separation, MeetsWhereTwoWaysCross) {
  // Both are at the crossing after 50 s: at the same altitude they meet there.
  const AgentState east = Flying({0, 500}, {1000, 500});
  const AgentState north = Flying({500, 0}, {500, 1000});
  EXPECT_TRUE(AreInConflict(Path(east, 40), Path(north, 40), kMinima));
  EXPECT_TRUE(AreInConflict(Path(east, 40), Path(north, 49), kMinima));
  EXPECT_FALSE(AreInConflict(Path(east, 40), Path(north, 50), kMinima));
  const auto closest = ClosestApproach(Path(east, 40), Path(north, 40), kMinima);
  ASSERT_TRUE(closest);
  EXPECT_NEAR(closest->horizontal_m, 0, 1e-6);
  EXPECT_NEAR(closest->t_s, 50, 1e-6);
  // 8 s later: when it is at the crossing, the other one is 80 m on. The distance is least 4 s
  // before, 40 m each: 40 * sqrt(2) = 56.6 m.
  AgentState later = north;
  later.depart_us = 8 * kSecondUs;
  later.arrive_us += 8 * kSecondUs;
  const auto passes = ClosestApproach(Path(east, 40), Path(later, 40), kMinima);
  EXPECT_NEAR(passes->horizontal_m, 40 * std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(passes->t_s, 54, 1e-6);
  EXPECT_FALSE(AreInConflict(Path(east, 40), Path(later, 40), kMinima));
  // 7 s later: 35 * sqrt(2) = 49.5 m.
  later.depart_us -= kSecondUs;
  later.arrive_us -= kSecondUs;
  EXPECT_TRUE(AreInConflict(Path(east, 40), Path(later, 40), kMinima));
}

TEST(Separation, CountsNobodyOnTheGround) {
  const AgentState stands = Flying({500, 500}, {500, 500});
  EXPECT_FALSE(AreInConflict(Path(Flying({0, 500}, {1000, 500}), 5), Path(stands, 0), kMinima));
  EXPECT_TRUE(AreInConflict(Path(Flying({0, 500}, {1000, 500}), 5), Path(stands, 5), kMinima));
  EXPECT_FALSE(ClosestApproach(Path(stands, 0), Path(stands, 0), kMinima));
}

TEST(Separation, OneThatHoversIsInTheWayForEver) {
  const AgentState hovers = Flying({0, 0}, {0, 0}, ActionKind::kNone);
  AgentState comes = Flying({-5000, 0}, {49, 0});
  EXPECT_TRUE(AreInConflict(Path(hovers, 40), Path(comes, 40), kMinima));
  comes = Flying({5000, 0}, {50, 0});
  EXPECT_FALSE(AreInConflict(Path(hovers, 40), Path(comes, 40), kMinima));
}

/// The closest approach of two drawn flights, by 20,000 samples.
double Sampled(const Trajectory& a, const Trajectory& b) {
  const double end_s = std::max(a.knots.back().t_s, b.knots.back().t_s) + 1;
  const auto at = [](const Trajectory& path, double t_s) {
    std::size_t i = 0;
    while (i + 1 < path.knots.size() && path.knots[i + 1].t_s <= t_s) ++i;
    Trajectory::Knot knot = path.knots[i];
    if (i + 1 == path.knots.size()) return knot;
    const Trajectory::Knot& next = path.knots[i + 1];
    const double share = (t_s - knot.t_s) / (next.t_s - knot.t_s);
    return Trajectory::Knot{t_s, Lerp(knot.at, next.at, share),
                            knot.up_m + share * (next.up_m - knot.up_m)};
  };
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 20'000; ++i) {
    const Trajectory::Knot x = at(a, end_s * i / 20'000), y = at(b, end_s * i / 20'000);
    if (x.up_m <= 0 || y.up_m <= 0) continue;
    least = std::min(least, std::max(Distance(x.at, y.at) / kMinima.horizontal_m,
                                     std::abs(x.up_m - y.up_m) / kMinima.vertical_m));
  }
  return least;
}

TEST(Separation, AgreesWithSamplesOfDrawnFlights) {
  const std::vector<ChargingPoint> points{{{300, 300}, 1}};
  const LandingPlaces landing(points);
  int conflicts = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Random random(seed, Stream::kTest, 35);
    const auto draw = [&] {
      const auto place = [&] { return Point{random.Uniform(0, 600), random.Uniform(0, 600)}; };
      const bool charges = random.Below(3) == 0;
      AgentState uav = Flying(place(), charges ? points[0].at : place(),
                              charges ? ActionKind::kCharge : ActionKind::kUavToTask);
      const TimeUs later_us = random.Below(3) == 0 ? 0 : ToUs(random.Uniform(0, 30));
      uav.depart_us += later_us;
      uav.arrive_us += later_us;
      const auto layer = [&] { return kMinima.AltitudeOf(static_cast<int>(random.Below(10))); };
      const Clearance clearance{0, 0, random.Below(2) == 0 ? 0 : layer(), layer(), later_us};
      return TrajectoryOf(uav, clearance, 0, landing);
    };
    const Trajectory a = draw(), b = draw();
    const auto closest = ClosestApproach(a, b, kMinima);
    const double sampled = Sampled(a, b);
    ASSERT_EQ(closest.has_value(), std::isfinite(sampled)) << "seed " << seed;
    if (!closest) continue;
    EXPECT_LE(closest->share, sampled + 1e-9) << "seed " << seed;
    EXPECT_GE(closest->share, sampled - 0.01) << "seed " << seed;
    EXPECT_EQ(AreInConflict(a, b, kMinima), closest->share < 1 - 1e-7) << "seed " << seed;
    EXPECT_EQ(AreInConflict(b, a, kMinima), AreInConflict(a, b, kMinima)) << "seed " << seed;
    conflicts += closest->share < 1 ? 1 : 0;
  }
  EXPECT_GT(conflicts, 20);
}

}  // namespace
}  // namespace muster
