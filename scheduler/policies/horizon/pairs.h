#pragma once

#include <cstdint>
#include <vector>

#include "scheduler/policies/horizon/matching.h"
#include "scheduler/policies/horizon/settings.h"
#include "scheduler/situation.h"
#include "scheduler/solver/instance.h"

namespace muster::scheduler {

/// The pairs that a matching chooses from, as an Instance without lone actions: its partners
/// are the workers, then the vehicles; its sites the open tasks, then the charging points with a
/// free place. A pair's weight is its worth, in tasks.
struct PossiblePairs {
  Instance instance;
  std::vector<std::int32_t> site_ids;  ///< [n_sites] task or charging point
  std::int32_t n_tasks = 0;            ///< sites that are tasks
  std::int32_t n_workers = 0;          ///< partners that are workers
};

/// The agents that could meet at each site. Ways that end too late with any partner are left out,
/// which only makes the instance smaller: Instance::Compatible refuses every pair that ends too
/// late. The search looks for agents near each site, so its cost is that of the ways found.
/// threads: 1 or 2; the result does not depend on it.
PossiblePairs FindPairs(const Situation& situation, const Participants& participants,
                        const OpenSites& open, const HorizonSettings& settings, int threads = 1);

/// The pair of two arcs of a site.
Match MatchOf(const PossiblePairs& pairs, const Participants& participants, std::int32_t site,
              const Instance::UavArc& uav, const Instance::PartnerArc& partner);
/// The pairs of an assignment, by UAV.
std::vector<Match> MatchesOf(const PossiblePairs& pairs, const Participants& participants,
                             const Assignment& assignment);

/// The chance's part (HorizonSettings::jitters) in the worth of a UAV, or worker, at a task.
double JitterOf(const Situation& situation, const HorizonSettings& settings, AgentKind kind,
                std::int32_t id, std::int32_t task);

}  // namespace muster::scheduler
