#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace muster::scheduler {

/// A draw of chance: a function of decision, UAV, partner, task and the draw's number.
struct Jitter {
  double most = 0;  ///< up to this much is added or taken, in tasks; 0: none
  std::uint32_t draw = 0;
};

/// Draws of chance that hold for a whole plan: at this decision and at all later ones of its
/// forecast.
struct TaskDraws {
  double most = 0;  ///< up to this much is added to an agent's worth at a task, or taken, in tasks
  std::vector<std::uint32_t> of;  ///< [known tasks] the draw's number; 0: none
};

/// How far agents hear each other where no centre decides.
struct Radio {
  double reach_m = 5e3;
  double loss = 0;             ///< share of the messages that do not arrive
  std::uint32_t exchange = 0;  ///< 0: on the first matching, 1: on the second

  bool operator==(const Radio&) const = default;
};

/// What `horizon` weighs and which of its ingredients are on. Source of all of them: ours.
struct HorizonSettings {
  // Ingredients; docs/results/ablation.md shows what each brings.

  /// A pair's duration is that of its ways, the waiting and the sensing or charging; off: the
  /// longer way alone, as in the paper's weights.
  bool true_duration = true;
  /// Agents that will be free at one of the next decisions take part; off: only idle ones.
  bool soon_idle = true;
  /// A second matching, after the first one's ends, says where unmatched agents go ahead to.
  bool send_ahead = true;
  /// Charging is worth the tasks that it enables; off: a tenth of a task, by the share of range
  /// that is missing, close to the paper's weights.
  bool charge_by_use = true;
  /// Among equal numbers of decisions the earlier end and the shorter way win.
  bool ties = true;
  /// A pair is worth more where its UAV can do another task close by afterwards.
  bool chains = true;
  /// A pair with an idle member and one that is not sends the idle one on its way.
  bool meet_ahead = true;

  /// No command leads farther than one interval. A pair that cannot meet before the next decision,
  /// and an agent that goes ahead, take a free move of one interval's length towards the place, and
  /// are matched anew. Off by default: the paper's nine kinds of action have no such move.
  bool steps = false;

  /// The agents agree on the pairs among themselves (policies/neighbours/game.h), without a centre
  /// that finds the heaviest.
  std::optional<Radio> radio = {};

  // Weights.

  /// A pair that ends after n decisions is worth n^-patience of a task.
  double patience = 1.0;
  /// What an interval's time is worth among pairs that end before the same decision, in tasks.
  double finish_weight = 0.1;
  /// What a UAV's way over its full range costs, in tasks.
  double uav_way = 0.35;
  /// What an interval of a partner's way costs, in tasks.
  double partner_way = 0.01;
  /// What a pair gains by the best next task, per worth of that one at its own end.
  double chain_worth = 0.3;
  /// Worth of a pair of which a member is not idle yet.
  double tentative = 0.95;
  /// Decisions ahead within which an agent must be free to take part.
  std::int32_t soon_decisions = 2;
  /// Worth of a task that charging enables.
  double charge_worth = 0.8;
  /// Way to the next task that is expected when the tasks that a range allows are counted, in mean
  /// distances between open tasks (sqrt(area / tasks)).
  double expected_way = 1.0;
  /// Both are added to each pair's worth by chance: one more way to weigh, for `rollout`.
  std::array<Jitter, 2> jitters = {};
  std::shared_ptr<const TaskDraws> task_draws = nullptr;  ///< the same; null: none
};

}  // namespace muster::scheduler
