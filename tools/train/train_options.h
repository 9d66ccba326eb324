#pragma once

#include <optional>

#include "learning/trainer.h"

namespace muster::tools {

struct TrainOptions {
  learning::TrainSettings settings;
  /// The torch-free one: the coefficients of a node's value (learning/node_value.h).
  bool node_value = false;
  bool quiet = false;
  bool random = false;  ///< tells what random choices get done, trains nothing
};

/// Reads the command line of `muster train`, which is that of muster-train. No value: --help was
/// answered. Throws InputError.
std::optional<TrainOptions> ParseTrainOptions(int argc, const char* const* argv);

}  // namespace muster::tools
