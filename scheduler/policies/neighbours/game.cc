#include "scheduler/policies/neighbours/game.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "base/grid_index.h"
#include "base/index.h"
#include "base/random.h"
#include "model/agent.h"

namespace muster::scheduler {
namespace {

constexpr int kMostRounds = 40;
/// With losses, silence may mean that proposals were lost.
constexpr int kQuietRounds = 3;
/// A pair looks at its best sites only, so that memory stays bounded where everybody hears
/// everybody.
constexpr std::size_t kMostSites = 32;
constexpr double kLeastGain = 1e-9;

/// What is said in a round, in this order.
enum class Word : std::uint64_t { kPlan, kProposal, kAnswer };

class Air {
 public:
  Air(const Situation& situation, const Participants& participants, const Radio& radio)
      : situation_(situation), radio_(radio) {
    for (const AgentKind kind : kAgentKinds) {
      for (const Participant& participant : participants[kind]) {
        voices_.push_back({PositionAt(*participant.agent, situation.now_us),
                           static_cast<std::uint64_t>(kind) << 26 |
                               static_cast<std::uint64_t>(participant.agent->id)});
      }
    }
  }

  Point place(std::size_t agent) const { return voices_[agent].at; }
  std::size_t size() const { return voices_.size(); }

  bool Hears(std::size_t listener, std::size_t speaker, Word word, int round) const {
    if (Distance(place(listener), place(speaker)) > radio_.reach_m) return false;
    if (radio_.loss <= 0) return true;
    const auto said = static_cast<std::uint64_t>(round) * 3 + static_cast<std::uint64_t>(word);
    const std::uint64_t message = static_cast<std::uint64_t>(radio_.exchange) << 63 | said << 56 |
                                  voices_[speaker].name << 28 | voices_[listener].name;
    return Random(situation_.site->seed, Stream::kPolicy, message,
                  static_cast<std::uint32_t>(situation_.decision))
               .Uniform() >= radio_.loss;
  }

 private:
  struct Voice {
    Point at;
    std::uint64_t name;  ///< 28 bits
  };
  const Situation& situation_;
  const Radio radio_;
  std::vector<Voice> voices_;  ///< UAVs, then partners, as in the Instance
};

/// A pair that a UAV may propose.
struct Offer {
  double weight = 0;
  std::int32_t partner = -1, site = -1;
  std::int32_t uav_arc = -1, partner_arc = -1;
};

struct Proposal {
  std::int32_t uav = -1;
  const Offer* offer = nullptr;
  double gain = 0;
  std::vector<std::int32_t> give_way;  ///< UAVs whose pairs end
};

class Game {
 public:
  Game(const Situation& situation, const Participants& participants, const PossiblePairs& pairs,
       const Radio& radio)
      : participants_(participants),
        pairs_(pairs),
        instance_(pairs.instance),
        radio_(radio),
        air_(situation, participants, radio),
        n_uavs_(instance_.uavs.size()),
        held_(n_uavs_, nullptr),
        uav_of_(instance_.partners.size(), -1),
        at_site_(instance_.capacity.size()) {
    FindOffers();
  }

  std::int64_t candidates() const {
    return std::accumulate(offers_.begin(), offers_.end(), std::int64_t{0},
                           [](std::int64_t sum, const std::vector<Offer>& offers) {
                             return sum + static_cast<std::int64_t>(offers.size());
                           });
  }

  std::vector<Match> Play() {
    const int patience = radio_.loss > 0 ? kQuietRounds : 1;
    for (int round = 0, quiet = 0; round < kMostRounds && quiet < patience; ++round) {
      std::vector<Proposal> proposals = Propose(round);
      quiet = proposals.empty() ? quiet + 1 : 0;
      Agree(Settle(Accept(std::move(proposals), round), round));
    }
    AskForSites();
    std::vector<Match> matches;
    for (const Offer* offer : held_) {
      if (offer == nullptr) continue;
      matches.push_back(MatchOf(pairs_, participants_, offer->site,
                                instance_.uav_arcs[At(offer->uav_arc)],
                                instance_.partner_arcs[At(offer->partner_arc)]));
    }
    return matches;
  }

 private:
  std::size_t VoiceOfPartner(std::int32_t partner) const { return n_uavs_ + At(partner); }

