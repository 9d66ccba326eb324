#include "tools/graph/conflict_graph.h"
#include "tests/simulation/audited.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/order.h"
#include "model/scenario_json.h"
#include "scheduler/policies/certified/certified_policy.h"
#include "scheduler/policies/external/situation_json.h"
#include "simulation/simulator.h"
#include "tests/scheduler/reference_graph.h"
#include "tests/scheduler/situation_builder.h"
#include "tools/graph/situations.h"

namespace muster::tools {
namespace {

using scheduler::Situation;
using scheduler::testing::RandomSituation;
using scheduler::testing::SituationBuilder;

/// A situation whose charging points all have one place or no limit.
Situation SmallSituation(std::uint64_t seed) {
  Situation situation = RandomSituation(seed, {4, 4, 3, 5, 3, 12});
  auto site = std::make_shared<scheduler::Site>(*situation.site);
  for (ChargingPoint& point : site->charging_points) {
    if (point.capacity) point.capacity = 1;
  }
  situation.site = site;
  return situation;
}

TEST(ConflictGraph, MetisHasTheConflictsOfTheReference) {
  std::size_t edges = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = SmallSituation(seed);
    const ConflictGraph graph(situation);
    std::stringstream file;
    graph.WriteMetis(file, 1e6);
    std::size_t n = 0, m = 0;
    int form = 0;
    file >> n >> m >> form;
    ASSERT_EQ(form, 10);
    ASSERT_EQ(n, graph.nodes().size());
    const scheduler::Candidates candidates = scheduler::EnumerateCandidates(situation);
    std::vector<Action> actions;
    for (const scheduler::Node& node : graph.nodes()) {
      actions.push_back(candidates.ToAction(situation, node));
    }
    const scheduler::testing::ReferenceGraph reference(situation);
    std::string line;
    std::getline(file, line);
    std::size_t half_edges = 0;
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_TRUE(std::getline(file, line));
      std::istringstream words(line);
      long long weight = 0;
      words >> weight;
      ASSERT_EQ(weight, std::llround(actions[i].weight * 1e6));
      std::set<std::size_t> neighbours;
      for (std::size_t j = 0; words >> j;) neighbours.insert(j - 1);
      half_edges += neighbours.size();
      for (std::size_t j = 0; j < n; ++j) {
        ASSERT_EQ(neighbours.count(j) == 1, i != j && reference.Conflict(actions[i], actions[j]));
      }
    }
    ASSERT_EQ(half_edges, 2 * m);
    edges += m;
  }
  EXPECT_GT(edges, 1000u);
}

TEST(ConflictGraph, RefusesWhatIsNoGraph) {
  const Situation situation =
      SituationBuilder().Uav({1e3, 1e3}, 9e3).Vehicle({2e3, 1e3}).Charge({3e3, 1e3}, 2).Build();
  const ConflictGraph graph(situation);
  std::stringstream metis, mps;
  EXPECT_THROW(graph.WriteMetis(metis, 1e6), InputError);
  graph.WriteMps(mps);
  EXPECT_NE(mps.str().find(" rhs charge:0 2\n"), std::string::npos);
}

TEST(ConflictGraph, MpsHoldsEveryNodeOnce) {
  const ConflictGraph graph(SmallSituation(3));
  std::stringstream file;
  graph.WriteMps(file);
  std::size_t costs = 0, rows = 0;
  for (std::string line; std::getline(file, line);) {
    costs += line.find(" minus_weight -") != std::string::npos;
    rows += line.rfind(" L uav:", 0) == 0;
  }
  EXPECT_EQ(costs, graph.nodes().size());
  EXPECT_GT(rows, 0u);
}

TEST(ConflictGraph, JsonParses) {
  const ConflictGraph graph(SmallSituation(4));
  std::stringstream file;
  graph.WriteJson(file);
  const auto json = nlohmann::json::parse(file.str());
  ASSERT_EQ(json["nodes"].size(), graph.nodes().size());
  for (std::size_t i = 0; i < graph.nodes().size(); ++i) {
    EXPECT_EQ(json["nodes"][i]["weight"].get<double>(), graph.nodes()[i].weight);
  }
}

