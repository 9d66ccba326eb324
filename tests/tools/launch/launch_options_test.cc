#include "tools/launch/launch_options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "base/check.h"
#include "scheduler/policies/registry.h"
#include "tests/error_of.h"
#include "tests/temporary_folder.h"

namespace muster::tools {
namespace {

LaunchOptions Parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "muster run");
  return ParseLaunchOptions(static_cast<int>(arguments.size()), arguments.data()).value();
}

std::string RefusalOf(const std::vector<const char*>& arguments) {
  return ErrorOf([&] { Parse(arguments); });
}

Scenario ScenarioWith(std::size_t uavs, std::size_t workers, std::size_t vehicles) {
  Scenario scenario;
  scenario.uavs.resize(uavs);
  scenario.workers.resize(workers);
  scenario.vehicles.resize(vehicles);
  return scenario;
}

std::string ValueOf(const ProcessPlan& plan, const std::string& flag) {
  const auto at = std::find(plan.arguments.begin(), plan.arguments.end(), flag);
  return at == plan.arguments.end() ? "" : *(at + 1);
}

TEST(LaunchOptions, WhatIsExpectedIsPartOfThePolicysName) {
  EXPECT_EQ(Parse({"s.json", "--expect-arrivals", "12"}).policy, "rollout-steps:expect=12");
  EXPECT_EQ(Parse({"s.json", "--policy", "rollout", "--expect-arrivals", "0.5"}).policy,
            "rollout:expect=0.5");
  EXPECT_EQ(Parse({"s.json", "--expect-arrivals", "0"}).policy, "rollout-steps");
  EXPECT_EQ(Parse({"s.json", "--effort", "20", "--know-shifts"}).policy,
            "rollout-steps:shifts=1:effort=20");
  EXPECT_EQ(Parse({"s.json", "--effort", "1"}).policy, "rollout-steps") << "as without";
  EXPECT_NE(RefusalOf({"s.json", "--effort", "0"}).find("--effort"), std::string::npos);
  EXPECT_NE(RefusalOf({"s.json", "--policy", "mpq", "--know-shifts"}).find("--know-shifts"),
            std::string::npos);
  for (const char* bad : {"-1", "x", "nan", "100001"}) {
    EXPECT_NE(RefusalOf({"s.json", "--expect-arrivals", bad}).find("--expect-arrivals"),
              std::string::npos)
        << bad;
  }
  for (const char* policy : {"mpq", "external:true", "learned:models/x"}) {
    EXPECT_NE(RefusalOf({"s.json", "--policy", policy, "--expect-arrivals", "3"})
                  .find(std::string("found policy ") + policy),
              std::string::npos);
  }
  EXPECT_NE(RefusalOf({"s.json", "--policy", "rollout:expect=3", "--expect-arrivals", "3"})
                .find("--expect-arrivals"),
            std::string::npos);
}

TEST(LaunchOptions, ReachAndLossArePartOfThePolicysName) {
  EXPECT_EQ(Parse({"s.json", "--policy", "neighbours", "--reach", "2.5"}).policy,
            "neighbours:reach=2.5");
  EXPECT_EQ(
      Parse({"s.json", "--policy", "neighbours", "--radio-loss", "0.2", "--reach", "3"}).policy,
      "neighbours:reach=3:loss=0.2");
  for (const char* bad : {"-1", "1001", "x", "nan"}) {
    EXPECT_NE(RefusalOf({"s.json", "--policy", "neighbours", "--reach", bad}).find("--reach"),
              std::string::npos)
        << bad;
  }
  EXPECT_NE(RefusalOf({"s.json", "--reach", "3"}).find("--reach: found policy rollout-steps"),
            std::string::npos);
}

TEST(LaunchOptions, DefaultsLeaveTheScenarioAsItIs) {
  const LaunchOptions options = Parse({"a.json"});
  EXPECT_EQ(options.scenario_file, "a.json");
  EXPECT_EQ(options.policy, scheduler::kDefaultPolicy);
  EXPECT_EQ(options.rate, "max");
  EXPECT_FALSE(options.interval_min || options.limit_min || options.seed || options.availability);
  EXPECT_EQ(options.processes.at(AgentKind::kUav), 1);
}