  /// What each UAV could propose to the partners within reach, best first.
  void FindOffers() {
    const ArcsByAgent uav_arcs = UavArcsOf(instance_), partner_arcs = PartnerArcsOf(instance_);
    std::vector<Point> places;
    for (std::size_t i = n_uavs_; i < air_.size(); ++i) places.push_back(air_.place(i));
    const GridIndex index(places);
    offers_.resize(n_uavs_);
    std::vector<Offer> of_pair;
    for (std::size_t u = 0; u < n_uavs_; ++u) {
      const auto ways = uav_arcs.of(static_cast<std::int32_t>(u));
      index.Within(air_.place(u), radio_.reach_m, [&](std::int32_t partner, Point, double) {
        OffersOf(ways, partner, partner_arcs.of(partner), &of_pair);
        offers_[u].insert(offers_[u].end(), of_pair.begin(), of_pair.end());
      });
      std::sort(offers_[u].begin(), offers_[u].end(), [](const Offer& a, const Offer& b) {
        if (a.weight != b.weight) return a.weight > b.weight;
        return std::pair(a.site, a.partner) < std::pair(b.site, b.partner);
      });
    }
  }

  using SiteArcs = std::span<const std::pair<std::int32_t, std::int32_t>>;
  void OffersOf(SiteArcs uav, std::int32_t partner, SiteArcs other, std::vector<Offer>* out) const {
    out->clear();
    auto it = other.begin();
    for (const auto& [site, arc] : uav) {
      while (it != other.end() && it->first < site) ++it;
      if (it == other.end()) break;
      if (it->first != site) continue;
      const Instance::UavArc& u = instance_.uav_arcs[At(arc)];
      const Instance::PartnerArc& p = instance_.partner_arcs[At(it->second)];
      const double weight = Instance::PairWeight(u, p);
      if (weight > kLeastGain && instance_.Compatible(u, p)) {
        out->push_back({weight, partner, site, arc, it->second});
      }
    }
    if (out->size() <= kMostSites) return;
    std::nth_element(out->begin(), out->begin() + kMostSites, out->end(),
                     [](const Offer& a, const Offer& b) {
                       return a.weight != b.weight ? a.weight > b.weight : a.site < b.site;
                     });
    out->resize(kMostSites);
  }

  double WeightOf(std::int32_t uav) const {
    return uav >= 0 && held_[At(uav)] != nullptr ? held_[At(uav)]->weight : 0;
  }

  /// Whether the agent has heard of that UAV's pair in this round, from either of the two.
  bool KnowsPair(std::size_t agent, std::int32_t uav, std::int32_t partner, int round) const {
    return air_.Hears(agent, At(uav), Word::kPlan, round) ||
           air_.Hears(agent, VoiceOfPartner(partner), Word::kPlan, round);
  }

  /// The UAVs of other pairs that hold a place at the site, as far as that UAV knows, the lightest
  /// first.
  std::vector<std::int32_t> HoldersOf(std::int32_t site, std::int32_t uav, int round) const {
    std::vector<std::int32_t> known;
    for (const std::int32_t other : at_site_[At(site)]) {
      if (other != uav && KnowsPair(At(uav), other, held_[At(other)]->partner, round)) {
        known.push_back(other);
      }
    }
    std::sort(known.begin(), known.end(), [&](std::int32_t a, std::int32_t b) {
      return std::pair(WeightOf(a), -a) < std::pair(WeightOf(b), -b);
    });
    return known;
  }

  std::optional<Proposal> BestOf(std::int32_t uav, int round) const {
    Proposal best;
    best.gain = kLeastGain;
    const double own = WeightOf(uav);
    for (const Offer& offer : offers_[At(uav)]) {
      if (offer.weight - own <= best.gain) break;  // no later offer can gain more
      if (&offer == held_[At(uav)]) continue;
      if (!air_.Hears(At(uav), VoiceOfPartner(offer.partner), Word::kPlan, round)) continue;
      Proposal proposal{uav, &offer, offer.weight - own, {}};
      const std::int32_t rival = uav_of_[At(offer.partner)];
      if (rival >= 0 && rival != uav) proposal.give_way.push_back(rival);
      std::vector<std::int32_t> holders = HoldersOf(offer.site, uav, round);
      std::erase(holders, rival);
      const auto capacity = At(instance_.capacity[At(offer.site)]);
      for (std::size_t i = 0; i + capacity <= holders.size(); ++i) {
        proposal.give_way.push_back(holders[i]);
      }
      for (const std::int32_t other : proposal.give_way) proposal.gain -= WeightOf(other);
      if (proposal.gain > best.gain) best = std::move(proposal);
    }
    if (best.offer == nullptr) return {};
    return best;
  }

