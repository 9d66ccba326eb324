#pragma once

#include <cstdint>
#include <vector>

#include "scheduler/policies/horizon/pairs.h"

namespace muster::scheduler {

/// The pairs that agents agree on among themselves, without a centre. Each agent knows the sites
/// and what it hears of others within `radio.reach_m`; a message is lost with `radio.loss`
/// (Stream::kPolicy, keyed by decision, exchange, round, speaker and listener).
///
/// One round: everybody says which pair it is in. Each UAV proposes to one partner the site at
/// which the two gain most by what it has heard: their pair's weight, less that of the pairs which
/// must give way (its own, the partner's, those that hold the site's last place). A partner accepts
/// the proposal with the highest gain, then the lower UAV. Of new pairs at one site that hear of
/// each other those with the highest gain stand. The rounds end when nobody proposes, or after 40.
/// Pairs that are too many for a site and never heard of each other ask for it at last: the
/// heaviest count, the others stay. Each accepted round raises the sum of the weights as far as the
/// agents know it, so without losses and with a reach over the whole area the result is a Nash
/// equilibrium: no UAV and partner gain by moving to another site.
///
/// Sorted by UAV. `candidates`, when given, takes the number of possible proposals. Cost: that
/// number, and the rounds' look at those that can gain. Source: ours, after the local game of
/// HoAs-PALN (arXiv 2506.04276).
std::vector<Match> AgreeOnPairs(const Situation& situation, const Participants& participants,
                                const PossiblePairs& pairs, const Radio& radio,
                                std::int64_t* candidates = nullptr);

}  // namespace muster::scheduler
