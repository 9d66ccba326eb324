#pragma once

#include <string>
#include <vector>

#include "tools/bench/paper_plan.h"

namespace muster::tools {

struct PaperOptions {
  PaperFilter filter;
  std::string out;   ///< folder
  int jobs = 1;      ///< missions at a time, each in a process of its own
  std::string data;  ///< folder with the tables of places; "": drawn places only
  bool quiet = false;
};

/// Flies the runs that OUT/runs.csv does not have yet, each row appended when it is done, and at
/// the end writes the file sorted, and results.md and results.html beside it. Rows are the same in
/// any order and with any number of jobs, but for times. Throws InputError when OUT has rows of
/// another build or of other tables of places. Returns whether all runs went well; the others are
/// named on stderr.
bool RunPaperSuite(const PaperOptions& options);

/// Prints the runs as commands, one a line, all seeds of a setting and policy together: each writes
/// to a folder of its own below `out`, for --merge.
void ListPaperJobs(const PaperOptions& options, const std::string& program);

/// Puts the rows of several such folders into `out`. Throws InputError when rows are of different
/// builds or places, when a run is there twice, and when one of the filter's is missing.
void MergePaperRuns(const PaperOptions& options, const std::vector<std::string>& folders);

}  // namespace muster::tools