TEST(LaunchOptions, OneOfTwoWritesTheLog) {
  EXPECT_EQ(Parse({"a.json"}).logger, Logger::kMuster);
  EXPECT_EQ(Parse({"a.json", "--logger", "lcm"}).logger, Logger::kLcm);
  EXPECT_EQ(Parse({"a.json", "--logger", "muster"}).logger, Logger::kMuster);
  EXPECT_EQ(RefusalOf({"a.json", "--logger", "tape"}),
            "command line: --logger: found 'tape', expected lcm or muster");
}

TEST(LaunchOptions, WithoutALogNobodyWaitsForOne) {
  LaunchOptions options = Parse({"a.json"});
  Scenario scenario;
  scenario.uavs.resize(1), scenario.workers.resize(1), scenario.vehicles.resize(1);
  const auto joined = [&] {
    std::string all;
    for (const ProcessPlan& plan : PlanProcesses(options, scenario, {})) {
      EXPECT_EQ(ValueOf(plan, "--window") == "0" || ValueOf(plan, "--window").empty(),
                !options.recorded)
          << plan.name;
      for (const std::string& argument : plan.arguments) all += argument + " ";
    }
    return all;
  };
  EXPECT_NE(joined().find("--recorder "), std::string::npos);
  options.recorded = false;
  EXPECT_EQ(joined().find("--recorder "), std::string::npos);
}

TEST(LaunchOptions, SealsWhatLeavesTheHost) {
  EXPECT_FALSE(Parse({"a.json"}).sealed);
  EXPECT_TRUE(Parse({"a.json", "--seal"}).sealed);
  EXPECT_TRUE(Parse({"a.json", "--key", "k"}).sealed);
  EXPECT_FALSE(Parse({"--seal", "a.json"}).sealed_per_process);
  EXPECT_TRUE(Parse({"--seal", "per-process", "a.json"}).sealed_per_process);
  EXPECT_TRUE(Parse({"a.json", "--seal=per-process", "--key", "k"}).sealed_per_process);
  EXPECT_EQ(RefusalOf({"a.json", "--seal=each"}),
            "command line: --seal: found 'each', expected mission or per-process");
  const TemporaryFolder folder;
  const std::string hosts = folder.File("hosts.json");
  std::ofstream(hosts) << R"({"version": 1, "hosts": [
      {"name": "a", "netns": "a", "processes": ["uav"]}]})";
  EXPECT_TRUE(Parse({"a.json", "--hosts", hosts.c_str()}).sealed);
  EXPECT_FALSE(Parse({"a.json", "--hosts", hosts.c_str(), "--no-seal"}).sealed);
  EXPECT_EQ(RefusalOf({"a.json", "--seal", "--no-seal"}),
            "command line: --no-seal: found --seal, expected one of the two");
  EXPECT_EQ(RefusalOf({"a.json", "--key", "k", "--no-seal"}),
            "command line: --no-seal: found --key, expected one of the two");
}

TEST(LaunchOptions, NoCommandLineHasTheKey) {
  MissionIdentity mission;
  mission.key = SealKey::Fresh(7);
  const auto plans = PlanProcesses(Parse({"a.json", "--seal"}), ScenarioWith(1, 1, 1), mission);
  ASSERT_EQ(plans.size(), 5U);
  for (const ProcessPlan& plan : plans) {
    EXPECT_EQ(ValueOf(plan, "--key"), "-") << plan.name;
    for (const std::string& argument : plan.arguments) {
      EXPECT_EQ(argument.find(mission.key->Text().substr(0, 64)), std::string::npos);
    }
  }
}

TEST(LaunchOptions, AnOwnProgramTakesThePlaceOfOurs) {
  const LaunchOptions options =
      Parse({"a.json", "--program", "worker=/bin/true", "--program", "scheduler=/bin/false",
             "--policy", "mine", "--processes", "worker=2"});
  EXPECT_EQ(options.policy, "mine");
  std::string programs;
  for (const ProcessPlan& plan : PlanProcesses(options, ScenarioWith(1, 2, 1), {})) {
    programs += plan.name + "=" + plan.program + " ";
    if (plan.name == "scheduler") {
      EXPECT_EQ(ValueOf(plan, "--policy"), "mine");
    }
  }
  EXPECT_EQ(programs,
            "world=muster-world uav=muster-uav worker-1=/bin/true worker-2=/bin/true "
            "vehicle=muster-vehicle scheduler=/bin/false ");
}

