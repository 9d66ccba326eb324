// As audit/findings_test.cc, of missions with what its missions lack: streets, zones, UAVs that are
// kept apart, orders and directives. directed_findings.txt has the lines.
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/audit/edits.h"
#include "tests/tools/trials/directed_missions.h"
#include "tools/trials/campaign.h"

namespace muster::tools {
namespace {

using testing::Edit;
using testing::Field;
using testing::Findings;
using testing::ItemField;
using testing::ItemGoneOrTwice;

testing::Packets PacketsOf(VirtualMission mission) {
  testing::Packets packets;
  mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t) {
    packets.push_back(*event.packet);
  };
  RunVirtualMission(mission);
  return packets;
}

class DirectedFindings : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(DirectedFindings, AreThoseTheyWere) {
  VirtualMission mission = DirectedMission("horizon", GetParam());
  mission.scenario.rules.limit_us = 60 * kMinuteUs;
  const testing::Packets packets = PacketsOf(mission);
  bool found = false;
  const std::string text = testing::AuditOf(packets, &found);
  ASSERT_FALSE(found) << text;
  Findings findings("seed-" + std::to_string(GetParam()));

  const auto agent = [&](const std::string& name, auto field) {
    Edit<agent_states_t>(&findings, packets, "agent " + name,
                         ItemField(&agent_states_t::agents, field));
  };
  agent("x", &agent_t::x_m);
  agent("y", &agent_t::y_m);
  agent("range", &agent_t::range_left_m);
  agent("departure", &agent_t::depart_us);
  agent("arrival", &agent_t::arrive_us);
  agent("status", &agent_t::status);
  agent("target", &agent_t::target_id);
  agent("partner", &agent_t::partner_id);
  const auto activity = [&](const std::string& name, auto field) {
    Edit<world_state_t>(&findings, packets, "activity " + name,
                        ItemField(&world_state_t::activities, field));
  };
  activity("partner", &activity_t::partner_id);
  activity("site", &activity_t::site_id);
  activity("start", &activity_t::start_us);
  activity("end", &activity_t::end_us);
  Edit<rulings_t>(&findings, packets, "ruling gone or twice",
                  ItemGoneOrTwice(&rulings_t::rulings, &rulings_t::n));
  const auto action = [&](const std::string& name, auto field) {
    Edit<schedule_t>(&findings, packets, "action " + name, ItemField(&schedule_t::actions, field));
  };
  action("kind", &action_t::kind);
  action("uav", &action_t::uav_id);
  action("worker", &action_t::worker_id);
  action("vehicle", &action_t::vehicle_id);
  action("task", &action_t::task_id);
  action("charge", &action_t::charge_id);
  action("x", &action_t::x_m);
  Edit<schedule_t>(&findings, packets, "action gone or twice",
                   ItemGoneOrTwice(&schedule_t::actions, &schedule_t::n));
  const auto clearance = [&](const std::string& name, auto field) {
    Edit<clearances_t>(&findings, packets, "clearance " + name,
                       ItemField(&clearances_t::clearances, field));
  };
  clearance("uav", &clearance_t::uav_id);
  clearance("begin", &clearance_t::begin_us);
  Edit<clearances_t>(&findings, packets, "clearance gone or twice",
                     ItemGoneOrTwice(&clearances_t::clearances, &clearances_t::n));
  Edit<clearances_t>(&findings, packets, "clearances tick", Field(&clearances_t::tick));
  // Of an order, one digit.
  Edit<orders_t>(&findings, packets, "order", [](orders_t& orders, int i, Random* random) {
    if (orders.taken.empty()) return false;
    auto& one = orders.taken[random->Below(static_cast<std::uint32_t>(orders.taken.size()))];
    const std::size_t at = one.json.find_first_of("123456789", static_cast<std::size_t>(5 * i));
    if (at == std::string::npos) return false;
    one.json[at] = one.json[at] == '9' ? '1' : static_cast<char>(one.json[at] + 1);
    return true;
  });
  Edit<orders_t>(&findings, packets, "order gone or twice",
                 ItemGoneOrTwice(&orders_t::taken, &orders_t::n_taken));
  findings.ExpectThoseOf(MUSTER_SOURCE_DIR "/tests/tools/trials/directed_findings.txt");
}

INSTANTIATE_TEST_SUITE_P(Seeds, DirectedFindings,
                         ::testing::Range(std::uint64_t{1}, std::uint64_t{7}));

}  // namespace
}  // namespace muster::tools
