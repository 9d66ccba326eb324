// The checker of drivers, with the example as it is and spoilt.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/spawn.h"
#include "tests/temporary_folder.h"
#include "tests/tools/host/child_process.h"
#include "tools/drive/driver_check.h"

namespace muster::tools {
namespace {

const std::string kExample = MUSTER_EXAMPLES "/uav.py";

class Drive : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!FindProgram("python3")) GTEST_SKIP() << "no python3";
  }
  static DriverCheckResult Check(const std::vector<std::string>& arguments,
                                 AgentKind kind = AgentKind::kUav, double rate = 0,
                                 std::string file = kExample) {
    DriverCheckOptions options;
    options.argv = {*FindProgram("python3"), std::move(file)};
    options.argv.insert(options.argv.end(), arguments.begin(), arguments.end());
    options.kind = kind;
    options.rules.rate = rate;
    return CheckDriver(options);
  }
  /// The example with that put in the place of something.
  std::string Spoilt(const std::string& what, const std::string& with) const {
    std::ostringstream text;
    text << std::ifstream(kExample).rdbuf();
    std::string program = text.str();
    const std::size_t at = program.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    std::ofstream(folder_.File("spoilt.py")) << program.replace(at, what.size(), with);
    return folder_.File("spoilt.py");
  }
  static std::string FirstWrong(const DriverCheckResult& result) {
    return result.wrong.empty() ? "nothing" : result.wrong.front().what;
  }

  TemporaryFolder folder_;
};

TEST_F(Drive, SaysWhatTheDriverDoesNow) {
  DriverCheckOptions options;
  options.argv = {*FindProgram("python3"), kExample, "--ready", "2"};
  std::vector<std::string> said;
  options.progress = [&](const std::string& what) { said.push_back(what); };
  EXPECT_EQ(FirstWrong(CheckDriver(options)), "nothing");
  ASSERT_EQ(said.size(), 8U);
  EXPECT_NE(said[0].find(" it waits for "), std::string::npos) << said[0];
  EXPECT_EQ(said[1], "0:02:00 goto 1");
  EXPECT_NE(said[7].find(" goto 7"), std::string::npos) << said[7];
}

TEST_F(Drive, TheExampleDoesAllAsPlanned) {
  for (const AgentKind kind : kAgentKinds) {
    const DriverCheckResult result = Check({}, kind);
    EXPECT_EQ(FirstWrong(result), "nothing");
    EXPECT_EQ(result.name, "uav.py");
    ASSERT_EQ(result.steps.size(), 7U);
    for (const DriverCheckResult::Step& step : result.steps) {
      if (!step.note.empty()) continue;
      ASSERT_TRUE(step.took_s) << step.what;
      EXPECT_NEAR(*step.took_s, step.planned_s, 1) << step.what;
    }
  }
}

TEST_F(Drive, LatenessIsToldAndNotWrong) {
  const DriverCheckResult result = Check({"--late", "20"});
  EXPECT_EQ(FirstWrong(result), "nothing");
  ASSERT_EQ(result.steps.size(), 7U);
  EXPECT_EQ(result.steps[0].took_s, 180);
  EXPECT_EQ(result.steps[1].took_s, 90);
  EXPECT_EQ(result.steps[2].took_s, 180);
}

TEST_F(Drive, SilenceDeathAndNonsenseAreWrong) {
  EXPECT_EQ(FirstWrong(Check({"--silent", "2:12"})), "silent for 5 s while it was on its way");
  EXPECT_EQ(FirstWrong(Check({"--dies", "2"})), "its program exited with code 1");
  const std::tuple<const char*, const char*, const char*> cases[] = {
      {"say(type=\"arrived\", id=leg[\"id\"])", "say(type=\"arrived\", id=99)",
       "id 99 was never given"},
      {"version=1", "version=2", "version: found 2, expected 1"},
      {"say(type=\"state\", at=me, mission_s=now, expected",
       "say(type=\"state\", mission_s=now, expected", "at: found no such key"},
      {"part = min(1, ", "part = min(1, 1.5 * ", "are faster than its 16.6667 m/s"},
      {"say(type=\"done\"", "say(type=\"finished\"", "type: found \"finished\""},
      {"leg = work = None", "pass", "m after cancel"},
      {"sys.exit(0 if kind == \"bye\" else 1)", "sys.exit(7)",
       "after bye its program exited with code 7"},
      {"print(json.dumps(line), flush=True)", "print(line, flush=True)", "valid JSON"},
  };
  for (const auto& [what, with, wrong] : cases) {
    const DriverCheckResult result = Check({}, AgentKind::kUav, 0, Spoilt(what, with));
    EXPECT_NE(FirstWrong(result).find(wrong), std::string::npos) << FirstWrong(result);
  }
}

TEST_F(Drive, WhoNeverSaysThatHeIsThereIsGivenUp) {
  const std::string file = Spoilt("say(type=\"arrived\", id=leg[\"id\"])", "pass");
  EXPECT_EQ(FirstWrong(Check({}, AgentKind::kUav, 0, file)),
            "not there 10 min after it should have been");
}

TEST_F(Drive, ACommandTellsItWithItsExitCode) {
  const ChildResult good = RunMuster({"drive", "--check", "python3 " + kExample, "--json"});
  EXPECT_EQ(good.exit_code, 0) << good.output;
  const auto told = nlohmann::json::parse(good.output);
  EXPECT_EQ(told["name"], "uav.py");
  EXPECT_EQ(told["steps"].size(), 7U);
  EXPECT_TRUE(told["wrong"].empty());
  const ChildResult late =
      RunMuster({"drive", "--check", "python3 " + kExample + " --silent 2:12", "--rate", "900"});
  EXPECT_EQ(late.exit_code, 0) << late.output;  // ten minutes are soon over
  EXPECT_NE(late.output.find("% late"), std::string::npos) << late.output;
  const ChildResult bad = RunMuster({"drive", "--check", "python3 " + kExample + " --dies 3"});
  EXPECT_EQ(bad.exit_code, 4);
  EXPECT_NE(bad.output.find("WRONG     at "), std::string::npos) << bad.output;
  EXPECT_EQ(RunMuster({"drive", "--check", "no-such-program-there"}).exit_code, 2);
  EXPECT_EQ(RunMuster({"drive"}).exit_code, 2);
}

}  // namespace
}  // namespace muster::tools
