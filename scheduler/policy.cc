#include "scheduler/policy.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "scheduler/policies/paper_policies.h"
#include "world/model/check.h"

namespace muster::scheduler {
namespace {

/// One row a policy: its name, what users read about it, how to make it.
struct Row {
  PolicyInfo info;
  std::unique_ptr<Policy> (*make)();
};

const Row kPolicies[] = {
    {{"mpq", "HoCs-MPQ: iterated local search on a growing subgraph (paper, Alg. 5)"},
     [] { return std::unique_ptr<Policy>(new MpqPolicy(Foundation::kHierarchical)); }},
    {{"mpq-uniform", "HoCs-MPQ with uniform foundational weights (paper, section 5.3.3)"},
     [] { return std::unique_ptr<Policy>(new MpqPolicy(Foundation::kUniform)); }},
    {{"ils", "HoCs-ILS: iterated local search on the whole graph (paper, Alg. 2)"},
     [] { return std::unique_ptr<Policy>(new IlsPolicy()); }},
};

}  // namespace

Decision MakeDecision(std::vector<Action> actions, std::int64_t candidates) {
  Decision decision;
  decision.candidates = candidates;
  decision.actions = std::move(actions);
  const auto key = [](const Action& a) {
    return std::tuple(a.kind, a.uav, a.worker, a.vehicle, a.task, a.charge);
  };
  std::sort(decision.actions.begin(), decision.actions.end(),
            [&key](const Action& a, const Action& b) { return key(a) < key(b); });
  for (const Action& action : decision.actions) decision.weight += action.weight;
  return decision;
}

const std::vector<PolicyInfo>& Policies() {
  static const std::vector<PolicyInfo> policies = [] {
    std::vector<PolicyInfo> list;
    for (const Row& row : kPolicies) list.push_back(row.info);
    return list;
  }();
  return policies;
}

std::unique_ptr<Policy> MakePolicy(std::string_view name) {
  std::string known;
  for (const Row& row : kPolicies) {
    if (row.info.name == name) return row.make();
    if (!known.empty()) known += ", ";
    known += row.info.name;
  }
  throw InputError(fmt::format("policy: found {}, expected one of {}", name, known));
}

}  // namespace muster::scheduler
