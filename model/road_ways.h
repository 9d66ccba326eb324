#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "model/roads.h"
#include "model/ways.h"

namespace muster {

/// How the agents of one class get from a place to the road nearest to it and back.
struct OpenGround {
  std::int32_t percent = 100;  ///< of the agent's speed; 0: it never leaves the road
  double reach_m = 0;          ///< no further than this from the road
};

class RoadNetwork;

/// Workers and vehicles go by road, UAVs fly. A way leads across open ground to the nearest road
/// that the class may use, along roads by the shortest time, and across open ground to its end.
/// docs/reference/roads.md has the rules to the millimetre; the auditor keeps them by its own code.
///
/// Lengths are sums of whole millimetres and equal ways are told apart by ids, so every machine
/// finds the same way. What is found out is kept; memory: docs/reference/roads.md.
class RoadWays final : public Ways, public std::enable_shared_from_this<RoadWays> {
 public:
  /// `sites`: places where agents may stop beside the road points, as tasks and charging points.
  RoadWays(std::shared_ptr<const Roads> roads, const PerKind<OpenGround>& open_ground,
           std::vector<Point> sites);
  ~RoadWays() override;

  const std::shared_ptr<const Roads>& roads() const { return roads_; }

  /// The same roads without those: indices, ascending. It is made once for equal ones, and is there
  /// as long as this object, which a shared pointer must own. Stops stay: who is sent to one on a
  /// closed road goes to it across open ground.
  std::shared_ptr<const RoadWays> Without(const std::vector<std::int32_t>& closed) const;

  /// Metres across open ground to the nearest road; none: no road is within reach.
  std::optional<double> ToRoad(AgentKind kind, Point place) const;

 private:
  double BentLength(AgentKind kind, Point from, Point to) const override;
  void BentLengths(AgentKind kind, std::span<const Point> from, std::span<const Point> to,
                   std::span<double> lengths_m) const override;
  std::unique_ptr<const Destinations> BentDestinations(
      AgentKind kind, std::span<const Point> places) const override;
  std::vector<Corner> BentCorners(AgentKind kind, Point from, Point to) const override;
  Point BentPlaceAfter(AgentKind kind, Point from, Point to, double share) const override;
  double BentGroundLength(AgentKind kind, Point from, Point to) const override;
  Stop BentStopNear(AgentKind kind, Point wanted) const override;
  Point BentStopBefore(AgentKind kind, Point from, Point to, double share) const override;
  std::optional<Point> BentNumberedStop(AgentKind kind, std::int32_t number) const override;
  std::optional<double> BentBarredAt(AgentKind kind, Point from, Point to, double share,
                                     const Ways& now) const override;
  RoadWays(const RoadWays& all, const std::vector<bool>& closed);
  const RoadNetwork& network(AgentKind kind) const;

  std::shared_ptr<const Roads> roads_;
  std::unique_ptr<const RoadNetwork> workers_, vehicles_;
  mutable std::mutex mutex_;
  mutable std::map<std::vector<std::int32_t>, std::unique_ptr<const RoadWays>> without_;
};

}  // namespace muster
