#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/tools/launch/process_test_util.h"
#include "tools/host/child.h"

namespace muster::tools {

inline std::vector<std::string> MusterArgv(const std::vector<std::string>& arguments) {
  std::vector<std::string> argv = {MUSTER_PROGRAM};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  return argv;
}

/// Audits that run and makes its decisions again; what they say goes to `output` and an ending.
inline void CheckRun(const std::string& run, const std::string& output) {
  for (const std::string check : {"audit", "redecide"}) {
    const std::string said = output + "." + check;
    Child child({check, MusterArgv({check, run}), said});
    ASSERT_TRUE(Eventually([&child] { return child.Poll().has_value(); })) << check;
    EXPECT_TRUE(child.Poll()->clean()) << check << ": " << TextOf(said);
  }
}

/// Decides in milliseconds, where the default policy takes a second for a mission of Random_1.
inline constexpr const char* kQuickPolicy = "horizon-steps";

/// The command; missions that name no policy get kQuickPolicy.
inline std::vector<std::string> WithAPolicy(std::vector<std::string> arguments) {
  if (arguments.front() != "run" && arguments.front() != "simulate") return arguments;
  for (const std::string& argument : arguments) {
    if (argument == "--policy") return arguments;
  }
  arguments.insert(arguments.begin() + 1, {"--policy", kQuickPolicy});
  return arguments;
}

/// A `muster` process and what it said. Its missions are by kQuickPolicy, unless the test names
/// another one. A mission that it has ended well, with a log, is audited, and its decisions are
/// made again: no test has to ask for that.
class Muster {
 public:
  Muster(const TemporaryFolder& folder, const std::string& name,
         const std::vector<std::string>& arguments)
      : arguments_(WithAPolicy(arguments)),
        output_(folder.File(name + ".output")),
        child_({name, MusterArgv(arguments_), output_}) {}

  /// Its exit code once it has ended; -1 when it was killed or does not end.
  int Wait(std::chrono::minutes longest = std::chrono::minutes(1)) {
    if (!Eventually([this] { return child_.Poll().has_value(); }, longest)) return -1;
    const int status = child_.Poll()->wait_status;
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (code == 0 && !checked_) CheckLog();
    return code;
  }
  std::string output() const { return TextOf(output_); }
  Child& child() { return child_; }

 private:
  void CheckLog() {
    checked_ = true;
    const auto out = std::find(arguments_.begin(), arguments_.end(), "--out");
    if (arguments_.front() != "run" && arguments_.front() != "simulate") return;
    if (out == arguments_.end() || out + 1 == arguments_.end()) return;
    const std::string run = *(out + 1);
    if (!std::filesystem::exists(run + "/mission.lcm")) return;
    CheckRun(run, output_);
  }
  std::vector<std::string> arguments_;
  std::string output_;
  bool checked_ = false;
  Child child_;
};

}  // namespace muster::tools
