#include "tools/trials/shrink.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "tools/trials/campaign.h"

namespace muster::tools {
namespace {

/// A plan of so many faults that are told apart by their ids.
VirtualMission Planned(std::size_t n) {
  VirtualMission mission;
  for (std::size_t i = 0; i < n; ++i) {
    PlannedFault& fault = mission.faults.emplace_back();
    fault.id = "f" + std::to_string(i);
    fault.for_us = 40 * kMinuteUs;
  }
  mission.drop = 0.1;
  mission.schedulers = 3;
  return mission;
}

std::set<std::string> IdsOf(const VirtualMission& mission) {
  std::set<std::string> ids;
  for (const PlannedFault& fault : mission.faults) ids.insert(fault.id);
  return ids;
}

TEST(Shrink, KeepsJustTheFaultsThatItTakes) {
  for (const std::set<std::string>& needed :
       {std::set<std::string>{"f7"}, std::set<std::string>{"f0", "f19"},
        std::set<std::string>{"f3", "f4", "f11"}, std::set<std::string>{}}) {
    const VirtualMission smallest = Shrink(Planned(20), [&](const VirtualMission& mission) {
      const std::set<std::string> ids = IdsOf(mission);
      return std::includes(ids.begin(), ids.end(), needed.begin(), needed.end());
    });
    EXPECT_EQ(IdsOf(smallest), needed);
    EXPECT_EQ(smallest.drop, 0);
    EXPECT_EQ(smallest.schedulers, 1);
  }
}

TEST(Shrink, MakesThemAsShortAsTheyMayBe) {
  const VirtualMission smallest = Shrink(Planned(3), [](const VirtualMission& mission) {
    return !mission.faults.empty() && mission.faults.front().for_us >= 7 * kMinuteUs &&
           mission.schedulers > 1;
  });
  ASSERT_EQ(smallest.faults.size(), 1U);
  EXPECT_EQ(smallest.faults[0].for_us, 10 * kMinuteUs);
  EXPECT_EQ(smallest.schedulers, 3);
}

TEST(Shrink, EndsWhenItIsAskedTo) {
  int tried = 0;
  Shrink(
      Planned(20), [&](const VirtualMission&) { return ++tried, true; },
      [&] { return tried >= 3; });
  EXPECT_EQ(tried, 3);
}

TEST(Shrink, FindsThePlantedFaultOfARealMission) {
  // Damaged packets pass for true ones; nothing else of this plan breaks a promise.
  CampaignSettings settings;
  settings.goes_on = false;
  VirtualMission mission = DrawMission(settings, 1);
  ASSERT_EQ(FindingsOf(mission), std::vector<std::string>());
  ASSERT_FALSE(mission.faults.empty());
  PlannedFault planted = ParseFaultFlag("corruption:*@1=0.2", 0);
  planted.id = "planted";
  mission.faults.push_back(planted);
  const VirtualMission smallest =
      Shrink(mission, [](const VirtualMission& less) { return !FindingsOf(less).empty(); });
  EXPECT_EQ(IdsOf(smallest), std::set<std::string>{"planted"});
}

TEST(Shrink, NumbersAreNoOtherKindOfFinding) {
  EXPECT_EQ(FindingKind("audit, 12.0 min: motion: uav:3 is 4 m away"),
            FindingKind("audit, 7.5 min: motion: uav:11 is 1 m away"));
  EXPECT_NE(FindingKind("audit, 12.0 min: motion: uav:3"),
            FindingKind("audit, 12.0 min: range: uav:3"));
}

}  // namespace
}  // namespace muster::tools