TEST(LaunchOptions, AnOwnProgramMustBeThereAndHaveARole) {
  for (const char* program : {"worker", "worker=", "worker=/nothing/there", "worker=/etc/passwd",
                              "worker=/bin", "recorder=/bin/true", "=/bin/true"}) {
    EXPECT_NE(RefusalOf({"a.json", "--program", program}), "") << program;
  }
  EXPECT_EQ(RefusalOf({"a.json", "--program", "scheduler=/bin/true"}),
            "command line: --program: found scheduler without --policy, expected --policy with it: "
            "the name of a policy that your scheduler has");
  EXPECT_NE(RefusalOf({"a.json", "--policy", "mine"}), "") << "no scheduler that has it";
}

TEST(LaunchOptions, BadValuesNameFlagValueAndWhatIsExpected) {
  EXPECT_EQ(RefusalOf({}), "command line: SCENARIO: found nothing, expected a scenario file");
  EXPECT_EQ(RefusalOf({"a.json", "--rate", "fast"}),
            "command line: --rate: found 'fast', expected max or a number from 0.001");
  for (const char* rate : {"0", "-1", "nan", "inf", "1x", ""}) {
    EXPECT_NE(RefusalOf({"a.json", "--rate", rate}), "") << rate;
  }
  for (const char* drop : {"1", "-0.1", "nan"}) {
    EXPECT_NE(RefusalOf({"a.json", "--drop", drop}), "") << drop;
  }
  for (const char* processes : {"uav", "uav=", "uav=x", "uav=-1", "boat=1", "uav=1000", "=1"}) {
    EXPECT_NE(RefusalOf({"a.json", "--processes", processes}), "") << processes;
  }
  EXPECT_NE(RefusalOf({"a.json", "--availability", "lax"}), "");
  EXPECT_NE(RefusalOf({"a.json", "--lcm-url", "tcp://x"}), "");
  EXPECT_NE(RefusalOf({"a.json", "b.json"}), "");
  for (const char* deadline : {"0", "-1", "nan", "1e9", "x"}) {
    EXPECT_NE(RefusalOf({"a.json", "--deadline", deadline}), "") << deadline;
  }
  EXPECT_EQ(RefusalOf({"a.json", "--policy", "mpq", "--deadline", "20"}),
            "options: --deadline: found policy mpq, expected one that can be cut short: certified, "
            "rollout, rollout-steps, external:COMMAND");
  // Nobody could reach the network of the mission's own.
  EXPECT_NE(RefusalOf({"a.json", "--processes", "uav=0"}), "");
}

TEST(LaunchOptions, ThinkingIsMoreSearchThatTheClockEnds) {
  const LaunchOptions options = Parse({"a.json", "--think", "2.5"});
  EXPECT_EQ(options.deadline_ms, 2500);
  EXPECT_EQ(options.policy, "rollout-steps:effort=1000");
  EXPECT_EQ(Parse({"a.json", "--think", "1", "--policy", "rollout", "--know-shifts"}).policy,
            "rollout:shifts=1:effort=1000");
  for (const char* think : {"0", "-1", "nan", "3601", "x"}) {
    EXPECT_NE(RefusalOf({"a.json", "--think", think}), "") << think;
  }
  EXPECT_EQ(RefusalOf({"a.json", "--policy", "mpq", "--think", "5"}),
            "command line: --think: found 5 s, expected --policy rollout or rollout-steps with it, "
            "not mpq");
  EXPECT_EQ(RefusalOf({"a.json", "--deadline", "20", "--think", "5"}),
            "command line: --think: found 5 s, expected no --deadline with it, which says the same "
            "in milliseconds");
  EXPECT_EQ(RefusalOf({"a.json", "--effort", "3", "--think", "5"}),
            "command line: --think: found 5 s, expected no --effort with it, which is a fixed "
            "amount of search");
}

