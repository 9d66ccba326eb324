#include "learning/mixers.h"

#include "learning/nets.h"

namespace muster::learning {

namespace nn = torch::nn;

namespace {

constexpr std::int64_t kEmbed = 32;
constexpr std::int64_t kHyper = 64;
constexpr std::int64_t kCentral = 256;
constexpr double kAboveZero = 1e-10;

}  // namespace

nn::Sequential Layers(const std::vector<std::int64_t>& widths) {
  nn::Sequential layers;
  for (std::size_t i = 0; i + 1 < widths.size(); ++i) {
    if (i > 0) layers->push_back(nn::ReLU());
    layers->push_back(nn::Linear(widths[i], widths[i + 1]));
  }
  return layers;
}

QmixMixer::QmixMixer(std::int64_t agents, std::int64_t width) : agents_(agents) {
  w1_ = register_module("w1", Layers({width, kHyper, agents * kEmbed}));
  b1_ = register_module("b1", nn::Linear(width, kEmbed));
  w2_ = register_module("w2", Layers({width, kHyper, kEmbed}));
  v_ = register_module("v", Layers({width, kEmbed, 1}));
}

QmixMixer::Weights QmixMixer::Of(const Tensor& e) {
  return {w1_->forward(e).abs().reshape({-1, agents_, kEmbed}), b1_(e), w2_->forward(e).abs(),
          v_->forward(e).squeeze(1)};
}

Tensor QmixMixer::forward(const Tensor& q, const Tensor& e) {
  const Weights w = Of(e);
  const Tensor hidden = torch::elu(torch::matmul(q.unsqueeze(1), w.w1).squeeze(1) + w.b1);
  return (hidden * w.w2).sum(1) + w.v;
}

Tensor QmixMixer::Deviations(const Tensor& q, const Tensor& others, const Tensor& e) {
  const Weights w = Of(e);
  const Tensor base = torch::matmul(q.unsqueeze(1), w.w1).squeeze(1) + w.b1;  // [B x 32]
  const Tensor change = (others - q.unsqueeze(2)).unsqueeze(3) * w.w1.unsqueeze(2);
  const Tensor hidden = torch::elu(base.unsqueeze(1).unsqueeze(1) + change);
  return torch::matmul(hidden, w.w2.unsqueeze(1).unsqueeze(3)).squeeze(3) +
         w.v.unsqueeze(1).unsqueeze(1);
}

ActionLayer::ActionLayer(std::int64_t agents, std::int64_t options, std::int64_t width,
                         std::int64_t out)
    : options_(options) {
  state_ = register_module("state", nn::Linear(width, out));
  action_ = register_module("action", nn::Embedding(agents * options, out));
  const torch::NoGradGuard guard;
  const double most = 1 / std::sqrt(static_cast<double>(width + agents * options));
  state_->weight.uniform_(-most, most);
  action_->weight.uniform_(-most, most);
}

Tensor ActionLayer::forward(const Tensor& e, const Tensor& actions, const Tensor& present) {
  const Tensor index = actions + torch::arange(actions.size(1)) * options_;
  return state_(e) + (action_(index) * present.unsqueeze(2)).sum(1);
}

QplexMixer::QplexMixer(std::int64_t agents, std::int64_t options, std::int64_t width, int heads,
                       int layers) {
  w_ = register_module("w", Layers({width, kHyper, agents}));
  v_ = register_module("v", Layers({width, kHyper, agents}));
  const auto widths = [&](std::int64_t out) {
    std::vector<std::int64_t> list = {width};
    list.insert(list.end(), static_cast<std::size_t>(layers - 1), kHyper);
    list.push_back(out);
    return list;
  };
  for (int k = 0; k < heads; ++k) {
    const std::string name = "head" + std::to_string(k);
    Head head;
    head.key = register_module(name + "_key", Layers(widths(1)));
    head.agents = register_module(name + "_agents", Layers(widths(agents)));
    std::vector<std::int64_t> of_action = widths(agents);
    head.action = register_module(
        name + "_action", std::make_shared<ActionLayer>(agents, options, width, of_action[1]));
    of_action.erase(of_action.begin());
    if (of_action.size() > 1) head.rest = register_module(name + "_rest", Layers(of_action));
    heads_.push_back(head);
  }
}

Tensor QplexMixer::Lambda(const Tensor& actions, const Tensor& present, const Tensor& e) {
  Tensor sum;
  for (Head& head : heads_) {
    Tensor action = head.action->forward(e, actions, present);
    if (!head.rest.is_empty()) action = head.rest->forward(torch::relu(action));
    const Tensor part = (head.key->forward(e).abs() + kAboveZero) *
                        torch::sigmoid(head.agents->forward(e)) * torch::sigmoid(action);
    sum = sum.defined() ? sum + part : part;
  }
  return sum;
}

Tensor QplexMixer::forward(const Tensor& q, const Tensor& best_q, const Tensor& actions,
                           const Tensor& present, const Tensor& e) {
  const Tensor w = w_->forward(e).abs() + kAboveZero;
  const Tensor v = v_->forward(e);
  const Tensor value = w * q + v;
  const Tensor advantage = ((w * q - w * best_q) * present).detach();
  return value.sum(1) + ((Lambda(actions, present, e) - 1) * advantage).sum(1);
}

FreeMixer::FreeMixer(std::int64_t agents, std::int64_t width) {
  joint_ = register_module("joint", Layers({width + agents, kCentral, kCentral, kCentral, 1}));
  v_ = register_module("v", Layers({width, kCentral, 1}));
}

Tensor FreeMixer::forward(const Tensor& q, const Tensor& e) {
  return (joint_->forward(torch::cat({e, q}, 1)) + v_->forward(e)).squeeze(1);
}

QtranJoint::QtranJoint(std::int64_t options, std::int64_t width) : options_(options) {
  const std::int64_t enc = kHidden + options;
  encode_ = register_module("encode", Layers({enc, enc, enc}));
  q_ = register_module("q", Layers({width + enc, kHidden, kHidden, 1}));
  v_ = register_module("v", Layers({width, kHidden, kHidden, 1}));
}

Tensor QtranJoint::forward(const Tensor& hidden, const Tensor& actions, const Tensor& present,
                           const Tensor& e) {
  const Tensor chosen = torch::one_hot(actions, options_).to(torch::kFloat32);
  const Tensor each = encode_->forward(torch::cat({hidden, chosen}, 2)) * present.unsqueeze(2);
  return q_->forward(torch::cat({e, each.sum(1)}, 1)).squeeze(1);
}

Tensor QtranJoint::V(const Tensor& e) { return v_->forward(e).squeeze(1); }

}  // namespace muster::learning
