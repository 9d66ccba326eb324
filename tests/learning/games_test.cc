// What tells the methods apart: games whose joint values some of them cannot represent
// (docs/guide/learned.md). Rashid et al. 2018 and 2020, Wang et al. 2021 have the games.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <string>
#include <tuple>

#include "base/random.h"
#include "learning/learner.h"
#include "learning/trainer.h"

namespace muster::learning {
namespace {

constexpr std::int64_t kBatch = 32;
using Payoff = std::array<std::array<float, 3>, 3>;
constexpr Payoff kMatrix = {{{8, -12, -12}, {-12, 0, 0}, {-12, 0, 0}}};
constexpr Payoff kMonotone = {{{8, 3, 2}, {3, 1, 0}, {2, 0, -1}}};

struct Played {
  float value = 0;        ///< of the joint action that the agents end up with
  float first_total = 0;  ///< two-step game: the largest |Q_tot| of the first step
};

LearnerSettings SettingsOf(Method method, std::uint64_t seed) {
  LearnerSettings settings;
  settings.method.method = method;
  // One head of one layer cannot tell these payoffs apart; large missions need no more.
  settings.method.heads = 10;
  settings.method.layers = 3;
  settings.learning_rate = 2e-3;
  settings.seed = seed;
  return settings;
}

Seen StatesOf(const std::vector<std::int64_t>& states, std::int64_t n_states,
              std::int64_t options) {
  Seen seen;
  seen.size = static_cast<std::int64_t>(states.size());
  seen.state = torch::zeros({seen.size, n_states});
  for (std::int64_t b = 0; b < seen.size; ++b)
    seen.state[b][states[static_cast<std::size_t>(b)]] = 1;
  seen.present = torch::ones({seen.size, 2});
  seen.available = torch::ones({seen.size, 2, options}, torch::kBool);
  return seen;
}

Tensor Drawn(Random* random, std::int64_t n, std::uint32_t options) {
  Tensor actions = torch::zeros({n, 2}, torch::kInt64);
  auto at = actions.accessor<std::int64_t, 2>();
  for (std::int64_t b = 0; b < n; ++b) {
    for (std::int64_t i = 0; i < 2; ++i) at[b][i] = random->Below(options);
  }
  return actions;
}

/// One state, one step.
Played PlayMatrix(Method method, const Payoff& payoff, std::uint64_t seed, int steps) {
  Learner learner(SettingsOf(method, seed), GameProblem(2, 3, 1));
  Random random(seed, Stream::kTest);
  const Seen seen = StatesOf(std::vector<std::int64_t>(kBatch, 0), 1, 3);
  Happened happened;
  happened.done = torch::ones({kBatch});
  happened.charge_gain = torch::zeros({kBatch});
  happened.next = torch::arange(kBatch);
  for (int step = 1; step <= steps; ++step) {
    happened.actions = Drawn(&random, kBatch, 3);
    happened.reward = torch::zeros({kBatch});
    const auto actions = happened.actions.accessor<std::int64_t, 2>();
    auto reward = happened.reward.accessor<float, 1>();
    for (std::int64_t b = 0; b < kBatch; ++b) {
      const std::int64_t row = actions[b][0], column = actions[b][1];
      reward[b] = payoff[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
    }
    learner.Update(seen, happened);
    if (step % 100 == 0) learner.CopyToTarget();
  }
  const torch::NoGradGuard guard;
  const Sight sight = learner.See(seen);
  const Tensor best = BestActions(sight.own.q, sight.available)[0];
  return {payoff[static_cast<std::size_t>(best[0].item<std::int64_t>())]
                [static_cast<std::size_t>(best[1].item<std::int64_t>())],
          0};
}

/// The first agent's first choice leads to a game of 7 everywhere, or to one of up to 8.
Played PlayTwoSteps(Method method, std::uint64_t seed, int steps) {
  static constexpr float kLast[2][2][2] = {{{7, 7}, {7, 7}}, {{0, 1}, {1, 8}}};
  Learner learner(SettingsOf(method, seed), GameProblem(2, 2, 3));
  Random random(seed, Stream::kTest);
  for (int step = 1; step <= steps; ++step) {
    Happened happened;
    happened.actions = Drawn(&random, kBatch, 2);
    happened.reward = torch::zeros({kBatch});
    happened.charge_gain = torch::zeros({kBatch});
    happened.done = torch::zeros({kBatch});
    happened.next = torch::arange(kBatch);
    std::vector<std::int64_t> states(kBatch, 0);
    const auto actions = happened.actions.accessor<std::int64_t, 2>();
    auto reward = happened.reward.accessor<float, 1>();
    for (std::int64_t b = 0; b < kBatch; b += 2) {
      const std::int64_t first = actions[b][0];
      states[static_cast<std::size_t>(b + 1)] = 1 + first;
      happened.next[b] = b + 1;
      happened.done[b + 1] = 1;
      reward[b + 1] = kLast[first][actions[b + 1][0]][actions[b + 1][1]];
    }
    learner.Update(StatesOf(states, 3, 2), happened);
    if (step % 100 == 0) learner.CopyToTarget();
  }
  const torch::NoGradGuard guard;
  const Sight sight = learner.See(StatesOf({0, 1, 2}, 3, 2));
  const Tensor best = BestActions(sight.own.q, sight.available);
  const auto first = best[0][0].item<std::int64_t>();
  Played played;
  played.value = kLast[first][best[1 + first][0].item<std::int64_t>()]
                      [best[1 + first][1].item<std::int64_t>()];
  for (std::int64_t i = 0; i < 4; ++i) {
    const Tensor actions = torch::tensor({i / 2, i % 2}).unsqueeze(0).repeat({3, 1});
    const float total = learner.joiner().Joint(sight, actions)[0].item<float>();
    played.first_total = std::max(played.first_total, std::abs(total));
  }
  return played;
}

struct GameCase {
  const char* name;
  Method method;
  bool represents_any;  ///< whether it can tell the matrix game's best joint action
};
void PrintTo(const GameCase& c, std::ostream* out) { *out << c.name; }

class Games : public ::testing::TestWithParam<std::tuple<GameCase, std::uint64_t>> {
 protected:
  void SetUp() override { SetUpLibtorch(); }
  static GameCase Case() { return std::get<0>(GetParam()); }
  static std::uint64_t Seed() { return std::get<1>(GetParam()); }
};

TEST_P(Games, MatrixGameIsSolvedByWhoCanRepresentIt) {
  EXPECT_EQ(PlayMatrix(Case().method, kMatrix, Seed(), 2000).value, Case().represents_any ? 8 : 0);
}

TEST_P(Games, MonotoneGameIsSolvedByAll) {
  EXPECT_EQ(PlayMatrix(Case().method, kMonotone, Seed(), 1000).value, 8);
}

TEST_P(Games, TwoStepGameNeedsWhatComesLater) {
  const Played played = PlayTwoSteps(Case().method, Seed(), 2000);
  if (Case().method == Method::kMadl) {
    EXPECT_LT(played.first_total, 0.5) << "it learns the reward at hand";
  } else {
    EXPECT_EQ(played.value, Case().method == Method::kVdn ? 7 : 8);
  }
}

const auto kCases = ::testing::Values(
    GameCase{"Vdn", Method::kVdn, false}, GameCase{"Madl", Method::kMadl, false},
    GameCase{"Qmix", Method::kQmix, false}, GameCase{"MfQmix", Method::kMfQmix, false},
    GameCase{"Sqix", Method::kSqix, false}, GameCase{"CwQmix", Method::kCwQmix, true},
    GameCase{"OwQmix", Method::kOwQmix, true}, GameCase{"Qtran", Method::kQtran, true},
    GameCase{"Qplex", Method::kQplex, true});

std::string NameOf(const ::testing::TestParamInfo<std::tuple<GameCase, std::uint64_t>>& row) {
  return std::get<0>(row.param).name + std::to_string(std::get<1>(row.param));
}

// Each takes seconds: two of the three seeds are left to the slow tests.
INSTANTIATE_TEST_SUITE_P(All, Games, ::testing::Combine(kCases, ::testing::Values(1)), NameOf);
INSTANTIATE_TEST_SUITE_P(SlowSeeds, Games, ::testing::Combine(kCases, ::testing::Values(2, 3)),
                         NameOf);

TEST(Learner, TrainsBitForBitAlike) {
  SetUpLibtorch();
  for (const Method method : {Method::kQmix, Method::kQplex, Method::kOwQmix}) {
    std::string hashes[2];
    for (std::string& hash : hashes) {
      Learner learner(SettingsOf(method, 5), GameProblem(2, 3, 1));
      Random random(5, Stream::kTest);
      const Seen seen = StatesOf(std::vector<std::int64_t>(kBatch, 0), 1, 3);
      for (int step = 0; step < 50; ++step) {
        Happened happened;
        happened.actions = Drawn(&random, kBatch, 3);
        happened.reward = happened.actions.sum(1).to(torch::kFloat32);
        happened.charge_gain = torch::zeros({kBatch});
        happened.done = torch::ones({kBatch});
        happened.next = torch::arange(kBatch);
        learner.Update(seen, happened);
      }
      hash = learner.Hash();
    }
    EXPECT_EQ(hashes[0], hashes[1]);
  }
}

}  // namespace
}  // namespace muster::learning
