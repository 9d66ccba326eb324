#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "scheduler/policies/learned/features.h"

namespace muster::scheduler::learned {

/// Numbers of one layer, row-major.
struct Tensor {
  std::vector<int> shape;
  std::vector<float> values;
};
/// By the name that the layer has in training.
using Tensors = std::map<std::string, Tensor>;

/// Q of each agent's options; those that are not available are not meaningful.
using Values = PerKind<std::vector<std::array<float, kOptions>>>;

/// Expected action of an agent that takes option k with probability softmax(Q / this).
inline constexpr float kMeanFieldTemperature = 0.5F;
inline constexpr int kAttentionWidth = 16;

/// What a trained model decides with: the convolutions over the maps and one network per agent
/// class, in plain C++. Training computes the same with libtorch (learning/mission_nets.h); a test
/// compares them. Source: the paper's appendix B; sizes and the network over options: ours.
class Network {
 public:
  /// Takes what it needs; throws InputError naming `file` when a layer is missing or of another
  /// shape. `mean_field`: MF-QMIX's networks, that also hear what the neighbours are about to do.
  Network(Tensors tensors, const Shape& shape, bool mean_field, const std::string& file);

  Values ValuesOf(const Observation& observation) const;

 private:
  Tensors tensors_;
  Shape shape_;
  bool mean_field_;
};

/// The option with the largest value among those that are available, the first one in a tie.
Choices BestOf(const Observation& observation, const Values& values);

}  // namespace muster::scheduler::learned
