#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/bench/mission_runs.h"

namespace muster::tools {

/// Whole missions, each as `muster run` or `muster simulate` runs it.
struct MissionSuite {
  std::vector<std::string> instances;  ///< presets
  std::vector<double> scales;          ///< times Random_29, behind them
  std::vector<int> processes;          ///< of each agent class
  std::vector<std::string> runs;       ///< as MissionSetting::run
  std::string policy;
  std::optional<double> limit_min;  ///< of mission; none: the setting's
  int repetitions = 1;
  std::uint64_t seed = 1;
};

/// One mission: a CSV row.
struct MissionRow {
  std::string instance;
  double size = 1;  ///< times the preset's
  std::int64_t agents = 0, tasks = 0;
  double limit_min = 0;
  std::string policy;
  int processes = 1;
  std::string run;
  int repetition = 0;
  MissionFigures figures;
};

/// Runs them one after the other, all of a repetition before the next one; `simulate` once, however
/// many processes. Each mission's files are gone when the next one begins. Throws SystemError where
/// no private network can be had. `stop`: no further one is begun.
void RunMissionSuite(
    const MissionSuite& suite, const std::function<void(const MissionRow&)>& report,
    const std::function<bool()>& stop = [] { return false; });

std::string MissionCsvHeader();
std::string ToCsv(const MissionRow& row);

/// What a person reads: medians by instance, processes and run, beside `simulate` where that was
/// asked for, and by which power of the number of agents time and log grow over the sizes of one
/// preset.
std::string SummaryOf(const std::vector<MissionRow>& rows);

/// Those that did not end well, and those that decided otherwise than the first of their instance:
/// a line each.
std::vector<std::string> ProblemsOf(const std::vector<MissionRow>& rows);

/// A gnuplot script that draws wall time and size of the log against agents out of the CSV file, as
/// SVG: with one process a class and, where that is more, with `most`.
std::string MissionPlotScript(const std::string& csv_file, const std::string& svg_file, int most);

}  // namespace muster::tools
