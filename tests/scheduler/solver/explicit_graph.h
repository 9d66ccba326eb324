#pragma once

#include <coin/Cbc_C_Interface.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/random.h"
#include "scheduler/solver/instance.h"

namespace muster::scheduler::testing {

/// A node written out: its weight and the elements that it uses (UAVs, then partners, then sites).
struct ExplicitNode {
  double weight = 0;
  std::array<std::int32_t, 3> elements = {-1, -1, -1};
};

inline std::vector<ExplicitNode> ExplicitNodes(const Instance& instance) {
  std::vector<ExplicitNode> nodes;
  const std::int32_t nu = instance.n_uavs(), np = instance.n_partners();
  for (std::int32_t u = 0; u < nu; ++u) {
    nodes.push_back({instance.uavs[static_cast<std::size_t>(u)].stay, {u, -1, -1}});
  }
  for (std::int32_t p = 0; p < np; ++p) {
    nodes.push_back({instance.partners[static_cast<std::size_t>(p)].stay, {-1, nu + p, -1}});
  }
  for (std::int32_t s = 0; s < instance.n_sites(); ++s) {
    const auto at = static_cast<std::size_t>(s);
    for (auto i = instance.uav_begin[at]; i < instance.uav_begin[at + 1]; ++i) {
      const auto& uav = instance.uav_arcs[static_cast<std::size_t>(i)];
      if (uav.solo != Instance::kNone) nodes.push_back({uav.solo, {uav.uav, -1, nu + np + s}});
      if (uav.pair_gain == Instance::kNone) continue;
      for (auto j = instance.partner_begin[at]; j < instance.partner_begin[at + 1]; ++j) {
        const auto& partner = instance.partner_arcs[static_cast<std::size_t>(j)];
        if (!instance.Compatible(uav, partner)) continue;
        nodes.push_back(
            {Instance::PairWeight(uav, partner), {uav.uav, nu + partner.partner, nu + np + s}});
      }
    }
    for (auto j = instance.partner_begin[at]; j < instance.partner_begin[at + 1]; ++j) {
      const auto& partner = instance.partner_arcs[static_cast<std::size_t>(j)];
      if (partner.solo) nodes.push_back({partner.gain, {-1, nu + partner.partner, nu + np + s}});
    }
  }
  return nodes;
}

inline std::vector<std::int32_t> Capacities(const Instance& instance) {
  std::vector<std::int32_t> capacity(instance.uavs.size() + instance.partners.size(), 1);
  capacity.insert(capacity.end(), instance.capacity.begin(), instance.capacity.end());
  return capacity;
}

/// The optimum by trying every node of every agent; small instances only.
class BruteForce {
 public:
  explicit BruteForce(const Instance& instance)
      : nodes_(ExplicitNodes(instance)), left_(Capacities(instance)) {
    n_agents_ = instance.n_uavs() + instance.n_partners();
    of_agent_.resize(static_cast<std::size_t>(n_agents_));
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const auto& e = nodes_[k].elements;
      of_agent_[static_cast<std::size_t>(e[0] >= 0 ? e[0] : e[1])].push_back(k);
    }
  }
  double Best() { return Best(0); }

 private:
  double Best(std::int32_t agent) {
    if (agent == n_agents_) return 0;
    // A partner that a UAV took along needs no node of its own.
    double best = left_[static_cast<std::size_t>(agent)] == 0 ? Best(agent + 1) : -1e300;
    for (const std::size_t k : of_agent_[static_cast<std::size_t>(agent)]) {
      bool free = true;
      for (const std::int32_t e : nodes_[k].elements) {
        free = free && (e < 0 || left_[static_cast<std::size_t>(e)] > 0);
      }
      if (!free) continue;
      for (const std::int32_t e : nodes_[k].elements) {
        if (e >= 0) --left_[static_cast<std::size_t>(e)];
      }
      best = std::max(best, nodes_[k].weight + Best(agent + 1));
      for (const std::int32_t e : nodes_[k].elements) {
        if (e >= 0) ++left_[static_cast<std::size_t>(e)];
      }
    }
    return best;
  }

  std::vector<ExplicitNode> nodes_;
  std::vector<std::int32_t> left_;
  std::int32_t n_agents_ = 0;
  std::vector<std::vector<std::size_t>> of_agent_;
};

/// What CBC is asked for: the packing problem itself or its linear relaxation.
enum class Nodes { kWhole, kShared };

