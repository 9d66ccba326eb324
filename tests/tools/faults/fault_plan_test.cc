#include "tools/faults/fault_plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/check.h"
#include "tests/error_of.h"
#include "tests/model/block.h"

namespace muster::tools {
namespace {

Scenario TwoUavs() {
  Scenario scenario;
  scenario.uavs.resize(2);
  scenario.rules.limit_us = 180 * kMinuteUs;
  return scenario;
}
const std::vector<std::string> kProcesses = {"world", "uav", "scheduler"};

std::string PlanRefusal(const std::string& faults) {
  return ErrorOf([&] {
    FaultPlan plan = ParseFaultPlan("{\"version\": 1, \"faults\": [" + faults + "]}", "plan.json");
    CheckFaultPlan(&plan, kProcesses, TwoUavs(), false);
  });
}

TEST(FaultPlan, RefusesANumberThatNoDoubleHolds) {
  EXPECT_EQ(
      PlanRefusal(R"({"kind": "loss", "target": "*", "at_min": 2e2232, "probability": 1})"),
      "plan.json: line 1, column 74: found '2e2232', expected valid JSON (number overflow parsing "
      "'2e2232')");
}

/// What is said against a mission of that scenario with that fault; "": nothing.
std::string ErrorWith(const char* flag, const Scenario& scenario) {
  try {
    FaultPlan plan = {ParseFaultFlag(flag, 0)};
    CheckFaultPlan(&plan, kProcesses, scenario, false);
  } catch (const InputError& refused) {
    return refused.what();
  }
  return "";
}

TEST(FaultPlan, MakesZonesInTheArea) {
  Scenario scenario = TwoUavs();
  EXPECT_NE(ErrorWith("zone_unknown:1/1/0.5@10", scenario).find("the key air"), std::string::npos);
  scenario.width_m = scenario.height_m = 3000;
  UseAir({}, &scenario);
  EXPECT_EQ(ErrorWith("zone_unknown:1/1/0.5@10+20", scenario), "");
  for (const char* flag : {"zone_unknown:1/1@10", "zone_unknown:1/1/0.0009@10",
                           "zone_unknown:-1/1/3@10", "zone_unknown:1/999/3@10"}) {
    EXPECT_NE(ErrorWith(flag, scenario).find("a circle of at least 0.001 km"), std::string::npos)
        << flag;
  }
  EXPECT_NE(ErrorWith("zone_unknown:1/1/0.5@10+2s", scenario).find("mission time"),
            std::string::npos);
  EXPECT_EQ(WorldOptionsOf({ParseFaultFlag("zone_unknown:1/1/0.5@10", 3)}),
            (std::vector<std::string>{
                "--closure", fmt::format("zone_unknown:1/1/0.5:600000000:{}:flag3", kNever)}));
}

TEST(FaultPlan, ClosesRoadsThatThereAre) {
  const auto error = &ErrorWith;
  Scenario block = testing::OnTheBlock();
  block.rules.limit_us = 60 * kMinuteUs;
  EXPECT_EQ(error("road_closed:0.4/0/0.1@10+20", block), "");
  for (const char* flag :
       {"road_closed:0.4/0@10", "road_closed:1.5/1.5/0.1@10", "road_closed:*@10"}) {
    EXPECT_NE(error(flag, block).find("X_KM/Y_KM/RADIUS_KM, a circle with roads"),
              std::string::npos)
        << flag;
  }
  EXPECT_NE(error("road_closed:0.4/0/0.1@10+2s", block).find("mission time"), std::string::npos);
  EXPECT_NE(error("road_closed:0.4/0/0.1@10", TwoUavs()).find("with roads"), std::string::npos);
  EXPECT_EQ(
      WorldOptionsOf({ParseFaultFlag("road_closed:0.4/0/0.1@10+20", 3)}),
      (std::vector<std::string>{"--closure", "road_closed:0.4/0/0.1:600000000:1800000000:flag3"}));
}

TEST(FaultPlan, KnowsWhatWhomWhenAndHowLong) {
  FaultPlan plan = ParseFaultPlan(R"({"version": 1, "faults": [
      {"kind": "loss", "target": "*", "at_min": 30, "for_min": 10, "probability": 0.3},
      {"kind": "partition", "target": "uav|world", "at_min": 20, "for_s": 2, "id": "cut"},
      {"kind": "delay", "target": "uav", "at_min": 0.5, "delay_ms": 20},
      {"kind": "agent_silent", "target": "uav:1", "at_min": 5, "for_min": 30}]})",
                                  "plan.json");
  CheckFaultPlan(&plan, kProcesses, TwoUavs(), false);
  ASSERT_EQ(plan.size(), 4u);
  EXPECT_EQ(plan[0].kind, FaultKind::kDelay);  // by time
  EXPECT_DOUBLE_EQ(plan[0].probability, 0.02);
  EXPECT_EQ(ToWire(plan[0]).for_us, kNever);
  EXPECT_EQ(plan[2].id, "cut");
  EXPECT_EQ(ToWire(plan[2]).for_us, 2 * kSecondUs);
  EXPECT_EQ(plan[3].id, "f0");
  EXPECT_EQ(plan[3].at_us, 30 * kMinuteUs);
  EXPECT_EQ(ToWire(plan[3]).for_us, 10 * kMinuteUs);
  EXPECT_EQ(WorldOptionsOf(plan),
            (std::vector<std::string>{"--outage", "uav:1:300000000:2100000000:f3"}));
}

