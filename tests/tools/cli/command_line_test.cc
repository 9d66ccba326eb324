// What users get back from the real program.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"
#include "tests/tools/host/child_process.h"

namespace muster::tools {
namespace {

std::string TextOf(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class CommandLine : public ::testing::Test {
 protected:
  void SetUp() override {
    const ChildResult made =
        RunMuster({"scenario", "--uavs", "2", "--workers", "2", "--vehicles", "1", "--tasks", "3",
                   "--charging-points", "1", "--limit", "30", "-o", scenario_});
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }

  /// A run directory with a log.
  std::string MakeRun() {
    const std::string run = folder_.File("run");
    const ChildResult result = RunMuster({"simulate", scenario_, "--log", "--out", run});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return run;
  }

  TemporaryFolder folder_;
  const std::string scenario_ = folder_.File("s.json");
};

TEST_F(CommandLine, NamesWhatTheUserMayHaveMeant) {
  const struct {
    std::vector<std::string> arguments;
    std::string meant;
  } cases[] = {
      {{"runn", scenario_}, "muster: no command 'muster runn' (did you mean 'run'?)\n"},
      {{"log", "inof"}, "muster: no command 'muster log inof' (did you mean 'info'?)\n"},
      {{"help", "simulat"}, "muster: no command 'muster simulat' (did you mean 'simulate'?)\n"},
      {{"frobnicate"}, "muster: no command 'muster frobnicate' (see muster --help)\n"},
      {{"simulate", scenario_, "--polcy", "ils"},
       "muster: no option '--polcy' (did you mean '--policy'?)\n"},
      {{"simulate", scenario_, "--policy", "rolout"}, "(did you mean 'rollout'?)\n"},
      {{"run", scenario_, "--policy", "rolout"}, "(did you mean 'rollout'?)\n"},
      {{"train", "--policy", "qmxi"}, "(did you mean 'qmix'?)\n"},
      {{"scenario", "--preset", "Radnom_3"}, "(did you mean 'Random_3'?)\n"},
      {{"run", scenario_, "--on-loss", "contniue"}, "(did you mean 'continue'?)\n"},
      {{"faults", "random", scenario_, "--kinds", "los"}, "(did you mean 'loss'?)\n"},
  };
  for (const auto& c : cases) {
    const ChildResult result = RunMuster(c.arguments);
    EXPECT_EQ(result.exit_code, 2) << result.output;
    EXPECT_TRUE(result.output.ends_with(c.meant)) << result.output;
  }
}

TEST_F(CommandLine, HelpOfACommandIsItsHelp) {
  EXPECT_EQ(RunMuster({"help"}).output, RunMuster({"--help"}).output);
  EXPECT_EQ(RunMuster({"help", "run"}).output, RunMuster({"run", "--help"}).output);
  EXPECT_EQ(RunMuster({"help", "log", "cut"}).output, RunMuster({"log", "cut", "--help"}).output);
  EXPECT_EQ(RunMuster({"log", "help", "cut"}).output, RunMuster({"log", "cut", "--help"}).output);
  EXPECT_EQ(RunMuster({"-v"}).output, RunMuster({"--version"}).output);
  const ChildResult cut = RunMuster({"log", "cut", "--help"});
  EXPECT_EQ(cut.exit_code, 0);
  EXPECT_TRUE(cut.output.starts_with("Usage: muster log cut [OPTION...] RUN\n\n")) << cut.output;
  EXPECT_TRUE(
      RunMuster({"bench", "--help"}).output.starts_with("Usage: muster bench [OPTION...]\n"));
  const ChildResult none = RunMuster({});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_EQ(none.output, RunMuster({"--help"}).output);
}

TEST_F(CommandLine, WhatIsExpectedIsATaskRateOfAPolicyThatLooksAhead) {
  const std::string out = folder_.File("out");
  const std::vector<std::vector<std::string>> bad = {
      {"--expect-arrivals", "-1"},
      {"--expect-arrivals", "many"},
      {"--expect-arrivals", "12", "--policy", "mpq"},
      {"--policy", "rollout:expect=-1"},
      {"--policy", "horizon:expect=1"},
  };
  for (std::vector<std::string> arguments : bad) {
    arguments.insert(arguments.begin(), {"simulate", scenario_, "--out", out});
    const ChildResult result = RunMuster(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.output;
    EXPECT_FALSE(std::filesystem::exists(out));
  }
  EXPECT_EQ(RunMuster({"bench", "--suite", "arrivals", "--instances", "haiti"}).exit_code, 2);
  const ChildResult runs = RunMuster({"compare", folder_.path(), folder_.path()});
  EXPECT_EQ(runs.exit_code, 2);
  EXPECT_EQ(runs.output,
            "muster: command line: POLICY: found " + folder_.path().string() +
                ", expected a policy, as horizon; \"muster report RUN RUN\" compares runs\n");
}

TEST_F(CommandLine, AMissingOrImpossibleScenarioIsBadInputEverywhere) {
  const std::string run = MakeRun();
  const std::string garbage = folder_.File("garbage.json");
  std::ofstream(garbage) << R"({"version": 1, "name": "x"})";
  const std::string plan = folder_.File("plan.json");
  std::ofstream(plan) << RunMuster({"faults", "random", scenario_}).output;
  const std::string out = folder_.File("out");
  const std::vector<std::vector<std::string>> commands = {
      {"run"},
      {"simulate"},
      {"bound"},
      {"faults", "random"},
      {"faults", "drop", "--share", "0.5", "--at-min", "5"},
      {"faults", "run", "--out", out, "--"},
      {"export-graph", "--out", out},
  };
  for (const std::string& scenario : {folder_.File("none.json"), garbage, run}) {
    for (std::vector<std::string> command : commands) {
      if (command[0] == "export-graph" && scenario == run) continue;  // takes runs too
      if (command.back() == "--") {
        command.pop_back();
        command.insert(command.end(), {scenario, plan});
      } else {
        command.push_back(scenario);
      }
      const ChildResult result = RunMuster(command);
      EXPECT_EQ(result.exit_code, 2) << command[0] << " " << scenario << "\n" << result.output;
      EXPECT_TRUE(Contains(result.output, scenario)) << result.output;
      if (scenario == run) {
        EXPECT_TRUE(Contains(result.output, "its scenario is " + run + "/scenario.json"))
            << result.output;
      }
      EXPECT_FALSE(std::filesystem::exists(out)) << command[0];
    }
  }
  for (const char* command : {"explain", "audit", "redecide", "replay"}) {
    std::vector<std::string> arguments = {command, folder_.File("none")};
    if (arguments[0] == "explain") arguments.insert(arguments.end(), {"--task", "0"});
    EXPECT_EQ(RunMuster(arguments).exit_code, 2) << command;
  }
}

TEST_F(CommandLine, SimulatePrintsItsReportAsJson) {
  const std::string run = folder_.File("run");
  const ChildResult result = RunMuster({"simulate", scenario_, "--json", "-o", run});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(result.output, TextOf(run + "/report.json"));
}

TEST_F(CommandLine, TopTellsOneSnapshotAsJson) {
  const ChildResult result = RunMuster({"top", MakeRun(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const auto top = nlohmann::json::parse(result.output);
  EXPECT_EQ(top["version"], 1);
  EXPECT_EQ(top["limit_s"], 1800);
  EXPECT_EQ(top["at_s"], 1800);
  EXPECT_EQ(top["ended"], true);
  EXPECT_EQ(top["decision"], 2);
  EXPECT_EQ(top["policy"], "rollout-steps");
  int tasks = 0;
  for (const auto& [status, count] : top["tasks"].items()) tasks += count.get<int>();
  EXPECT_EQ(tasks, 3);
  int uavs = 0;
  for (const auto& [status, count] : top["agents"]["uav"].items()) uavs += count.get<int>();
  EXPECT_EQ(uavs, 2);
  EXPECT_TRUE(top["processes"].is_array());
}

TEST_F(CommandLine, ReportWritesOverPagesOnly) {
  const std::string run = MakeRun();
  const std::string page = folder_.File("page.html");
  const ChildResult first = RunMuster({"report", run, "-o", page});
  if (Contains(first.output, "built without esbuild")) GTEST_SKIP() << first.output;
  EXPECT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(RunMuster({"report", run, "-o", page}).exit_code, 0) << "a page may be made again";
  std::ofstream(page, std::ios::trunc).close();
  EXPECT_EQ(RunMuster({"report", run, "-o", page}).exit_code, 0) << "an empty file too";

  const std::string scenario = TextOf(scenario_);
  const ChildResult refused = RunMuster({"report", run, "-o", scenario_});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_TRUE(Contains(refused.output, "--out: found " + scenario_)) << refused.output;
  EXPECT_EQ(TextOf(scenario_), scenario);
}

TEST_F(CommandLine, ReportSaysWhatItCannotPaint) {
  const std::string run = MakeRun();
  const ChildResult nothing = RunMuster({"report", run, run});
  if (Contains(nothing.output, "built without esbuild")) GTEST_SKIP() << nothing.output;
  EXPECT_EQ(nothing.exit_code, 2) << nothing.output;
  EXPECT_TRUE(Contains(nothing.output, "--out")) << nothing.output;
  const ChildResult suffix = RunMuster({"report", run, "--scene", folder_.File("scene.gif")});
  EXPECT_EQ(suffix.exit_code, 2) << suffix.output;
  EXPECT_TRUE(Contains(suffix.output, "FILE.png or FILE.webm")) << suffix.output;
  const ChildResult show =
      RunMuster({"report", run, "-o", folder_.File("a.html"), "--show", "t=60"});
  EXPECT_EQ(show.exit_code, 2) << show.output;

  const std::string picture = folder_.File("scene.png");
  std::ofstream(picture) << "a letter";
  const ChildResult other = RunMuster({"report", run, "--scene", picture});
  EXPECT_EQ(other.exit_code, 2) << other.output;
  if (Contains(other.output, "built without three.js")) GTEST_SKIP() << other.output;
  EXPECT_EQ(TextOf(picture), "a letter");

  const std::string path = std::getenv("PATH") == nullptr ? "" : std::getenv("PATH");
  setenv("PATH", folder_.File("nowhere").c_str(), 1);
  const ChildResult missing = RunMuster({"report", run, "--scene", folder_.File("new.png")});
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(missing.exit_code, 3) << missing.output;
  EXPECT_TRUE(Contains(missing.output, "apt-get install chromium")) << missing.output;
}

}  // namespace
}  // namespace muster::tools
