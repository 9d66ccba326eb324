#include "scheduler/policies/baselines/without_roads.h"

#include <set>
#include <vector>

#include "scheduler/checker.h"

namespace muster::scheduler {

Decision WithoutRoadsPolicy::Decide(const Situation& situation) {
  auto site = std::make_shared<Site>(*situation.site);
  site->ways = {&StraightWays(), [](const Ways*) {}};
  site->open_roads = nullptr;
  Situation straight = situation;
  straight.site = std::move(site);
  for (std::vector<AgentState>* agents : {&straight.uavs, &straight.workers, &straight.vehicles}) {
    for (AgentState& agent : *agents) agent.ways = agent.leg_ways = &StraightWays();
  }
  const Decision decided = policy_->Decide(straight);
  std::set<std::size_t> broken;
  for (const Violation& violation : CheckActions(situation, decided.actions)) {
    broken.insert(violation.action);
  }
  std::vector<Action> kept;
  for (std::size_t i = 0; i < decided.actions.size(); ++i) {
    if (!broken.contains(i)) kept.push_back(decided.actions[i]);
  }
  return MakeDecision(std::move(kept), decided.candidates);
}

}  // namespace muster::scheduler
