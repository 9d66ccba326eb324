#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "model/airspace.h"
#include "model/ways.h"

namespace muster {

/// An airspace that is made when it is asked for first: a mission that begins with many zones takes
/// them one by one, and hardly anybody flies in between. Safe in several threads.
class LazyAirspace {
 public:
  LazyAirspace(std::vector<Zone> zones, double margin_m, Airspace::Extent extent)
      : has_zones_(!zones.empty()),
        zones_(std::move(zones)),
        margin_m_(margin_m),
        extent_(extent) {}
  bool has_zones() const { return has_zones_; }
  const Airspace& get() const {
    std::call_once(made_once_, [&] { made_.emplace(std::move(zones_), margin_m_, extent_); });
    return *made_;
  }

 private:
  bool has_zones_;
  mutable std::once_flag made_once_;
  mutable std::vector<Zone> zones_;
  double margin_m_;
  Airspace::Extent extent_;
  mutable std::optional<Airspace> made_;
};

/// UAVs fly around zones; workers and vehicles travel as `ground` says.
///
/// A move of a UAV to no site ends at a place of a grid of 100 m, numbered from the south-west
/// corner of the area, row by row to the north: the free one that is nearest.
class AirWays final : public Ways {
 public:
  using Extent = Airspace::Extent;
  AirWays(std::shared_ptr<const Ways> ground, std::shared_ptr<const LazyAirspace> air,
          Extent extent);

  const Airspace& air() const { return air_->get(); }

 private:
  double BentLength(AgentKind kind, Point from, Point to) const override;
  std::unique_ptr<const Destinations> BentDestinations(
      AgentKind kind, std::span<const Point> places) const override;
  void BentLengths(AgentKind kind, std::span<const Point> from, std::span<const Point> to,
                   std::span<double> lengths_m) const override;
  std::vector<Corner> BentCorners(AgentKind kind, Point from, Point to) const override;
  Point BentPlaceAfter(AgentKind kind, Point from, Point to, double share) const override;
  double BentGroundLength(AgentKind kind, Point from, Point to) const override;
  Stop BentStopNear(AgentKind kind, Point wanted) const override;
  Point BentStopBefore(AgentKind kind, Point from, Point to, double share) const override;
  std::optional<Point> BentNumberedStop(AgentKind kind, std::int32_t number) const override;
  std::optional<double> BentBarredAt(AgentKind kind, Point from, Point to, double share,
                                     const Ways& now) const override;

  std::shared_ptr<const Ways> ground_;
  std::shared_ptr<const LazyAirspace> air_;
  std::int32_t columns_, rows_;  ///< of the grid
};

/// The ways of one scenario around each set of zones that it has had. Each is there as long as this
/// object: agents under way keep the ways that they set out by.
class AirWaysStore {
 public:
  AirWaysStore(double margin_m, AirWays::Extent extent) : margin_m_(margin_m), extent_(extent) {}
  /// The same object for the same ground and zones. What is found of equal zones is shared by all
  /// missions of this process.
  std::shared_ptr<const Ways> Around(std::shared_ptr<const Ways> ground,
                                     std::vector<Zone> zones) const;

 private:
  using Key = std::pair<const Ways*, std::vector<double>>;
  double margin_m_;
  AirWays::Extent extent_;
  mutable std::mutex mutex_;
  mutable std::map<Key, std::shared_ptr<const Ways>> made_;
};

}  // namespace muster
