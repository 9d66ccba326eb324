#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scheduler/policies/learned/network.h"

namespace muster::scheduler::learned {

/// The methods of the paper's appendix B that are learned, by the names of `muster train --policy`.
inline const std::vector<std::string> kMethodNames = {"madl",  "qmix",  "cw-qmix", "ow-qmix",
                                                      "qtran", "qplex", "mf-qmix", "sqix"};

/// A trained model, as its folder holds it: model.json says what it is, model.bin has the numbers.
struct Model {
  std::string method;  ///< one of kMethodNames
  Shape shape;
  Tensors tensors;
  // For people.
  std::string preset;
  std::uint64_t seed = 0;
  std::int64_t episodes = 0;
  double train_s = 0;
  double held_out = 0;     ///< completion of the held-out missions, 0 to 1
  std::string trained_by;  ///< versions
};

/// Writes both files, each whole or not at all. Throws SystemError.
void WriteModel(const Model& model, const std::string& folder);

/// Throws InputError when there is no model of this version in the folder, or when its two files do
/// not belong together.
Model ReadModel(const std::string& folder);

}  // namespace muster::scheduler::learned
