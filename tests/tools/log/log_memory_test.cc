// Whoever reads a log needs memory for what the mission is, not for how long its log is.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "lcmtypes/bus/event_log.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/base/sanitized.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

/// Peak memory of `muster ARGUMENTS`, bytes; -1 when it does not end well.
std::int64_t PeakOf(const std::vector<std::string>& arguments) {
  std::vector<char*> argv = {const_cast<char*>(MUSTER_PROGRAM)};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const int null = open("/dev/null", O_WRONLY);
    dup2(null, STDOUT_FILENO);
    execv(argv[0], argv.data());
    _exit(98);
  }
  int status = 0;
  rusage usage = {};
  if (child < 0 || wait4(child, &status, 0, &usage) != child) return -1;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return -1;
  return usage.ru_maxrss * 1024;
}

class LogMemory : public ::testing::Test {
 protected:
  /// A log of half an hour; ticks of 30 s make one that is 30 times smaller than ticks of 1 s.
  std::int64_t Write(const std::string& name, TimeUs tick_us) {
    GeneratorSettings settings = PresetByName("Random_10");
    settings.rules.limit_us = 30 * kMinuteUs;
    settings.rules.tick_us = tick_us;
    const std::string file = folder_.File(name);
    EventLogWriter writer(file);
    Simulate(ScenarioToJson(Generate(settings, 1)), "mpq",
             [&](const Packet& packet) { writer.Write(1, packet); });
    writer.Flush();
    return static_cast<std::int64_t>(std::filesystem::file_size(file));
  }
  TemporaryFolder folder_;
};

TEST_F(LogMemory, DoesNotGrowWithTheLog) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer keeps memory of its own";
  const std::int64_t small = Write("small.lcm", 30 * kSecondUs);
  const std::int64_t large = Write("large.lcm", kSecondUs);
  ASSERT_GT(large, 10'000'000 + small);
  const std::vector<std::string> commands[] = {
      {"audit"},
      {"redecide"},
      {"explain", "--task", "1"},
      {"log", "info"},
      {"log", "repair", "--out", "PATH"},
      {"log", "cut", "--from", "60", "--out", "PATH"},
      {"log", "export", "--format", "csv", "--out", "PATH"},
      {"log", "export", "--format", "geojson", "--origin", "18,-72", "--out", "PATH"},
      {"log", "export", "--format", "mcap", "--out", "PATH"},
  };
  int number = 0;
  for (const auto& command : commands) {
    const auto peak = [&](const char* log) {
      std::vector<std::string> arguments = command;
      for (std::string& argument : arguments) {
        if (argument == "PATH") argument = folder_.File(fmt::format("out-{}", number++));
      }
      arguments.push_back(folder_.File(log));
      return PeakOf(arguments);
    };
    const std::int64_t before = peak("small.lcm");
    const std::int64_t after = peak("large.lcm");
    ASSERT_GT(before, 0) << fmt::format("{}", fmt::join(command, " "));
    ASSERT_GT(after, 0) << fmt::format("{}", fmt::join(command, " "));
    // A twentieth of what the log grew by, and what the allocator rounds to.
    EXPECT_LT(after - before, (large - small) / 20 + 2'000'000)
        << fmt::format("{}: {} bytes of {}", fmt::join(command, " "), after, large);
  }
}

}  // namespace
}  // namespace muster::tools
