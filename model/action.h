#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "base/ids.h"
#include "lcmtypes/words.h"
#include "model/scenario.h"

namespace muster {

inline bool IsPair(ActionKind kind) {
  return kind == ActionKind::kSense || kind == ActionKind::kCharge;
}
inline bool IsStay(ActionKind kind) {
  return kind == ActionKind::kUavStays || kind == ActionKind::kWorkerStays ||
         kind == ActionKind::kVehicleStays;
}

/// Which ids a kind has.
struct ActionShape {
  bool uav = false, worker = false, vehicle = false, task = false, charge = false;
};
/// None: kNone has none, kGoTo that of any one agent.
std::optional<ActionShape> ShapeOf(ActionKind kind);

/// One action: a node of the conflict graph. Ids that the kind does not have are invalid (-1).
struct Action {
  ActionKind kind = ActionKind::kNone;
  UavId uav;
  WorkerId worker;
  VehicleId vehicle;
  TaskId task;
  ChargeId charge;
  Point to;           ///< destination; for a staying agent where it stands
  double weight = 0;  ///< expected benefit per decision interval

  bool operator==(const Action&) const = default;
};

/// The id of the agent of that class that takes part; -1: none.
inline std::int32_t MemberOf(const Action& action, AgentKind kind) {
  return ByKind(kind, action.uav.value, action.worker.value, action.vehicle.value);
}

/// Whether it has the ids that its kind has, and no others.
bool HasItsIds(const Action& action);

/// "UiTxWj uav:3 worker:5 task:17"
std::string ToString(const Action& action);

}  // namespace muster
