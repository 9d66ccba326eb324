#pragma once

#include <cstdint>
#include <string_view>

#include "lcmtypes/bus/lossy_bus.h"
#include "lcmtypes/words.h"

namespace muster {

/// What a fault of a kind can hit, and so how a plan writes its target.
enum class FaultTarget {
  kAgent,      ///< "uav:3"
  kProcess,    ///< "scheduler"
  kSides,      ///< "world|uav+worker": neither side hears the other
  kReceivers,  ///< the process whose incoming packets suffer; "*": all processes
  kEverybody,  ///< "*"
  kLog,        ///< the process that writes the log
  kRoads,      ///< "2.5/3/0.4": the roads in a circle, as its centre and radius in km
  kAir,        ///< "2.5/3/0.4": a circle, the same, that UAVs are to keep out of
};

/// All that is particular to one kind of fault. Its name is in lcmtypes/words.h.
struct FaultRow {
  FaultKind kind;
  FaultTarget target;
  /// What a score says when the fault had an effect; "": how many packets it hit.
  std::string_view effect = {};
  /// The mission waits while it lasts, so it lasts in real time unless the mission goes on.
  bool holds_clock = false;
  /// At a value of 1 its target hears nothing, so the mission waits as well.
  bool deafens = false;
  /// It cannot last for good.
  bool must_end = false;
  /// It has taken effect when its target has died.
  bool kills = false;
  /// Sent to the target when the fault begins and when it ends; 0: none.
  int begin_signal = 0, end_signal = 0;
  /// It changes what messages say. Decisions may then differ, so it is not drawn unless asked for,
  /// and the launcher is spared: a damaged number would make it wait for what never happened.
  bool damages = false;

  /// Key of the value in a plan; "": the kind takes none. A plan counts it in `value_unit`.
  std::string_view value_key = {};
  double value_most = 0, value_unit = 1;
  /// A random plan draws 0.1 to 0.4 times this, in the wire's unit.
  double value_drawn = 1;
  /// Adds the fault to those of a receiver's bus; of several at a time the largest value holds.
  void (*apply)(double value, PacketFaults* faults) = nullptr;
  /// The packets that it has hit; null: those that the process has rejected.
  std::int64_t PacketFaultCounters::*hits = nullptr;

  constexpr bool of_agents() const { return target == FaultTarget::kAgent; }
  /// It changes where agents can travel.
  constexpr bool of_ways() const {
    return target == FaultTarget::kRoads || target == FaultTarget::kAir;
  }
  /// In mission time, and the world says so.
  constexpr bool by_world() const { return of_agents() || of_ways(); }
  /// Each process that it concerns sees it in the packets that it receives, and confirms it.
  constexpr bool of_packets() const {
    return target == FaultTarget::kSides || target == FaultTarget::kReceivers ||
           target == FaultTarget::kEverybody;
  }
};

const FaultRow& RowOf(FaultKind kind);

}  // namespace muster
