#include "scheduler/policies/learned/network.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"
#include "base/index.h"

namespace muster::scheduler::learned {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Row = Eigen::Matrix<float, 1, Eigen::Dynamic>;

constexpr int kMeanField = 3 * kOptionFeatures;

int Halved(int n) { return (n + 1) / 2; }

Eigen::Map<const Matrix> MatrixOf(const Tensors& tensors, const std::string& name) {
  const Tensor& tensor = tensors.at(name);
  const int rows = tensor.shape[0];
  return {tensor.values.data(), rows, static_cast<Eigen::Index>(tensor.values.size()) / rows};
}
Eigen::Map<const Row> RowOf(const Tensors& tensors, const std::string& name) {
  const Tensor& tensor = tensors.at(name);
  return {tensor.values.data(), static_cast<Eigen::Index>(tensor.values.size())};
}

/// 3 x 3, stride 2, padding 1, then ReLU. Input and output [channels x (rows * columns)].
Matrix Convolve(const Matrix& input, int rows, int columns, Eigen::Map<const Matrix> weight,
                Eigen::Map<const Row> bias) {
  const int channels = static_cast<int>(input.rows());
  const int out_rows = Halved(rows), out_columns = Halved(columns);
  Matrix patches = Matrix::Zero(channels * 9, out_rows * out_columns);
  for (int c = 0; c < channels; ++c) {
    for (int i = 0; i < 9; ++i) {
      for (int r = 0; r < out_rows; ++r) {
        const int from_row = 2 * r + i / 3 - 1;
        if (from_row < 0 || from_row >= rows) continue;
        for (int k = 0; k < out_columns; ++k) {
          const int from = 2 * k + i % 3 - 1;
          if (from < 0 || from >= columns) continue;
          patches(c * 9 + i, r * out_columns + k) = input(c, from_row * columns + from);
        }
      }
    }
  }
  Matrix output = weight * patches;
  output.colwise() += bias.transpose();
  return output.cwiseMax(0.0F);
}

Row StateOf(const Tensors& t, const Shape& shape, const Observation& observation) {
  Matrix maps(kMaps, shape.rows * shape.columns);
  for (Eigen::Index i = 0; i < maps.size(); ++i) {
    const float scale = i / maps.cols() == 3 ? 1.0F / 32 : 1.0F;
    maps.data()[i] = static_cast<float>(observation.maps[At(i)]) * scale;
  }
  const Matrix first = Convolve(maps, shape.rows, shape.columns, MatrixOf(t, "state.first.weight"),
                                RowOf(t, "state.first.bias"));
  const Matrix second = Convolve(first, Halved(shape.rows), Halved(shape.columns),
                                 MatrixOf(t, "state.second.weight"), RowOf(t, "state.second.bias"));
  const Eigen::Map<const Row> flat(second.data(), second.size());
  const Row state = flat * MatrixOf(t, "state.last.weight").transpose();
  return (state + RowOf(t, "state.last.bias")).cwiseMax(0.0F);
}

/// What the agents of one kind come to: [agents x 64], [agents][options].
struct KindValues {
  Matrix hidden;
  std::vector<std::array<float, kOptions>> q;
};

KindValues ValuesOfKind(const Tensors& t, const std::string& kind,
                        const std::vector<AgentView>& agents, const Row& state,
                        const Matrix* mean_field) {
  const auto n = static_cast<Eigen::Index>(agents.size());
  KindValues values;
  if (n == 0) return values;
  Matrix own(n, kAgentFeatures);
  for (Eigen::Index i = 0; i < n; ++i) {
    own.row(i) = Eigen::Map<const Row>(agents[At(i)].own.data(), kAgentFeatures);
  }
  const Row of_state = state * MatrixOf(t, kind + ".state.weight").transpose();
  Matrix hidden = own * MatrixOf(t, kind + ".own.weight").transpose();
  hidden.rowwise() += of_state + RowOf(t, kind + ".own.bias");
  const auto ids = MatrixOf(t, kind + ".id.weight");
  for (Eigen::Index i = 0; i < n; ++i) hidden.row(i) += ids.row(agents[At(i)].id);
  if (mean_field != nullptr) {
    hidden += *mean_field * MatrixOf(t, kind + ".mean.weight").transpose();
  }
  hidden = hidden.cwiseMax(0.0F).eval();
  hidden = (hidden * MatrixOf(t, kind + ".second.weight").transpose()).eval();
  hidden.rowwise() += RowOf(t, kind + ".second.bias");
  hidden = hidden.cwiseMax(0.0F).eval();
  Matrix wish = hidden * MatrixOf(t, kind + ".wish.weight").transpose();
  wish.rowwise() += RowOf(t, kind + ".wish.bias");
  const auto of_option = MatrixOf(t, kind + ".option.weight");
  const auto score = RowOf(t, kind + ".score.weight");
  const float bias = RowOf(t, kind + ".score.bias")(0);
  values.q.resize(agents.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Map<const Matrix> features(agents[At(i)].features.front().data(), kOptions,
                                            kOptionFeatures);
    Matrix layer = features * of_option.transpose();
    layer.rowwise() += wish.row(i);
    const Eigen::VectorXf q = layer.cwiseMax(0.0F) * score.transpose();
    for (int k = 0; k < kOptions; ++k) values.q[At(i)][At(k)] = q(k) + bias;
  }
  values.hidden = std::move(hidden);
  return values;
}

/// Expected features of what the agent takes, under softmax(Q / temperature).
Row ExpectedFeatures(const AgentView& agent, const std::array<float, kOptions>& q) {
  float most = -INFINITY;
  for (std::size_t k = 0; k < kOptions; ++k) {
    if (agent.options[k].kind != PlaceOption::Kind::kNone) most = std::max(most, q[k]);
  }
  Row sum = Row::Zero(kOptionFeatures);
  float total = 0;
  for (std::size_t k = 0; k < kOptions; ++k) {
    if (agent.options[k].kind == PlaceOption::Kind::kNone) continue;
    const float weight = std::exp((q[k] - most) / kMeanFieldTemperature);
    sum += weight * Eigen::Map<const Row>(agent.features[k].data(), kOptionFeatures);
    total += weight;
  }
  return sum / total;
}

/// The mean field of every agent, by kind: [agents x 42].
PerKind<Matrix> MeanFields(const Tensors& t, const Observation& observation,
                           const PerKind<KindValues>& values) {
  struct One {
    AgentKind kind;
    const AgentView* view;
    Row key, query, expected;
  };
  const auto query = MatrixOf(t, "attention.query.weight");
  const auto key = MatrixOf(t, "attention.key.weight");
  std::vector<One> all;
  for (const AgentKind kind : kAgentKinds) {
    for (std::size_t i = 0; i < observation.agents[kind].size(); ++i) {
      const AgentView& view = observation.agents[kind][i];
      const auto hidden = values[kind].hidden.row(static_cast<Eigen::Index>(i));
      all.push_back({kind, &view, hidden * key.transpose(), hidden * query.transpose(),
                     ExpectedFeatures(view, values[kind].q[i])});
    }
  }
  PerKind<Matrix> fields;
  for (const AgentKind kind : kAgentKinds) {
    fields[kind] =
        Matrix::Zero(static_cast<Eigen::Index>(observation.agents[kind].size()), kMeanField);
  }
  PerKind<Eigen::Index> next;
  // Neighbours are the agents within a straight distance: what counts is which are seen, not
  // travel.
  for (const One& one : all) {
    const auto neighbours = [&](double reach_m) {
      std::vector<const One*> near;
      for (const One& other : all) {
        if (&other != &one && Distance(one.view->at, other.view->at) <= reach_m) {
          near.push_back(&other);
        }
      }
      return near;
    };
    std::vector<const One*> near = neighbours(2 * one.view->reach_m);
    if (near.empty()) near = neighbours(INFINITY);
    Row field = Row::Zero(kMeanField);
    std::vector<float> logits;
    float most = -INFINITY;
    for (const One* other : near) {
      logits.push_back(one.query.dot(other->key) / std::sqrt(static_cast<float>(kAttentionWidth)));
      most = std::max(most, logits.back());
    }
    float total = 0;
    for (std::size_t j = 0; j < near.size(); ++j) {
      const float weight = std::exp(logits[j] - most);
      total += weight;
      field.segment(static_cast<int>(near[j]->kind) * kOptionFeatures, kOptionFeatures) +=
          weight * near[j]->expected;
    }
    if (total > 0) fields[one.kind].row(next[one.kind]) = field / total;
    ++next[one.kind];
  }
  return fields;
}

}  // namespace

