#pragma once

#include <string>

#include "base/random.h"
#include "scheduler/policies/learned/model.h"

namespace muster::scheduler::testing {

/// A model with numbers by chance, for scenarios of that shape: what it decides makes no sense, and
/// must keep every rule all the same.
inline learned::Model RandomModel(const learned::Shape& shape, std::uint64_t seed,
                                  const std::string& method = "qmix") {
  Random random(seed, Stream::kTest);
  learned::Model model;
  model.method = method;
  model.shape = shape;
  model.preset = "test";
  const auto add = [&](const std::string& name, const std::vector<int>& dims) {
    learned::Tensor tensor;
    tensor.shape = dims;
    std::size_t n = 1;
    for (const int dim : dims) n *= static_cast<std::size_t>(dim);
    for (std::size_t i = 0; i < n; ++i) {
      tensor.values.push_back(static_cast<float>(random.Uniform(-0.2, 0.2)));
    }
    model.tensors[name] = std::move(tensor);
  };
  const auto quarter = [](int n) { return ((n + 1) / 2 + 1) / 2; };
  add("state.first.weight", {16, 6, 3, 3});
  add("state.first.bias", {16});
  add("state.second.weight", {32, 16, 3, 3});
  add("state.second.bias", {32});
  add("state.last.weight", {64, 32 * quarter(shape.rows) * quarter(shape.columns)});
  add("state.last.bias", {64});
  for (const AgentKind kind : kAgentKinds) {
    const std::string k(ToString(kind));
    add(k + ".own.weight", {64, 7});
    add(k + ".own.bias", {64});
    add(k + ".id.weight", {shape.agents[kind], 64});
    add(k + ".state.weight", {64, 64});
    if (method == "mf-qmix") add(k + ".mean.weight", {64, 42});
    add(k + ".second.weight", {64, 64});
    add(k + ".second.bias", {64});
    add(k + ".wish.weight", {64, 64});
    add(k + ".wish.bias", {64});
    add(k + ".option.weight", {64, 14});
    add(k + ".score.weight", {1, 64});
    add(k + ".score.bias", {1});
  }
  if (method == "mf-qmix") {
    add("attention.query.weight", {16, 64});
    add("attention.key.weight", {16, 64});
  }
  return model;
}

}  // namespace muster::scheduler::testing