TEST(PlanProcesses, TheSchedulerIsToldItsDeadline) {
  const auto scheduler = [](const LaunchOptions& options) {
    return PlanProcesses(options, ScenarioWith(3, 3, 1),
                         {"run/scenario.json", "udpm://239.255.76.67:7000", 42})
        .back();
  };
  EXPECT_EQ(ValueOf(scheduler(Parse({"a.json", "--deadline", "12.5"})), "--deadline"), "12.5");
  EXPECT_EQ(ValueOf(scheduler(Parse({"a.json"})), "--deadline"), "");
}

TEST(PlanProcesses, SeveralSchedulersAreNumberedAndTheWorldIsTold) {
  const std::vector<ProcessPlan> plans = PlanProcesses(
      Parse({"a.json", "--processes", "scheduler=3,uav=2", "--program", "scheduler-2=/bin/true"}),
      ScenarioWith(3, 3, 1), {"run/scenario.json", "udpm://239.255.76.67:7000", 42});
  ASSERT_EQ(plans.size(), 8U);
  EXPECT_EQ(ValueOf(plans[0], "--schedulers"), "3");
  for (std::size_t i = 0; i < 3; ++i) {
    const ProcessPlan& plan = plans[5 + i];
    EXPECT_EQ(plan.name, "scheduler-" + std::to_string(i + 1));
    EXPECT_EQ(plan.program, i == 1 ? "/bin/true" : "muster-scheduler");
    EXPECT_EQ(ValueOf(plan, "--policy"), "rollout-steps");
  }
}

TEST(PlanProcesses, WithoutASchedulerTheProcessesOfAgentsDecide) {
  const auto plans_of = [](const std::vector<const char*>& arguments) {
    return PlanProcesses(Parse(arguments), ScenarioWith(3, 3, 1),
                         {"run/scenario.json", "udpm://239.255.76.67:7000", 42});
  };
  for (const auto& plans :
       {plans_of({"a.json", "--policy", "neighbours", "--reach", "3", "--processes", "uav=2"}),
        plans_of({"a.json", "--policy", "certified", "--processes", "scheduler=0,uav=2"})}) {
    ASSERT_EQ(plans.size(), 5U);
    EXPECT_EQ(ValueOf(plans[0], "--schedulers"), "4");
    EXPECT_EQ(plans[0].decides_as, "");
    for (std::size_t i = 1; i < 5; ++i) {
      EXPECT_EQ(plans[i].decides_as, "scheduler-" + std::to_string(i));
      EXPECT_EQ(ValueOf(plans[i], "--decide-as"), plans[i].decides_as);
      EXPECT_NE(ValueOf(plans[i], "--policy"), "");
    }
  }
  // One process of agents decides alone, under the name of a single scheduler.
  const auto one = plans_of({"a.json", "--policy", "neighbours", "--processes", "uav=0,worker=0",
                             "--lcm-url", "udpm://239.255.76.67:7000?ttl=0"});
  ASSERT_EQ(one.size(), 2U);
  EXPECT_EQ(ValueOf(one[0], "--schedulers"), "");
  EXPECT_EQ(one[1].decides_as, "scheduler");
  // A program of the user's need not know how to.
  const auto own = plans_of({"a.json", "--policy", "neighbours", "--program", "worker=/bin/true"});
  ASSERT_EQ(own.size(), 4U);
  EXPECT_EQ(ValueOf(own[0], "--schedulers"), "2");
  EXPECT_EQ(own[1].decides_as, "scheduler-1");
  EXPECT_EQ(own[2].program, "/bin/true");
  EXPECT_EQ(own[2].decides_as, "");
  EXPECT_EQ(ValueOf(own[2], "--decide-as"), "");
  EXPECT_EQ(own[3].decides_as, "scheduler-2");
  // A scheduler that is asked for works the agreement out.
  const auto central = plans_of({"a.json", "--policy", "neighbours", "--processes", "scheduler=1"});
  ASSERT_EQ(central.size(), 5U);
  EXPECT_EQ(central.back().name, "scheduler");
  EXPECT_EQ(ValueOf(central[1], "--decide-as"), "");
}

