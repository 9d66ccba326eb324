#pragma once

#include "base/options.h"
#include "model/generator.h"

namespace muster::tools {

/// Adds the flags that `muster scenario` and `muster import` share: --seed, --out, --name, every
/// number of GeneratorSettings, rules, disturbances and --scale. `may_be_rows`: --arrivals may
/// also be kArrivalsOfRows, which leaves the settings as they are.
void AddSettingsOptions(Options* options, bool may_be_rows = false);
/// The same without --seed and --out.
void AddNumberOptions(Options* options, bool may_be_rows = false);
inline constexpr const char* kArrivalsOfRows = "rows";

/// `base` with what the flags say: first scaled by --scale, then each number that a flag names, so
/// a number that was given is final. Throws InputError naming the flag.
GeneratorSettings SettingsFrom(const Arguments& arguments, const GeneratorSettings& base,
                               bool may_be_rows = false);

/// Writes the scenario to the file of --out (through a temporary file beside it) or to stdout.
/// Throws InputError when the scenario breaks a rule of the file, SystemError when writing fails.
void WriteScenario(const Scenario& scenario, const Arguments& arguments);

}  // namespace muster::tools
