#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scheduler/policies/horizon/settings.h"
#include "scheduler/situation.h"

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

  /// Metres that time and, for UAVs, range allow from ready_us on, and a little more.
  double reach_m() const;
};

/// The agents that take part, by AgentKind.
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
AgentKind PartnerKindOf(const Match& match);
Point PlaceOf(const Site& site, const Match& match);

/// What a UAV may expect of the tasks that are open to a matching.
struct Outlook {
  double open_tasks = 1;  ///< at least 1
  double cost_m = 0;      ///< mean
  double way_m = 0;       ///< mean distance between them
};

/// What is open to a matching: tasks, and places at charging points.
struct OpenSites {
  std::vector<char> task;           ///< [n_tasks]
  std::vector<std::int32_t> place;  ///< [n_charging_points] free places
  /// Of the whole area, where the above is a part of it.
  std::optional<Outlook> outlook = {};
};
Outlook OutlookOf(const Situation& situation, const OpenSites& open);
OpenSites OpenSitesOf(const Situation& situation);

/// The heaviest set of pairs in which no agent, task or place is used twice, or with
/// `settings.radio` what the agents agree on. Sorted by UAV.
/// `candidates`, when given, takes the number of pairs to choose from. threads: 1 or 2; the result
/// does not depend on it.
std::vector<Match> HeaviestPairs(const Situation& situation, const Participants& participants,
                                 const OpenSites& open, const HorizonSettings& settings,
                                 int threads = 1, std::int64_t* candidates = nullptr);

}  // namespace muster::scheduler
