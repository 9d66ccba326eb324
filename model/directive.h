#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "model/per_kind.h"
#include "model/zone.h"

namespace muster {

/// What the commander has decided instead of the policy, in force until it is released
/// (docs/guide/directives.md).
struct Directive {
  enum class Kind : std::int8_t {
    kPin,     ///< a UAV, a worker or both do that task and nothing before it; nobody else does it
    kForbid,  ///< an agent does not do that task, or a class does nothing in that area
    kChargeNow,  ///< a UAV is charged before it does anything else
    kGoTo,       ///< an agent goes to that place and waits there
  };

  Kind kind = Kind::kPin;
  std::string order, issuer;                    ///< of the order that gave it
  PerKind<std::int32_t> agents = {-1, -1, -1};  ///< of each class the one that is named
  std::int32_t task = -1;
  std::int32_t charge = -1;              ///< where to charge; -1: the policy's choice
  Point place;                           ///< of kGoTo
  AgentKind of_class = AgentKind::kUav;  ///< that keeps out of `area`
  std::shared_ptr<const Zone> area;      ///< null: of kForbid, one agent and one task

  /// The only agent of kChargeNow, kGoTo and a forbidden pair.
  AgentKind agent_kind() const;
};

/// "pin: uav:3 and worker:7 to task 12", for people.
std::string ToString(const Directive& directive);

/// An agent that must not do a task.
struct ForbiddenPair {
  AgentKind kind;
  std::int32_t agent, task;
  auto operator<=>(const ForbiddenPair&) const = default;
};

/// Those of the directives, sorted.
std::vector<ForbiddenPair> ForbiddenPairs(std::span<const Directive> directives);

/// Whether agents of that class may do nothing at that place.
bool IsOffLimits(std::span<const Directive> directives, AgentKind kind, Point place);

}  // namespace muster
