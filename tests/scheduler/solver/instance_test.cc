#include "scheduler/solver/instance.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "tests/scheduler/solver/explicit_graph.h"

namespace muster::scheduler {
namespace {

/// Two UAVs, two workers and two tasks of one place; everybody may go anywhere, alone and in pairs,
/// but worker 1 ends too late for a pair at task 1.
Instance TwoOfEach() {
  Instance instance;
  instance.uavs = {{0.5}, {0.25}};
  instance.partners = {{0.125}, {2, 100}};
  instance.capacity = {1, 1};
  instance.uav_begin = {0, 2, 4};
  instance.partner_begin = {0, 2, 4};
  for (int site = 0; site < 2; ++site) {
    for (int i = 0; i < 2; ++i) {
      Instance::UavArc uav;
      uav.uav = i;
      uav.level = 1 + i;
      uav.solo = 3 + i;
      uav.base = 12;
      uav.pair_gain = 10 + site;
      uav.arrive_us = 60;
      uav.duration_us = site == 0 ? 40 : 41;
      instance.uav_arcs.push_back(uav);
      instance.partner_arcs.push_back({i, 2 + i, 20.0 + i, 50, true});
    }
  }
  return instance;
}

Assignment Nothing() {
  Assignment assignment;
  assignment.uavs.resize(2);
  assignment.partner_solo = {-1, -1};
  return assignment;
}

TEST(Instance, AnAssignmentIsValidUnlessSomethingIsUsedTwiceOrNotOffered) {
  struct Case {
    const char* what;
    bool valid;
    std::function<void(Instance*, Assignment*)> edit;
  };
  const Case cases[] = {
      {"all stay", true, [](Instance*, Assignment*) {}},
      {"a UAV goes alone", true,
       [](Instance*, Assignment* a) {
         a->uavs[0] = {0, 0, -1};
       }},
      {"a worker goes alone", true, [](Instance*, Assignment* a) { a->partner_solo[0] = 0; }},
      {"a pair", true,
       [](Instance*, Assignment* a) {
         a->uavs[0] = {0, 0, 0};
       }},
      {"a pair that ends in time", true,
       [](Instance*, Assignment* a) {
         a->uavs[0] = {0, 0, 1};
       }},
      {"a pair that ends too late", false,
       [](Instance*, Assignment* a) {
         a->uavs[0] = {1, 2, 3};
       }},
      {"two pairs", true,
       [](Instance*, Assignment* a) {
         a->uavs[0] = {0, 0, 1};
         a->uavs[1] = {1, 3, 2};
       }},
      {"one worker in two pairs", false,
       [](Instance*, Assignment* a) {
         a->uavs[0] = {0, 0, 0};
         a->uavs[1] = {1, 3, 2};
       }},
      {"two UAVs at one place", false,
       [](Instance*, Assignment* a) {
         a->uavs[0] = {0, 0, -1};
         a->uavs[1] = {0, 1, -1};
       }},
      {"two UAVs at two places of one site", true,
       [](Instance* i, Assignment* a) {
         i->capacity[0] = 2;
         a->uavs[0] = {0, 0, -1};
         a->uavs[1] = {0, 1, -1};
       }},
      {"a worker where a UAV is", false,
       [](Instance*, Assignment* a) {
         a->uavs[1] = {0, 1, -1};
         a->partner_solo[0] = 0;
       }},
      {"a worker elsewhere", true,
       [](Instance*, Assignment* a) {
         a->uavs[1] = {0, 1, -1};
         a->partner_solo[0] = 2;
       }},
      {"a worker at the last site where a UAV is", false,
       [](Instance*, Assignment* a) {
         a->uavs[1] = {1, 3, -1};
         a->partner_solo[1] = 3;
       }},
      {"a worker in a pair and alone", false,
       [](Instance*, Assignment* a) {
         a->uavs[0] = {0, 0, 0};
         a->partner_solo[0] = 2;
       }},
      {"another UAV's way", false,
       [](Instance*, Assignment* a) {
         a->uavs[0] = {0, 1, -1};
       }},
      {"a UAV's move alone that is not offered", false,
       [](Instance* i, Assignment* a) {
         i->uav_arcs[0].solo = Instance::kNone;
         a->uavs[0] = {0, 0, -1};
       }},
      {"a pair that is not offered", false,
       [](Instance* i, Assignment* a) {
         i->uav_arcs[0].pair_gain = Instance::kNone;
         a->uavs[0] = {0, 0, 0};
       }},
      {"a worker's move alone that is not offered", false,
       [](Instance* i, Assignment* a) {
         i->partner_arcs[0].solo = false;
         a->partner_solo[0] = 0;
       }},
      {"one UAV is forgotten", false, [](Instance*, Assignment* a) { a->uavs.pop_back(); }},
      {"one worker is forgotten", false,
       [](Instance*, Assignment* a) { a->partner_solo.pop_back(); }},
  };
  for (const Case& c : cases) {
    Instance instance = TwoOfEach();
    Assignment assignment = Nothing();
    c.edit(&instance, &assignment);
    EXPECT_EQ(IsValid(instance, assignment), c.valid) << c.what;
  }
}

TEST(Instance, WeighsEverybodyOnce) {
  const Instance instance = TwoOfEach();
  Assignment assignment = Nothing();
  EXPECT_EQ(WeightOf(instance, assignment), 0.5 + 0.25 + 0.125 + 2);
  assignment.partner_solo[0] = 0;
  EXPECT_EQ(WeightOf(instance, assignment), 0.5 + 0.25 + 20 + 2);
  assignment = Nothing();
  assignment.uavs[1] = {1, 3, -1};
  EXPECT_EQ(WeightOf(instance, assignment), 0.5 + 4 + 0.125 + 2);
  assignment.uavs[0] = {0, 0, 1};  // levels 1 and 3, gains 10 and 21
  EXPECT_EQ(WeightOf(instance, assignment), 12.0 / 3 + 10 + 21 + 4 + 0.125);
}

TEST(Instance, CountsTheNodesOfTheExplicitGraph) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Instance instance = testing::RandomInstance(seed, 1 + static_cast<int>(seed % 9),
                                                      1 + static_cast<int>(seed % 7), 5);
    const auto nodes = static_cast<std::int64_t>(testing::ExplicitNodes(instance).size());
    EXPECT_EQ(CountNodes(instance), nodes) << "seed " << seed;
    EXPECT_EQ(CountNodes(instance, 2), nodes) << "seed " << seed;
  }
  EXPECT_EQ(CountNodes(TwoOfEach()), 4 + 4 + 4 + 4 + 2);
}

}  // namespace
}  // namespace muster::scheduler
