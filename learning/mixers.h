#pragma once

#include <torch/nn.h>

namespace muster::learning {

using torch::Tensor;

/// Linear layers with ReLU between them; widths [in, ..., out].
torch::nn::Sequential Layers(const std::vector<std::int64_t>& widths);

/// Q_tot = |W2(e)|^T ELU(|W1(e)|^T q + b1(e)) + V(e): no less where any q is more. e [B x width],
/// q [B x N]; returns [B]. Source: Rashid et al. 2018 (QMIX), the paper's appendix B.
class QmixMixer : public torch::nn::Module {
 public:
  QmixMixer(std::int64_t agents, std::int64_t width);
  Tensor forward(const Tensor& q, const Tensor& e);
  /// The same for joint actions that differ from q in one agent's value: others [B x N x k];
  /// returns [B x N x k], without mixing each anew.
  Tensor Deviations(const Tensor& q, const Tensor& others, const Tensor& e);

 private:
  struct Weights {
    Tensor w1, b1, w2, v;  ///< [B x N x 32], [B x 32], [B x 32], [B]
  };
  Weights Of(const Tensor& e);

  std::int64_t agents_;
  torch::nn::Sequential w1_{nullptr}, w2_{nullptr}, v_{nullptr};
  torch::nn::Linear b1_{nullptr};
};

/// First layer over [e, one-hot of all agents' actions] without that wide row: one embedding for
/// each (agent, option), summed over the present agents.
class ActionLayer : public torch::nn::Module {
 public:
  ActionLayer(std::int64_t agents, std::int64_t options, std::int64_t width, std::int64_t out);
  /// actions [B x N], present [B x N]; returns [B x out].
  Tensor forward(const Tensor& e, const Tensor& actions, const Tensor& present);

 private:
  friend struct ActionLayerTest;
  std::int64_t options_;
  torch::nn::Linear state_{nullptr};
  torch::nn::Embedding action_{nullptr};
};

/// Q_tot = sum q~ + sum (lambda - 1) (q~ - max q~), q~ = w(e) q + v(e), lambda(e, a) > 0 from
/// several heads: any function whose best joint action is the best of each agent. Source: Wang et
/// al. 2021 (QPLEX), the paper's appendix B.
class QplexMixer : public torch::nn::Module {
 public:
  QplexMixer(std::int64_t agents, std::int64_t options, std::int64_t width, int heads, int layers);
  /// q, best_q [B x N] of the actions and of each agent's best one; actions, present [B x N].
  Tensor forward(const Tensor& q, const Tensor& best_q, const Tensor& actions,
                 const Tensor& present, const Tensor& e);
  /// [B x N], above 0.
  Tensor Lambda(const Tensor& actions, const Tensor& present, const Tensor& e);

 private:
  struct Head {
    torch::nn::Sequential key{nullptr}, agents{nullptr};
    std::shared_ptr<ActionLayer> action;
    torch::nn::Sequential rest{nullptr};  ///< layers above `action`; none with one layer
  };
  torch::nn::Sequential w_{nullptr}, v_{nullptr};
  std::vector<Head> heads_;
};

/// Q^ of the weighted QMIX: any function of e and q. Source: Rashid et al. 2020.
class FreeMixer : public torch::nn::Module {
 public:
  FreeMixer(std::int64_t agents, std::int64_t width);
  Tensor forward(const Tensor& q, const Tensor& e);

 private:
  torch::nn::Sequential joint_{nullptr}, v_{nullptr};
};

/// Q_jt(s, a) and V(s) of QTRAN, from the hidden layers of the agents' networks and their actions.
/// Source: Son et al. 2019 (QTRAN-base), the paper's appendix B.
class QtranJoint : public torch::nn::Module {
 public:
  QtranJoint(std::int64_t options, std::int64_t width);
  /// hidden [B x N x 64], actions and present [B x N]; returns [B].
  Tensor forward(const Tensor& hidden, const Tensor& actions, const Tensor& present,
                 const Tensor& e);
  Tensor V(const Tensor& e);

 private:
  std::int64_t options_;
  torch::nn::Sequential encode_{nullptr}, q_{nullptr}, v_{nullptr};
};

}  // namespace muster::learning