Network::Network(Tensors tensors, const Shape& shape, bool mean_field, const std::string& file)
    : tensors_(std::move(tensors)), shape_(shape), mean_field_(mean_field) {
  const auto expect = [&](const std::string& name, const std::vector<int>& dims) {
    const auto found = tensors_.find(name);
    if (found == tensors_.end()) throw InputError(file, name, "nothing", "a layer");
    if (found->second.shape == dims) return;
    throw InputError(file, name, fmt::format("{}", fmt::join(found->second.shape, " x ")),
                     fmt::format("{}", fmt::join(dims, " x ")));
  };
  expect("state.first.weight", {16, kMaps, 3, 3});
  expect("state.first.bias", {16});
  expect("state.second.weight", {32, 16, 3, 3});
  expect("state.second.bias", {32});
  const int flat = 32 * Halved(Halved(shape.rows)) * Halved(Halved(shape.columns));
  expect("state.last.weight", {64, flat});
  expect("state.last.bias", {64});
  for (const AgentKind kind : kAgentKinds) {
    const std::string k(ToString(kind));
    expect(k + ".own.weight", {64, kAgentFeatures});
    expect(k + ".own.bias", {64});
    expect(k + ".id.weight", {std::max(1, shape.agents[kind]), 64});
    expect(k + ".state.weight", {64, 64});
    if (mean_field) expect(k + ".mean.weight", {64, kMeanField});
    expect(k + ".second.weight", {64, 64});
    expect(k + ".second.bias", {64});
    expect(k + ".wish.weight", {64, 64});
    expect(k + ".wish.bias", {64});
    expect(k + ".option.weight", {64, kOptionFeatures});
    expect(k + ".score.weight", {1, 64});
    expect(k + ".score.bias", {1});
  }
  if (mean_field) {
    expect("attention.query.weight", {kAttentionWidth, 64});
    expect("attention.key.weight", {kAttentionWidth, 64});
  }
}

