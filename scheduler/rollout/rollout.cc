#include "scheduler/rollout/rollout.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <utility>

#include "scheduler/horizon/horizon.h"
#include "scheduler/rollout/forward_model.h"
#include "world/model/check.h"

namespace muster::scheduler {

std::vector<HorizonSettings> RolloutSettings::DefaultVariants() {
  const HorizonSettings base;
  std::vector<HorizonSettings> variants = {base};
  const auto add = [&](auto change) {
    HorizonSettings variant = base;
    change(&variant);
    variants.push_back(variant);
  };
  add([](HorizonSettings* s) { s->patience = 0.6; });
  add([](HorizonSettings* s) { s->patience = 1.6; });
  add([](HorizonSettings* s) { s->uav_way = 0.15; });
  add([](HorizonSettings* s) { s->uav_way = 0.7; });
  add([](HorizonSettings* s) { s->finish_weight = 0.4; });
  add([](HorizonSettings* s) { s->charge_worth = 0.4; });
  add([](HorizonSettings* s) { s->charge_worth = 1.2; });
  add([](HorizonSettings* s) { s->tentative = 0.8; });
  add([](HorizonSettings* s) { s->soon_idle = false; });
  add([](HorizonSettings* s) { s->partner_way = 0.04; });
  add([](HorizonSettings* s) { s->soon_decisions = 4; });
  return variants;
}

RolloutPolicy::RolloutPolicy(RolloutSettings settings) : settings_(std::move(settings)) {
  MUSTER_CHECK(!settings_.variants.empty() && settings_.work > 0, "work={}", settings_.work);
}

Decision RolloutPolicy::Decide(const Situation& situation) {
  const auto start = std::chrono::steady_clock::now();
  const std::size_t n = settings_.variants.size();
  std::vector<Decision> decisions(n);
  std::vector<double> worth(n, 0);
  std::vector<char> followed(n, 0);

  /// Calls body(i) for every variant, by two threads at once.
  const auto for_each = [&](auto body) {
    std::atomic<std::size_t> next{0};
    const auto run = [&] {
      for (std::size_t i = next++; i < n; i = next++) body(i);
    };
    if (settings_.threads < 2) return run();
    const std::jthread other(run);
    run();
  };

  for_each([&](std::size_t i) {
    decisions[i] = HorizonPolicy(settings_.variants[i]).Decide(situation);
  });
  std::vector<char> same(n, 0);
  std::size_t different = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i && !same[i]; ++j) {
      const auto& a = decisions[i].actions;
      const auto& b = decisions[j].actions;
      same[i] = std::equal(a.begin(), a.end(), b.begin(), b.end(), [](Action x, Action y) {
        x.weight = y.weight = 0;
        return x == y;
      });
    }
    if (!same[i]) ++different;
  }
  if (different == 1) return decisions[0];

  const auto depth = std::max<std::size_t>(1, static_cast<std::size_t>(settings_.work) / different);
  const auto limit = static_cast<double>(situation.site->rules.limit_us);
  for_each([&](std::size_t i) {
    if (same[i]) return;
    if (i > 0 && settings_.deadline &&
        std::chrono::steady_clock::now() - start >= *settings_.deadline) {
      return;
    }
    followed[i] = 1;
    ForwardModel model(situation);
    HorizonPolicy policy(settings_.variants[i]);
    model.Step(decisions[i].actions);
    for (std::size_t k = 1; k < depth && !model.over() && model.anybody(); ++k) {
      model.Step(policy.Decide(model.situation()).actions);
    }
    for (const TimeUs done : model.done_us()) {
      worth[i] += 1 + settings_.early * (1 - static_cast<double>(done) / limit);
    }
  });
  std::size_t best = 0;
  for (std::size_t i = 1; i < n; ++i) {
    if (followed[i] && worth[i] > worth[best] + 1e-9) best = i;
  }
  return decisions[best];
}

}  // namespace muster::scheduler
