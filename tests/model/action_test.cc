#include "model/action.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace muster {
namespace {

/// An action with those ids 0; the letters stand for UAV, worker, vehicle, task, charging point.
Action With(ActionKind kind, const std::string& ids) {
  Action action;
  action.kind = kind;
  for (const char id : ids) {
    if (id == 'u') action.uav = UavId(0);
    if (id == 'w') action.worker = WorkerId(0);
    if (id == 'v') action.vehicle = VehicleId(0);
    if (id == 't') action.task = TaskId(0);
    if (id == 'c') action.charge = ChargeId(0);
  }
  return action;
}

TEST(Action, HasExactlyTheIdsOfItsKind) {
  struct Row {
    ActionKind kind;
    std::vector<std::string> right;
  };
  const Row rows[] = {{ActionKind::kNone, {}},
                      {ActionKind::kUavStays, {"u"}},
                      {ActionKind::kWorkerStays, {"w"}},
                      {ActionKind::kVehicleStays, {"v"}},
                      {ActionKind::kUavToTask, {"ut"}},
                      {ActionKind::kWorkerToTask, {"wt"}},
                      {ActionKind::kUavToCharge, {"uc"}},
                      {ActionKind::kVehicleToCharge, {"vc"}},
                      {ActionKind::kSense, {"uwt"}},
                      {ActionKind::kCharge, {"uvc"}},
                      {ActionKind::kGoTo, {"u", "w", "v"}}};
  for (const Row& row : rows) {
    // All 32 sets of ids.
    for (unsigned set = 0; set < 32; ++set) {
      std::string ids;
      for (unsigned i = 0; i < 5; ++i) {
        if ((set >> i & 1) != 0) ids += "uwvtc"[i];
      }
      const bool right = std::find(row.right.begin(), row.right.end(), ids) != row.right.end();
      EXPECT_EQ(HasItsIds(With(row.kind, ids)), right) << ToString(row.kind) << " with " << ids;
    }
  }
}

TEST(Action, SaysTheIdsThatItHas) {
  Action action = With(ActionKind::kSense, "uwt");
  action.worker = WorkerId(5);
  EXPECT_EQ(ToString(action), "UiTxWj uav:0 worker:5 task:0");
  EXPECT_EQ(MemberOf(action, AgentKind::kWorker), 5);
  EXPECT_EQ(MemberOf(action, AgentKind::kVehicle), -1);
}

}  // namespace
}  // namespace muster
