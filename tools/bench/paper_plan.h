#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "model/scenario.h"

namespace muster::tools {

/// A kind of mission: what a run is, but for policy and seed.
struct PaperCase {
  std::string setting;  ///< a preset, an imported place (paper_scenarios.h) or a row of Table 6
  int interval_min = 10;
  int limit_min = 180;
  std::string disturbance = "none";  ///< or wind, communication, failure, match
  Availability availability = Availability::kStrict;

  auto operator<=>(const PaperCase&) const = default;
};

struct PaperRun {
  PaperCase what;
  std::string policy;  ///< or kUpperBound
  std::uint64_t seed = 1;

  auto operator<=>(const PaperRun&) const = default;
};

/// Stands where a policy's name does: no mission, but the bound on what any could do.
inline constexpr std::string_view kUpperBound = "upper-bound";

/// A line of a table: the mean over some cases, in both availability modes.
struct PaperLine {
  std::string label;
  std::vector<PaperCase> cases;  ///< strict; the table of the other mode has the same in overrun
  std::string published;         ///< dataset_or_setting of the published figures, "" without any
};

/// A group of the paper's Table 2, or one of its tables.
struct PaperExperiment {
  std::string title;
  std::string note;
  std::string section;  ///< how table_or_section of the published figures begins
  std::vector<PaperLine> lines;
};

/// Everything that the paper's section 5 varies, and the same on imported places when
/// `with_imports`. Sources: the paper's Table 2 and Tables 3 to 6.
std::vector<PaperExperiment> PaperExperiments(bool with_imports);

struct PaperFilter {
  bool longer = false;  ///< the runs that the main suite leaves out, instead of its own
  bool with_imports = true;
  std::uint64_t first_seed = 1;
  int seeds = 10;
  /// Only these; empty: all.
  std::vector<std::string> settings, policies, availability;
};

/// The runs, each once, seeds outermost: a part of them covers all cases evenly. The main suite
/// has every policy; the longer one the variants of our policies and of kwta, and what takes
/// longest: ils and rollout on the settings with 1000 agents.
std::vector<PaperRun> PlanRuns(const PaperFilter& filter);

/// "learned-qmix", ...: trained models as columns of the tables, in the paper suite where they are
/// present: models/SETTING-METHOD of the present folder, as scripts/train-baselines makes them.
std::vector<std::string> LearnedColumns();
/// What decides in that run: its policy, or the model of its setting that it stands for.
std::string PolicyToRun(const PaperRun& run);

/// The policies of both suites, kUpperBound first: the order of tables.
std::vector<std::string> PaperPolicies();

std::string_view NameOf(Availability availability);

}  // namespace muster::tools
