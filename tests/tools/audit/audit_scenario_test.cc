#include "tools/audit/audit_scenario.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace muster::tools::audit {
namespace {

std::string Places(std::mt19937* random, int n, const char* more) {
  std::uniform_int_distribution<int> km(0, 40);  // many share an x
  std::string text;
  for (int i = 0; i < n; ++i) {
    text += fmt::format("{}{{\"x_km\": {}, \"y_km\": {}{}}}", i == 0 ? "" : ", ", km(*random),
                        km(*random), more);
  }
  return text;
}

TEST(AuditScenario, KnowsEachTasksNearestChargingPoint) {
  for (const int n_charges : {0, 1, 7, 60}) {
    std::mt19937 random(static_cast<unsigned>(n_charges));
    const Scenario scenario = ParseScenario(fmt::format(
        R"({{"seed": 1, "interval_min": 10, "limit_min": 60, "area_km": [40, 40], "uavs": [], "workers": [],
            "vehicles": [], "charging_points": [{}], "tasks": [{}]}})",
        Places(&random, n_charges, ""), Places(&random, 200, ", \"cost_km\": 1")));
    ASSERT_EQ(scenario.tasks.size(), 200u);
    for (const Scenario::Task& task : scenario.tasks) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Scenario::Charge& charge : scenario.charges) {
        nearest = std::min(nearest, Apart(task.at, charge.at));
      }
      EXPECT_EQ(task.to_charge_m, nearest) << n_charges << " charging points";
    }
  }
}

}  // namespace
}  // namespace muster::tools::audit
