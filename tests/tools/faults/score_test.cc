// A simulated mission whose log is told of faults: what the scorer makes of it.
#include "tools/faults/score.h"

#include <gtest/gtest.h>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tools/record/digest.h"

namespace muster::tools {
namespace {

class ScoreTest : public ::testing::Test {
 protected:
  ScoreTest() {
    Simulate(json_, "mpq", [&](const Packet& packet) { evidence_.Add(packet); });
    evidence_.undisturbed_digest = Digest(evidence_.record);
  }
  void Say(int kind, TimeUs at_us, TimeUs said_us, const std::string& fault,
           const std::string& detail, std::array<int, 4> ids = {-1, -1, -1, -1}) {
    event_t event{};
    event.header.run_id = 1;
    event.header.sender = "test";
    event.header.seq = seq_++;
    event.header.sim_us = said_us;
    event.kind = static_cast<std::int8_t>(kind);
    event.at_us = at_us;
    event.fault_id = fault;
    event.detail = detail;
    event.uav_id = ids[0];
    event.worker_id = ids[1];
    event.vehicle_id = ids[2];
    event.task_id = ids[3];
    event.charge_id = -1;
    evidence_.Add({std::string(channel::kEvent), Encode(event)});
  }
  std::string Observed(const FaultPlan& plan, std::size_t line, bool met) {
    const std::vector<FaultScore> scores = ScoreFaults(plan, evidence_);
    if (line >= scores.size()) return "no such line";
    EXPECT_EQ(scores[line].met, met) << ToTable(scores);
    return scores[line].observed;
  }
  static FaultPlan Plan(const std::string& fault) {
    return ParseFaultPlan("{\"version\": 1, \"faults\": [" + fault + "]}", "plan.json");
  }
  /// The first task done by a pair: its event.
  const event_t& FirstDone() const {
    for (const event_t& event : evidence_.record.events()) {
      if (event.kind == 5) return event;
    }
    ADD_FAILURE() << "no task was done";
    return evidence_.record.events().front();
  }

  std::string json_ = ScenarioToJson(Generate(PresetByName("Random_10"), 5));
  FaultEvidence evidence_;
  std::int64_t seq_ = 0;
};

TEST_F(ScoreTest, AFaultThatNobodySawIsMissed) {
  const FaultPlan plan = Plan(R"({"kind": "loss", "target": "*", "at_min": 5, "probability": 0.1,
                                  "expect": {"same_decisions": true, "completion_rate": 0.999}})");
  EXPECT_EQ(Observed(plan, 0, false), "none");
  EXPECT_EQ(Observed(plan, 1, false).substr(0, 2), "0.");
  EXPECT_EQ(Observed(plan, 2, true), "as undisturbed");
  Say(13, 5 * kMinuteUs, 5 * kMinuteUs, "f0", "uav");
  EXPECT_EQ(Observed(plan, 0, false), "none") << "applied, but it hit nothing";
  Say(14, 9 * kMinuteUs, 9 * kMinuteUs, "f0", "uav: 5 packets");
  Say(14, 9 * kMinuteUs, 9 * kMinuteUs, "f0", "world: 2 packets");
  EXPECT_EQ(Observed(plan, 0, true), "7 packets");
  evidence_.undisturbed_digest = "another";
  EXPECT_EQ(Observed(plan, 2, false), "others");
}

TEST_F(ScoreTest, DetectionCountsTicksUntilSomebodySaysSo) {
  const FaultPlan plan = Plan(R"({"kind": "process_killed", "target": "uav", "at_min": 10,
                                  "expect": {"detected_within_ticks": 2}})");
  EXPECT_EQ(Observed(plan, 1, false), "never");
  Say(11, 10 * kMinuteUs, 12 * kMinuteUs, "", "uav was killed");
  EXPECT_EQ(Observed(plan, 1, false), "4 ticks") << "of 30 s";
  Say(11, 10 * kMinuteUs, 10 * kMinuteUs + 45 * kSecondUs, "", "uav");
  EXPECT_EQ(Observed(plan, 1, true), "2 ticks");
}

TEST_F(ScoreTest, ExpectationsWithNothingToShowThemOnAreMissed) {
  const FaultPlan plan = Plan(R"({"kind": "agent_fails", "target": "uav:0", "at_min": 10, "expect":
      {"partner_released_within_decisions": 1, "tasks_finished_by_min": 100}})");
  Say(2, 10 * kMinuteUs, 10 * kMinuteUs, "", "f0", {0, -1, -1, -1});
  EXPECT_EQ(Observed(plan, 1, false), "there was no partner");
  EXPECT_EQ(Observed(plan, 2, false), "none was interrupted");
}

TEST_F(ScoreTest, FindsThePartnerInASchedulesAndTheTaskDone) {
  const event_t done = FirstDone();
  const TimeUs at = done.at_us - 5 * kMinuteUs;
  const std::string head =
      R"({"kind": "agent_fails", "target": "uav:19", "at_min": 1, "expect": {)";
  // As if another UAV had tried the same task with this worker before.
  Say(13, at, at, "f0", "world");
  Say(2, at, at, "", "f0", {19, -1, -1, -1});
  Say(6, at, at, "", "under way", {19, done.worker_id, -1, done.task_id});
  const FaultPlan by = Plan(
      head + "\"tasks_finished_by_min\": " + std::to_string(ToMinutes(done.at_us) + 0.1) + "}}");
  EXPECT_NE(Observed(by, 1, true).find(" min"), std::string::npos);
  const FaultPlan earlier = Plan(
      head + "\"tasks_finished_by_min\": " + std::to_string(ToMinutes(done.at_us) - 0.1) + "}}");
  Observed(earlier, 1, false);
  const FaultPlan released = Plan(head + "\"partner_released_within_decisions\": 18}}");
  EXPECT_NE(Observed(released, 1, true).find("decisions"), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
