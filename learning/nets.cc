#include "learning/nets.h"

#include <torch/nn/functional.h>

#include <cmath>
#include <string>

namespace muster::learning {

using scheduler::learned::kAgentFeatures;
using scheduler::learned::kAttentionWidth;
using scheduler::learned::kMaps;
using scheduler::learned::kMeanFieldTemperature;
using scheduler::learned::kOptionFeatures;
using scheduler::learned::kOptions;
using scheduler::learned::Shape;
namespace nn = torch::nn;

namespace {

nn::Linear Plain(std::int64_t in, std::int64_t out) {
  return nn::Linear(nn::LinearOptions(in, out).bias(false));
}

class MissionState : public StateNet {
 public:
  explicit MissionState(const Shape& shape) {
    const auto conv = [](std::int64_t in, std::int64_t out) {
      return nn::Conv2d(nn::Conv2dOptions(in, out, 3).stride(2).padding(1));
    };
    const auto quarter = [](int n) { return ((n + 1) / 2 + 1) / 2; };
    first_ = register_module("first", conv(kMaps, 16));
    second_ = register_module("second", conv(16, 32));
    last_ = register_module("last",
                            nn::Linear(32 * quarter(shape.rows) * quarter(shape.columns), kHidden));
    scale_ = torch::ones({1, kMaps, 1, 1});
    scale_[0][3] = 1.0F / 32;
  }
  Tensor Encode(const Seen& seen) override {
    const Tensor maps = seen.maps.to(torch::kFloat32) * scale_;
    const Tensor x = torch::relu(second_(torch::relu(first_(maps))));
    return torch::relu(last_(x.flatten(1)));
  }

 private:
  nn::Conv2d first_{nullptr}, second_{nullptr};
  nn::Linear last_{nullptr};
  Tensor scale_;
};

/// The network of one agent class.
class ClassNet : public nn::Module {
 public:
  ClassNet(int agents, bool mean_field) {
    own_ = register_module("own", nn::Linear(kAgentFeatures, kHidden));
    id_ = register_module("id", nn::Embedding(std::max(agents, 1), kHidden));
    state_ = register_module("state", Plain(kHidden, kHidden));
    if (mean_field) mean_ = register_module("mean", Plain(3 * kOptionFeatures, kHidden));
    second_ = register_module("second", nn::Linear(kHidden, kHidden));
    wish_ = register_module("wish", nn::Linear(kHidden, kHidden));
    option_ = register_module("option", Plain(kOptionFeatures, kHidden));
    score_ = register_module("score", nn::Linear(kHidden, 1));
    // The parts of one layer, as if its inputs stood side by side.
    const torch::NoGradGuard guard;
    const double most = 1 / std::sqrt(kAgentFeatures + agents + 2 * kHidden);
    for (const Tensor& weight : {own_->weight, id_->weight, state_->weight}) {
      weight.uniform_(-most, most);
    }
  }

  /// q [R x K], hidden [R x 64]. `mean` [R x 42], or nothing.
  Utilities forward(const Rows& rows, const Tensor& e, const Tensor& mean) {
    Tensor first = own_(rows.own) + id_(rows.id) + state_(e).index_select(0, rows.situation);
    if (mean.defined()) first = first + mean_(mean);
    const Tensor hidden = torch::relu(second_(torch::relu(first)));
    const Tensor layer = torch::relu(wish_(hidden).unsqueeze(1) + option_(rows.features));
    return {score_(layer).squeeze(2), hidden};
  }

 private:
  nn::Linear own_{nullptr}, state_{nullptr}, mean_{nullptr}, second_{nullptr}, wish_{nullptr},
      option_{nullptr}, score_{nullptr};
  nn::Embedding id_{nullptr};
};

class MissionAgents : public AgentNets {
 public:
  MissionAgents(const Shape& shape, bool mean_field) : agents_(shape.n_agents()) {
    classes_ = torch::zeros({3, agents_});
    for (const AgentKind kind : kAgentKinds) {
      const auto i = static_cast<std::size_t>(kind);
      nets_[i] = register_module(std::string(ToString(kind)),
                                 std::make_shared<ClassNet>(shape.agents[kind], mean_field));
      classes_[static_cast<std::int64_t>(i)].narrow(0, shape.first(kind), shape.agents[kind]) = 1;
    }
    if (mean_field) attention_ = register_module("attention", std::make_shared<MeanField>());
  }

  Utilities Value(const Seen& seen, const Tensor& e) override {
    if (!attention_) return Pass(seen, e, {});
    Utilities first;
    Tensor features = torch::zeros({seen.size * agents_, kOptions, kOptionFeatures});
    {
      const torch::NoGradGuard guard;
      first = Pass(seen, e, {});
      for (const Rows& rows : seen.rows) features.index_copy_(0, rows.slot, rows.features);
    }
    features = features.reshape({seen.size, agents_, kOptions, kOptionFeatures});
    return Pass(seen, e,
                attention_->forward(first, seen, features,
                                    Neighbours(seen, seen.at_km, 2 * seen.reach_km), classes_));
  }

 private:
  Utilities Pass(const Seen& seen, const Tensor& e, const Tensor& mean) {
    Tensor q = torch::zeros({seen.size * agents_, kOptions});
    Tensor hidden = torch::zeros({seen.size * agents_, kHidden});
    for (std::size_t i = 0; i < 3; ++i) {
      const Rows& rows = seen.rows[i];
      if (rows.slot.numel() == 0) continue;
      const Tensor of_rows =
          mean.defined() ? mean.flatten(0, 1).index_select(0, rows.slot) : Tensor();
      const Utilities part = nets_[i]->forward(rows, e, of_rows);
      q = q.index_copy(0, rows.slot, part.q);
      hidden = hidden.index_copy(0, rows.slot, part.hidden);
    }
    return {q.reshape({seen.size, agents_, kOptions}),
            hidden.reshape({seen.size, agents_, kHidden})};
  }

