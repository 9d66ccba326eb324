// Missions that take orders while they run: audited, decided again, and the same whatever befalls
// the processes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "base/random.h"
#include "base/sha256.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/simulation/audited.h"
#include "tests/simulation/order_draws.h"
#include "tools/explain/decision_log.h"
#include "tools/explain/redecide.h"
#include "tools/faults/fault_plan.h"
#include "tools/faults/random_plan.h"
#include "tools/record/digest.h"
#include "tools/record/run_record.h"
#include "tools/simulate/virtual_mission.h"

namespace muster::tools {
namespace {

struct OrdersOutcome {
  std::string digest;
  int taken = 0, refused = 0, cancelled = 0, joined = 0, left = 0;
};

/// Plays it in one process; audits it and makes its decisions again.
OrdersOutcome Play(std::uint64_t seed, const Scenario& scenario,
                   const std::vector<world::PlannedOrder>& orders) {
  RunRecord record;
  Packets packets;
  OrdersOutcome outcome;
  {
    Audited audited;
    Simulate(
        ScenarioToJson(scenario), PolicyOf(seed),
        [&](const Packet& packet) {
          record.Add(packet);
          audited.Add(packet);
          packets.all.push_back(packet);
        },
        {}, orders);
  }
  EXPECT_TRUE(record.CheckComplete().complete);
  for (const event_t& event : record.events()) {
    outcome.cancelled += event.kind == EventKind::kTaskCancelled;
    outcome.joined += event.kind == EventKind::kAgentJoined;
    outcome.left += event.kind == EventKind::kAgentLeaves;
  }
  for (const auto& [tick, said] : record.reader().orders().said()) {
    outcome.taken += said.n_taken;
    outcome.refused += said.n_refused;
  }
  const DecisionLog log = ReadDecisionLog(&packets);
  const std::vector<Redecided> again = Redecide(log, "", {});
  EXPECT_EQ(again.size(), 10u);
  for (const Redecided& decision : again) {
    EXPECT_EQ(decision.missing, "");
    EXPECT_EQ(FirstDifference(decision.again, decision.logged.front()), "");
  }
  outcome.digest = Digest(record);
  return outcome;
}

int Missions(int usual) {
  const char* const given = std::getenv("MUSTER_ORDER_MISSIONS");
  return given == nullptr ? usual : std::atoi(given);
}

TEST(OrdersMission, IsAuditedAndDecidedAgain) {
  OrdersOutcome all;
  const auto n = static_cast<std::uint64_t>(Missions(40));
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scenario scenario = Draw(seed);
    const OrdersOutcome one = Play(seed, scenario, DrawOrders(seed));
    all.taken += one.taken;
    all.refused += one.refused;
    all.cancelled += one.cancelled;
    all.joined += one.joined;
    all.left += one.left;
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_GT(all.taken, 10 * static_cast<int>(n));
  EXPECT_GT(all.refused, static_cast<int>(n));
  EXPECT_GT(all.cancelled, 0);
  EXPECT_GT(all.joined, 0);
  EXPECT_GT(all.left, 0);
}

TEST(OrdersMission, DecidesBetweenIntervalsWhenItIsAskedTo) {
  Scenario scenario = Draw(2);
  scenario.rules.emergencies_at_once = true;
  std::vector<world::PlannedOrder> orders;
  for (const char* json :
       {R"({"at_min": 7, "order": "decide_now"})", R"({"at_min": 10, "order": "decide_now"})",
        R"({"at_min": 12, "order": "task_add", "task": {"x_km": 3, "y_km": 3, "priority": 3}})"}) {
    orders.push_back({ParseOrder(json, "order"), json});
    orders.back().order.id = fmt::format("o{}", orders.size());
  }
  const auto play = [&](const FaultPlan& faults) {
    RunRecord record;
    Packets packets;
    Audited audited;
    VirtualMission mission{scenario, "horizon"};
    mission.orders = orders;
    mission.faults = faults;
    mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t) {
      record.Add(*event.packet);
      audited.Add(*event.packet);
      packets.all.push_back(*event.packet);
    };
    RunVirtualMission(mission);
    EXPECT_TRUE(record.CheckComplete().complete);
    std::vector<double> at_min;
    for (const auto& [decision, schedule] : record.schedules()) {
      EXPECT_EQ(schedule.header.sim_us, record.scenario()->rules.TimeOfDecision(decision));
      at_min.push_back(ToMinutes(schedule.header.sim_us));
    }
    const DecisionLog log = ReadDecisionLog(&packets);
    const std::vector<Redecided> again = Redecide(log, "", {});
    EXPECT_EQ(again.size(), at_min.size());
    for (const Redecided& decision : again) {
      EXPECT_EQ(decision.missing, "");
      EXPECT_EQ(FirstDifference(decision.again, decision.logged.front()), "");
    }
    // Every 10 minutes, and twice more.
    EXPECT_EQ(at_min.size(), static_cast<std::size_t>(Draw(2).decisions()) + 2);
    EXPECT_TRUE(std::count(at_min.begin(), at_min.end(), 7) == 1 &&
                std::count(at_min.begin(), at_min.end(), 12) == 1);
    return Digest(record);
  };
  const std::string undisturbed = play({});
  for (const char* process : {"world", "scheduler", "worker"}) {
    FaultPlan faults;
    for (const double at_min : {6.9, 7.0, 7.5, 12.0}) {
      PlannedFault fault;
      fault.kind = FaultKind::kProcessKilled;
      fault.target = process;
      fault.at_us = ToUs(60 * at_min);
      fault.id = fmt::format("{}-{}", process, at_min);
      faults.push_back(fault);
    }
    EXPECT_EQ(play(faults), undisturbed) << process;
  }
}

/// What the audit finds first when the log of a mission that adds, cancels and leaves is changed.
std::string FirstFinding(const std::function<void(orders_t*)>& change) {
  const Scenario scenario = Draw(2);
  std::vector<world::PlannedOrder> orders;
  for (const char* json : {R"({"at_min": 5, "order": "task_add", "task": {"x_km": 3, "y_km": 3}})",
                           R"({"at_min": 5, "order": "task_cancel", "task": 2})",
                           R"({"at_min": 8, "order": "agent_leave", "agent": "worker:1"})",
                           R"({"at_min": 6, "order": "withdraw", "withdraws": "o5"})",
                           R"({"at_min": 7, "order": "task_hold", "task": 4})"}) {
    orders.push_back({ParseOrder(json, "order"), json});
    orders.back().order.id = fmt::format("o{}", orders.size());
  }
  audit::Auditor auditor;
  Simulate(
      ScenarioToJson(scenario), "mpq",
      [&](const Packet& packet) {
        auto said = packet.channel == channel::kOrders ? DecodeValid<orders_t>(packet.bytes)
                                                       : std::optional<orders_t>();
        if (said) change(&*said);
        auditor.Add(said ? Packet{packet.channel, Encode(*said)} : packet);
      },
      {}, orders);
  const auto findings = auditor.Finish();
  return findings.empty() ? "" : findings.front().invariant + ": " + findings.front().text;
}

TEST(OrdersMission, TheAuditSeesAnEmergencyThatWaits) {
  Scenario scenario = Draw(2);
  scenario.tasks[3].priority = Priority::kEmergency;
  scenario.tasks[3].reported_us = 7 * kMinuteUs;
  audit::Auditor auditor;
  Simulate(ScenarioToJson(scenario), "mpq", [&](const Packet& packet) {
    auto said = packet.channel == channel::kScenario ? DecodeValid<scenario_t>(packet.bytes)
                                                     : std::optional<scenario_t>();
    if (!said) return auditor.Add(packet);
    // The log says that the mission was to decide at once.
    Scenario other = scenario;
    other.rules.emergencies_at_once = true;
    said->json = ScenarioToJson(other);
    said->sha256 = Sha256(said->json);
    auditor.Add({packet.channel, Encode(*said)});
  });
  const auto findings = auditor.Finish();
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().invariant, "orders");
  EXPECT_EQ(findings.front().text, "task 3, an emergency, opens without a decision");
  EXPECT_EQ(findings.front().at_us, 7 * kMinuteUs);
}

