#include "tools/scenario/order_text.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/check.h"
#include "tests/temporary_folder.h"

namespace muster::tools {
namespace {

std::string Refusal(const std::string& json, const std::optional<Origin>& origin = {}) {
  try {
    ReadOrder(json, "order", origin);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(OrderText, PlacesOnEarthBecomePlacesOfTheMap) {
  const Origin origin{18.5, -72.4};
  // A minute of latitude is 1.844 km at 18.5 degrees (WGS84).
  const auto planned = ReadOrder(
      R"({"order": "task_add", "task": {"latitude_deg": 18.51666667, "longitude_deg": -72.4}})",
      "order", origin);
  EXPECT_NEAR(planned.order.task.at.y_m, 1844.6, 1);
  EXPECT_NEAR(planned.order.task.at.x_m, 0, 0.1);
  EXPECT_EQ(nlohmann::json::parse(planned.json)["task"].count("latitude_deg"), 0u);
  EXPECT_FALSE(planned.order.id.empty());
}

TEST(OrderText, SaysWhatIsWrong) {
  EXPECT_EQ(Refusal("nonsense").substr(0, 24), "order: line 1, column 2:");
  EXPECT_EQ(Refusal("[]"), "order: top level: found no object, expected an object");
  EXPECT_EQ(
      Refusal(R"({"order": "fly"})"),
      "order: order: found \"fly\", expected one of task_add, task_change, task_cancel, "
      "task_hold, task_resume, agent_join, agent_leave, agent_recall, road_close, "
      "road_open, zone_add, zone_lift, pin, unpin, forbid, charge_now, go_to, release, withdraw, "
      "decide_now");
  EXPECT_EQ(
      Refusal(R"({"order": "task_cancel", "task": 1, "x": 2})"),
      "order: top level: found the unknown key \"x\", expected only id, issuer, at_min, order, "
      "task");
  EXPECT_EQ(Refusal(R"({"order": "task_cancel", "task": -1})"),
            "order: task: found -1, expected an integer in [0, 2147483647]");
  EXPECT_EQ(Refusal(R"({"order": "agent_leave", "agent": "uav3"})"),
            "order: agent: found \"uav3\", expected an agent, as \"uav:3\"");
  const std::string on_earth =
      R"({"order": "task_add", "task": {"latitude_deg": 91, "longitude_deg": 0}})";
  EXPECT_EQ(Refusal(on_earth),
            "order: task.latitude_deg: found a place on Earth, expected x_km and y_km: this "
            "scenario has no origin");
  EXPECT_EQ(Refusal(on_earth, Origin{1, 2}),
            "order: task.latitude_deg: found 91, expected a number in [-90, 90]");
}

TEST(OrderText, AFileIsReadAndWrittenLineByLine) {
  const TemporaryFolder folder;
  const std::string file = folder.File("orders.jsonl");
  std::ofstream(file)
      << R"({"id": "a", "issuer": "me", "order": "task_cancel", "task": 1})"
      << "\n\n"
      << R"({"id": "b", "at_min": 5, "order": "task_add", "task": {"x_km": 1, "y_km": 2}})"
      << "\n";
  const auto orders = ReadOrderFile(file, {});
  ASSERT_EQ(orders.size(), 2u);
  EXPECT_EQ(orders[1].order.not_before_us, 5 * kMinuteUs);
  EXPECT_EQ(RoomFor(orders).tasks, 1u);
  const std::string again = folder.File("again.jsonl");
  std::ofstream(again) << OrderLines(orders);
  const auto read = world::ReadPlannedOrders(again);
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].order.id, "a");
  EXPECT_EQ(read[0].order.issuer, "me");
  std::ofstream(file, std::ios::app) << R"({"id": "a", "order": "task_cancel", "task": 1})"
                                     << "\n";
  EXPECT_THROW(ReadOrderFile(file, {}), InputError);
}

TEST(OrderText, AFolderIsNoEmptyFile) {
  const TemporaryFolder folder;
  EXPECT_THROW(ReadOrderFile(folder.path().string(), {}), InputError);
  EXPECT_THROW(world::ReadPlannedOrders(folder.path().string()), InputError);
}

}  // namespace
}  // namespace muster::tools