Values Network::ValuesOf(const Observation& observation) const {
  const Row state = StateOf(tensors_, shape_, observation);
  PerKind<KindValues> values;
  for (const AgentKind kind : kAgentKinds) {
    values[kind] = ValuesOfKind(tensors_, std::string(ToString(kind)), observation.agents[kind],
                                state, nullptr);
  }
  if (mean_field_) {
    const PerKind<Matrix> fields = MeanFields(tensors_, observation, values);
    for (const AgentKind kind : kAgentKinds) {
      values[kind] = ValuesOfKind(tensors_, std::string(ToString(kind)), observation.agents[kind],
                                  state, &fields[kind]);
    }
  }
  Values result;
  for (const AgentKind kind : kAgentKinds) result[kind] = std::move(values[kind].q);
  return result;
}

Choices BestOf(const Observation& observation, const Values& values) {
  Choices choices;
  for (const AgentKind kind : kAgentKinds) {
    for (std::size_t i = 0; i < observation.agents[kind].size(); ++i) {
      const AgentView& view = observation.agents[kind][i];
      std::size_t best = 0;
      for (std::size_t k = 1; k < kOptions; ++k) {
        if (view.options[k].kind != PlaceOption::Kind::kNone &&
            values[kind][i][k] > values[kind][i][best]) {
          best = k;
        }
      }
      choices[kind].push_back(static_cast<int>(best));
    }
  }
  return choices;
}

}  // namespace muster::scheduler::learned
