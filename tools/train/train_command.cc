#include "tools/train/train_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/program.h"
#include "base/say.h"
#include "learning/node_value.h"
#include "tools/train/train_options.h"

namespace muster::tools {

namespace {

/// Finds the coefficients and prints them, a line for each weighting.
int LearnNodeValue(const TrainOptions& options) {
  learning::NodeValueSettings settings;
  settings.scenarios = options.settings.scenario.name == "Random_1"
                           ? std::vector<GeneratorSettings>()
                           : std::vector{options.settings.scenario};
  if (settings.scenarios.empty()) {
    for (const char* name : {"Random_1", "Random_3", "Random_8", "Random_10"}) {
      settings.scenarios.push_back(PresetByName(name));
    }
  }
  settings.seed = options.settings.seed;
  if (options.settings.episodes > 0) {
    settings.generations = static_cast<int>(options.settings.episodes);
  }
  const auto coefficients =
      learning::LearnNodeValue(settings, [&](const learning::NodeValueProgress& now) {
        if (options.quiet) return;
        Say("generation {} of {}  mean score {:.4f}  best {:.4f}  spread {:.3f}\n", now.generation,
            settings.generations, now.mean, now.best, now.spread);
      });
  for (const auto& row : coefficients) fmt::print("{{{:.4f}}},\n", fmt::join(row, ", "));
  return kExitOk;
}

}  // namespace

int TrainCommand(int argc, const char* const* argv) {
  const auto options = ParseTrainOptions(argc, argv);
  if (!options) return kExitOk;
  if (options->node_value) return LearnNodeValue(*options);
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (self.parent_path() / "muster-train").string();
  if (error || access(program.c_str(), X_OK) != 0) {
    throw InputError(
        "muster train: there is no muster-train beside this program: it needs libtorch (apt-get "
        "install libtorch-dev libopenblas0-pthread) and is built by scripts/train-baselines, or as "
        "target muster-train (docs/guide/learned.md)");
  }
  // One thread, from the moment that the libraries are loaded: two are slower here.
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  std::vector<char*> arguments;
  for (int i = 0; i < argc; ++i) arguments.push_back(const_cast<char*>(argv[i]));
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  throw SystemError(fmt::format("cannot start {}: {}", program, std::strerror(errno)));
}

}  // namespace muster::tools
