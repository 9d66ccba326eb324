#include "tools/bench/small_missions.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace muster::tools {
namespace {

TEST(SmallMissions, EachPolicyIsBelowTheBestPlanAndThatIsBelowTheBound) {
  BenchOptions options;
  options.first_seed = 1;
  options.seeds = 2;
  options.methods = {"kwta", "horizon"};
  std::vector<SmallRow> rows;
  RunSmallMissions(options, [&](const SmallRow& row) { rows.push_back(row); });
  ASSERT_EQ(rows.size(), 4u);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    SCOPED_TRACE(ToCsv(rows[i]));
    EXPECT_EQ(rows[i].seed, 1 + i / 2);
    EXPECT_EQ(rows[i].policy, options.methods[i % 2]);
    EXPECT_LE(rows[i].done, rows[i].best);
    EXPECT_LE(rows[i].best, rows[i].bound);
    EXPECT_LE(rows[i].bound, rows[i].tasks);
    EXPECT_GT(rows[i].bound, 0);
    EXPECT_LE(rows[i].uavs, 8);
    EXPECT_EQ(rows[i].bound, rows[i / 2 * 2].bound) << "of one mission";
    const std::string line = ToCsv(rows[i]), header = SmallCsvHeader();
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
  }
}

TEST(SmallMissions, ShareOfTheOptimumIsOfProvenMissionsAlone) {
  SmallRow proven, open;
  proven.policy = open.policy = "kwta";
  proven.done = 3;
  proven.best = proven.bound = 4;
  open.done = 5;
  open.best = 5;
  open.bound = 8;
  const std::string text = SummaryOf({proven, open});
  // 8 of 12, 3 of 4; the second one may be at its optimum, but nobody knows.
  EXPECT_NE(text.find("66.7"), std::string::npos) << text;
  EXPECT_NE(text.find("75.0"), std::string::npos) << text;
  EXPECT_NE(text.find("1 of 2 missions: "), std::string::npos) << text;
  EXPECT_NE(text.find("9 tasks, all bounds: 12"), std::string::npos) << text;
}

}  // namespace
}  // namespace muster::tools
