#pragma once

#include <cstdint>
#include <cxxopts.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "model/generator.h"

namespace muster::tools {

/// Adds the flags that `muster scenario` and `muster import` share: --seed, --out, --name, every
/// number of GeneratorSettings, rules, disturbances and --scale.
void AddSettingsOptions(cxxopts::Options* options);

/// `base` with what the flags say: first scaled by --scale, then each number that a flag names, so
/// a number that was given is final. Throws InputError naming the flag.
GeneratorSettings SettingsFrom(const cxxopts::ParseResult& flags, const GeneratorSettings& base);

std::uint64_t SeedFrom(const cxxopts::ParseResult& flags);

/// Writes the scenario to the file of --out (through a temporary file beside it) or to stdout.
/// Throws InputError when the scenario breaks a rule of the file, SystemError when writing fails.
void WriteScenario(const Scenario& scenario, const cxxopts::ParseResult& flags);

/// A finite number; throws InputError naming the flag, what was found and `expected`.
double ParseNumber(std::string_view flag, std::string_view text, std::string_view expected);

std::vector<std::string> Split(std::string_view text, char separator);

}  // namespace muster::tools
