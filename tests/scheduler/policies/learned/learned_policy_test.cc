#include "scheduler/policies/learned/learned_policy.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/check.h"
#include "model/generator.h"
#include "scheduler/checker.h"
#include "scheduler/policies/registry.h"
#include "tests/scheduler/policies/learned/learned_model.h"
#include "tests/scheduler/situation_builder.h"
#include "tests/temporary_folder.h"

namespace muster::scheduler {
namespace {

using testing::RandomModel;
using testing::RandomSituation;
using testing::SituationBuilder;

constexpr testing::RandomSize kSize{6, 8, 5, 9, 3, 12};

learned::Shape ShapeOfSize() {
  learned::Shape shape;
  shape.columns = shape.rows = 12;
  shape.agents = {6, 8, 5};
  shape.interval_us = Rules().interval_us;
  shape.limit_us = Rules().limit_us;
  return shape;
}

TEST(LearnedPolicy, KeepsEveryRuleWhateverItsNumbersAre) {
  const TemporaryFolder folder;
  for (const std::string method : {"qmix", "mf-qmix"}) {
    WriteModel(RandomModel(ShapeOfSize(), 3, method), folder.path().string());
    const auto policy = MakePolicy("learned:" + folder.path().string());
    std::size_t moves = 0, pairs = 0;
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      Rules rules;
      if (seed % 3 == 1) rules.availability = Availability::kOverrun;
      testing::RandomSize size = kSize;
      size.times = seed % 2 == 1;
      const Situation situation = RandomSituation(seed, size, rules);
      const Decision decision = policy->Decide(situation);
      for (const Violation& violation : CheckActions(situation, decision.actions)) {
        ADD_FAILURE() << violation.message;
      }
      for (const Action& action : decision.actions) {
        moves += action.kind == ActionKind::kGoTo;
        pairs += IsPair(action.kind);
      }
      EXPECT_EQ(policy->Decide(situation).actions, decision.actions);
      EXPECT_EQ(MakePolicy("learned:" + folder.path().string())->Decide(situation).actions,
                decision.actions);
    }
    EXPECT_GT(moves, 200u) << method;
    EXPECT_GT(pairs, 10u) << method;
  }
}

TEST(LearnedPolicy, IsForOneShapeOfScenario) {
  const TemporaryFolder folder;
  const Scenario scenario = Generate(PresetByName("Random_1"), 1);
  WriteModel(RandomModel(learned::ShapeOf(scenario), 3), folder.path().string());
  const auto policy = MakePolicy("learned:" + folder.path().string());
  EXPECT_NO_THROW(policy->CheckScenario(scenario));
  EXPECT_NO_THROW(policy->CheckScenario(Generate(PresetByName("Random_1"), 2)));
  const Scenario other = Generate(PresetByName("Random_2"), 1);
  try {
    policy->CheckScenario(other);
    FAIL();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("20 x 20 km, 30 UAVs"), std::string::npos) << message;
    EXPECT_NE(message.find("30 x 30 km, 30 UAVs"), std::string::npos) << message;
  }
  EXPECT_THROW(policy->Decide(RandomSituation(1, kSize)), InputError);
}

TEST(LearnedPolicy, LeavesAgentsThatItDoesNotKnowWhereTheyAre) {
  const TemporaryFolder folder;
  learned::Shape shape = ShapeOfSize();
  shape.agents = {4, 5, 2};
  WriteModel(RandomModel(shape, 3), folder.path().string());
  const auto policy = MakePolicy("learned:" + folder.path().string());
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  const learned::Shape before = learned::ShapeOf(scenario);
  AddRoom({3, {1, 2, 3}}, &scenario);
  EXPECT_TRUE(learned::ShapeOf(scenario) == before) << "agents that orders may add";
  std::size_t actions = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Situation situation = RandomSituation(seed, kSize);
    const Decision decision = policy->Decide(situation);
    EXPECT_TRUE(CheckActions(situation, decision.actions).empty());
    for (const Action& action : decision.actions) {
      ++actions;
      EXPECT_LT(action.uav.value, 4);
      EXPECT_LT(action.worker.value, 5);
      EXPECT_LT(action.vehicle.value, 2);
    }
  }
  EXPECT_GT(actions, 20u);
}

