// Training whole models, briefly: that it is repeatable, goes on after an end, and that what is
// written decides as what was trained.
#include "learning/trainer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/check.h"
#include "learning/learner.h"
#include "learning/practice_mission.h"
#include "learning/replay.h"
#include "scheduler/policies/learned/learned_policy.h"
#include "scheduler/policies/learned/model.h"
#include "tests/temporary_folder.h"

namespace muster::learning {
namespace {

using scheduler::learned::kMethodNames;
using scheduler::learned::Network;

/// 8 x 8 km, 3 UAVs, 4 workers, 2 vehicles, 12 tasks, everybody online for three hours.
GeneratorSettings Tiny() {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.name = "tiny";
  settings.width_km = settings.height_km = 8;
  settings.uavs = 3;
  settings.workers = 4;
  settings.vehicles = 2;
  settings.tasks = 12;
  settings.charging_points = 3;
  return settings;
}

TrainSettings Brief(const std::string& method, const std::string& folder, std::int64_t episodes) {
  TrainSettings settings;
  settings.method = method;
  settings.scenario = Tiny();
  settings.seed = 3;
  settings.seconds = 1e6;
  settings.episodes = episodes;
  settings.folder = folder;
  settings.look_every = 20;
  settings.held_out = 2;
  return settings;
}

TrainResult TrainAll(const TrainSettings& settings) {
  return Train(
      settings, [](const TrainProgress&) {}, [] { return false; });
}

class EveryMethod : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { SetUpLibtorch(); }
};

TEST_P(EveryMethod, TrainsBitForBitAlikeAndDecidesAsItWasTrained) {
  const TemporaryFolder one, two;
  const TrainResult first = TrainAll(Brief(GetParam(), one.path().string(), 40));
  EXPECT_EQ(first.hash, TrainAll(Brief(GetParam(), two.path().string(), 40)).hash);
  EXPECT_EQ(first.end.episodes, 40);
  EXPECT_GT(first.end.loss, 0);

  // The networks of training and those of use, on the same situations.
  const auto shape = scheduler::learned::ShapeOf(Generate(Tiny(), 1));
  LearnerSettings settings;
  settings.method.method = MethodOf(GetParam());
  Learner learner(settings, MissionProblem(shape));
  const Network network(learner.ActingTensors(), shape, GetParam() == "mf-qmix", "test");
  const Episode episode =
      PlayEpisode(Generate(Tiny(), 7), shape, &network, 0.5, Random(7, Stream::kTest), true);
  std::vector<const Turn*> turns;
  for (const Turn& turn : episode.turns) turns.push_back(&turn);
  const torch::NoGradGuard guard;
  const Seen seen = SeenOf(turns, shape);
  const Sight sight = learner.See(seen);
  std::size_t compared = 0;
  for (std::size_t b = 0; b < turns.size(); ++b) {
    const auto values = network.ValuesOf(turns[b]->observation);
    for (const AgentKind kind : kAgentKinds) {
      for (std::size_t i = 0; i < values[kind].size(); ++i) {
        const auto& view = turns[b]->observation.agents[kind][i];
        for (std::size_t k = 0; k < scheduler::learned::kOptions; ++k) {
          if (view.options[k].kind == scheduler::learned::PlaceOption::Kind::kNone) continue;
          const float theirs = sight.own
                                   .q[static_cast<std::int64_t>(b)][shape.first(kind) + view.id]
                                     [static_cast<std::int64_t>(k)]
                                   .item<float>();
          EXPECT_NEAR(values[kind][i][k], theirs, 1e-4);
          ++compared;
        }
      }
    }
  }
  EXPECT_GT(compared, 200u);
}

INSTANTIATE_TEST_SUITE_P(All, EveryMethod, ::testing::ValuesIn(kMethodNames), [](const auto& row) {
  std::string name = row.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(Train, GoesOnFromItsCheckpoint) {
  SetUpLibtorch();
  const TemporaryFolder folder;
  const std::string path = folder.path().string();
  int said = 0;
  const TrainResult stopped = Train(
      Brief("qmix", path, 60), [&](const TrainProgress&) { ++said; }, [&] { return said >= 30; });
  EXPECT_TRUE(stopped.interrupted);
  EXPECT_EQ(stopped.end.episodes, 30);
  EXPECT_FALSE(stopped.resumed);
  for (const char* file : {"model.json", "model.bin", "curve.csv", "curve.gp", "checkpoint.pt"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  }
  const TrainResult ended = TrainAll(Brief("qmix", path, 60));
  EXPECT_TRUE(ended.resumed);
  EXPECT_EQ(ended.end.episodes, 60);
  EXPECT_GE(ended.end.best, stopped.end.best);
  EXPECT_GT(ended.end.seconds, stopped.end.seconds);
  std::ifstream csv(folder.File("curve.csv"));
  std::string line, last;
  int lines = 0;
  while (std::getline(csv, line)) ++lines, last = line;
  EXPECT_EQ(lines, 5) << "heading, 20, 30 where it stopped, 40, 60: " << last;

  // The best model is the one that is kept, and the policy decides with it.
  const auto model = scheduler::learned::ReadModel(path);
  EXPECT_EQ(model.held_out, ended.end.best);
  scheduler::LearnedPolicy policy("learned:" + path);
  double completion = 0;
  for (std::uint64_t i = 0; i < 2; ++i) {
    completion += CompletionOf(Generate(Tiny(), 900'000'000 + i), &policy) / 2;
  }
  EXPECT_DOUBLE_EQ(completion, ended.end.best);

  TrainSettings other = Brief("sqix", path, 60);
  EXPECT_THROW(TrainAll(other), InputError) << "another method's checkpoint";
  other.resume = false;
  EXPECT_FALSE(TrainAll(other).resumed);
  std::ofstream(folder.File("checkpoint.pt")) << "no archive";
  other.resume = true;
  EXPECT_THROW(TrainAll(other), InputError);
}

TEST(SlowTrain, LearnsMoreThanChance) {
  SetUpLibtorch();
  const TemporaryFolder folder;
  TrainSettings settings = Brief("qmix", folder.path().string(), 500);
  settings.anneal = 200;
  settings.look_every = 100;
  settings.held_out = 10;
  const double chance = RandomCompletion(settings);
  const double best = TrainAll(settings).end.best;
  EXPECT_GT(best, 2 * chance) << "chance " << chance;
  RecordProperty("chance", std::to_string(chance));
  RecordProperty("best", std::to_string(best));
}

}  // namespace
}  // namespace muster::learning