TEST(LaunchOptions, WithoutASchedulerOneToNineProcessesOfAgentsDecide) {
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(
      has(RefusalOf({"s.json", "--processes", "scheduler=0,uav=4,worker=5"}),
          "expected 1 to 9 agent processes of Muster's own with it, which decide; there are 10"));
  EXPECT_TRUE(has(RefusalOf({"s.json", "--processes", "scheduler=0,uav=0,worker=0,vehicle=0",
                             "--lcm-url", "udpm://239.255.76.67:7000?ttl=0"}),
                  "there are 0"));
  EXPECT_TRUE(has(RefusalOf({"s.json", "--processes", "scheduler=0", "--deadline", "50"}),
                  "no --deadline with it"));
  EXPECT_TRUE(has(RefusalOf({"s.json", "--processes", "scheduler=0", "--policy", "certified",
                             "--program", "scheduler=/bin/true"}),
                  "no --program scheduler=FILE with it"));
}

TEST(LaunchOptions, SeveralSchedulersMustDecideAlike) {
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  for (const char* bad : {"scheduler=-1", "scheduler=10", "scheduler=", "scheduler", "world=2"}) {
    EXPECT_TRUE(has(RefusalOf({"s.json", "--processes", bad}), "scheduler=N from 0 to 9")) << bad;
  }
  EXPECT_TRUE(has(RefusalOf({"s.json", "--processes", "scheduler=2", "--deadline", "50"}),
                  "found scheduler=2, expected no --deadline with it"));
  EXPECT_TRUE(has(RefusalOf({"s.json", "--processes", "scheduler=2", "--policy", "external:true"}),
                  "expected no external policy with it"));
  for (const char* name : {"scheduler-1=/bin/true", "scheduler-4=/bin/true"}) {
    const char* n = name[10] == '1' ? "scheduler=1" : "scheduler=3";
    EXPECT_TRUE(
        has(RefusalOf({"s.json", "--processes", n, "--program", name}), "a process of the mission"))
        << name;
  }
}

TEST(PlanProcesses, OneProcessAClassByDefault) {
  const std::vector<ProcessPlan> plans =
      PlanProcesses(Parse({"a.json", "--policy", "ils", "--rate", "60"}), ScenarioWith(3, 3, 1),
                    {"run/scenario.json", "udpm://239.255.76.67:7000", 42});
  ASSERT_EQ(plans.size(), 5u);
  const char* names[] = {"world", "uav", "worker", "vehicle", "scheduler"};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(plans[i].name, names[i]);
    EXPECT_EQ(plans[i].program, std::string("muster-") + names[i]);
    EXPECT_EQ(ValueOf(plans[i], "--name"), names[i]);
    EXPECT_EQ(ValueOf(plans[i], "--lcm-url"), "udpm://239.255.76.67:7000");
    EXPECT_EQ(ValueOf(plans[i], "--run-id"), "42");
    EXPECT_EQ(ValueOf(plans[i], "--ids"), "");
    EXPECT_EQ(ValueOf(plans[i], "--drop"), "");
  }
  EXPECT_EQ(plans[0].arguments.front(), "run/scenario.json");
  EXPECT_EQ(ValueOf(plans[0], "--rate"), "60");
  EXPECT_EQ(ValueOf(plans[4], "--policy"), "ils");
}

TEST(PlanProcesses, DriversGoToWhoHasTheirAgent) {
  const LaunchOptions options =
      Parse({"a.json", "--processes", "uav=2", "--rate", "60", "--lost-after", "3", "--driver",
             "uav:7=true a,b", "--driver", "vehicle:0=true"});
  const std::vector<ProcessPlan> plans = PlanProcesses(options, ScenarioWith(10, 1, 1), {});
  for (const ProcessPlan& plan : plans) {
    const bool drives = plan.name == "uav-2" || plan.name == "vehicle";
    EXPECT_EQ(ValueOf(plan, "--driver"), plan.name == "uav-2"     ? "7=true a,b"
                                         : plan.name == "vehicle" ? "0=true"
                                                                  : "");
    if (drives) {
      EXPECT_EQ(ValueOf(plan, "--rate"), "60") << plan.name;
    }
    EXPECT_EQ(ValueOf(plan, "--lost-after"), drives ? "3" : "") << plan.name;
  }
  Scenario scenario = ScenarioWith(10, 1, 1);
  MarkDriven(options.drivers, &scenario);
  EXPECT_TRUE(scenario.uavs[7].measured && scenario.vehicles[0].measured);
  EXPECT_FALSE(scenario.uavs[6].measured || scenario.workers[0].measured);
}

