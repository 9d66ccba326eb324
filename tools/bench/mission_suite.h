#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/bench/mission_runs.h"
#include "tools/bench/suites.h"

namespace muster::tools {

/// A whole mission, as `muster run` or `muster simulate` runs it: a CSV row.
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

/// Runs the missions one after the other, all of a repetition before the next one; `simulate` once,
/// however many processes. Of the options: instances, scales (behind them), processes, runs, the
/// first method, limit_min, repetitions, first_seed. Each mission's files are gone when the next
/// one begins. Throws SystemError where no private network can be had. `stop`: no further one is
/// begun.
void RunMissionSuite(
    const BenchOptions& options, const std::function<void(const MissionRow&)>& report,
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
