#pragma once

#include <torch/nn.h>

#include <array>
#include <functional>
#include <memory>

#include "scheduler/policies/learned/network.h"

namespace muster::learning {

using scheduler::learned::Tensors;
using torch::Tensor;

/// The agents of one class in a batch of situations, one row each.
struct Rows {
  Tensor slot;       ///< [R] situation * agents of all classes + place among them
  Tensor situation;  ///< [R]
  Tensor id;         ///< [R] within the class
  Tensor own;        ///< [R x kAgentFeatures]
  Tensor features;   ///< [R x options x kOptionFeatures]
};

/// A batch of B situations with N agents and K options each. Missions fill maps and rows, games
/// `state`.
struct Seen {
  std::int64_t size = 0;     ///< B
  Tensor maps;               ///< [B x kMaps x rows x columns] bytes
  std::array<Rows, 3> rows;  ///< UAVs, workers, vehicles
  Tensor at_km;              ///< [B x N x 2]
  Tensor reach_km;           ///< [B x N]
  Tensor state;              ///< [B x S]
  Tensor present;            ///< [B x N] 1: takes part; 0: offline or busy
  Tensor available;          ///< [B x N x K] the first option always is
};

/// What agents come to: q [B x N x K], hidden [B x N x 64], 0 where absent.
struct Utilities {
  Tensor q, hidden;
};

/// Makes e [B x width] of a situation: the paper's cnnSpace.
class StateNet : public torch::nn::Module {
 public:
  virtual Tensor Encode(const Seen& seen) = 0;
};

/// One network per agent class, shared by its agents.
class AgentNets : public torch::nn::Module {
 public:
  virtual Utilities Value(const Seen& seen, const Tensor& e) = 0;
};

/// How a problem makes its networks, and how large they are.
struct Problem {
  std::int64_t agents = 0, options = 0, state_width = 0;
  std::function<std::shared_ptr<StateNet>()> state_net;
  std::function<std::shared_ptr<AgentNets>(bool mean_field)> agent_nets;
};
inline constexpr std::int64_t kHidden = 64;

/// q with -1e9 where an option is not available.
Tensor Masked(const Tensor& q, const Tensor& available);
/// The mean field: for each agent what its neighbours are expected to do. Attention over them says
/// how much each counts; `classes` [C x N] parts the sum by agent class. Source: the paper's
/// appendix B (MF-QMIX); over expected features instead of options, which mean another place for
/// each agent: ours.
class MeanField : public torch::nn::Module {
 public:
  MeanField();
  /// q, hidden of a first pass without a mean field; features [B x N x K x F]; neighbours
  /// [B x N x N]; returns [B x N x C * F].
  Tensor forward(const Utilities& first, const Seen& seen, const Tensor& features,
                 const Tensor& neighbours, const Tensor& classes);

 private:
  torch::nn::Linear query_{nullptr}, key_{nullptr};
};

/// Those within `reach` [B x N] of each, present ones, without itself; where there are none, all.
Tensor Neighbours(const Seen& seen, const Tensor& at, const Tensor& reach);

/// Missions of that shape: networks of scheduler/policies/learned/network.h.
Problem MissionProblem(const scheduler::learned::Shape& shape);
/// Small games in a table, to tell methods apart.
Problem GameProblem(std::int64_t agents, std::int64_t options, std::int64_t states);

/// The numbers by the names that scheduler::learned::Network knows.
Tensors Export(const StateNet& state, const AgentNets& agents);

}  // namespace muster::learning
