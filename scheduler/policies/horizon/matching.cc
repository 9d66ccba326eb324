#include "scheduler/policies/horizon/matching.h"

#include <algorithm>
#include <cmath>

#include "base/index.h"
#include "model/feasibility.h"
#include "scheduler/neighbourhood.h"
#include "scheduler/policies/horizon/pairs.h"
#include "scheduler/policies/horizon/regions.h"
#include "scheduler/policies/neighbours/game.h"
#include "scheduler/solver/solver.h"

namespace muster::scheduler {
namespace {

/// From so many UAVs on, a matching is made by region, of about so many UAVs each.
constexpr std::size_t kManyUavs = 2400, kRegionUavs = 600;

}  // namespace

double Participant::reach_m() const {
  const double reach_m = ToSeconds(latest_us - ready_us) * agent->speed_m_s * (1 + 1e-9) + 1;
  return agent->kind == AgentKind::kUav ? std::min(reach_m, range_m) : reach_m;
}

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
    if (ByNeighbourhood(situation)) {
      Neighbourhoods(*situation.site).Sort(&participants[kind], [](const Participant& participant) {
        return participant.at;
      });
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

AgentKind PartnerKindOf(const Match& match) {
  return match.charging ? AgentKind::kVehicle : AgentKind::kWorker;
}

Point PlaceOf(const Site& site, const Match& match) {
  return match.charging ? site.charging_points[At(match.site)].at : site.tasks[At(match.site)].at;
}

Outlook OutlookOf(const Situation& situation, const OpenSites& open) {
  if (open.outlook) return *open.outlook;
  const Site& site = *situation.site;
  double n = 0, cost_m = 0;
  for (std::size_t x = 0; x < site.tasks.size(); ++x) {
    if (!open.task[x]) continue;
    ++n;
    cost_m += site.tasks[x].cost_m;
  }
  Outlook outlook;
  outlook.open_tasks = std::max(1.0, n);
  outlook.cost_m = cost_m / outlook.open_tasks;
  outlook.way_m = std::sqrt(site.width_m * site.height_m / outlook.open_tasks);
  return outlook;
}

std::vector<Match> HeaviestPairs(const Situation& situation, const Participants& participants,
                                 const OpenSites& open, const HorizonSettings& settings,
                                 int threads, std::int64_t* candidates) {
  const std::size_t n_uavs = participants.uavs.size();
  if (!settings.radio && n_uavs >= kManyUavs) {
    std::size_t n = 1;
    while ((n + 1) * (n + 1) * kRegionUavs <= n_uavs) ++n;
    // Where many regions do not suit, few may: the whole takes the most time and memory.
    for (; n > 1; n = n == 2 ? 1 : (n + 1) / 2) {
      if (auto matches =
              PairsByRegion(situation, participants, open, settings, n, threads, candidates)) {
        return std::move(*matches);
      }
    }
  }
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