TEST(ConflictGraph, ChecksWhatIsChosen) {
  // uav 0: stays 0, goes to the task 1, senses with worker 0 there 2; worker 0: stays 3, goes 4.
  const Situation situation = SituationBuilder()
                                  .Uav({1e3, 1e3})
                                  .Worker({2e3, 1e3})
                                  .Task({3e3, 1e3})
                                  .Charge({3e3, 1e3}, 1)
                                  .Build();
  const ConflictGraph graph(situation);
  std::int32_t pair = -1, worker_stays = -1;
  for (std::int32_t i = 0; i < graph.n_nodes(); ++i) {
    const auto kind = graph.nodes()[static_cast<std::size_t>(i)].kind;
    if (kind == ActionKind::kSense) pair = i;
    if (kind == ActionKind::kWorkerStays) worker_stays = i;
  }
  ASSERT_GE(pair, 0);
  const std::int32_t good[] = {pair}, bad[] = {pair, worker_stays};
  EXPECT_TRUE(graph.Check(good).conflicts.empty());
  EXPECT_GT(graph.Check(good).weight, 100);
  ASSERT_EQ(graph.Check(bad).conflicts.size(), 1u);
  EXPECT_NE(graph.Check(bad).conflicts[0].find("worker:0"), std::string::npos);
}

std::vector<std::int32_t> Read(const std::string& text, const std::string& form, std::int32_t n) {
  std::istringstream in(text);
  return ReadSolution(in, "answer", form, n);
}

TEST(ReadSolution, TakesEachForm) {
  const std::vector<std::int32_t> expected = {1, 3};
  EXPECT_EQ(Read("0\n1\n0\n1\n", "indicator", 4), expected);
  EXPECT_EQ(Read("1 3\n", "nodes", 4), expected);
  EXPECT_EQ(Read("2\n4\n", "nodes-from-1", 4), expected);
  EXPECT_EQ(
      Read("Optimal - objective value -2\n  0 n1 1 -3\n  7 n3 0.99999 -1\n  8 n2 0 0\n", "mps", 4),
      expected);
}

TEST(ReadSolution, NamesWhatIsWrong) {
  for (const auto& [text, form] :
       std::vector<std::pair<std::string, std::string>>{{"0\n1\n", "indicator"},
                                                        {"0\n2\n0\n0\n", "indicator"},
                                                        {"0\n1\n0\n1\n1\n", "indicator"},
                                                        {"4\n", "nodes"},
                                                        {"-1\n", "nodes"},
                                                        {"x\n", "nodes"},
                                                        {"0\n", "nodes-from-1"},
                                                        {"5\n", "nodes-from-1"},
                                                        {"n9 1\n", "mps"},
                                                        {"n1 0.5\n", "mps"},
                                                        {"n1\n", "mps"},
                                                        {"0\n", "text"}}) {
    EXPECT_THROW(Read(text, form, 4), InputError) << form << ": " << text;
  }
}

TEST(SituationRecorder, HasTheSituationsThatTheSchedulerDecidedOn) {
  const Scenario scenario = Generate(PresetByName("DidiOrders"), 2);
  SituationRecorder recorder;
  Audited audited;
  std::vector<double> weights;
  Simulate(ScenarioToJson(scenario), "certified", [&](const Packet& packet) {
    recorder.Add(packet);
    audited.Add(packet);
    if (packet.channel == channel::kSchedule) {
      weights.push_back(Decode<schedule_t>(packet.bytes)->weight);
    }
  });
  const auto situations = recorder.Situations();
  ASSERT_EQ(situations.size(), static_cast<std::size_t>(scenario.decisions()));
  ASSERT_EQ(weights.size(), situations.size());
  for (std::size_t d = 0; d < situations.size(); ++d) {
    EXPECT_EQ(situations[d].decision, static_cast<std::int32_t>(d));
    EXPECT_EQ(scheduler::CertifiedPolicy().Decide(situations[d]).weight, weights[d]);
  }
}

TEST(SituationRecorder, HearsDecisionsBetweenIntervalsInAnyOrder) {
  Scenario scenario = Generate(PresetByName("DidiOrders"), 2);
  AddRoom({1, {1, 1, 1}}, &scenario);
  const std::string decide = R"({"at_min": 7, "order": "decide_now"})";
  world::PlannedOrder order{ParseOrder(decide, "order"), decide};
  order.order.id = "now";
  std::vector<Packet> packets;
  Simulate(ScenarioToJson(scenario), "horizon",
           [&](const Packet& packet) { packets.push_back(packet); }, {}, {order});
  const auto told = [&] {
    SituationRecorder recorder;
    for (const Packet& packet : packets) recorder.Add(packet);
    std::vector<std::string> all;
    for (const Situation& situation : recorder.Situations()) {
      all.push_back(scheduler::ToJson(situation).dump());
    }
    return all;
  };
  const std::vector<std::string> as_logged = told();
  EXPECT_EQ(as_logged.size(), static_cast<std::size_t>(scenario.decisions()) + 1);
  std::reverse(packets.begin(), packets.end());
  EXPECT_EQ(told(), as_logged);
}

}  // namespace
}  // namespace muster::tools
