#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/record/service.h"

namespace muster::tools {

/// One mission of the suite: Random_1 whose tasks are reported while it runs, with priorities, due
/// and expiry times.
struct ArrivalsRow {
  std::string arrivals;  ///< "steady" or "bursts"
  double load = 1;       ///< tasks, times those of Random_1
  std::uint64_t seed = 0;
  std::string policy;
  Service service;
};

struct ArrivalsOptions {
  std::vector<std::string> policies;
  std::vector<double> loads;
  int seeds = 10;
  int first_seed = 1;
};

/// Flies the missions in virtual time, policies of one mission one after the other.
void RunArrivals(const ArrivalsOptions& options,
                 const std::function<void(const ArrivalsRow&)>& report);

std::string ArrivalsCsvHeader();
std::string ToCsv(const ArrivalsRow& row);

/// Means over the seeds by arrivals, load and policy, as a Markdown table.
std::string SummaryOf(const std::vector<ArrivalsRow>& rows);

/// A gnuplot script that draws the share of the worth, mean over the seeds, by load, as SVG.
std::string ArrivalsPlot(const std::vector<ArrivalsRow>& rows, const std::string& svg_file);

}  // namespace muster::tools
