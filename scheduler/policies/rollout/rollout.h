#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "scheduler/policies/horizon/horizon.h"
#include "scheduler/policies/rollout/expected_tasks.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

struct RolloutSettings {
  /// Ways to weigh, the first one first in a tie. Each is followed to the end of the known agents'
  /// time by deciding on with the same weights.
  std::vector<HorizonSettings> variants = DefaultVariants();
  /// When the best variant leaves a known task undone: the best decision so far is varied this
  /// often by chance (HorizonSettings::jitters), each followed with the variant's own weights.
  int draws = 48;
  double jitter = 0.1;
  /// Rounds that the draws are parted into. Once a draw is better than the variant, those of later
  /// rounds are around it: their own jitter is added to the draw's.
  int rounds = 1;
  double later_jitter = 0.07;
  /// Decisions that are simulated for the variants, and again for the draws; half as many where the
  /// first variant's decision has more than `many_pairs` pairs to choose from. Repeatable: all that
  /// are followed may go equally far.
  std::int32_t work = 800;
  std::int64_t many_pairs = 12'000;
  /// Pairs that these decisions may choose from, all together, for the variants and again for the
  /// draws, as if each had those of the first variant's decision. Where that allows fewer than
  /// `work`, the first variants and the first draws are followed, as many as can go to the end;
  /// where not even two can, the first variant's decision stands.
  std::int64_t pairs = 50'000'000;
  /// Wall time after which nothing further is followed, for live use: an answer may then depend on
  /// the machine's speed.
  std::optional<std::chrono::steady_clock::duration> deadline;
  int threads = 2;  ///< 1 or 2; no answer depends on it without a deadline
  /// What a task done at mission start is worth above one done at the limit, in tasks.
  double early = 0.5;
  /// Tasks an hour that are expected to be reported from now on (ExpectTasks); 0: none.
  double expect_per_hour = 0;
  /// So many futures are drawn where tasks are expected. A decision counts with what it gets done
  /// in all of them; `work` is for each.
  int futures = 8;

  static std::vector<HorizonSettings> DefaultVariants();
};

/// Decides like that variant of `horizon` under which most tasks get done, the known situation
/// carried forward on the rule book (ForwardModel); then tries other decisions near that one.
/// Decisions that are alike are followed once, the first of them. Source: ours; the idea is that of
/// rollout algorithms (Bertsekas, Tsitsiklis and Wu 1997): one step of improvement over base
/// policies.
class RolloutPolicy : public MatchingPolicy {
 public:
  explicit RolloutPolicy(RolloutSettings settings = {});
  Decision Decide(const Situation& situation) override;
  /// The first of its variants, else of the draws around them, that leads to these actions.
  Deciding Explain(const Situation& situation, const std::vector<Action>& commanded) const override;
  bool SetDeadline(std::chrono::steady_clock::duration deadline) override {
    settings_.deadline = deadline;
    return true;
  }
  bool ExpectArrivals(double per_hour) override {
    settings_.expect_per_hour = per_hour;
    return true;
  }

 private:
  struct Plan {
    HorizonSettings settings;  ///< decided with these
    HorizonSettings follow;    ///< decides on with these
    Decision decision;
    bool decided = false, followed = false;
    double worth = 0;
    std::size_t done = 0;  ///< tasks
  };
  /// What the plans are followed into; without expected tasks the situation alone.
  std::vector<ExpectedTasks> FuturesOf(const Situation& situation) const;
  /// Decides all plans that are not decided yet, follows those that differ from each other and from
  /// `known`, for `work` simulated decisions in all.
  void Follow(const Situation& situation, const std::vector<ExpectedTasks>& futures,
              std::chrono::steady_clock::time_point start, std::int64_t work, const Plan* known,
              std::vector<Plan>* plans) const;

  /// Varies the settings by a draw: by a first one widely, by another one around that.
  void AddDraw(std::uint32_t draw, HorizonSettings* settings) const;

  RolloutSettings settings_;
};

}  // namespace muster::scheduler
