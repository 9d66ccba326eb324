// What becomes of a command whose stdout or stderr cannot be written, and of what would steer a
// terminal.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"
#include "tests/tools/host/child_process.h"

namespace muster::tools {
namespace {

void Open(int fd, const char* file) {
  const int opened = open(file, O_WRONLY);
  dup2(opened, fd);
  close(opened);
}

/// A pipe that nobody reads.
void OpenBrokenPipe(int fd) {
  int ends[2];
  if (pipe(ends) != 0) _exit(97);
  dup2(ends[1], fd);
  close(ends[0]);
  close(ends[1]);
  signal(SIGPIPE, SIG_DFL);
}

class Output : public ::testing::Test {
 protected:
  void SetUp() override {
    Run({"scenario", "--uavs", "2", "--workers", "2", "--vehicles", "1", "--tasks", "3",
         "--charging-points", "1", "--limit", "30", "-o", scenario_});
    Run({"simulate", scenario_, "--quiet", "--log", "--out", run_});
  }
  ChildResult Run(
      const std::vector<std::string>& arguments, const std::function<void()>& prepare = [] {}) {
    return RunInChild([&]() -> int {
      prepare();
      Exec(MUSTER_PROGRAM, arguments);
    });
  }
  TemporaryFolder folder_;
  const std::string scenario_ = folder_.File("s.json");
  const std::string run_ = folder_.File("run");
};

TEST_F(Output, ResultsThatCannotBeWrittenAreExitCode3) {
  const std::vector<std::vector<std::string>> commands = {
      {"--help"},
      {"--version"},
      {"run", "--help"},
      {"simulate", scenario_, "--quiet"},
      {"simulate", scenario_, "--json"},
      {"scenario", "--preset", "Random_1"},
      {"scenario", "--list"},
      {"audit", run_},
      {"audit", run_, "--json"},
      {"redecide", run_},
      {"redecide", run_, "--json"},
      {"log", "info", run_},
      {"log", "info", run_, "--json"},
      {"faults", "random", scenario_},
      {"faults", "drop", scenario_, "--share", "0.5", "--at-min", "10"},
      {"explain", run_, "--agent", "uav:0"},
      {"top", run_, "--json"},
      {"bound", scenario_},
  };
  const struct {
    const char* name;
    std::function<void()> prepare;
    const char* why;
  } cases[] = {
      {"full", [] { Open(STDOUT_FILENO, "/dev/full"); }, "No space left on device"},
      {"closed", [] { close(STDOUT_FILENO); }, "Bad file descriptor"},
      {"unread", [] { OpenBrokenPipe(STDOUT_FILENO); }, "Broken pipe"},
  };
  for (const auto& [name, prepare, why] : cases) {
    for (const std::vector<std::string>& command : commands) {
      std::string text;
      for (const std::string& word : command) text += word + " ";
      SCOPED_TRACE(text + "with a stdout that is " + name);
      const ChildResult result = Run(command, prepare);
      EXPECT_EQ(result.exit_code, 3) << result.output;
      EXPECT_NE(result.output.find("stdout"), std::string::npos) << result.output;
      EXPECT_NE(result.output.find(why), std::string::npos) << result.output;
      EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
    }
  }
}

TEST_F(Output, AStderrThatCannotBeWrittenEndsNothing) {
  const std::function<void()> cases[] = {
      [] { Open(STDERR_FILENO, "/dev/full"); },
      [] { close(STDERR_FILENO); },
      [] { OpenBrokenPipe(STDERR_FILENO); },
  };
  for (const auto& prepare : cases) {
    const ChildResult simulated =
        Run({"simulate", scenario_, "--fault", "loss:*@1+5=0.5"}, prepare);
    EXPECT_EQ(simulated.exit_code, 0);
    EXPECT_NE(simulated.output.find("digest"), std::string::npos) << simulated.output;
    EXPECT_EQ(Run({"runn"}, prepare).exit_code, 2);
  }
}

TEST_F(Output, AFileThatMayNotGrowIsAnErrorToReport) {
  const ChildResult result =
      Run({"simulate", scenario_, "--quiet", "--log", "--out", folder_.File("small")}, [] {
        const rlimit limit = {100, 100};
        setrlimit(RLIMIT_FSIZE, &limit);
        signal(SIGXFSZ, SIG_DFL);
      });
  EXPECT_EQ(result.exit_code, 3) << result.output;
  EXPECT_NE(result.output.find("File too large"), std::string::npos) << result.output;
}

TEST_F(Output, NothingInALogSteersTheTerminal) {
  const std::string log = run_ + "/mission.lcm";
  std::ifstream in(log, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  in.close();
  std::size_t changed = 0;
  for (const std::string word : {"rollout-steps", "MUSTER_LOG", "MUSTER_EVENT"}) {
    for (std::size_t at = 0; (at = bytes.find(word, at)) != std::string::npos; ++changed) {
      bytes.replace(at, 4, "\x1b[2J");
    }
  }
  ASSERT_GT(changed, 0u);
  std::ofstream(log, std::ios::binary) << bytes;
  std::filesystem::remove(run_ + "/report.json");
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"log", "info", run_},
                                             {"redecide", run_},
                                             {"audit", run_},
                                             {"top", run_, "--json"},
                                             {"explain", run_, "--agent", "uav:0"},
                                             {"explain", run_, "--decision", "0"}}) {
    const ChildResult result = Run(command);
    EXPECT_EQ(result.output.find('\x1b'), std::string::npos) << command[0] << result.output;
  }
  std::ifstream scenario(scenario_);
  std::string json{std::istreambuf_iterator<char>(scenario), std::istreambuf_iterator<char>()};
  json.replace(json.find("\"name\": \"") + 9, 1, "\\u001b");
  std::ofstream(folder_.File("named.json")) << json;
  const ChildResult named = Run({"simulate", folder_.File("named.json")});
  EXPECT_EQ(named.exit_code, 0) << named.output;
  EXPECT_NE(named.output.find("\\x1bandom_1"), std::string::npos) << named.output;
}

}  // namespace
}  // namespace muster::tools