/// The optimum by COIN-OR CBC on the explicit packing problem; none when it proves none within
/// `seconds`.
inline std::optional<double> CbcOptimum(const Instance& instance, double seconds,
                                        Nodes shares = Nodes::kWhole) {
  const std::vector<ExplicitNode> nodes = ExplicitNodes(instance);
  const std::vector<std::int32_t> capacity = Capacities(instance);
  std::vector<CoinBigIndex> start = {0};
  std::vector<int> row;
  std::vector<double> weight;
  for (const ExplicitNode& node : nodes) {
    for (const std::int32_t e : node.elements) {
      if (e >= 0) row.push_back(e);
    }
    start.push_back(static_cast<CoinBigIndex>(row.size()));
    weight.push_back(node.weight);
  }
  const std::vector<double> ones(row.size(), 1), low(nodes.size(), 0), high(nodes.size(), 1);
  const std::vector<double> row_low(capacity.size(), -1e30);
  const std::vector<double> row_high(capacity.begin(), capacity.end());
  Cbc_Model* model = Cbc_newModel();
  Cbc_setLogLevel(model, 0);
  Cbc_loadProblem(model, static_cast<int>(nodes.size()), static_cast<int>(capacity.size()),
                  start.data(), row.data(), ones.data(), low.data(), high.data(), weight.data(),
                  row_low.data(), row_high.data());
  Cbc_setObjSense(model, -1);
  for (int c = 0; shares == Nodes::kWhole && c < static_cast<int>(nodes.size()); ++c) {
    Cbc_setInteger(model, c);
  }
  Cbc_setAllowableGap(model, 1e-9);
  Cbc_setAllowableFractionGap(model, 0);
  Cbc_setMaximumSeconds(model, seconds);
  Cbc_solve(model);
  std::optional<double> optimum;
  if (Cbc_isProvenOptimal(model)) optimum = Cbc_getObjValue(model);
  Cbc_deleteModel(model);
  return optimum;
}

/// A random instance that need not come from any situation: weights on a coarse scale so that they
/// tie, windows that forbid some pairs, sites with several places.
inline Instance RandomInstance(std::uint64_t seed, int uavs, int partners, int sites) {
  Random random(seed, Stream::kTest);
  const auto below = [&](int n) {
    return static_cast<int>(random.Below(static_cast<std::uint32_t>(n)));
  };
  const int kind = below(4);  // 0: equal weights, 1: coarse, else fine
  const auto weigh = [&](double most) {
    return kind == 0 ? most : kind == 1 ? most * below(4) / 3 : most * random.Uniform();
  };
  const int density = 1 + below(4);
  Instance instance;
  for (int u = 0; u < uavs; ++u) {
    instance.uavs.push_back({0.7, below(3) == 0 ? 40 + below(60) : kNever});
  }
  for (int p = 0; p < partners; ++p) {
    instance.partners.push_back({0.7, below(3) == 0 ? 40 + below(60) : kNever, 1.0 + below(3)});
  }
  instance.uav_begin = instance.partner_begin = {0};
  for (int s = 0; s < sites; ++s) {
    instance.capacity.push_back(below(4) == 0 ? 1 + below(3) : 1);
    const bool charging = below(3) == 0;
    for (int u = 0; u < uavs; ++u) {
      if (below(5) >= density) continue;
      Instance::UavArc arc;
      arc.uav = u;
      arc.level = 1 + below(3);
      if (below(4) != 0) arc.solo = weigh(1.3);
      arc.base = charging ? 10 + weigh(2) : 100;
      if (arc.solo == Instance::kNone || below(4) != 0) arc.pair_gain = weigh(1.3);
      arc.arrive_us = below(50);
      arc.duration_us = below(30);
      arc.missing_m = charging ? below(30) * 1e-6 : -1;
      instance.uav_arcs.push_back(arc);
    }
    for (int level = 1; level <= 3; ++level) {
      for (int p = 0; p < partners; ++p) {
        if (p % 3 != (s + level) % 3 || below(5) >= density) continue;
        instance.partner_arcs.push_back({p, level, weigh(1.3), below(50), below(4) != 0});
      }
    }
    instance.uav_begin.push_back(static_cast<std::int32_t>(instance.uav_arcs.size()));
    instance.partner_begin.push_back(static_cast<std::int32_t>(instance.partner_arcs.size()));
  }
  return instance;
}

}  // namespace muster::scheduler::testing
