#pragma once

#include <torch/optim.h>

#include <memory>
#include <string>

#include "learning/methods.h"

namespace muster::learning {

/// Hyper-parameters common to all methods. Sources: docs/reference/learned.md.
struct LearnerSettings {
  MethodSettings method;
  double learning_rate = 5e-4;
  double most_gradient = 10;
  std::uint64_t seed = 1;  ///< of the first weights
};

/// Networks of one method, their copies for targets, the optimiser.
class Learner {
 public:
  /// Sets libtorch's own seed.
  Learner(const LearnerSettings& settings, const Problem& problem);

  /// One step of the optimiser; returns the loss.
  double Update(const Seen& seen, const Happened& happened);
  void CopyToTarget();

  Sight See(const Seen& seen) { return See(&trained_, seen); }
  Joiner& joiner() { return *trained_.joiner; }
  /// For acting.
  Tensors ActingTensors() const { return Export(*trained_.state, *trained_.agents); }
  /// SHA-256 of all numbers that are trained.
  std::string Hash() const;

  /// Networks, targets and optimiser.
  void Save(torch::serialize::OutputArchive* archive) const;
  void Load(torch::serialize::InputArchive* archive);

 private:
  struct Networks {
    std::shared_ptr<StateNet> state;
    std::shared_ptr<AgentNets> agents, central;
    std::shared_ptr<Joiner> joiner;
    std::vector<std::shared_ptr<torch::nn::Module>> modules() const;
  };
  static Sight See(Networks* networks, const Seen& seen);
  std::vector<Tensor> Parameters(const Networks& networks) const;

  LearnerSettings settings_;
  Networks trained_, target_;
  std::unique_ptr<torch::optim::RMSprop> optimizer_;
};

}  // namespace muster::learning
