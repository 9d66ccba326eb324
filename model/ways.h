#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "model/per_kind.h"

namespace muster {

/// How the agents of a mission travel. Every length of a way, every place on one and so every
/// travel time comes from here; only the auditor has its own. The scenario owns the object, and all
/// processes of a mission hold equal ones.
///
/// This class is the plain case, in which everybody travels in a straight line. A derived class
/// names the agent kinds whose ways may bend, and those that have rules, and answers for them.
///
/// What callers may rely on: a way is never shorter than the straight line, so a search by straight
/// distance finds every place that is within reach. A way may be longer in one direction than in
/// the other. The answer depends on the arguments alone and is safe to ask for in several threads.
class Ways {
 public:
  Ways() = default;
  Ways(const Ways&) = delete;
  Ways& operator=(const Ways&) = delete;
  virtual ~Ways() = default;

  /// Whether all ways of that kind are straight lines.
  bool straight(AgentKind kind) const { return !bends_[kind]; }
  /// Whether that kind has rules of its own, though its ways may be straight today: a move to no
  /// site ends at a stop, ways can be closed, and an agent can hold before it sets out.
  bool ruled(AgentKind kind) const { return ruled_[kind]; }

  /// Metres from one place to the other, as the agent would make them at full speed; infinity where
  /// there is no way.
  double Length(AgentKind kind, Point from, Point to) const {
    return straight(kind) ? Distance(from, to) : BentLength(kind, from, to);
  }
  /// What Length() says of each of `from` and each of `to`, in less time: into `lengths_m`
  /// [from.size() * to.size()], all of the first of `from` first.
  void Lengths(AgentKind kind, std::span<const Point> from, std::span<const Point> to,
               std::span<double> lengths_m) const;
  /// Places to which many ways are asked for, looked up once. The ways outlive it.
  class Destinations {
   public:
    virtual ~Destinations() = default;
    /// Metres from there to those of the places, by index: into `lengths_m` [which.size()].
    virtual void LengthsFrom(Point from, std::span<const std::int32_t> which,
                             std::span<double> lengths_m) const = 0;
  };
  std::unique_ptr<const Destinations> DestinationsAt(AgentKind kind,
                                                     std::span<const Point> places) const {
    return BentDestinations(kind, places);
  }
  /// The place after that share (0 to 1) of the way.
  Point PlaceAfter(AgentKind kind, Point from, Point to, double share) const {
    return straight(kind) ? Lerp(from, to, share) : BentPlaceAfter(kind, from, to, share);
  }
  /// Metres travelled after that share of the way.
  double LengthAfter(AgentKind kind, Point from, Point to, double share) const {
    if (share >= 1) return Length(kind, from, to);
    return straight(kind) ? Distance(from, Lerp(from, to, share))
                          : share * BentLength(kind, from, to);
  }
  /// Metres that an agent has travelled that set out from one place and is at the other: straight
  /// where it is at a place that no way leads to, as a UAV that leaves a zone.
  double Gone(AgentKind kind, Point from, Point to) const {
    const double way_m = Length(kind, from, to);
    return std::isinf(way_m) ? Distance(from, to) : way_m;
  }
  /// Metres on the ground: those of Length() where the agent makes its full speed all along.
  double GroundLength(AgentKind kind, Point from, Point to) const {
    return straight(kind) ? Distance(from, to) : BentGroundLength(kind, from, to);
  }

  /// Where a move to no site can end. Places that are numbered can be told exactly by a report that
  /// has room for an id only.
  struct Stop {
    Point at;
    std::int32_t number = -1;  ///< -1: any place, none is numbered
  };
  /// The stop nearest to that place, in a straight line; it itself where none is numbered.
  Stop StopNear(AgentKind kind, Point wanted) const {
    return ruled(kind) ? BentStopNear(kind, wanted) : Stop{wanted};
  }
  /// The last stop on the way that is not beyond that share of it; `from` where there is none.
  Point StopBefore(AgentKind kind, Point from, Point to, double share) const {
    return ruled(kind) ? BentStopBefore(kind, from, to, share) : Lerp(from, to, share);
  }
  /// The place of that number.
  std::optional<Point> NumberedStop(AgentKind kind, std::int32_t number) const {
    return ruled(kind) ? BentNumberedStop(kind, number) : std::optional<Point>();
  }
  /// The places where the way changes direction, in order, without its two ends.
  struct Corner {
    Point at;
    double share = 0;  ///< of the way that ends there
    bool operator==(const Corner&) const = default;
  };
  std::vector<Corner> Corners(AgentKind kind, Point from, Point to) const {
    return straight(kind) ? std::vector<Corner>{} : BentCorners(kind, from, to);
  }
  /// The share of the way at which it comes to what is closed by `now`, not before that share;
  /// none: the rest can still be gone.
  std::optional<double> BarredAt(AgentKind kind, Point from, Point to, double share,
                                 const Ways& now) const {
    return ruled(kind) ? BentBarredAt(kind, from, to, share, now) : std::optional<double>();
  }

 protected:
  explicit Ways(PerKind<bool> bends) : Ways(bends, bends) {}
  Ways(PerKind<bool> bends, PerKind<bool> ruled) : bends_(bends), ruled_(ruled) {}

  /// Each by BentLength().
  virtual void BentLengths(AgentKind kind, std::span<const Point> from, std::span<const Point> to,
                           std::span<double> lengths_m) const;
  /// By Lengths().
  virtual std::unique_ptr<const Destinations> BentDestinations(AgentKind kind,
                                                               std::span<const Point> places) const;
  /// By BentCorners().
  virtual Point BentPlaceAfter(AgentKind kind, Point from, Point to, double share) const;

 private:
  virtual double BentLength(AgentKind kind, Point from, Point to) const;
  virtual std::vector<Corner> BentCorners(AgentKind kind, Point from, Point to) const;
  virtual double BentGroundLength(AgentKind kind, Point from, Point to) const;
  virtual Stop BentStopNear(AgentKind kind, Point wanted) const;
  virtual Point BentStopBefore(AgentKind kind, Point from, Point to, double share) const;
  virtual std::optional<Point> BentNumberedStop(AgentKind kind, std::int32_t number) const;
  virtual std::optional<double> BentBarredAt(AgentKind kind, Point from, Point to, double share,
                                             const Ways& now) const;

  PerKind<bool> bends_ = {}, ruled_ = {};
};

/// Straight lines for all.
const Ways& StraightWays();

/// The ways of a scenario that says nothing of them: straight ones.
std::shared_ptr<const Ways> DefaultWays();

/// For tests that code does not take ways to be straight: as long as it lives, DefaultWays() is
/// what it was given.
class ScopedDefaultWays {
 public:
  explicit ScopedDefaultWays(std::shared_ptr<const Ways> ways);
  ~ScopedDefaultWays();
  ScopedDefaultWays(const ScopedDefaultWays&) = delete;
  ScopedDefaultWays& operator=(const ScopedDefaultWays&) = delete;

 private:
  std::shared_ptr<const Ways> before_;
};

/// The ways of one agent class. The ways must outlive it.
struct WaysOf {
  const Ways* ways = &StraightWays();
  AgentKind kind = AgentKind::kUav;

  bool straight() const { return ways->straight(kind); }
  double Length(Point from, Point to) const { return ways->Length(kind, from, to); }
};

}  // namespace muster
