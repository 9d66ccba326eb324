#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "scheduler/policies/horizon/pairs.h"
#include "scheduler/situation.h"
#include "scheduler/solver/candidates.h"

namespace muster::scheduler {

/// What keeps every pair from a place, or one pair.
enum class Obstacle {
  kNone,
  kNoUav,      ///< no UAV is idle
  kNoPartner,  ///< no worker (vehicle) is idle
  kNoPlace,    ///< the charging point is full
  kRange,      ///< constraint (6) at a task, (5) at a charging point
  kWindow,     ///< it would end after a participant's downtime
  kLimit,      ///< it would end after the mission
  kExpiry,     ///< they would not be there before the task expires
  kNoRoad,     ///< no way by road leads there for any partner
  kClosed,     ///< none does since roads were closed
  kZone,       ///< the place is in a zone that UAVs keep out of, or cut off by zones
  kForbidden,  ///< the commander forbids the task to everybody who could do it
  kNoUse,      ///< charging would enable no further task; only in horizon's terms
};
/// "none", "no idle uav", "no idle partner", "no free place", "range", "online window",
/// "time limit", "expiry", "no road", "closed road", "zone", "forbidden", "no use"
std::string_view ToString(Obstacle obstacle);

/// A UAV's range against what a place asks of it, metres.
struct RangeNeed {
  UavId uav;
  double range_m = 0;
  double way_m = 0;
  double cost_m = 0;              ///< of sensing; 0 at a charging point
  double to_charge_m = 0;         ///< from the task to the nearest charging point; 0 at one
  std::optional<TimeUs> free_us;  ///< when it will be free with that range, if it is not idle
  double needs_m() const { return way_m + cost_m + to_charge_m; }
};

/// A way that is not straight.
struct RoadLook {
  double ground_m = 0;
  double straight_m = 0;
};

/// One UAV and one partner at one place.
struct PairLook {
  UavId uav;
  std::int32_t partner = -1;  ///< worker or vehicle
  Obstacle obstacle = Obstacle::kNone;
  double weight = 0;     ///< when nothing stands against it
  TimeUs end_us = 0;     ///< when it would be done; of kExpiry when both would be there
  TimeUs latest_us = 0;  ///< by when it must be: of kWindow the downtime, of kLimit the limit
  std::optional<AgentKind> window_of;  ///< of kWindow: whose downtime
  /// When they can be commanded, unless they are idle; only in horizon's terms.
  std::optional<TimeUs> uav_free_us, partner_free_us;
  std::optional<RoadLook> partner_way;  ///< of those that end too late, by road
};

/// All pairs at one place: of idle agents, in horizon's terms also of those that will be free soon.
struct PlaceLook {
  bool charging = false;
  std::int32_t site = -1;  ///< task or charging point
  Obstacle obstacle = Obstacle::kNone;
  int idle_uavs = 0, idle_partners = 0;
  int soon_uavs = 0, soon_partners = 0;  ///< take part, as they will be free soon
  std::int32_t soon_decisions = 0;       ///< within that many decisions; 0: idle ones only
  int busy_uavs = 0, busy_partners = 0;  ///< under way, and take no part
  int unready_uavs = 0, unready_partners = 0;
  int uavs_in_range = 0;
  int pairs = 0;  ///< of a UAV in range and a partner
  int pairs_feasible = 0, pairs_after_window = 0, pairs_after_limit = 0, pairs_after_expiry = 0;
  std::vector<PairLook> best;  ///< feasible, heaviest first, at most kBest
  std::optional<RangeNeed>
      nearest_range;                     ///< of the UAVs that lack range, the one that lacks least
  std::optional<PairLook> nearest_time;  ///< of the pairs that end too late, the least late
  std::optional<Closure> closure;        ///< of kClosed: one that the partner's way led through; of
                                         ///< kZone: the zone that the place is in

  AgentKind partner_kind() const { return charging ? AgentKind::kVehicle : AgentKind::kWorker; }

  static constexpr std::size_t kBest = 3;
  /// Keeps a feasible pair if it is among the best. Ties by the order of the calls.
  void Offer(const PairLook& pair);
  /// Keeps a pair that ends too late if it is the least late. Sets its obstacle, counts it.
  void OfferLate(PairLook pair, TimeUs limit_us, const AgentState& uav, const AgentState& partner);
  /// The same for a pair that is at the task, at `there_us`, after it has expired.
  void OfferExpired(PairLook pair, TimeUs there_us, TimeUs expires_us);
  /// Keeps the need if it is the one that lacks least.
  void OfferShort(const RangeNeed& need);

