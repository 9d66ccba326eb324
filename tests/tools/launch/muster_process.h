#pragma once

#include <sys/wait.h>

#include <string>
#include <vector>

#include "tests/tools/launch/process_test_util.h"
#include "tools/launch/child.h"

namespace muster::tools {

/// A `muster` process and what it said.
class Muster {
 public:
  Muster(const TemporaryFolder& folder, const std::string& name,
         const std::vector<std::string>& arguments)
      : output_(folder.File(name + ".output")), child_({name, Argv(arguments), output_}) {}

  /// Its exit code once it has ended; -1 when it was killed or does not end.
  int Wait() {
    if (!Eventually([this] { return child_.Poll().has_value(); })) return -1;
    const int status = child_.Poll()->wait_status;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string output() const { return TextOf(output_); }
  Child& child() { return child_; }

 private:
  static std::vector<std::string> Argv(const std::vector<std::string>& arguments) {
    std::vector<std::string> argv = {MUSTER_PROGRAM};
    argv.insert(argv.end(), arguments.begin(), arguments.end());
    return argv;
  }
  std::string output_;
  Child child_;
};

}  // namespace muster::tools