TEST(LaunchOptions, ADriverIsAnAgentsAndAProgram) {
  EXPECT_EQ(RefusalOf({"a.json", "--driver", "true"}),
            "command line: --driver: found true, expected AGENT=COMMAND, e.g. "
            "uav:3='./my-driver --fast'");
  EXPECT_NE(RefusalOf({"a.json", "--driver", "uav:-1=true"}), "");
  EXPECT_NE(RefusalOf({"a.json", "--driver", "boat:1=true"}), "");
  EXPECT_NE(RefusalOf({"a.json", "--driver", "uav:1=/no/such/driver"}), "");
  EXPECT_NE(RefusalOf({"a.json", "--driver", "uav:1=true", "--driver", "uav:1=true"}), "");
  EXPECT_NE(RefusalOf({"a.json", "--driver", "uav:1=true", "--processes", "uav=0", "--lcm-url",
                       "udpm://239.255.76.67:7667?ttl=0"}),
            "");
  Scenario scenario = ScenarioWith(1, 1, 1);
  EXPECT_THROW(MarkDriven({{AgentKind::kWorker, 1, "true"}}, &scenario), InputError);
}

TEST(PlanProcesses, DealsAClassOutWithoutOverlapOrHole) {
  const LaunchOptions options = Parse({"a.json", "--processes", "uav=3,vehicle=0", "--drop=0.3",
                                       "--lcm-url", "udpm://239.255.76.67:7000"});
  const std::vector<ProcessPlan> plans = PlanProcesses(options, ScenarioWith(10, 1, 1), {});
  ASSERT_EQ(plans.size(), 6u);
  EXPECT_EQ(plans[1].name, "uav-1");
  EXPECT_EQ(ValueOf(plans[1], "--ids"), "0-2");
  EXPECT_EQ(ValueOf(plans[2], "--ids"), "3-5");
  EXPECT_EQ(ValueOf(plans[3], "--ids"), "6-9");
  EXPECT_EQ(plans[3].name, "uav-3");
  EXPECT_EQ(plans[4].name, "worker");
  EXPECT_EQ(plans[5].name, "scheduler");
  EXPECT_EQ(ValueOf(plans[5], "--drop"), "0.3");
  EXPECT_NE(ValueOf(plans[4], "--drop-seed"), ValueOf(plans[5], "--drop-seed"));
}

TEST(PlanProcesses, ManyProcessesShareWhatLcmLoggerQueues) {
  const auto plans = [](const char* processes, const char* logger) {
    return PlanProcesses(Parse({"a.json", "--processes", processes, "--logger", logger}),
                         ScenarioWith(50, 50, 50), {});
  };
  EXPECT_EQ(ValueOf(plans("uav=2", "lcm")[1], "--window"), "3");
  EXPECT_EQ(ValueOf(plans("uav=4,worker=4,vehicle=4", "lcm")[1], "--window"), "2");
  EXPECT_EQ(ValueOf(plans("uav=20,worker=20,vehicle=20", "lcm")[60], "--window"), "1");
  EXPECT_EQ(ValueOf(plans("uav=20,worker=20,vehicle=20", "muster")[60], "--window"), "8");
  EXPECT_EQ(ValueOf(plans("uav=2", "lcm")[0], "--window-bytes"), "");
  EXPECT_EQ(ValueOf(plans("uav=2", "muster")[0], "--window-bytes"), "65536");
}

TEST(PlanProcesses, MoreProcessesThanAgentsIsAnError) {
  const LaunchOptions options = Parse({"a.json", "--processes", "vehicle=2"});
  EXPECT_THROW(PlanProcesses(options, ScenarioWith(1, 1, 1), {}), InputError);
}

}  // namespace
}  // namespace muster::tools
