#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "tools/bench/paper_plan.h"

namespace muster::tools {

/// What came of a run.
struct PaperRow {
  std::string build;   ///< commit of the program
  std::string places;  ///< PaperScenarios::PlacesOf
  std::int64_t tasks = 0;
  std::int64_t done = 0;  ///< of kUpperBound: the bound on it
  std::int64_t charges = 0;
  double flown_km = 0;
  std::string digest;  ///< of decisions and outcomes (tools/record/digest.h)
  /// Measured: everything above is a function of run, build and places, these are not. Seconds;
  /// the first three of one decision.
  double decision_median_s = 0, decision_mean_s = 0, decision_max_s = 0;
  double cpu_s = 0;  ///< of the whole run

  double completion() const {
    return tasks == 0 ? 0 : static_cast<double>(done) / static_cast<double>(tasks);
  }
};

using PaperRows = std::map<PaperRun, PaperRow>;

/// Flies the mission, or computes the bound.
PaperRow FlyPaperRun(const PaperRun& run, const Scenario& scenario);

std::string PaperCsvHeader();
/// One line with its end; times are the last four columns.
std::string PaperCsvLine(const PaperRun& run, const PaperRow& row);
std::string PaperCsv(const PaperRows& rows);  ///< sorted by run, with header

/// Reads the file of PaperCsv, or one that was being appended to when its writer was killed: a last
/// line without end is left out. No such file: no rows. Throws InputError naming file and line.
PaperRows ReadPaperCsv(const std::string& file);

/// "Random_1 10 min 180 min none strict mpq seed 3"
std::string NameOf(const PaperRun& run);

/// Commit of this program; of a build with changed files also the beginning of its own SHA-256, so
/// that rows of different programs never mix.
std::string BuildName();

}  // namespace muster::tools
