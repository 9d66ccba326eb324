#include "tools/bench/arrivals_suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace muster::tools {
namespace {

TEST(ArrivalsSuite, EveryPolicyServesTheSameReports) {
  ArrivalsOptions options;
  options.policies = {"mpq", "horizon"};
  options.loads = {0.25, 0.5};
  options.seeds = 1;
  options.first_seed = 3;
  std::vector<ArrivalsRow> rows;
  RunArrivals(options, [&](const ArrivalsRow& row) { rows.push_back(row); });
  ASSERT_EQ(rows.size(), 8u);
  for (std::size_t i = 0; i < rows.size(); i += 2) {
    const ArrivalsRow &mpq = rows[i], &horizon = rows[i + 1];
    EXPECT_EQ(mpq.policy, "mpq");
    EXPECT_EQ(horizon.policy, "horizon");
    EXPECT_EQ(mpq.service.reported(), horizon.service.reported());
    EXPECT_EQ(mpq.service.worth_all, horizon.service.worth_all);
    EXPECT_GT(horizon.service.reported(), mpq.load * 100);  // of 120 times the load
    EXPECT_GT(mpq.service.worth_done, 0);
    EXPECT_LE(horizon.service.worth_done, horizon.service.worth_all);
    const std::string line = ToCsv(mpq), header = ArrivalsCsvHeader();
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
  }
  const std::string summary = SummaryOf(rows);
  EXPECT_EQ(std::count(summary.begin(), summary.end(), '\n'), 2 + 8) << summary;
}

}  // namespace
}  // namespace muster::tools
