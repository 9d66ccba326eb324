#include "tools/bench/hard_suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "scheduler/solver/candidates.h"
#include "tools/bench/general_solver.h"
#include "tools/bench/random_missions.h"
#include "tools/bench/suites.h"

namespace muster::tools {
namespace {

TEST(HardSuite, DrawnSettingsAreDecidedWithinTheirBoundAndNoneBelowOthers) {
  BenchOptions options;
  options.seeds = 8;
  std::vector<HardRow> rows;
  RunRandomSettings(options, [&](const HardRow& row) { rows.push_back(row); });
  ASSERT_GE(rows.size(), 6u);
  for (const HardRow& row : rows) {
    SCOPED_TRACE("seed " + std::to_string(row.seed));
    EXPECT_GE(row.bound, row.weight);
    EXPECT_LE(row.gap(), 1e-3);
    EXPECT_FALSE(row.others > row.weight * (1 + 1e-6));
    const std::string line = ToCsv(row), header = HardCsvHeader();
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
  }
  EXPECT_NE(rows[0].nodes, rows[1].nodes);
  EXPECT_NE(SummaryOf(rows).find("random"), std::string::npos);
}

TEST(RandomMissions, EveryDecisionIsARowAndNearItsBound) {
  // In the last three one decision was 0.03, 0.07 and 0.7 % below its bound, until matchings were
  // tried there and proofs had more columns, time, and rows for cliques.
  for (const int seed : {3, 60074, 60175, 70169}) {
    BenchOptions options;
    options.first_seed = seed;
    std::vector<HardRow> rows;
    RunRandomMissions(options, [&](const HardRow& row) { rows.push_back(row); });
    ASSERT_GE(rows.size(), 2u);
    std::int32_t decision = 0;
    for (const HardRow& row : rows) {
      SCOPED_TRACE(ToCsv(row));
      EXPECT_EQ(row.seed, static_cast<std::uint64_t>(seed));
      EXPECT_EQ(row.decision, decision++);
      EXPECT_GE(row.bound, row.weight);
      EXPECT_LE(row.gap(), 1e-6);
    }
    EXPECT_NE(SummaryOf(rows).find("to-1-million"), std::string::npos);
    EXPECT_EQ(SummaryOf(rows).find("relaxations"), std::string::npos) << "the log has none";
  }
}

TEST(HardSuite, EachFamilysSettingsAreValidAndItsOwn) {
  ASSERT_GE(HardFamilies().size(), 6u);
  for (const HardFamily& family : HardFamilies()) {
    SCOPED_TRACE(family.name);
    const Scenario scenario = Generate(family.settings, 1);
    EXPECT_FALSE(scenario.uavs.empty());
    const bool hour = scenario.rules.limit_us == 60 * kMinuteUs;
    EXPECT_NE(family.flags.find(hour ? "--limit 60" : "--online-min 180"), std::string::npos);
  }
}

TEST(GeneralSolver, ItsOptimumAndRelaxationBoundEachOther) {
  const auto cbc = GeneralSolver::Load();
  if (cbc == nullptr) GTEST_SKIP() << "COIN-OR CBC is not installed";
  const scheduler::Candidates graph =
      scheduler::EnumerateCandidates(MidMission(Scaled(PresetByName("Random_1"), 0.3), 1));
  const auto whole = cbc->Heaviest(graph.nodes, graph.elements, false, 20);
  const auto shares = cbc->Heaviest(graph.nodes, graph.elements, true, 20);
  ASSERT_TRUE(whole.weight && shares.weight);
  EXPECT_GT(*whole.weight, 0);
  EXPECT_LE(*whole.weight, *shares.weight + 1e-6);
}

}  // namespace
}  // namespace muster::tools
