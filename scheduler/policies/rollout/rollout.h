#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "scheduler/policies/horizon/horizon.h"
#include "scheduler/policies/rollout/forward_model.h"
#include "scheduler/policies/rollout/plan_search.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

struct RolloutSettings {
  /// Settings of horizon to try; in a tie the first one wins. Each one's decision is simulated to
  /// the end of the known agents' time, and all later decisions are made with the same settings.
  std::vector<HorizonSettings> variants = DefaultVariants();
  /// If the best variant leaves a known task undone, the best decision so far is varied this often
  /// by chance (HorizonSettings::jitters). Each is simulated with the variant's own settings.
  int draws = 48;
  double jitter = 0.1;
  /// The draws come in so many rounds. Once a draw is better than the variant, the draws of later
  /// rounds are near it: their own jitter is added to that draw's.
  int rounds = 1;
  double later_jitter = 0.07;
  /// Decisions that are simulated for the variants, and again for the draws; half as many where the
  /// first variant's decision has more than `many_pairs` pairs to choose from. Repeatable: all
  /// simulations have the same share of it.
  std::int32_t work = 800;
  std::int64_t many_pairs = 12'000;
  /// Limit of the sum of pairs that these decisions choose from, for the variants and again for the
  /// draws, with as many for each as the first variant's decision has. If that allows fewer
  /// decisions than `work`, only so many of the first variants and draws are simulated as can go to
  /// the end. If not even two can, the first variant's decision stands.
  std::int64_t pairs = 50'000'000;
  /// Wall time after which nothing more is simulated, for live use: an answer may then depend on
  /// the machine's speed.
  std::optional<std::chrono::steady_clock::duration> deadline;
  int threads = 2;  ///< 1 or 2; no answer depends on it without a deadline
  /// How much more a task done at mission start is worth than one done at the limit, in tasks.
  double early = 0.5;
  /// Tasks an hour that are expected to be reported from now on (ExpectTasks); 0: none.
  double expect_per_hour = 0;
  /// How many futures are drawn if tasks are expected. A decision counts with what it gets done in
  /// all of them; each future has `work` decisions.
  int futures = 8;
  /// The shift plan is known: the forecast has the agents that come online later (Site::shifts).
  bool shifts = false;
  /// From 2 on, whole plans are searched after the draws (SearchPlans), with as many more simulated
  /// decisions as `work` and `pairs` allow, times effort - 1.
  std::int64_t effort = 1;

  static std::vector<HorizonSettings> DefaultVariants();
};

/// A decision with what leads to it.
struct RolloutPlan {
  HorizonSettings settings;  ///< decided with these
  HorizonSettings follow;    ///< later decisions of the forecast are made with these
  std::int32_t variant = 0;  ///< of RolloutSettings::variants, that both began with
  Decision decision;
  bool decided = false, followed = false;
  Forecast forecast = {};
};

/// Simulates the known situation forward by the rule book (ForwardModel) and decides like the
/// variant of `horizon` that gets most tasks done; then tries other decisions near that one. Of
/// equal decisions only the first is simulated. Source: ours; the idea is that of rollout
/// algorithms (Bertsekas, Tsitsiklis and Wu 1997): one step of improvement over base policies.
class RolloutPolicy : public MatchingPolicy {
 public:
  explicit RolloutPolicy(RolloutSettings settings = {});
  Decision Decide(const Situation& situation) override;
  /// The plan of the search, if there is one and it leads to these actions; else the first of its
  /// variants, else of the draws around them, that does.
  Deciding Explain(const Situation& situation, const std::vector<Action>& commanded) const override;
  bool SetDeadline(std::chrono::steady_clock::duration deadline) override {
    settings_.deadline = deadline;
    return true;
  }
  /// "expect", tasks an hour; "shifts", 0 or 1; "effort", a whole number.
  bool Set(std::string_view key, double value) override;
  /// The plan whose decision is taken in these futures of the situation.
  RolloutPlan Plan(const Situation& situation, const std::vector<Future>& futures) const;

 private:
  using Clock = std::chrono::steady_clock;

  /// The futures in which plans are simulated; without expected tasks the situation alone.
  std::vector<Future> FuturesOf(const Situation& situation) const;
  /// Decides all plans that are not decided yet, and simulates those that differ from each other
  /// and from `known`, with `work` simulated decisions in all.
  void Follow(const Situation& situation, const std::vector<Future>& futures,
              Clock::time_point start, std::int64_t work, const RolloutPlan* known,
              std::vector<RolloutPlan>* plans) const;
  /// The best of `found` and of the plans that a search with `work` simulated decisions finds.
  RolloutPlan Search(const Situation& situation, const std::vector<Future>& futures,
                     Clock::time_point start, std::int64_t work, RolloutPlan found) const;

  /// Varies the settings by a draw: the first draw widely, further draws a little around it.
  void AddDraw(std::uint32_t draw, HorizonSettings* settings) const;

  RolloutSettings settings_;
};

}  // namespace muster::scheduler
