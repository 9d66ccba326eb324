#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/bench/suites.h"

namespace muster::tools {

/// Settings whose decisions are hard to prove: long online times, weights that tie, and one class
/// of agents or sites that all others wait for.
struct HardFamily {
  std::string name;
  std::string flags;  ///< of `muster scenario` that make its scenarios, but for --seed
  GeneratorSettings settings;
};
const std::vector<HardFamily>& HardFamilies();

/// One decision by `certified`, and what COIN-OR CBC says of it; NaN: not asked, or no answer.
struct HardRow {
  std::string family;
  std::uint64_t seed = 0;
  std::int32_t decision = 0;
  std::int64_t nodes = 0;
  double weight = 0, bound = 0;
  double relaxation = 0;  ///< value of our linear relaxation; NaN: not reached
  double cpu_s = 0;       ///< processor time of the decision, candidates and weights included
  double wall_s = 0;
  double cbc_relaxation = 0, cbc_relaxation_s = 0, cbc_optimum = 0, cbc_optimum_s = 0;
  double others = 0;  ///< heaviest of mpq, ils and kwta; NaN: not asked, as nothing is above bound

  double gap() const { return bound > 0 ? (bound - weight) / bound : 0; }
};

/// Decisions 2, 4, 8 and 12 of missions of each family by `certified`; of the options: seeds,
/// threads, ask. Returns false when CBC was to be asked and is not installed.
bool RunHard(const BenchOptions& options, const std::function<void(const HardRow&)>& report);

/// One decision an hour into a mission of settings drawn by the seed, for each seed; where the gap
/// is above 1e-9, mpq, ils and kwta are asked as well.
void RunRandomSettings(const BenchOptions& options,
                       const std::function<void(const HardRow&)>& report);
/// What they are drawn from, for a person.
std::string RandomSettingsLimits();

std::string HardCsvHeader();
std::string ToCsv(const HardRow& row);
/// For a person: by family and overall, with the worst of each.
std::string SummaryOf(const std::vector<HardRow>& rows);

}  // namespace muster::tools
