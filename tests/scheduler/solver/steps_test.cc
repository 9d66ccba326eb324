// How the solver gets where it gets: weights and sizes of instances, and weight, bound and number
// of steps of their solutions. Steps are a measure of speed that repeats on every machine. Where a
// change is meant to move them, the new lines (printed by a failure) and what was gained belong in
// its commit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "scheduler/solver/build.h"
#include "scheduler/solver/solver.h"
#include "tests/scheduler/situation_builder.h"
#include "tests/scheduler/solver/explicit_graph.h"

namespace muster::scheduler {
namespace {

std::string Found(const Instance& instance) {
  SolverLimits limits;
  limits.work = 1'000'000;
  const SolverResult solution = Solve(instance, limits);
  EXPECT_TRUE(IsValid(instance, solution.assignment));
  return fmt::format("{:.10g} {:.10g} {}", solution.assignment.weight, solution.bound,
                     solution.work);
}

TEST(Steps, OfRandomInstancesAreThoseTheyWere) {
  struct Case {
    std::uint64_t seed;
    int uavs, partners, sites;
    const char* found;
  };
  const Case cases[] = {
      {1, 6, 7, 6, "279.6333333 279.6333333 3539"},
      {2, 6, 7, 6, "297.3888889 297.3888889 1930"},
      {3, 9, 9, 8, "279.3701728 279.3701728 569"},
      {4, 12, 10, 8, "372.5651804 372.5651804 3246"},
      {5, 14, 16, 12, "1092.686053 1092.686053 25916"},
      {6, 20, 22, 16, "1382.172498 1382.172498 36857"},
      {7, 30, 36, 24, "1978.266667 1978.266667 381575"},
      {8, 30, 30, 30, "2656.777778 2656.777778 742343"},
      {9, 40, 44, 30, "2653.733333 2781.655556 1040191"},
      {10, 60, 50, 40, "3302.033333 3750.955556 3266701"},
      {11, 70, 90, 60, "5049.937083 5734.94306 1728745"},
      {12, 80, 70, 60, "5247.024008 5980.418592 1092005"},
      {14, 90, 100, 60, "6245.513276 9090.038315 1153292"},
      {19, 90, 100, 60, "5157.8 6052.15 1160948"},
      {21, 24, 20, 16, "1108.149754 1108.149754 59592"},
      {22, 24, 20, 16, "1239.533333 1239.533333 95369"},
      {23, 40, 40, 20, "1448.3722 1448.3722 23029"},
      {24, 40, 60, 20, "1838.936413 1838.936413 77796"},
      {25, 25, 12, 30, "1240.114114 1240.114114 74667"},
      {26, 50, 60, 50, "4840.533333 5139.1 1087140"},
      {27, 50, 60, 50, "3995.206022 4564.668475 1095516"},
      {28, 24, 24, 6, "474.8406801 474.8406801 1492"},
  };
  for (const Case& c : cases) {
    EXPECT_EQ(Found(testing::RandomInstance(c.seed, c.uavs, c.partners, c.sites)), c.found)
        << "seed " << c.seed << ", " << c.uavs << " UAVs";
  }
}

/// Twenty at a time: sums of weights, bounds and steps.
TEST(Steps, OfManySmallInstancesAreThoseTheyWere) {
  struct Case {
    int uavs, partners, sites;
    std::int64_t work;  ///< limit
    double weight, bound;
    std::int64_t steps;
  };
  const Case cases[] = {
      {12, 12, 9, 30000, 10700.86578, 10725.71578, 169789},
      {12, 12, 9, 300000, 10212.49445, 10212.49445, 134084},
      {16, 18, 14, 300000, 18368.42321, 18368.42321, 1358104},
      {18, 9, 12, 300000, 13058.40528, 13058.40528, 171908},
      {9, 18, 12, 300000, 11199.53707, 11199.53707, 382236},
      {20, 20, 8, 300000, 11981.75674, 11981.75674, 164497},
      {24, 26, 24, 500000, 38762.33023, 39951.18693, 9002930},
      {16, 16, 30, 300000, 27777.64825, 27884.65081, 1279173},
      {30, 30, 20, 20000, 35274.90402, 41648.03023, 722556},
      {30, 30, 20, 3000, 31094.25796, 54709.38225, 362488},
  };
  std::uint64_t seed = 100;
  for (const Case& c : cases) {
    double weight = 0, bound = 0;
    std::int64_t steps = 0;
    for (int i = 0; i < 20; ++i) {
      SolverLimits limits;
      limits.work = c.work;
      const SolverResult solution =
          Solve(testing::RandomInstance(seed++, c.uavs, c.partners, c.sites), limits);
      weight += solution.assignment.weight;
      bound += solution.bound;
      steps += solution.work;
    }
    EXPECT_EQ(fmt::format("{:.10g}, {:.10g}, {}", weight, bound, steps),
              fmt::format("{:.10g}, {:.10g}, {}", c.weight, c.bound, c.steps))
        << c.uavs << " UAVs";
  }
}

/// FNV-1a, 32 bits.
std::uint32_t HashOf(const std::string& text) {
  std::uint32_t hash = 2166136261u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

/// Number of arcs, sums of levels and of weights, and a hash of all that is in the instance.
std::string Told(const Instance& instance) {
  std::string text;
  std::int64_t levels = 0;
  double weights = 0;
  for (const auto& uav : instance.uavs) {
    text += fmt::format("{:.9g} {} {};", uav.stay, uav.latest_us, uav.place);
  }
  for (const auto& p : instance.partners) {
    text += fmt::format("{:.9g} {} {:.9g};", p.stay, p.latest_us, p.charge_rate_m_s);
  }
  for (const auto& arc : instance.uav_arcs) {
    levels += arc.level;
    weights += (arc.solo == Instance::kNone ? 0 : arc.solo) + arc.base +
               (arc.pair_gain == Instance::kNone ? 0 : arc.pair_gain);
    text += fmt::format("{} {} {:.9g} {:.9g} {:.9g} {} {} {:.9g};", arc.uav, arc.level, arc.solo,
                        arc.base, arc.pair_gain, arc.arrive_us, arc.duration_us, arc.missing_m);
  }
  for (const auto& arc : instance.partner_arcs) {
    levels += arc.level;
    weights += arc.gain;
    text += fmt::format("{} {} {:.9g} {} {};", arc.partner, arc.level, arc.gain, arc.arrive_us,
                        arc.solo);
  }
  for (const auto* list :
       {&instance.capacity, &instance.uav_begin, &instance.partner_begin, &instance.rest_level}) {
    for (const std::int32_t n : *list) text += fmt::format("{} ", n);
    text += ";";
  }
  return fmt::format("{} {} {} {:.10g} {:08x}", instance.uav_arcs.size(),
                     instance.partner_arcs.size(), levels, weights, HashOf(text));
}

TEST(Steps, OfSituationsAreThoseTheyWere) {
  struct Case {
    std::uint64_t seed;
    Availability availability;
    std::size_t exact_up_to, all_pairs_up_to;
    const char *told, *found;
  };
  const auto strict = Availability::kStrict, overrun = Availability::kOverrun;
  const Case cases[] = {
      {1, strict, 512, kAllPairs, "582 1138 5051 37746.69119 9126cb64",
       "1959.575925 1959.575925 22708"},
      {2, strict, 512, kAllPairs, "681 1495 7211 42823.10452 21db70fd",
       "1769.91221 1769.91221 17644"},
      {3, overrun, 512, kAllPairs, "922 3450 25888 64007.88466 74bb6c1b",
       "1704.580037 1704.580037 32418"},
      {4, overrun, 512, 0, "1316 3594 24687 80431.2845 8e5ae4fe", "2317.583682 2317.583682 42437"},
      {5, overrun, 8, 0, "1031 3312 20835 66385.37784 ec03b38a", "2104.842964 2104.842964 51933"},
      {6, strict, 8, kAllPairs, "788 1057 5773 49776.42727 9a637fa8",
       "2197.269379 2197.269379 12513"},
      {7, strict, 8, kAllPairs, "1040 1317 7550 71382.54315 848cd112",
       "2070.981936 2070.981936 22390"},
      {8, overrun, 8, kAllPairs, "1012 3492 26889 65214.7417 ba26d959",
       "2072.372059 2072.372059 35474"},
      {9, strict, 1, kAllPairs, "689 1186 6249 44883.64756 bf3b856a",
       "1648.502756 1648.502756 33213"},
      {10, overrun, 20, 100, "1168 3226 22056 72055.40106 f4adb78a",
       "2055.756082 2055.756082 58555"},
  };
  for (const Case& c : cases) {
    Rules rules;
    rules.availability = c.availability;
    const Situation situation = testing::RandomSituation(c.seed, {40, 50, 30, 90, 40, 40}, rules);
    const Instance instance =
        BuildInstance(situation, 1, c.exact_up_to, c.all_pairs_up_to).instance;
    EXPECT_EQ(Told(instance), c.told) << "seed " << c.seed;
    EXPECT_EQ(Found(instance), c.found) << "seed " << c.seed;
  }
}

/// Areas of all sizes, rules as printed in the paper, nobody of a class, nothing to do.
TEST(Steps, OfOtherSituationsAreThoseTheyWere) {
  struct Case {
    testing::RandomSize size;
    const char *told, *found;
  };
  const Case cases[] = {
      {{20, 20, 10, 30, 10, 6},
       "359 575 7393 25495.05457 d610dcc6",
       "562.7201655 562.7201655 8807"},
      {{20, 20, 10, 30, 10, 90},
       "17 504 7752 589.3168492 e338cf43",
       "85.70533606 85.70533606 2645"},
      {{30, 12, 4, 40, 30, 25},
       "675 245 2263 36007.43371 65975f5b",
       "914.0811198 914.0811198 20577"},
      {{0, 12, 4, 20, 10, 20}, "0 205 7346 5.891491555 10fdd90c", "9.010913347 9.010913347 436"},
      {{12, 0, 9, 20, 10, 20}, "71 27 180 4170.621683 b6ed8d38", "47.4119442 47.4119442 1563"},
      {{12, 15, 0, 20, 10, 20}, "103 198 998 7235.76689 5701ebc9", "297.1215292 297.1215292 1786"},
      {{12, 15, 8, 0, 10, 20}, "35 40 1061 398.2387076 4cdc968b", "21.463757 21.463757 631"},
      {{12, 15, 8, 20, 0, 20}, "0 210 945 41.9409306 6803316c", "20.10126824 20.10126824 434"},
      {{60, 10, 10, 20, 3, 30}, "38 6 44 2972.805512 ac32e213", "58.29570417 58.29570417 934"},
      {{10, 60, 30, 20, 3, 30},
       "47 674 28743 3390.109911 82cf6a6f",
       "111.8098868 111.8098868 5082"},
      {{25, 30, 15, 40, 20, 40},
       "89 307 1368 5238.950953 1669a73e",
       "680.8190332 680.8190332 4175"},
      {{25, 30, 15, 40, 20, 12},
       "628 1086 3759 41177.71246 18744d9f",
       "1591.000542 1591.000542 115559"},
  };
  std::uint64_t seed = 20;
  for (const Case& c : cases) {
    ++seed;
    Rules rules;
    if (seed % 2 == 0) rules.availability = Availability::kOverrun;
    rules.ceil_to_minutes = seed % 3 == 0;
    rules.mean_over_all = seed % 5 == 0;
    const Situation situation = testing::RandomSituation(seed, c.size, rules);
    const Instance instance = BuildInstance(situation, 1, seed % 4 == 0 ? 8 : kExactPlaces,
                                            seed % 4 == 2 ? 50 : kAllPairs)
                                  .instance;
    EXPECT_EQ(Told(instance), c.told) << "seed " << seed;
    EXPECT_EQ(Found(instance), c.found) << "seed " << seed;
  }
  // So many that neighbours get neighbouring numbers; two threads change nothing.
  const Situation large = testing::RandomSituation(40, {900, 900, 400, 1900, 200, 400});
  EXPECT_EQ(Told(BuildInstance(large).instance), "2251 4494 24559 174612.6755 db967ba5");
  EXPECT_EQ(Told(BuildInstance(large, 2).instance), "2251 4494 24559 174612.6755 db967ba5");
}

}  // namespace
}  // namespace muster::scheduler
