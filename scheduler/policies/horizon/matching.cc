#include "scheduler/policies/horizon/matching.h"

#include <algorithm>

#include "base/index.h"
#include "model/feasibility.h"
#include "scheduler/policies/horizon/pairs.h"
#include "scheduler/policies/neighbours/game.h"
#include "scheduler/solver/solver.h"

namespace muster::scheduler {

TimeUs DecisionAfter(TimeUs t, TimeUs interval_us) {
  return (t + interval_us - 1) / interval_us * interval_us;
}

Participants ParticipantsOf(const Situation& situation, const HorizonSettings& settings) {
  Participants participants;
  const Rules& rules = situation.site->rules;
  for (const AgentKind kind : kAgentKinds) {
    for (const AgentState& agent : situation.agents(kind)) {
      Participant participant;
      participant.agent = &agent;
      participant.idle = agent.idle(situation.now_us);
      participant.until_us = std::min(agent.online_until_us, rules.limit_us);
      // Even where an action may overrun its agents' time, what ends after the limit is lost.
      participant.latest_us = std::min(LatestEnd(agent, rules), rules.limit_us);
      if (participant.idle) {
        participant.at = agent.to;
        participant.ready_us = situation.now_us;
        participant.range_m = situation.range_m(agent);
      } else {
        if (!settings.soon_idle || agent.failed || agent.busy_until_us == kNever) continue;
        participant.at = agent.to;
        participant.ready_us = DecisionAfter(agent.busy_until_us, rules.interval_us);
        if (participant.ready_us - situation.now_us > settings.soon_decisions * rules.interval_us ||
            participant.ready_us >= rules.limit_us || !agent.online(participant.ready_us)) {
          continue;
        }
        participant.range_m = RangeAt(agent, agent.busy_until_us, situation.site->tasks);
      }
      participants[kind].push_back(participant);
    }
  }
  return participants;
}

OpenSites OpenSitesOf(const Situation& situation) {
  OpenSites open;
  for (const TaskStatus status : situation.task_status) {
    open.task.push_back(status == TaskStatus::kOpen ? 1 : 0);
  }
  for (std::size_t y = 0; y < situation.site->charging_points.size(); ++y) {
    open.place.push_back(situation.free_places(ChargeId(y)));
  }
  return open;
}

std::vector<Match> HeaviestPairs(const Situation& situation, const Participants& participants,
                                 const OpenSites& open, const HorizonSettings& settings,
                                 int threads, std::int64_t* candidates) {
  const PossiblePairs pairs = FindPairs(situation, participants, open, settings, threads);
  if (settings.radio) {
    return AgreeOnPairs(situation, participants, pairs, *settings.radio, candidates);
  }
  if (candidates != nullptr) *candidates = CountNodes(pairs.instance, threads);
  SolverLimits limits;
  limits.threads = threads;
  return MatchesOf(pairs, participants, Solve(pairs.instance, limits).assignment);
}

}  // namespace muster::scheduler
