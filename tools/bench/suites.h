#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "model/generator.h"
#include "scheduler/situation.h"

namespace muster::tools {

/// One decision by one method: a CSV row.
struct BenchRow {
  std::string instance;
  std::uint64_t seed = 0;
  std::int32_t decision = 0;
  std::string method;
  std::int32_t repetition = 0;
  std::int64_t nodes = 0;
  std::int64_t edges = -1;  ///< of the conflict graph; -1: too many nodes to count
  double weight = 0;
  double bound = 0;  ///< NaN: the method gives none
  /// Wall times, seconds; NaN where a method does not tell.
  double fuse_s = 0, weights_s = 0, candidates_s = 0, bound_s = 0, search_s = 0;
  double total_s = 0;
  std::int64_t peak_bytes = 0;  ///< of the process, during the decision

  double gap() const { return bound > 0 ? (bound - weight) / bound : 0; }
};

enum class AskCbc { kNothing, kRelaxation, kOptimum };

/// What the suites are run with; each says what of it it takes.
struct BenchOptions {
  std::vector<std::string> methods = {"certified"};  ///< policies
  std::vector<std::string> instances;
  std::vector<double> scales;          ///< times Random_29
  std::vector<double> loads;           ///< tasks, times those of the instance
  std::vector<std::string> scenarios;  ///< files
  std::vector<double> closed_percent;  ///< of the roads
  int seeds = 1;
  int first_seed = 1;
  int repetitions = 1;
  int threads = 1;  ///< of `certified`
  Availability availability = Availability::kStrict;
  AskCbc ask = AskCbc::kOptimum;
  std::string data;                 ///< folder with the tables of imported settings; "": none
  std::vector<int> processes;       ///< of each agent class
  std::vector<std::string> runs;    ///< as MissionSetting::run
  std::optional<double> limit_min;  ///< of mission; none: the setting's

  std::vector<std::uint64_t> AllSeeds() const;
};

/// Every decision of missions on the presets named by `instances`, decided by `certified` on the
/// way and by each method for the row.
void RunDecisions(const BenchOptions& options, const std::function<void(const BenchRow&)>& report);

/// One decision by each method on each of `scales` times Random_29.
void RunScale(const BenchOptions& options, const std::function<void(const BenchRow&)>& report);

/// The situation of each decision of a mission that `certified` decides, and how long each took to
/// combine.
std::vector<scheduler::Situation> SituationsOf(const GeneratorSettings& settings,
                                               std::uint64_t seed,
                                               std::vector<double>* fuse_s = nullptr);

/// A situation in the middle of a mission that is not simulated: agents that are online after an
/// hour where the scenario puts them, UAVs with 0.3 to all of their range, 30 % of the tasks done.
scheduler::Situation MidMission(const GeneratorSettings& settings, std::uint64_t seed,
                                Availability availability = Availability::kStrict);

/// Pairs of nodes that share an element with one free place.
std::int64_t CountEdges(const scheduler::Situation& situation);

std::string CsvHeader();
std::string ToCsv(const BenchRow& row);

/// What a person reads: median, spread and largest total time, gaps, by instance and method.
std::string SummaryOf(const std::vector<BenchRow>& rows);

/// A gnuplot script that draws a decision's time against nodes out of the CSV file, as SVG.
std::string PlotScript(const std::string& csv_file, const std::string& svg_file);

}  // namespace muster::tools
