#pragma once

#include <cstdint>
#include <vector>

#include "scheduler/policies/horizon/settings.h"
#include "scheduler/situation.h"
#include "scheduler/solver/instance.h"

namespace muster::scheduler {

/// An agent as a matching sees it: where and from which decision on it can be commanded.
struct Participant {
  const AgentState* agent = nullptr;
  Point at;
  TimeUs ready_us = 0;   ///< time of a decision, now or later
  TimeUs latest_us = 0;  ///< its actions must have ended
  TimeUs until_us = 0;   ///< it can be commanded before
  double range_m = 0;    ///< UAVs, at ready_us
  bool idle = false;     ///< can be commanded now
};

/// Who takes part, by AgentKind.
using Participants = PerKind<std::vector<Participant>>;

/// Time of the first decision at or after t.
TimeUs DecisionAfter(TimeUs t, TimeUs interval_us);

/// The idle agents and, with `settings.soon_idle`, those that will be free, and still online, at
/// one of the next decisions.
Participants ParticipantsOf(const Situation& situation, const HorizonSettings& settings);

/// A pair that a matching made. Members are indices into the participants.
struct Match {
  bool charging = false;
  std::int32_t uav = -1;
  std::int32_t partner = -1;  ///< worker, or vehicle when charging
  std::int32_t site = -1;     ///< task or charging point id
  double weight = 0;
  TimeUs end_us = 0;
};

/// What is open to a matching: tasks, and places at charging points.
struct OpenSites {
  std::vector<char> task;           ///< [n_tasks]
  std::vector<std::int32_t> place;  ///< [n_charging_points] free places
};
OpenSites OpenSitesOf(const Situation& situation);

/// The pairs that a matching chooses from, as a way of each member to each place: an instance in
/// which nobody goes alone. A pair's weight is its worth, in tasks.
struct PairInstance {
  Instance instance;                   ///< partners: workers, then vehicles
  std::vector<std::int32_t> site_ids;  ///< [n_sites] ids of open tasks, then of charging points
  std::int32_t n_tasks = 0;            ///< of the sites
  std::int32_t n_workers = 0;          ///< of the partners
};
PairInstance PairsToMatch(const Situation& situation, const Participants& participants,
                          const OpenSites& open, const HorizonSettings& settings);

/// The pair of two arcs of a site.
Match MatchOf(const PairInstance& pairs, const Participants& participants, std::int32_t site,
              const Instance::UavArc& uav, const Instance::PartnerArc& partner);
/// The pairs of an assignment, by UAV.
std::vector<Match> MatchesOf(const PairInstance& pairs, const Participants& participants,
                             const Assignment& assignment);

/// The chance's part (HorizonSettings::jitter) in the worth of a UAV, or worker, at a task.
double JitterOf(const Situation& situation, const HorizonSettings& settings, AgentKind kind,
                std::int32_t id, std::int32_t task);

/// The heaviest set of pairs in which nobody, no task and no place is used twice. Sorted by UAV.
/// `candidates`, when given, takes the number of pairs to choose from.
std::vector<Match> HeaviestPairs(const Situation& situation, const Participants& participants,
                                 const OpenSites& open, const HorizonSettings& settings,
                                 std::int64_t* candidates = nullptr);

}  // namespace muster::scheduler
