#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "scheduler/horizon/settings.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

struct RolloutSettings {
  /// Ways to weigh, the first one first in a tie. Each is followed to the end of the known agents'
  /// time by deciding on with the same weights.
  std::vector<HorizonSettings> variants = DefaultVariants();
  /// Decisions that are simulated in all. Repeatable: each variant may go equally far.
  std::int32_t work = 400;
  /// Wall time after which no further variant is begun, for live use: an answer may then depend on
  /// the machine's speed.
  std::optional<std::chrono::steady_clock::duration> deadline;
  int threads = 2;  ///< 1 or 2; no answer depends on it without a deadline
  /// What a task done at mission start is worth above one done at the limit, in tasks.
  double early = 0.5;

  static std::vector<HorizonSettings> DefaultVariants();
};

/// Decides like that variant of `horizon` under which most tasks get done, the known situation
/// carried forward on the rule book (ForwardModel). Variants that decide alike now are followed
/// once, the first of them. Source: ours; the idea is that of rollout algorithms (Bertsekas,
/// Tsitsiklis and Wu 1997): one step of improvement over base policies.
class RolloutPolicy : public Policy {
 public:
  explicit RolloutPolicy(RolloutSettings settings = {});
  Decision Decide(const Situation& situation) override;

 private:
  RolloutSettings settings_;
};

}  // namespace muster::scheduler
