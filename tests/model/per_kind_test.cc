#include "model/per_kind.h"

#include <gtest/gtest.h>

#include <utility>

namespace muster {
namespace {

TEST(PerKind, HasOneValueForEachClass) {
  PerKind<int> counts{1, 2};
  counts[AgentKind::kVehicle] = 3;
  counts[AgentKind::kUav] += 10;
  EXPECT_EQ(counts.uavs, 11);
  EXPECT_EQ(counts.workers, 2);
  EXPECT_EQ(counts.vehicles, 3);
  int sum = 0;
  for (const AgentKind kind : kAgentKinds) sum += std::as_const(counts)[kind];
  EXPECT_EQ(sum, 16);
}

TEST(AgentRow, HoldsUavsThenWorkersThenVehicles) {
  const AgentRow row({2, 0, 3});
  EXPECT_EQ(row.size(), 5u);
  EXPECT_EQ(row.Find(AgentKind::kUav, 1), 1u);
  EXPECT_EQ(row.Find(AgentKind::kVehicle, 0), 2u);
  EXPECT_EQ(row.Find(AgentKind::kVehicle, 2), 4u);
  EXPECT_EQ(row.Find(AgentKind::kVehicle, 3), std::nullopt);
  EXPECT_EQ(row.Find(AgentKind::kWorker, 0), std::nullopt);
  EXPECT_EQ(row.Find(AgentKind::kUav, -1), std::nullopt);
}

}  // namespace
}  // namespace muster
