#pragma once

#include <cxxopts.hpp>

namespace muster::tools {

/// The options of `muster bench` that only its suites paper and paper-long have.
void AddPaperOptions(cxxopts::Options* options);

/// `muster bench --suite paper` or paper-long: an exit code.
int PaperCommand(const cxxopts::ParseResult& flags);

/// A whole number from 1 to `most`; throws InputError naming the flag.
int PositiveOption(const cxxopts::ParseResult& flags, const char* name, int most);

}  // namespace muster::tools
