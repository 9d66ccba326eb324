#pragma once

#include <cstdint>
#include <optional>

#include "scheduler/explain/look.h"
#include "scheduler/policies/horizon/pairs.h"

namespace muster::scheduler {

/// One decision's first matching as `horizon` sees it, to be asked about single places and agents:
/// agents that will be free soon take part, members wait for each other, a pair's weight is its
/// worth in tasks. Pairs, their worth and their ends are FindPairs's. Source: ours.
class HorizonLook {
 public:
  /// `situation` must outlive this.
  HorizonLook(const Situation& situation, const HorizonSettings& settings);
  HorizonLook(const HorizonLook&) = delete;
  HorizonLook& operator=(const HorizonLook&) = delete;

  const Participants& participants() const { return participants_; }
  const PossiblePairs& pairs() const { return pairs_; }

  /// Among the participants of that kind; -1: takes no part.
  std::int32_t IndexOf(AgentKind kind, std::int32_t id) const;
  /// Of the instance; -1: not open.
  std::int32_t SiteOf(bool charging, std::int32_t site) const;

  /// All pairs at an open task; only those with that UAV or that worker when given. O(UAVs *
  /// workers) that take part.
  PlaceLook AtTask(TaskId task, UavId uav = {}, WorkerId worker = {}) const;
  PlaceLook AtCharge(ChargeId charge, UavId uav = {}, VehicleId vehicle = {}) const;

 private:
  PlaceLook AtPlace(bool charging, std::int32_t site, std::int32_t uav, std::int32_t partner) const;
  PairLook MakeLook(const Participants& participants, const Match& match) const;
  void AddFeasible(std::int32_t uav, std::int32_t partner, PlaceLook* look) const;
  void AddImpossible(std::int32_t uav, std::int32_t partner, PlaceLook* look) const;
  /// The same pairs as if nobody's time ended, at that place or at all charging points.
  struct Untimed {
    std::int32_t uav = -1, partner = -1;
    Participants participants;  ///< with their true times
    PossiblePairs pairs;
  };
  Untimed Build(const PlaceLook& look, std::int32_t uav, std::int32_t partner) const;

  const Situation& situation_;
  HorizonSettings settings_;
  Participants participants_;
  OpenSites open_;
  PossiblePairs pairs_;
  mutable std::optional<Untimed> charges_;  ///< of the last question about a charging point
};

}  // namespace muster::scheduler