TEST(OrdersMission, TheAuditSeesWhatWasNotTaken) {
  EXPECT_EQ(FirstFinding([](orders_t*) {}), "");
  const auto at_5 = [](const std::function<void(orders_t*)>& change) {
    return FirstFinding([&](orders_t* said) {
      if (said->tick == 10) change(said);
    });
  };
  EXPECT_EQ(at_5([](orders_t* said) { said->taken[0].task_id = 16; }),
            "orders: order o1: adds task 16, the next is 15");
  EXPECT_EQ(at_5([](orders_t* said) { said->before = 1; }),
            "orders: 1 orders are said to have come before, 0 have");
  EXPECT_EQ(at_5([](orders_t* said) { said->taken[1].id = "o1"; }),
            "orders: order o1: was answered before");
  EXPECT_EQ(at_5([](orders_t* said) { said->taken[1].task_id = 40; }),
            "orders: order o2: there is no task 40");
  EXPECT_EQ(at_5([](orders_t* said) { said->taken[1].json = "{}"; }).substr(0, 33),
            "orders: order o2: cannot be read:");
  EXPECT_EQ(at_5([](orders_t* said) { said->taken[1].task_id = 3; }),
            "task-status: task:2 is said to be cancelled, it is open");
  EXPECT_EQ(at_5([](orders_t* said) {
              said->taken.pop_back();
              said->n_taken = 1;
            }),
            "task-status: task:2 is said to be cancelled, it is open");
  EXPECT_EQ(FirstFinding([](orders_t* said) {
              if (said->tick == 12)
                said->taken[0].json = R"({"order":"withdraw","withdraws":"o1"})";
            }),
            "orders: order o4: withdraws o1, which was answered before");
  EXPECT_EQ(FirstFinding([](orders_t* said) {
              if (said->tick != 14) return;
              said->refused.clear();
              said->n_refused = 0;
              said->taken.push_back({"o5", "", R"({"order":"task_hold","task":4})", 4, 0, -1});
              said->n_taken = 1;
            }),
            "orders: order o5: was withdrawn and is taken");
}

/// Processes die, stand still, and lose packets: what was taken when does not change.
TEST(OrdersMission, IsTheSameUnderFaults) {
  const auto n = static_cast<std::uint64_t>(Missions(40)) / 2;
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    VirtualMission mission;
    mission.scenario = Draw(seed);
    mission.policy = PolicyOf(seed);
    mission.orders = DrawOrders(seed);
    mission.fault_seed = seed;
    mission.drop = seed % 3 == 0 ? 0.1 : 0;
    mission.faults = DrawFaults(seed);
    Audited audited;
    mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t) {
      audited.Add(*event.packet);
    };
    const MissionResult result = RunVirtualMission(mission);
    EXPECT_EQ(result.end, MissionEnd::kComplete);
    EXPECT_TRUE(result.record.CheckComplete().complete);
    EXPECT_EQ(Digest(result.record), UndisturbedDigest(mission));
    if (::testing::Test::HasFailure()) return;
  }
}

}  // namespace
}  // namespace muster::tools
