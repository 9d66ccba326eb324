#include "tools/bench/suites.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tests/scheduler/situation_builder.h"
#include "tools/graph/conflict_graph.h"

namespace muster::tools {
namespace {

TEST(Bench, EdgesAreThoseOfTheWrittenGraph) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto situation = scheduler::testing::RandomSituation(seed, {5, 6, 3, 6, 3, 12});
    const ConflictGraph graph(situation);
    std::stringstream file;
    try {
      graph.WriteMetis(file, 1);
    } catch (const std::exception&) {
      continue;  // a charging point with several places
    }
    std::int64_t n = 0, m = 0;
    file >> n >> m;
    EXPECT_EQ(CountEdges(situation), m) << "seed " << seed;
  }
}

TEST(Bench, RowsHoldEveryDecisionAndMethod) {
  BenchOptions options;
  options.methods = {"certified", "kwta"};
  options.instances = {"DidiOrders"};
  options.repetitions = 2;
  std::vector<BenchRow> rows;
  RunDecisions(options, [&](const BenchRow& row) { rows.push_back(row); });
  ASSERT_EQ(rows.size(), 18u * 2 * 2);
  const std::string header = CsvHeader();
  for (const BenchRow& row : rows) {
    const std::string line = ToCsv(row);
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
    EXPECT_GT(row.total_s, 0);
    if (row.method == "certified") {
      EXPECT_GE(row.bound, row.weight);
    }
  }
  EXPECT_NE(SummaryOf(rows).find("DidiOrders"), std::string::npos);
}

// gnuplot reads columns by name, so it takes the first line for names by itself: "every ::1" would
// leave out the first row, too.
TEST(Bench, ThePlotLeavesNoRowOut) {
  EXPECT_EQ(PlotScript("rows.csv", "plot.svg").find("every"), std::string::npos);
}

TEST(Bench, ScaleGrowsTheInstance) {
  BenchOptions options;
  options.methods = {"certified"};
  options.scales = {0.25, 1};
  std::vector<BenchRow> rows;
  RunScale(options, [&](const BenchRow& row) { rows.push_back(row); });
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_GT(rows[1].nodes, 2 * rows[0].nodes);
  EXPECT_LE(rows[1].gap(), 1e-3);
}

}  // namespace
}  // namespace muster::tools
