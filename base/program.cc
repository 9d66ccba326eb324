#include "base/program.h"

#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "base/check.h"

namespace muster {

int GuardedMain(const char* program, const std::function<int()>& body) {
  try {
    return body();
  } catch (const InputError& error) {
    fmt::print(stderr, "{}: {}\n", program, error.what());
    return kExitUsage;
  } catch (const cxxopts::exceptions::exception& error) {
    fmt::print(stderr, "{}: {} (see --help)\n", program, error.what());
    return kExitUsage;
  } catch (const SystemError& error) {
    fmt::print(stderr, "{}: {}\n", program, error.what());
    return kExitSystem;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: internal error: {}\n", program, error.what());
    return kExitInternal;
  }
}

std::optional<cxxopts::ParseResult> ParseOptions(cxxopts::Options* options, int argc,
                                                 const char* const* argv) {
  options->add_options()("h,help", "Print this help and exit")("version",
                                                               "Print the version and exit");
  cxxopts::ParseResult result = options->parse(argc, argv);
  if (result.count("help") > 0) {
    fmt::print("{}", options->help());
    return std::nullopt;
  }
  if (result.count("version") > 0) {
    fmt::print("{} {}\n", options->program(), MUSTER_VERSION);
    return std::nullopt;
  }
  if (!result.unmatched().empty()) {
    throw InputError(
        fmt::format("unexpected argument '{}' (see --help)", result.unmatched().front()));
  }
  return result;
}

}  // namespace muster