  std::int64_t agents_;
  Tensor classes_;
  std::array<std::shared_ptr<ClassNet>, 3> nets_;
  std::shared_ptr<MeanField> attention_;
};

class GameState : public StateNet {
 public:
  Tensor Encode(const Seen& seen) override { return seen.state; }
};

class GameAgents : public AgentNets {
 public:
  GameAgents(std::int64_t agents, std::int64_t options, std::int64_t states, bool mean_field)
      : agents_(agents), options_(options) {
    first_ = register_module("first", nn::Linear(states + agents, kHidden));
    second_ = register_module("second", nn::Linear(kHidden, kHidden));
    last_ = register_module("last", nn::Linear(kHidden, options));
    if (!mean_field) return;
    mean_ = register_module("mean", Plain(options, kHidden));
    attention_ = register_module("attention", std::make_shared<MeanField>());
  }

  Utilities Value(const Seen& seen, const Tensor&) override {
    const Tensor ids = torch::eye(agents_).unsqueeze(0).expand({seen.size, agents_, agents_});
    const Tensor states = seen.state.unsqueeze(1).expand({seen.size, agents_, -1});
    const Tensor input = first_(torch::cat({states, ids}, 2));
    if (!attention_) return Pass(input);
    Utilities first;
    {
      const torch::NoGradGuard guard;
      first = Pass(input);
    }
    const Tensor features = torch::eye(options_)
                                .reshape({1, 1, options_, options_})
                                .expand({seen.size, agents_, -1, -1});
    const Tensor neighbours = (1 - torch::eye(agents_)).unsqueeze(0).expand({seen.size, -1, -1});
    return Pass(input + mean_(attention_->forward(first, seen, features, neighbours,
                                                  torch::ones({1, agents_}))));
  }

 private:
  Utilities Pass(const Tensor& input) {
    const Tensor hidden = torch::relu(second_(torch::relu(input)));
    return {last_(hidden), hidden};
  }

  std::int64_t agents_, options_;
  nn::Linear first_{nullptr}, second_{nullptr}, last_{nullptr}, mean_{nullptr};
  std::shared_ptr<MeanField> attention_;
};

}  // namespace

Tensor Masked(const Tensor& q, const Tensor& available) {
  return q.masked_fill(available.logical_not(), -1e9);
}

MeanField::MeanField() {
  query_ = register_module("query", Plain(kHidden, kAttentionWidth));
  key_ = register_module("key", Plain(kHidden, kAttentionWidth));
}

Tensor MeanField::forward(const Utilities& first, const Seen& seen, const Tensor& features,
                          const Tensor& neighbours, const Tensor& classes) {
  const Tensor policy = torch::softmax(Masked(first.q, seen.available) / kMeanFieldTemperature, 2);
  const Tensor expected = (policy.unsqueeze(3) * features).sum(2);  // [B x N x F]
  const Tensor logits = torch::matmul(query_(first.hidden), key_(first.hidden).transpose(1, 2)) /
                        std::sqrt(static_cast<double>(kAttentionWidth));
  const Tensor among = logits.masked_fill(neighbours == 0, -1e9);
  const Tensor weights = torch::softmax(among, 2) * neighbours;
  std::vector<Tensor> parts;
  for (std::int64_t c = 0; c < classes.size(0); ++c) {
    parts.push_back(torch::matmul(weights * classes[c], expected));
  }
  return torch::cat(parts, 2);
}

Tensor Neighbours(const Seen& seen, const Tensor& at, const Tensor& reach) {
  const Tensor away = (at.unsqueeze(1) - at.unsqueeze(2)).square().sum(3).sqrt();
  const auto n = at.size(1);
  const Tensor others = seen.present.unsqueeze(1) * (1 - torch::eye(n));
  const Tensor near = others * (away <= reach.unsqueeze(2));
  const Tensor alone = (near.sum(2, true) == 0).to(torch::kFloat32);
  return near + alone * others;
}

Problem MissionProblem(const Shape& shape) {
  return {shape.n_agents(), kOptions, kHidden,
          [shape] { return std::make_shared<MissionState>(shape); },
          [shape](bool mean_field) { return std::make_shared<MissionAgents>(shape, mean_field); }};
}

Problem GameProblem(std::int64_t agents, std::int64_t options, std::int64_t states) {
  return {agents, options, states, [] { return std::make_shared<GameState>(); },
          [=](bool mean_field) {
            return std::make_shared<GameAgents>(agents, options, states, mean_field);
          }};
}

Tensors Export(const StateNet& state, const AgentNets& agents) {
  Tensors tensors;
  const auto add = [&](const std::string& prefix, const nn::Module& module) {
    for (const auto& item : module.named_parameters()) {
      const Tensor value = item.value().detach().contiguous();
      auto& tensor = tensors[prefix + item.key()];
      for (const std::int64_t n : value.sizes()) tensor.shape.push_back(static_cast<int>(n));
      tensor.values.assign(value.data_ptr<float>(), value.data_ptr<float>() + value.numel());
    }
  };
  add("state.", state);
  add("", agents);
  return tensors;
}

}  // namespace muster::learning
