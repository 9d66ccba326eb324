#pragma once

#include <vector>

#include "base/random.h"
#include "model/scenario.h"
#include "scheduler/policies/learned/network.h"

namespace muster::learning {

/// One decision of a practice mission.
struct Turn {
  scheduler::learned::Observation observation;
  scheduler::learned::Choices choices;
  float reward = 0;       ///< tasks whose sensing it commands and that end within the limit
  float charge_gain = 0;  ///< urgency that the charging which it commands takes away
};

struct Episode {
  std::vector<Turn> turns;  ///< empty where they are not kept
  double completion = 0;    ///< share of the tasks that get done
};

/// Plays a mission with the network's best choices (none: everybody stays), of which a share, each
/// agent by itself, is drawn from what it may choose.
Episode PlayEpisode(const Scenario& scenario, const scheduler::learned::Shape& shape,
                    const scheduler::learned::Network* network, double random_share, Random random,
                    bool keep_turns);

}  // namespace muster::learning
