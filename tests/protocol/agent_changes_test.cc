#include "protocol/agent_changes.h"

#include <gtest/gtest.h>

#include "base/random.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "protocol/report_reader.h"

namespace muster {
namespace {

/// One UAV, worker and vehicle that do what a decision at time 0 commands, and their reports.
class AgentChangesTest : public ::testing::Test {
 protected:
  AgentChangesTest() : AgentChangesTest(MakeScenario()) {}
  explicit AgentChangesTest(Scenario scenario)
      : scenario_(std::make_shared<const Scenario>(std::move(scenario))) {}

  static Scenario MakeScenario() {
    Scenario scenario = Generate(PresetByName("Random_10"), 5);
    scenario.disturbances.wind = {0.1, 0.4};
    return scenario;
  }
  TimeUs TimeOf(std::int64_t tick) const { return scenario_->rules.TimeOf(tick); }
  std::vector<AgentState> StartAll(AgentKind kind) const {
    std::vector<AgentState> agents;
    for (const AgentSpec& spec : scenario_->agents(kind)) {
      agents.push_back(
          StartOf(kind, static_cast<std::int32_t>(agents.size()), spec, StraightWays()));
    }
    return agents;
  }
  std::vector<agent_t> WiresOf(const std::vector<AgentState>& agents, std::int64_t tick) const {
    std::vector<agent_t> wires;
    for (const AgentState& agent : agents) {
      wires.push_back(ToWire(agent, TimeOf(tick), scenario_->tasks));
    }
    return wires;
  }
  agent_states_t Whole(AgentKind kind, std::int64_t tick, std::vector<agent_t> wires) {
    agent_states_t states{};
    states.header = Header(tick);
    states.kind = NumberOf(kind);
    states.tick = tick;
    states.applied_decision = 0;
    states.n = static_cast<std::int32_t>(wires.size());
    states.agents = std::move(wires);
    return states;
  }
  header_t Header(std::int64_t tick) {
    header_t header{};
    header.sender = "uav";
    header.seq = seq_++;
    header.sim_us = TimeOf(tick);
    return header;
  }
  agent_changes_t OneMessage(ToldAgents* sender, std::int64_t tick,
                             const std::vector<agent_t>& wires) {
    std::vector<agent_changes_t> messages = sender->ChangesSince(tick, 0, wires);
    EXPECT_EQ(messages.size(), 1U);
    messages[0].header = Header(tick);
    EXPECT_TRUE(Valid(messages[0]));
    return messages[0];
  }
  static std::vector<std::uint8_t> Bytes(const std::vector<agent_t>& agents) {
    agent_states_t states{};
    states.header.sender = "x";
    states.agents = agents;
    states.n = static_cast<std::int32_t>(agents.size());
    return Encode(states);
  }

