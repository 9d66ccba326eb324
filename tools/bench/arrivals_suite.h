#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/bench/imported_settings.h"
#include "tools/bench/suites.h"
#include "tools/record/service.h"

namespace muster::tools {

/// One mission of the suite: its tasks are reported while it runs, with priorities, due and expiry
/// times.
struct ArrivalsRow {
  std::string arrivals;  ///< "steady", "bursts": drawn, on Random_1; or an imported setting's name
  double load = 1;       ///< tasks, times those of Random_1 or of the imported setting
  std::uint64_t seed = 0;
  std::string policy;
  Service service;
};

/// Those that can be flown; with data the imported settings too, whose tasks are rows of their
/// tables, reported at their own times: the larger the load, the more of the rows.
std::vector<std::string> ArrivalsInstances(bool has_data);

/// One of them. Throws InputError where the table has fewer rows in the mission's time than the
/// load asks for.
Scenario ArrivalsScenario(ImportedSettings* imported, const std::string& arrivals, double load,
                          std::uint64_t seed);

/// Flies the missions in virtual time, policies of one mission one after the other; of the options:
/// methods, instances (of ArrivalsInstances), loads, seeds, data. Throws InputError, as
/// ArrivalsScenario does, before the first.
void RunArrivals(const BenchOptions& options,
                 const std::function<void(const ArrivalsRow&)>& report);

std::string ArrivalsCsvHeader();
std::string ToCsv(const ArrivalsRow& row);

/// Markdown tables of what was done in worth, in time, by priority, and how late: means over the
/// seeds, a row for each arrivals and load, a column for each policy. Behind those of the others
/// stands the mean of their differences, seed by seed, to the default policy (or where that was not
/// flown, to the first), and its standard error.
std::string SummaryOf(const std::vector<ArrivalsRow>& rows);

/// A gnuplot script that draws the share of the worth, mean over the seeds, by load, as SVG.
std::string ArrivalsPlot(const std::vector<ArrivalsRow>& rows, const std::string& svg_file);

}  // namespace muster::tools