 private:
  void KeepLeastLate(const PairLook& pair);
};

/// One decision's situation, to be asked about single places and agents. What a pair weighs, and
/// which agents take part, depends on how the policy scores: PaperLook, HorizonLook. Source: ours.
class Look {
 public:
  virtual ~Look() = default;
  Look(const Look&) = delete;
  Look& operator=(const Look&) = delete;

  const Situation& situation() const { return situation_; }
  const Participants& participants() const { return participants_; }
  /// Among the participants of that kind; -1: takes no part.
  std::int32_t IndexOf(AgentKind kind, std::int32_t id) const;

  /// All pairs at an open task; only those with that UAV or that worker when given. O(UAVs *
  /// workers) that take part.
  PlaceLook AtTask(TaskId task, UavId uav = {}, WorkerId worker = {}) const {
    return AtPlace(false, task.value, uav.value, worker.value);
  }
  PlaceLook AtCharge(ChargeId charge, UavId uav = {}, VehicleId vehicle = {}) const {
    return AtPlace(true, charge.value, uav.value, vehicle.value);
  }
  /// All places that an agent could be sent to, open tasks before charging points, each with the
  /// pairs that hold the agent.
  std::vector<PlaceLook> PlacesOf(AgentKind kind, std::int32_t id) const;

 protected:
  /// `situation` must outlive this. The settings say which agents take part.
  Look(const Situation& situation, const HorizonSettings& settings);
  /// Tells of all pairs at the place, or of those with the UAV or the partner whose ids are given
  /// (-1: any). Sets the obstacle where all pairs in range come too late.
  virtual void AddPairs(std::int32_t uav, std::int32_t partner, PlaceLook* look) const = 0;

  /// Says how the partner would get there, or that no road leads there.
  void LookAtRoad(PlaceLook* look) const;
  /// Whether the commander forbids the task to somebody.
  bool IsForbiddenToSome(const PlaceLook& look) const;
  /// Says why UAVs are in range of the place, and no partner could ever be there.
  void LookForWay(std::int32_t partner, PlaceLook* look) const;
  /// Whether UAVs cannot get there because of zones, and then which.
  void LookAtZones(PlaceLook* look) const;
  /// The first closure that bars the way which led there while all roads were open.
  std::optional<Closure> ClosureOnTheWay(AgentKind kind, Point from, Point to) const;
  bool IsFull(const PlaceLook& look) const {
    return look.charging && situation_.free_places(ChargeId(look.site)) == 0;
  }
  RangeNeed NeedOf(const Participant& uav, const PlaceLook& look) const;

  const Situation& situation_;
  const Participants participants_;
  const std::int32_t soon_decisions_;

 private:
  PlaceLook AtPlace(bool charging, std::int32_t site, std::int32_t uav, std::int32_t partner) const;
};

/// Idle agents, under the paper's weights. What it says is what EnumerateCandidates offers.
class PaperLook : public Look {
 public:
  explicit PaperLook(const Situation& situation);
  /// The paper's weight of an action of idle agents; none for a free move or what is not offered.
  std::optional<double> WeightOf(const Action& action) const { return weights_.Of(action); }

 private:
  void AddPairs(std::int32_t uav, std::int32_t partner, PlaceLook* look) const override;
  /// A pair whose UAV has the range that the place needs.
  void AddPair(const RangeNeed& need, const AgentState& uav, const AgentState& partner,
               PlaceLook* look) const;

  ActionWeights weights_;
};

/// The first matching of `horizon`: agents that will be free soon take part, members wait for each
/// other, a pair's weight is its worth in tasks. Pairs, their worth and their ends are FindPairs's.
class HorizonLook : public Look {
 public:
  HorizonLook(const Situation& situation, const HorizonSettings& settings);
  const PossiblePairs& pairs() const { return pairs_; }
  /// Of the instance; -1: not open.
  std::int32_t SiteOf(bool charging, std::int32_t site) const;

 private:
  void AddPairs(std::int32_t uav, std::int32_t partner, PlaceLook* look) const override;
  void AddFeasible(std::int32_t uav, std::int32_t partner, PlaceLook* look) const;
  void AddImpossible(std::int32_t uav, std::int32_t partner, PlaceLook* look) const;
  PairLook MakeLook(const Participants& participants, const Match& match) const;
  /// The same pairs as if no online time ended, at that place or at all charging points.
  struct Untimed {
    std::int32_t uav = -1, partner = -1;
    Participants participants;  ///< with their true times
    PossiblePairs pairs;
  };
  Untimed Build(const PlaceLook& look, std::int32_t uav, std::int32_t partner) const;

  HorizonSettings settings_;
  OpenSites open_;
  PossiblePairs pairs_;
  mutable std::optional<Untimed> charges_;  ///< of the last question about a charging point
};

}  // namespace muster::scheduler