TEST(LearnedPolicy, RefusesWhatIsNoModel) {
  const TemporaryFolder folder;
  EXPECT_THROW(MakePolicy("learned:"), InputError);
  EXPECT_THROW(MakePolicy("learned:" + folder.File("nowhere")), InputError);
  const learned::Model model = RandomModel(ShapeOfSize(), 3);
  WriteModel(model, folder.path().string());
  EXPECT_NO_THROW(MakePolicy("learned:" + folder.path().string()));
  const std::string weights = folder.File("model.bin");
  std::filesystem::resize_file(weights, 1000);
  EXPECT_THROW(MakePolicy("learned:" + folder.path().string()), InputError) << "cut short";
  learned::Model other = model;
  other.tensors.erase("uav.score.bias");
  WriteModel(other, folder.path().string());
  EXPECT_THROW(MakePolicy("learned:" + folder.path().string()), InputError) << "a layer is missing";
  other = model;
  other.method = "guess";
  WriteModel(other, folder.path().string());
  EXPECT_THROW(MakePolicy("learned:" + folder.path().string()), InputError) << "no such method";
  for (const char* text : {"", "{}", "[", "{\"format\": 99, \"features\": 1, \"options\": 17}"}) {
    std::ofstream(folder.File("model.json")) << text;
    EXPECT_THROW(MakePolicy("learned:" + folder.path().string()), InputError) << text;
  }
}

TEST(LearnedModel, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const learned::Model model = RandomModel(ShapeOfSize(), 8, "mf-qmix");
  WriteModel(model, folder.path().string());
  const learned::Model read = learned::ReadModel(folder.path().string());
  EXPECT_EQ(read.method, model.method);
  EXPECT_TRUE(read.shape == model.shape);
  ASSERT_EQ(read.tensors.size(), model.tensors.size());
  for (const auto& [name, tensor] : model.tensors) {
    EXPECT_EQ(read.tensors.at(name).shape, tensor.shape) << name;
    EXPECT_EQ(read.tensors.at(name).values, tensor.values) << name;
  }
}

TEST(LearnedFeatures, OffersWhatAnAgentMayDo) {
  // A UAV with 8 km left: the task at 2 km (3 km of sensing, 1 km on to charge) is within
  // constraint (6), that at 6 km is not; the charging point at 3 km is.
  const Situation situation = SituationBuilder()
                                  .Uav({0, 0}, 8e3)
                                  .Worker({2e3, 0})
                                  .Vehicle({0, 0})
                                  .Task({2e3, 0})
                                  .Task({6e3, 0})
                                  .Charge({3e3, 0})
                                  .Build();
  learned::Shape shape;
  shape.columns = shape.rows = 30;
  shape.agents = {1, 1, 1};
  const learned::Observation seen = learned::Observe(situation, shape);
  ASSERT_EQ(seen.agents.uavs.size(), 1u);
  const learned::AgentView& uav = seen.agents.uavs[0];
  using Kind = learned::PlaceOption::Kind;
  EXPECT_EQ(uav.options[0].kind, Kind::kStay);
  EXPECT_EQ(uav.options[1].kind, Kind::kTask);
  EXPECT_EQ(uav.options[1].site, 0);
  EXPECT_EQ(uav.options[2].kind, Kind::kCharge);
  EXPECT_EQ(uav.options[3].kind, Kind::kNone);
  // 10 m/s for 10 min: one interval is 6 km.
  EXPECT_FLOAT_EQ(uav.features[1][0], 1.0F / 3) << "dx";
  EXPECT_EQ(uav.features[1][3], 1) << "within one interval";
  EXPECT_EQ(uav.features[1][4], 1) << "a task";
  EXPECT_EQ(uav.features[1][11], 0) << "a worker stands there";
  EXPECT_FLOAT_EQ(uav.features[1][12], 1.0F / 3) << "the later of the two";
  EXPECT_EQ(uav.features[2][5], 1) << "a charging point";
  EXPECT_FLOAT_EQ(uav.features[2][11], 0.5F) << "the vehicle is half an interval away";
  EXPECT_EQ(seen.agents.workers[0].options[2].kind, Kind::kTask) << "no range to heed";
  EXPECT_EQ(seen.maps[4 * 900 + 2], 1) << "a task in the third cell";
  EXPECT_GT(seen.maps[3 * 900], 0) << "urgency";

  // Both at the first task: a pair. The vehicle's place is not the UAV's: it goes alone.
  learned::Choices choices;
  choices.uavs = {1};
  choices.workers = {1};
  choices.vehicles = {1};
  const auto actions = learned::ActionsOf(situation, seen, choices);
  ASSERT_EQ(actions.size(), 2u);
  EXPECT_EQ(actions[0].kind, ActionKind::kSense);
  EXPECT_EQ(actions[1].kind, ActionKind::kGoTo);
  // Apart: the worker gets 3 of the 4 km in ten minutes, at 5 m/s.
  choices.uavs = {0};
  choices.workers = {2};
  const auto apart = learned::ActionsOf(situation, seen, choices);
  ASSERT_EQ(apart.size(), 3u);
  EXPECT_EQ(apart[0].kind, ActionKind::kUavStays);
  EXPECT_NEAR(apart[1].to.x_m, 5e3, 0.1);
}

}  // namespace
}  // namespace muster::scheduler
