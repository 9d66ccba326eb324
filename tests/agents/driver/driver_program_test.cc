#include "agents/driver/driver_program.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "agents/driver/driver_programs.h"
#include "base/check.h"
#include "tests/temporary_folder.h"

namespace muster::agents {
namespace {

class Drivers : public ::testing::Test {
 protected:
  Drivers() {
    scenario_.width_m = scenario_.height_m = 1000;
    AgentSpec agent;
    agent.speed_m_s = 1;
    agent.online_until_us = kNever;
    agent.measured = true;
    scenario_.workers = {agent};
    agent_ = StartOf(AgentKind::kWorker, 0, agent, StraightWays());
  }
  /// What is wrong with a program, words of sh, that has been told the time and has to move.
  std::string Problem(const std::string& body, DriverSession::Rules rules = {}) {
    std::ofstream(folder_.path() / "driver") << body;
    DriverProgram program(DriverCommand("sh " + (folder_.path() / "driver").string()), scenario_,
                          agent_, 0, rules);
    const auto until = DriverProgram::Clock::now() + std::chrono::minutes(1);
    std::string problem = program.Pump(true, until);
    if (!problem.empty()) return problem;
    name_ = program.session().name();
    Action go;
    go.kind = ActionKind::kGoTo;
    go.worker = WorkerId(0);
    go.to = {100, 0};
    Begin(&agent_, go, 0, 0, {}, 1);
    program.session().Follow(agent_, 0, DriverProgram::WallUs());
    program.session().Tick(30 * kSecondUs, DriverProgram::WallUs());
    do problem = program.Pump(true, DriverProgram::Clock::now() + std::chrono::milliseconds(10));
    while (problem.empty() && !program.session().answered() && DriverProgram::Clock::now() < until);
    return problem;
  }

  TemporaryFolder folder_;
  Scenario scenario_;
  AgentState agent_;
  std::string name_;
};

constexpr const char* kHello = R"(echo '{"type":"hello","version":1,"name":"sh"}')";

TEST_F(Drivers, AreSpokenToInLines) {
  const std::string body = fmt::format(
      "{}\nwhile read -r line; do case $line in *time*) "
      R"(echo '{{"type":"state","at":{{"x_m":30,"y_m":0}}}}';; esac; done)",
      kHello);
  EXPECT_EQ(Problem(body), "");
  EXPECT_EQ(name_, "sh");
}

TEST_F(Drivers, ThatEndAreSaidToHaveEnded) {
  EXPECT_EQ(Problem("exit 3"), "its program exited with code 3");
  EXPECT_EQ(Problem(fmt::format("{}\nread -r a; read -r b; kill -9 $$", kHello)),
            "its program was killed by signal 9 (Killed)");
}

TEST_F(Drivers, ThatHangAreSilent) {
  DriverSession::Rules rules;
  rules.greeting_us = rules.lost_after_us = kSecondUs / 5;
  EXPECT_EQ(Problem("exec sleep 1000", rules), "no hello within 0.2 s");
  EXPECT_EQ(Problem(fmt::format("{}\nexec sleep 1000", kHello), rules),
            "silent for 0.2 s while it was on its way");
}

TEST_F(Drivers, ThatTalkNonsenseAreToldSo) {
  EXPECT_NE(Problem("echo hello; exec sleep 1000").find("valid JSON"), std::string::npos);
  EXPECT_EQ(Problem("head -c 100000 /dev/zero; exec sleep 1000"), "a line of more than 64 KiB");
}

TEST_F(Drivers, ThatAreNotThereAreRefusedBefore) {
  EXPECT_THROW(DriverCommand("no-such-program-there"), InputError);
  EXPECT_THROW(DriverCommand("sh 'open"), InputError);
  EXPECT_THROW(DriverCommand(" "), InputError);
}

/// Each leaves a mark when its stdin has ended, and ends only when all have.
TEST_F(Drivers, HaveTheSameMomentToEnd) {
  constexpr int kDrivers = 3;
  const std::string folder = folder_.path().string();
  scenario_.workers.resize(kDrivers, scenario_.workers[0]);
  std::vector<DriverPrograms::Command> commands;
  for (int i = 0; i < kDrivers; ++i) {
    const std::string file = fmt::format("{}/driver{}", folder, i);
    std::ofstream(file)
        << kHello << "\n"
        << "while read -r line; do :; done\n"
        << fmt::format("cd {}; : > shut{}\n", folder, i)
        << "until [ -e shut0 ] && [ -e shut1 ] && [ -e shut2 ]; do sleep 0.01; done\n"
        << fmt::format(": > ended{}\n", i);
    commands.push_back({i, DriverCommand("sh " + file)});
  }
  {
    DriverPrograms drivers(commands, {});
    for (int i = 0; i < kDrivers; ++i) {
      drivers.Begin(scenario_, StartOf(AgentKind::kWorker, i, scenario_.workers[0], StraightWays()),
                    0);
    }
    drivers.Bye("it is over");
  }
  for (int i = 0; i < kDrivers; ++i) {
    EXPECT_TRUE(std::filesystem::exists(fmt::format("{}/ended{}", folder, i))) << i;
  }
}

}  // namespace
}  // namespace muster::agents
