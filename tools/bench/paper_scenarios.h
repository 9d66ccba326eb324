#pragma once

#include <string>
#include <string_view>

#include "tools/bench/imported_settings.h"
#include "tools/bench/paper_plan.h"

namespace muster::tools {

/// Whether the policy can only start sensing on meeting, so that its missions need that rule.
bool MovesByCells(std::string_view policy);

/// Makes the scenarios of the suite: drawn ones, and on the imported places of a data folder.
class PaperScenarios {
 public:
  /// "": no imported places. Throws InputError when the folder lacks a table.
  explicit PaperScenarios(std::string data_folder);

  bool HasImports() const { return imported_.HasData(); }

  /// Reads what Make(run) needs, so that processes forked later share it. Throws InputError,
  /// SystemError.
  void Prepare(const std::string& setting);

  /// The mission of a run. Of the policy only Rules::start_on_meeting depends: MovesByCells.
  Scenario Make(const PaperRun& run);

  /// What a run of the setting rests on beside the program: the beginning of the SHA-256 of its
  /// table of places; "" for drawn ones.
  std::string PlacesOf(const std::string& setting);

 private:
  ImportedSettings imported_;
};

}  // namespace muster::tools
