#include "scheduler/policy.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace muster::scheduler {

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

}  // namespace muster::scheduler