  std::vector<Proposal> Propose(int round) const {
    std::vector<Proposal> proposals;
    for (std::size_t u = 0; u < n_uavs_; ++u) {
      auto proposal = BestOf(static_cast<std::int32_t>(u), round);
      if (proposal) proposals.push_back(std::move(*proposal));
    }
    return proposals;
  }

  /// The proposals that a partner accepts and whose UAV hears it, by gain.
  std::vector<Proposal> Accept(std::vector<Proposal> proposals, int round) const {
    std::erase_if(proposals, [&](const Proposal& proposal) {
      return !air_.Hears(VoiceOfPartner(proposal.offer->partner), At(proposal.uav), Word::kProposal,
                         round);
    });
    std::sort(proposals.begin(), proposals.end(), [](const Proposal& a, const Proposal& b) {
      return a.gain != b.gain ? a.gain > b.gain : a.uav < b.uav;
    });
    std::vector<char> taken(uav_of_.size(), 0);
    std::erase_if(proposals, [&](const Proposal& proposal) {
      return std::exchange(taken[At(proposal.offer->partner)], 1) == 1;
    });
    std::erase_if(proposals, [&](const Proposal& proposal) {
      return !air_.Hears(At(proposal.uav), VoiceOfPartner(proposal.offer->partner), Word::kAnswer,
                         round);
    });
    return proposals;
  }

  /// Of new pairs at one site that hear of each other as many as it has places, by gain.
  std::vector<Proposal> Settle(std::vector<Proposal> accepted, int round) const {
    std::vector<std::vector<const Proposal*>> standing(at_site_.size());
    std::vector<Proposal> settled;
    settled.reserve(accepted.size());
    for (Proposal& proposal : accepted) {
      const std::int32_t site = proposal.offer->site;
      std::size_t known = 0;
      for (const Proposal* other : standing[At(site)]) {
        if (KnowsPair(At(proposal.uav), other->uav, other->offer->partner, round)) ++known;
      }
      std::vector<std::int32_t> holders = HoldersOf(site, proposal.uav, round);
      std::erase_if(holders, [&](std::int32_t uav) {
        return std::find(proposal.give_way.begin(), proposal.give_way.end(), uav) !=
               proposal.give_way.end();
      });
      if (known + holders.size() >= At(instance_.capacity[At(site)])) continue;
      settled.push_back(std::move(proposal));
      standing[At(site)].push_back(&settled.back());
    }
    return settled;
  }

  void End(std::int32_t uav) {
    const Offer* offer = std::exchange(held_[At(uav)], nullptr);
    if (offer == nullptr) return;
    uav_of_[At(offer->partner)] = -1;
    std::erase(at_site_[At(offer->site)], uav);
  }

  void Agree(const std::vector<Proposal>& settled) {
    for (const Proposal& proposal : settled) {
      End(proposal.uav);
      for (const std::int32_t uav : proposal.give_way) End(uav);
    }
    for (const Proposal& proposal : settled) {
      held_[At(proposal.uav)] = proposal.offer;
      uav_of_[At(proposal.offer->partner)] = proposal.uav;
      at_site_[At(proposal.offer->site)].push_back(proposal.uav);
    }
  }

  /// The heaviest pairs get the places of a site that too many have agreed on.
  void AskForSites() {
    for (std::size_t site = 0; site < at_site_.size(); ++site) {
      std::vector<std::int32_t> uavs = at_site_[site];
      std::sort(uavs.begin(), uavs.end(), [&](std::int32_t a, std::int32_t b) {
        return std::pair(-WeightOf(a), a) < std::pair(-WeightOf(b), b);
      });
      for (std::size_t i = At(instance_.capacity[site]); i < uavs.size(); ++i) End(uavs[i]);
    }
  }

  const Participants& participants_;
  const PossiblePairs& pairs_;
  const Instance& instance_;
  const Radio radio_;
  const Air air_;
  const std::size_t n_uavs_;
  std::vector<std::vector<Offer>> offers_;          ///< by UAV
  std::vector<const Offer*> held_;                  ///< by UAV: the pair that it is in
  std::vector<std::int32_t> uav_of_;                ///< by partner
  std::vector<std::vector<std::int32_t>> at_site_;  ///< UAVs of the pairs of a site
};

}  // namespace

std::vector<Match> AgreeOnPairs(const Situation& situation, const Participants& participants,
                                const PossiblePairs& pairs, const Radio& radio,
                                std::int64_t* candidates) {
  Game game(situation, participants, pairs, radio);
  if (candidates != nullptr) *candidates = game.candidates();
  return game.Play();
}

}  // namespace muster::scheduler