TEST(FaultPlan, ARecorderThatWritesTheLogStandsForLcmLogger) {
  const std::vector<std::string> names = {"launcher", "world", "recorder"};
  const auto check = [&](const std::string& flag) {
    FaultPlan plan = {ParseFaultFlag(flag, 0)};
    CheckFaultPlan(&plan, names, TwoUavs(), false, true);
    return plan.front().target;
  };
  for (const char* flag :
       {"process_killed:lcm-logger@1", "process_killed:recorder@1", "process_stopped:recorder@1+2s",
        "disk_full:lcm-logger@1+1s", "disk_full:recorder@1+1s", "corruption:recorder@1=0.1"}) {
    EXPECT_EQ(check(flag), "recorder") << flag;
  }
  EXPECT_EQ(check("loss:launcher@1=0.5"), "launcher");
  EXPECT_THROW(check("process_killed:launcher@1"), InputError);
  EXPECT_THROW(check("corruption:launcher@1=0.1"), InputError);
  EXPECT_THROW(check("disk_full:world@1+1s"), InputError);
}

TEST(FaultPlan, BadPlansNameFileKeyValueAndWhatIsExpected) {
  EXPECT_EQ(PlanRefusal(R"({"kind": "process_killed", "target": "uav", "at_min": 1})"), "");
  EXPECT_EQ(PlanRefusal(R"({"kind": "loss", "target": "*", "at_min": 1, "probability": 2})"),
            "plan.json: faults[0]: probability: found 2, expected a number above 0 to 1");
  const std::pair<const char*, const char*> cases[] = {
      {R"({"kind": "fire", "target": "*", "at_min": 1})", "kind: found fire"},
      {R"({"kind": "loss", "target": "*", "at_min": 1})", "probability: found nothing"},
      {R"({"kind": "loss", "target": "gcs", "at_min": 1, "probability": 0.1})",
       "target: found gcs, expected * or one of world, uav, scheduler"},
      {R"({"kind": "process_killed", "target": "*", "at_min": 1})", "target: found *"},
      {R"({"kind": "process_killed", "target": "uav", "at_min": 180})", "at_min: found 180"},
      {R"({"kind": "process_killed", "target": "uav", "at_min": -1})", "at_min: found -1"},
      {R"({"kind": "process_killed", "target": "uav"})",
       "at_min: found no such key, expected a number"},
      {R"({"kind": "process_stopped", "target": "uav", "at_min": 1, "for_min": 1})",
       "for_min: found 1"},
      {R"({"kind": "partition", "target": "uav|uav", "at_min": 1, "for_s": 1})",
       "target: found uav|uav"},
      {R"({"kind": "agent_silent", "target": "uav:2", "at_min": 1, "for_min": 1})",
       "target: found uav:2"},
      {R"({"kind": "agent_fails", "target": "uav:1", "at_min": 1, "probability": 0.5})",
       "found the unknown key \"probability\", expected only kind"},
      {R"({"kind": "agent_fails", "target": "uav:1", "at_min": "1"})", "at_min: found \"1\""},
      {R"({"kind": "agent_fails", "target": "uav:1", "at_min": 1, "oops": 1})",
       "found the unknown key \"oops\", expected only kind"},
      {R"(7)", "found 7"},
  };
  for (const auto& [fault, expected] : cases) {
    const std::string error = PlanRefusal(fault);
    EXPECT_EQ(error.rfind("plan.json: faults[0]: ", 0), 0u) << fault << "\n" << error;
    EXPECT_NE(error.find(expected), std::string::npos) << fault << "\n" << error;
  }
  EXPECT_NE(PlanRefusal(R"({"kind": "process_killed", "target": "uav", "at_min": 1, "id": "a"},
                       {"kind": "process_killed", "target": "uav", "at_min": 2, "id": "a"})")
                .find("faults[1]: id: found a"),
            std::string::npos);
  for (const char* text :
       {"", "[]", "{}", R"({"version": 2, "faults": []})", R"({"version": 1, "faults": {}})",
        R"({"version": 1, "faults": [], "more": 1})"}) {
    EXPECT_THROW(ParseFaultPlan(text, "plan.json"), InputError) << text;
  }
}

TEST(FaultPlan, FlagsSayTheSame) {
  const PlannedFault loss = ParseFaultFlag("loss:*@30+10=0.3", 0);
  EXPECT_EQ(loss.kind, FaultKind::kLoss);
  EXPECT_EQ(loss.target, "*");
  EXPECT_EQ(loss.at_us, 30 * kMinuteUs);
  EXPECT_EQ(loss.for_us, 10 * kMinuteUs);
  EXPECT_DOUBLE_EQ(loss.probability, 0.3);
  const PlannedFault stop = ParseFaultFlag("process_stopped:worker-2@12.5+2s", 1);
  EXPECT_EQ(stop.target, "worker-2");
  EXPECT_EQ(stop.for_real_us, 2 * kSecondUs);
  EXPECT_EQ(ParseFaultFlag("agent_fails:uav:3@5", 0).target, "uav:3");
  for (const char* text : {"loss", "loss:*", "loss:@1=0.1", "loss:*@", "loss:*@1+=0.1",
                           "loss:*@1=0.1x", "loss:*@1", "fire:*@1", "process_killed:uav@1=0.5"}) {
    EXPECT_THROW(ParseFaultFlag(text, 0), InputError) << text;
  }
}

}  // namespace
}  // namespace muster::tools
