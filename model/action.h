#pragma once

#include <string>
#include <vector>

#include "base/geometry.h"
#include "base/ids.h"
#include "model/scenario.h"

namespace muster {

/// The nine node types of the conflict graph (paper section 4.1.1) and the free move of policies
/// that work by cells. The numbers are the wire's.
enum class ActionKind : std::int8_t {
  kNone = -1,
  kUavStays = 0,         ///< Ui
  kWorkerStays = 1,      ///< Wj
  kVehicleStays = 2,     ///< Vk
  kUavToTask = 3,        ///< UiTx
  kWorkerToTask = 4,     ///< WjTx
  kUavToCharge = 5,      ///< UiCy
  kVehicleToCharge = 6,  ///< VkCy
  kSense = 7,            ///< UiTxWj
  kCharge = 8,           ///< UiCyVk
  kGoTo = 9,             ///< one agent goes to a point
};

/// The paper's symbol: "Ui", "UiTxWj", ...; "go" for kGoTo.
std::string_view Symbol(ActionKind kind);

inline bool IsPair(ActionKind kind) {
  return kind == ActionKind::kSense || kind == ActionKind::kCharge;
}
inline bool IsStay(ActionKind kind) {
  return kind == ActionKind::kUavStays || kind == ActionKind::kWorkerStays ||
         kind == ActionKind::kVehicleStays;
}

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

/// "UiTxWj uav:3 worker:5 task:17"
std::string ToString(const Action& action);

}  // namespace muster
