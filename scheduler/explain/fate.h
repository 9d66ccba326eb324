#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "model/scenario.h"
#include "scheduler/explain/deciding.h"
#include "scheduler/explain/look.h"

namespace muster::scheduler {

enum class FateKind {
  kCameAbout,   ///< the pair was commanded, or met by itself
  kOthers,      ///< another pair was commanded or planned for the place
  kFailed,      ///< a member failed
  kOffline,     ///< a member went offline
  kImpossible,  ///< the pair was not possible any more
  kOutbid,      ///< possible, but the matching gave its members, or nothing, to the place
  kOpen         ///< still planned at the last decision of the log
};
/// "came about", "other pair", "failed", "offline", "impossible", "outbid", "still planned"
std::string_view ToString(FateKind kind);

/// What became of a pair that a matching planned for later.
struct Fate {
  FateKind kind = FateKind::kOpen;
  std::int32_t decision = -1;  ///< that settled it; -1: none followed
  TimeUs at_us = 0;
  int kept = 0;                          ///< decisions in between at which it was still planned
  std::optional<AgentKind> member_kind;  ///< of the agent that failed or went offline
  std::int32_t member = -1;
  std::optional<Action> taken_by;  ///< the pair that was commanded to the task
  /// The pairs that the matching had for its members, and for its task, instead.
  std::vector<PairPlan> rivals;
  std::optional<PlaceLook> look;  ///< impossible: that pair alone
};

/// Follows a pair that was planned at `decision` through the decisions after it, until it is
/// settled. `decision_at` gives them by number; null: the log does not hold it.
Fate FateOf(const PairPlan& pair, std::int32_t decision, const Scenario& scenario,
            const std::function<const HorizonDecision*(std::int32_t)>& decision_at);

}  // namespace muster::scheduler
