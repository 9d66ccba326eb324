#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "tools/files/scratch_folder.h"
#include "tools/host/child.h"

namespace muster::tools {

/// A question about a run that a command of muster answers, in a process of its own with less
/// priority than the mission: it may take long, and as much memory as the log needs.
class Question {
 public:
  static constexpr std::chrono::seconds kMostTime{60};

  /// Starts `muster COMMAND...`, which reads `input` as a line of stdin. Throws SystemError.
  Question(std::vector<std::string> command, const std::string& input);

  struct Answer {
    bool good = false;  ///< exit code 0; else the text says what is wrong
    std::string text;
  };
  /// None: it is not known yet.
  std::optional<Answer> Poll();

 private:
  ScratchFolder folder_;
  Child child_;
};

/// The command that says why "task:17" or "uav:3" was commanded as it was; none: it is no name.
std::optional<std::vector<std::string>> WhyCommand(const std::string& run, const std::string& name);

}  // namespace muster::tools