  std::shared_ptr<const Scenario> scenario_;
  std::int64_t seq_ = 0;
};

TEST_F(AgentChangesTest, WhoMovesAndSensesIsListedOnlyWhenSomethingHappensToIt) {
  std::vector<AgentState> uavs = StartAll(AgentKind::kUav), workers = StartAll(AgentKind::kWorker);
  AgentState &uav = uavs[3], &worker = workers[4];
  uav.online_from_us = worker.online_from_us = 0;
  uav.online_until_us = worker.online_until_us = kNever;
  Action sense;
  sense.kind = ActionKind::kSense;
  sense.uav = UavId(3);
  sense.worker = WorkerId(4);
  sense.task = TaskId(0);
  sense.to = scenario_->tasks[0].at;
  for (AgentState* agent : {&uav, &worker}) {
    Begin(agent, sense, 0, 0, scenario_->disturbances, scenario_->seed);
  }
  const Activity activity = PlanActivity(uav, worker, scenario_->tasks);
  const Verdict verdict({activity}, {});
  for (const AgentKind kind : {AgentKind::kUav, AgentKind::kWorker}) {
    std::vector<AgentState> agents = kind == AgentKind::kUav ? uavs : workers;
    AgentState& one = agents[kind == AgentKind::kUav ? 3 : 4];
    ToldAgents sender(scenario_, kind), receiver(scenario_, kind);
    const agent_states_t first = Whole(kind, 0, WiresOf(agents, 0));
    sender.Take(first);
    receiver.Take(first);
    std::vector<std::int64_t> listed;
    for (std::int64_t tick = 1; tick <= scenario_->rules.last_tick(); ++tick) {
      if (scenario_->rules.DecisionAt(tick) >= 0) {
        const agent_states_t whole = Whole(kind, tick, WiresOf(agents, tick));
        sender.Take(whole);
        receiver.Take(whole);
        continue;
      }
      if (tick >= 2) Settle(&one, verdict, TimeOf(tick), scenario_->tasks);
      const std::vector<agent_t> wires = WiresOf(agents, tick);
      const agent_changes_t changes = OneMessage(&sender, tick, wires);
      for (const agent_t& wire : changes.agents) {
        if (wire.id == one.id) listed.push_back(tick);
      }
      const auto states = receiver.Expand(changes);
      ASSERT_TRUE(states) << tick;
      ASSERT_EQ(Bytes(states->agents), Bytes(wires)) << tick;
    }
    // Its end becomes known, and it is over; wherever no decision told it whole.
    const std::int64_t end = activity.end_us / scenario_->rules.tick_us + 1;
    ASSERT_GE(listed.size(), 1U);
    EXPECT_EQ(listed.front(), 2);
    for (const std::int64_t tick : listed) EXPECT_TRUE(tick == 2 || tick == end) << tick;
  }
}

TEST_F(AgentChangesTest, WhateverHappensIsTold) {
  Random random(7, Stream::kTest);
  for (const AgentKind kind : kAgentKinds) {
    std::vector<AgentState> agents = StartAll(kind);
    ToldAgents sender(scenario_, kind), receiver(scenario_, kind);
    std::int64_t listed = 0, told = 0;
    const agent_states_t first = Whole(kind, 0, WiresOf(agents, 0));
    sender.Take(first);
    receiver.Take(first);
    for (std::int64_t tick = 1; tick < scenario_->rules.last_tick(); ++tick) {
      const TimeUs t = TimeOf(tick);
      for (AgentState& agent : agents) {
        if (random.Below(20) > 0) continue;
        // On its way to a task or nowhere, waiting, failed: any of it from this time on.
        agent.from = agent.to = PositionAt(agent, t);
        agent.range_at_departure_m = RangeAt(agent, t, scenario_->tasks);
        agent.depart_us = agent.arrive_us = agent.busy_until_us = t;
        agent.action = ActionKind::kNone;
        agent.target = agent.partner = -1;
        agent.failed = random.Below(5) == 0;
        if (agent.failed || random.Below(2) == 0 || kind == AgentKind::kVehicle) continue;
        agent.action = random.Below(3) == 0      ? ActionKind::kGoTo
                       : kind == AgentKind::kUav ? ActionKind::kUavToTask
                                                 : ActionKind::kWorkerToTask;
        agent.decision = static_cast<std::int32_t>(random.Below(9));
        agent.target = agent.action == ActionKind::kGoTo ? -1 : 1;
        agent.to = agent.target < 0 ? Point{random.Uniform(0, 1e4), random.Uniform(0, 1e4)}
                                    : scenario_->tasks[1].at;
        agent.arrive_us = agent.busy_until_us = t + 100 * kSecondUs;
        if (kind == AgentKind::kUav) {
          agent.range_per_m = RangePerMetre(UavId(agent.id), agent.decision,
                                            scenario_->disturbances, scenario_->seed);
        }
      }
      const std::vector<agent_t> wires = WiresOf(agents, tick);
      if (scenario_->rules.DecisionAt(tick) >= 0) {
        const agent_states_t whole = Whole(kind, tick, wires);
        sender.Take(whole);
        receiver.Take(whole);
        continue;
      }
      const agent_changes_t changes = OneMessage(&sender, tick, wires);
      listed += changes.n;
      told += static_cast<std::int64_t>(wires.size());
      const auto states = receiver.Expand(changes);
      ASSERT_TRUE(states) << tick;
      ASSERT_EQ(Bytes(states->agents), Bytes(wires)) << tick;
    }
    EXPECT_LT(listed * 3, told) << ToString(kind);
  }
}

TEST_F(AgentChangesTest, WithoutItsBaseNothingIsTakenIn) {
  const std::vector<AgentState> agents = StartAll(AgentKind::kUav);
  ToldAgents sender(scenario_, AgentKind::kUav), receiver(scenario_, AgentKind::kUav);
  sender.Take(Whole(AgentKind::kUav, 0, WiresOf(agents, 0)));
  const agent_changes_t one = OneMessage(&sender, 1, WiresOf(agents, 1));
  const agent_changes_t two = OneMessage(&sender, 2, WiresOf(agents, 2));
  EXPECT_FALSE(receiver.Expand(one)) << "nobody is known";
  receiver.Take(Whole(AgentKind::kUav, 0, WiresOf(agents, 0)));
  EXPECT_FALSE(receiver.Expand(two)) << "tick 1 lacks";
  EXPECT_TRUE(receiver.Possible(two));
  EXPECT_TRUE(receiver.Expand(one));
  EXPECT_TRUE(receiver.Expand(one)) << "hearing it twice does no harm";
  EXPECT_TRUE(receiver.Expand(two));
  EXPECT_FALSE(receiver.Expand(one)) << "it is over";
  receiver.Take(Whole(AgentKind::kUav, 0, WiresOf(agents, 0)));
  EXPECT_TRUE(receiver.Expand(two)) << "what is older changes nothing";
}

TEST_F(AgentChangesTest, WhatCannotBeIsRefused) {
  const std::vector<AgentState> agents = StartAll(AgentKind::kUav);
  ToldAgents sender(scenario_, AgentKind::kUav), receiver(scenario_, AgentKind::kUav);
  const agent_states_t first = Whole(AgentKind::kUav, 0, WiresOf(agents, 0));
  sender.Take(first);
  receiver.Take(first);
  std::vector<agent_t> wires = WiresOf(agents, 1);
  wires[2].decision = 0;
  const agent_changes_t good = OneMessage(&sender, 1, wires);
  ASSERT_EQ(good.n, 1);
  const auto refuse = [&](const char* what, const std::function<void(agent_changes_t*)>& change) {
    agent_changes_t bad = good;
    change(&bad);
    EXPECT_FALSE(receiver.Possible(bad)) << what;
    EXPECT_FALSE(receiver.Expand(bad)) << what;
  };
  refuse("another class", [](agent_changes_t* m) { m->kind = 1; });
  refuse("a decision's tick", [&](agent_changes_t* m) {
    m->tick = scenario_->rules.interval_us / scenario_->rules.tick_us;
    m->header.sim_us = scenario_->rules.interval_us;
  });
  refuse("after the last tick", [](agent_changes_t* m) { m->tick = 1'000'000; });
  refuse("another time", [](agent_changes_t* m) { ++m->header.sim_us; });
  refuse("agents that are not", [](agent_changes_t* m) { m->last_id = 1000; });
  refuse("an impossible state", [](agent_changes_t* m) { m->agents[0].speed_m_s = 0; });
  EXPECT_TRUE(receiver.Expand(good)) << "nothing of it was taken in";
}

TEST_F(AgentChangesTest, ManyChangesAreSplit) {
  Scenario large = MakeScenario();
  while (large.workers.size() < 700) large.workers.push_back(large.workers[0]);
  scenario_ = std::make_shared<const Scenario>(std::move(large));
  const std::vector<AgentState> agents = StartAll(AgentKind::kWorker);
  ToldAgents sender(scenario_, AgentKind::kWorker), receiver(scenario_, AgentKind::kWorker);
  const agent_states_t first = Whole(AgentKind::kWorker, 0, WiresOf(agents, 0));
  sender.Take(first);
  receiver.Take(first);
  std::vector<agent_t> wires = WiresOf(agents, 1);
  for (std::size_t i = 50; i < 650; ++i) wires[i].decision = 0;
  std::vector<agent_changes_t> messages = sender.ChangesSince(1, 0, wires);
  ASSERT_EQ(messages.size(), 3U);
  std::vector<agent_t> all;
  for (agent_changes_t& changes : messages) {
    changes.header = Header(1);
    EXPECT_TRUE(Valid(changes));
    EXPECT_LT(Encode(changes).size(), 65'000U);
    const auto states = receiver.Expand(changes);
    ASSERT_TRUE(states);
    all.insert(all.end(), states->agents.begin(), states->agents.end());
  }
  EXPECT_EQ(Bytes(all), Bytes(wires));
}

/// What a reader tells of UAVs by tick, whatever the order in which it hears it.
class ReportReaderTest : public AgentChangesTest {
 protected:
  ReportReaderTest() : reader_(scenario_), sender_(scenario_, AgentKind::kUav) {
    const std::vector<AgentState> agents = StartAll(AgentKind::kUav);
    for (std::int64_t tick = 0; tick <= 100; ++tick) {
      if (tick == 0 || scenario_->rules.DecisionAt(tick) >= 0) {
        const agent_states_t whole = Whole(AgentKind::kUav, tick, WiresOf(agents, tick));
        sender_.Take(whole);
        messages_.push_back(whole);
      } else {
        messages_.push_back(OneMessage(&sender_, tick, WiresOf(agents, tick)));
      }
    }
  }
  void Hear(std::int64_t seq) {
    seqs_.Add(seq);
    reader_.Add(messages_[static_cast<std::size_t>(seq)], Packet{}, seqs_,
                [&](const agent_states_t& states, const Packet&) { ticks_.insert(states.tick); });
  }

  ReportReader reader_;
  ToldAgents sender_;
  std::vector<Message> messages_;  ///< one a tick
  IntervalSet seqs_;
  std::set<std::int64_t> ticks_;
};

TEST_F(ReportReaderTest, OrderDoesNotMatter) {
  Random random(3, Stream::kTest);
  std::vector<std::int64_t> order;
  for (std::int64_t seq = 0; seq <= 100; ++seq) order.push_back(seq);
  for (std::size_t i = 0; i + 10 < order.size(); i += 10) {
    for (std::size_t k = 9; k > 0; --k) {
      std::swap(order[i + k], order[i + random.Below(static_cast<std::uint32_t>(k + 1))]);
    }
  }
  for (const std::int64_t seq : order) Hear(seq);
  EXPECT_EQ(ticks_.size(), 101U);
}

TEST_F(ReportReaderTest, ALogThatBeginsLateIsReadFromTheNextWholeStatesOn) {
  for (std::int64_t seq = 5; seq <= 100; ++seq) Hear(seq);
  EXPECT_EQ(*ticks_.begin(), 20);
  EXPECT_EQ(ticks_.size(), 81U);
}

TEST_F(ReportReaderTest, WhatNeverComesIsNotWaitedForForEver) {
  for (std::int64_t seq = 0; seq <= 100; ++seq) {
    if (seq != 10) Hear(seq);
  }
  // 10 to 19 rest on what lacks.
  EXPECT_EQ(ticks_.size(), 101U - 10U);
}

}  // namespace
}  // namespace muster
