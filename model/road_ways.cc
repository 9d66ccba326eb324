#include "model/road_ways.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "model/road_network.h"

namespace muster {
namespace {

/// Metres of a way that costs so many millimetres; -1: there is none.
double ToLength(std::int64_t mm, Point from, Point to) {
  if (mm < 0) return std::numeric_limits<double>::infinity();
  // Rounding may not make it shorter than the straight line.
  return std::max(static_cast<double>(mm) / 1000, Distance(from, to));
}

/// The corner that the way has reached after `mm`, or the last before; not its last one.
std::size_t CornerBefore(const RoadNetwork::Way& way, double mm) {
  const auto next = std::upper_bound(
      way.reached_mm.begin() + 1, way.reached_mm.end() - 1, mm,
      [](double done, std::int64_t reached) { return done < static_cast<double>(reached); });
  return static_cast<std::size_t>(next - way.reached_mm.begin()) - 1;
}

}  // namespace

RoadWays::RoadWays(std::shared_ptr<const Roads> roads, const PerKind<OpenGround>& open_ground,
                   std::vector<Point> sites)
    : Ways({false, true, true}),
      roads_(std::move(roads)),
      workers_(
          std::make_unique<RoadNetwork>(*roads_, AgentKind::kWorker, open_ground.workers, sites)),
      vehicles_(std::make_unique<RoadNetwork>(*roads_, AgentKind::kVehicle, open_ground.vehicles,
                                              sites)) {}

RoadWays::RoadWays(const RoadWays& all, const std::vector<bool>& closed)
    : Ways({false, true, true}),
      roads_(all.roads_),
      workers_(std::make_unique<RoadNetwork>(*all.workers_, closed)),
      vehicles_(std::make_unique<RoadNetwork>(*all.vehicles_, closed)) {}

RoadWays::~RoadWays() = default;

std::shared_ptr<const RoadWays> RoadWays::Without(const std::vector<std::int32_t>& closed) const {
  if (closed.empty()) return shared_from_this();
  const std::lock_guard lock(mutex_);
  std::unique_ptr<const RoadWays>& made = without_[closed];
  if (made == nullptr) {
    std::vector<bool> is_closed(roads_->roads.size());
    for (const std::int32_t road : closed) is_closed[static_cast<std::size_t>(road)] = true;
    made.reset(new RoadWays(*this, is_closed));
  }
  return {shared_from_this(), made.get()};
}

const RoadNetwork& RoadWays::network(AgentKind kind) const {
  return kind == AgentKind::kWorker ? *workers_ : *vehicles_;
}

std::optional<double> RoadWays::ToRoad(AgentKind kind, Point place) const {
  const auto spot = network(kind).SpotOf(place);
  return spot ? std::optional(Distance(place, spot->at)) : std::nullopt;
}

double RoadWays::BentLength(AgentKind kind, Point from, Point to) const {
  return ToLength(network(kind).Cost(from, to), from, to);
}

void RoadWays::BentLengths(AgentKind kind, std::span<const Point> from, std::span<const Point> to,
                           std::span<double> lengths_m) const {
  network(kind).Costs(from, to, [&](std::size_t i, std::size_t j, std::int64_t mm) {
    lengths_m[i * to.size() + j] = ToLength(mm, from[i], to[j]);
  });
}

std::unique_ptr<const Ways::Destinations> RoadWays::BentDestinations(
    AgentKind kind, std::span<const Point> places) const {
  struct ByRoad final : Destinations {
    ByRoad(const RoadNetwork& by, std::span<const Point> at)
        : network(by), places(network.LookUp(at)) {}
    void LengthsFrom(Point from, std::span<const std::int32_t> which,
                     std::span<double> lengths_m) const override {
      network.Costs(from, places, which, [&](std::size_t i, Point to, std::int64_t mm) {
        lengths_m[i] = ToLength(mm, from, to);
      });
    }
    const RoadNetwork& network;
    const RoadNetwork::Places places;
  };
  return std::make_unique<const ByRoad>(network(kind), places);
}

std::vector<Ways::Corner> RoadWays::BentCorners(AgentKind kind, Point from, Point to) const {
  const auto way = network(kind).WayBetween(from, to);
  std::vector<Corner> corners;
  if (!way) return corners;
  const auto whole_mm = static_cast<double>(way->reached_mm.back());
  for (std::size_t i = 1; i + 1 < way->corners.size(); ++i) {
    corners.push_back({way->corners[i], static_cast<double>(way->reached_mm[i]) / whole_mm});
  }
  return corners;
}

Point RoadWays::BentPlaceAfter(AgentKind kind, Point from, Point to, double share) const {
  const auto way = network(kind).WayBetween(from, to);
  if (!way || share <= 0) return from;
  if (share >= 1) return to;
  const double mm = share * static_cast<double>(way->reached_mm.back());
  const std::size_t i = CornerBefore(*way, mm);
  const auto begin_mm = static_cast<double>(way->reached_mm[i]);
  const auto step_mm = static_cast<double>(way->reached_mm[i + 1]) - begin_mm;
  return step_mm == 0 ? to : Lerp(way->corners[i], way->corners[i + 1], (mm - begin_mm) / step_mm);
}

double RoadWays::BentGroundLength(AgentKind kind, Point from, Point to) const {
  const auto way = network(kind).WayBetween(from, to);
  return way ? static_cast<double>(way->ground_mm) / 1000 : std::numeric_limits<double>::infinity();
}

Ways::Stop RoadWays::BentStopNear(AgentKind kind, Point wanted) const {
  return network(kind).StopNear(wanted);
}

Point RoadWays::BentStopBefore(AgentKind kind, Point from, Point to, double share) const {
  const auto way = network(kind).WayBetween(from, to);
  if (!way) return from;
  const double mm = share * static_cast<double>(way->reached_mm.back());
  for (std::size_t i = CornerBefore(*way, mm); i > 0; --i) {
    const Stop stop = StopNear(kind, way->corners[i]);
    if (stop.at == way->corners[i]) return stop.at;
  }
  return from;
}

std::optional<double> RoadWays::BentBarredAt(AgentKind kind, Point from, Point to, double share,
                                             const Ways& now) const {
  const auto way = network(kind).WayBetween(from, to);
  const auto* roads_now = dynamic_cast<const RoadWays*>(&now);
  if (!way || roads_now == nullptr) return {};
  const auto whole_mm = static_cast<double>(way->reached_mm.back());
  const std::int64_t mm = network(kind).BarredAt(*way, share * whole_mm, roads_now->network(kind));
  if (mm < 0) return {};
  return std::max(share, static_cast<double>(mm) / whole_mm);
}

std::optional<Point> RoadWays::BentNumberedStop(AgentKind kind, std::int32_t number) const {
  return network(kind).NumberedStop(number);
}

}  // namespace muster
