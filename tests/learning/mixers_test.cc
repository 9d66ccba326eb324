// Identities that the mixers hold whatever their numbers are.
#include <gtest/gtest.h>

#include <memory>

#include "learning/methods.h"

namespace muster::learning {

struct ActionLayerTest {
  /// The same layer over the one-hot row that it stands for.
  static Tensor Dense(ActionLayer* layer, const Tensor& e, const Tensor& actions,
                      const Tensor& present, std::int64_t options) {
    const Tensor one_hot = torch::one_hot(actions, options).to(torch::kFloat32);
    return layer->state_(e) +
           torch::matmul((one_hot * present.unsqueeze(2)).flatten(1), layer->action_->weight);
  }
};

namespace {

constexpr std::int64_t kSituations = 20, kAgents = 3, kChoices = 4, kWidth = 6;

Problem Small() { return GameProblem(kAgents, kChoices, kWidth); }

/// Random values, with absent agents.
Sight RandomSight() {
  Sight sight;
  sight.e = torch::rand({kSituations, kWidth});
  sight.present = torch::ones({kSituations, kAgents});
  sight.present[3][1] = 0;
  sight.available = torch::ones({kSituations, kAgents, kChoices}, torch::kBool);
  sight.available[2][0][3] = false;
  sight.own = {torch::randn({kSituations, kAgents, kChoices}),
               torch::rand({kSituations, kAgents, kHidden})};
  sight.central = {torch::randn({kSituations, kAgents, kChoices}), sight.own.hidden};
  return sight;
}

Tensor SameForAll(const std::vector<std::int64_t>& actions) {
  return torch::tensor(actions).unsqueeze(0).repeat({kSituations, 1});
}

TEST(QmixMixer, FallsInNoAgentsValue) {
  torch::manual_seed(1);
  QmixMixer mixer(kAgents, kWidth);
  Tensor q = torch::randn({kSituations, kAgents}).requires_grad_();
  mixer.forward(q, torch::randn({kSituations, kWidth})).sum().backward();
  EXPECT_GE(q.grad().min().item<float>(), 0);
  EXPECT_GT(q.grad().max().item<float>(), 0);
}

TEST(Joiner, BestOfAllIsTheBestOfEach) {
  torch::manual_seed(2);
  for (const Method method : {Method::kMadl, Method::kQmix, Method::kMfQmix, Method::kSqix,
                              Method::kCwQmix, Method::kOwQmix, Method::kQplex, Method::kVdn}) {
    MethodSettings settings;
    settings.method = method;
    const auto joiner = MakeJoiner(settings, Small());
    const torch::NoGradGuard guard;
    const Sight sight = RandomSight();
    const Tensor best = joiner->Joint(sight, BestActions(sight.own.q, sight.available));
    for (std::int64_t i = 0; i < 64; ++i) {
      const Tensor actions = SameForAll({i / 16, i / 4 % 4, i % 4});
      const Tensor usable = sight.available.gather(2, actions.unsqueeze(2)).squeeze(2).all(1);
      const Tensor excess = (joiner->Joint(sight, actions) - best) * usable;
      EXPECT_LE(excess.max().item<float>(), 1e-5) << static_cast<int>(method);
    }
  }
}

TEST(QplexMixer, WeighsAdvantagesAboveZero) {
  torch::manual_seed(3);
  QplexMixer mixer(kAgents, kChoices, kWidth, 4, 1);
  const Tensor lambda =
      mixer.Lambda(torch::randint(0, kChoices, {kSituations, kAgents}),
                   torch::ones({kSituations, kAgents}), torch::randn({kSituations, kWidth}));
  EXPECT_GT(lambda.min().item<float>(), 0);
}

TEST(ActionLayer, IsTheDenseOneHotLayer) {
  torch::manual_seed(4);
  ActionLayer layer(kAgents, kChoices, kWidth, 5);
  const Sight sight = RandomSight();
  const Tensor actions = torch::randint(0, kChoices, {kSituations, kAgents});
  const Tensor dense = ActionLayerTest::Dense(&layer, sight.e, actions, sight.present, kChoices);
  EXPECT_TRUE(torch::allclose(layer.forward(sight.e, actions, sight.present), dense, 1e-5, 1e-6));
}

TEST(Sqix, MixesDeviationsAsIfEachWereWhole) {
  torch::manual_seed(5);
  QmixMixer mixer(kAgents, kWidth);
  const torch::NoGradGuard guard;
  const Tensor q = torch::randn({kSituations, kAgents}), e = torch::randn({kSituations, kWidth});
  const Tensor others = torch::randn({kSituations, kAgents, 2});
  const Tensor quick = mixer.Deviations(q, others, e);
  for (std::int64_t i = 0; i < kAgents; ++i) {
    for (std::int64_t k = 0; k < 2; ++k) {
      Tensor changed = q.clone();
      changed.select(1, i).copy_(others.select(1, i).select(1, k));
      EXPECT_TRUE(
          torch::allclose(quick.select(1, i).select(1, k), mixer.forward(changed, e), 1e-5, 1e-5));
    }
  }
}

TEST(Sqix, ColdestIsTheBestAndWarmestTheMean) {
  torch::manual_seed(6);
  QmixMixer mixer(kAgents, kWidth);
  const torch::NoGradGuard guard;
  const Sight sight = RandomSight();
  const Tensor best = BestActions(sight.own.q, sight.available);
  const Tensor most = mixer.forward(ChosenOf(sight.own.q, best, sight.present), sight.e);
  const Tensor cold = SqixValue(&mixer, &mixer, sight, sight, 1e6, 4);
  EXPECT_TRUE(torch::allclose(cold, most, 1e-4, 1e-4));
  // All of each agent's other options, the same weight for each: by hand in the first situation.
  const Tensor warm = SqixValue(&mixer, &mixer, sight, sight, 0, 3);
  double sum = most[0].item<double>();
  for (std::int64_t i = 0; i < kAgents; ++i) {
    for (std::int64_t k = 0; k < kChoices; ++k) {
      if (k == best[0][i].item<std::int64_t>()) continue;
      Tensor actions = best.clone();
      actions[0][i] = k;
      sum +=
          mixer.forward(ChosenOf(sight.own.q, actions, sight.present), sight.e)[0].item<double>();
    }
  }
  EXPECT_NEAR(warm[0].item<double>(), sum / 10, 1e-4);
}

TEST(MeanField, IsTheWeightedMeanOfWhatNeighboursAreExpectedToDo) {
  torch::manual_seed(7);
  MeanField field;
  const torch::NoGradGuard guard;
  const Sight sight = RandomSight();
  Seen seen;
  seen.size = kSituations;
  seen.present = sight.present;
  seen.available = sight.available;
  const Tensor features = torch::ones({kSituations, kAgents, kChoices, 2});
  Tensor at = torch::zeros({kSituations, kAgents, 2});
  at.select(1, 2).fill_(10);  // the third is far from the others
  const Tensor near = Neighbours(seen, at, torch::ones({kSituations, kAgents}));
  EXPECT_EQ(near[0][0][1].item<float>(), 1);
  EXPECT_EQ(near[0][0][2].item<float>(), 0);
  EXPECT_EQ(near[0][2].sum().item<float>(), 2) << "nobody near: everybody";
  EXPECT_EQ(near[0].diagonal().sum().item<float>(), 0);
  EXPECT_EQ(near[3][0][1].item<float>(), 0) << "absent";
  Tensor classes = torch::zeros({2, kAgents});
  classes[0][0] = classes[0][1] = classes[1][2] = 1;
  const Tensor mean = field.forward(sight.own, seen, features, near, classes);
  EXPECT_EQ(mean.size(2), 4);
  EXPECT_TRUE(torch::allclose(mean[0][0], torch::tensor({1.0F, 1.0F, 0.0F, 0.0F})));
  EXPECT_TRUE(torch::allclose(mean[0][2], torch::tensor({1.0F, 1.0F, 0.0F, 0.0F})));
  // Alone: nothing.
  seen.present = torch::zeros({kSituations, kAgents});
  const Tensor none = Neighbours(seen, at, torch::ones({kSituations, kAgents}));
  EXPECT_EQ(field.forward(sight.own, seen, features, none, classes).abs().sum().item<float>(), 0);
}

TEST(MethodOf, NamesWhatIsMeant) {
  EXPECT_EQ(MethodOf("marl"), Method::kQmix);
  EXPECT_EQ(MethodOf("sqix"), Method::kSqix);
  EXPECT_THROW(MethodOf("qmxi"), std::runtime_error);
}

}  // namespace
}  // namespace muster::learning
