#include "learning/episode.h"

#include <algorithm>
#include <utility>

#include "base/index.h"
#include "learning/practice_mission.h"

namespace muster::learning {

using scheduler::learned::ActionsOf;
using scheduler::learned::Choices;
using scheduler::learned::kOptions;
using scheduler::learned::Network;
using scheduler::learned::Observation;
using scheduler::learned::PlaceOption;
using scheduler::learned::Shape;
using scheduler::learned::Urgency;

namespace {

/// Options at random with that probability.
void Explore(const Observation& observation, double share, Random* random, Choices* choices) {
  for (const AgentKind kind : kAgentKinds) {
    for (std::size_t i = 0; i < observation.agents[kind].size(); ++i) {
      if (random->Uniform() >= share) continue;
      std::vector<int> open;
      for (int k = 0; k < kOptions; ++k) {
        const PlaceOption& option = observation.agents[kind][i].options[At(k)];
        if (option.kind != PlaceOption::Kind::kNone) open.push_back(k);
      }
      (*choices)[kind][i] = open[random->Below(static_cast<std::uint32_t>(open.size()))];
    }
  }
}

/// Notes what the actions earn.
void Reward(const scheduler::Situation& situation, const std::vector<Action>& actions,
            TimeUs limit_us, Turn* turn) {
  const auto find = [](const std::vector<AgentState>& agents, std::int32_t id) {
    return *std::find_if(agents.begin(), agents.end(),
                         [id](const AgentState& agent) { return agent.id == id; });
  };
  for (const Action& action : actions) {
    if (!IsPair(action.kind)) continue;
    AgentState uav = find(situation.uavs, action.uav.value);
    const double range = situation.range_m(uav);
    if (action.kind == ActionKind::kCharge) {
      turn->charge_gain += static_cast<float>(Urgency(uav, range) - Urgency(uav, uav.range_full_m));
      continue;
    }
    AgentState worker = find(situation.workers, action.worker.value);
    for (AgentState* agent : {&uav, &worker}) {
      Begin(agent, action, situation.decision, situation.now_us, Disturbances(), 0);
    }
    turn->reward +=
        PlanActivity(uav, worker, situation.site->tasks).end_us <= limit_us ? 1.0F : 0.0F;
  }
}

}  // namespace

Episode PlayEpisode(const Scenario& scenario, const Shape& shape, const Network* network,
                    double random_share, Random random, bool keep_turns) {
  PracticeMission mission(scenario);
  Episode episode;
  while (!mission.over()) {
    Turn turn;
    turn.observation = Observe(mission.situation(), shape);
    if (network != nullptr) {
      turn.choices = BestOf(turn.observation, network->ValuesOf(turn.observation));
    } else {
      for (const AgentKind kind : kAgentKinds) {
        turn.choices[kind].assign(turn.observation.agents[kind].size(), 0);
      }
    }
    if (random_share > 0) Explore(turn.observation, random_share, &random, &turn.choices);
    const auto actions = ActionsOf(mission.situation(), turn.observation, turn.choices);
    if (keep_turns) Reward(mission.situation(), actions, scenario.rules.limit_us, &turn);
    mission.Step(actions);
    if (keep_turns) episode.turns.push_back(std::move(turn));
  }
  episode.completion =
      static_cast<double>(mission.done()) / static_cast<double>(scenario.tasks.size());
  return episode;
}

}  // namespace muster::learning
