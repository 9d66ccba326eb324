#include "model/air_ways.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace muster {
namespace {

constexpr double kGrid_m = 100;

std::int32_t Count(double extent_m) {
  return static_cast<std::int32_t>(std::floor(extent_m / kGrid_m)) + 1;
}

/// What a flight depends on, as numbers.
std::vector<double> KeyOf(const std::vector<Zone>& zones, double margin_m,
                          const Airspace::Extent& extent) {
  std::vector<double> key{margin_m, extent.width_m, extent.height_m};
  for (const Zone& zone : zones) {
    key.push_back(static_cast<double>(zone.rings.size()));
    for (const std::vector<Point>& ring : zone.rings) {
      key.push_back(static_cast<double>(ring.size()));
      for (const Point corner : ring) key.insert(key.end(), {corner.x_m, corner.y_m});
    }
  }
  return key;
}

std::shared_ptr<const LazyAirspace> SharedAirspace(std::vector<Zone> zones, double margin_m,
                                                   const Airspace::Extent& extent) {
  static std::mutex mutex;
  static std::map<std::vector<double>, std::weak_ptr<const LazyAirspace>> known;
  const std::lock_guard lock(mutex);
  std::erase_if(known, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<const LazyAirspace>& entry = known[KeyOf(zones, margin_m, extent)];
  std::shared_ptr<const LazyAirspace> air = entry.lock();
  if (air == nullptr)
    entry = air = std::make_shared<const LazyAirspace>(std::move(zones), margin_m, extent);
  return air;
}

}  // namespace

AirWays::AirWays(std::shared_ptr<const Ways> ground, std::shared_ptr<const LazyAirspace> air,
                 Extent extent)
    : Ways({air->has_zones(), !ground->straight(AgentKind::kWorker),
            !ground->straight(AgentKind::kVehicle)},
           {true, ground->ruled(AgentKind::kWorker), ground->ruled(AgentKind::kVehicle)}),
      ground_(std::move(ground)),
      air_(std::move(air)),
      columns_(Count(extent.width_m)),
      rows_(Count(extent.height_m)) {}

double AirWays::BentLength(AgentKind kind, Point from, Point to) const {
  return kind == AgentKind::kUav ? air().Length(from, to) : ground_->Length(kind, from, to);
}

void AirWays::BentLengths(AgentKind kind, std::span<const Point> from, std::span<const Point> to,
                          std::span<double> lengths_m) const {
  if (kind != AgentKind::kUav) return ground_->Lengths(kind, from, to, lengths_m);
  air().Lengths(from, to, lengths_m);
}

std::unique_ptr<const Ways::Destinations> AirWays::BentDestinations(
    AgentKind kind, std::span<const Point> places) const {
  if (kind != AgentKind::kUav) return ground_->DestinationsAt(kind, places);
  struct Goals final : Destinations {
    Goals(const Airspace& air, std::span<const Point> at) : goals(air, at) {}
    void LengthsFrom(Point from, std::span<const std::int32_t> which,
                     std::span<double> lengths_m) const override {
      goals.LengthsFrom(from, which, lengths_m);
    }
    const Airspace::Goals goals;
  };
  return std::make_unique<const Goals>(air(), places);
}

std::vector<Ways::Corner> AirWays::BentCorners(AgentKind kind, Point from, Point to) const {
  if (kind != AgentKind::kUav) return ground_->Corners(kind, from, to);
  const auto flight = air().FlightBetween(from, to);
  std::vector<Corner> corners;
  if (!flight) return corners;
  const double length_m = flight->reached_m.back();
  for (std::size_t i = 1; i + 1 < flight->corners.size(); ++i) {
    corners.push_back({flight->corners[i], flight->reached_m[i] / length_m});
  }
  return corners;
}

Point AirWays::BentPlaceAfter(AgentKind kind, Point from, Point to, double share) const {
  if (kind != AgentKind::kUav) return ground_->PlaceAfter(kind, from, to, share);
  return Ways::BentPlaceAfter(kind, from, to, share);
}

double AirWays::BentGroundLength(AgentKind kind, Point from, Point to) const {
  return kind == AgentKind::kUav ? air().Length(from, to) : ground_->GroundLength(kind, from, to);
}

Ways::Stop AirWays::BentStopNear(AgentKind kind, Point wanted) const {
  if (kind != AgentKind::kUav) return ground_->StopNear(kind, wanted);
  const auto nearest = [](double at_m, std::int32_t n) {
    const double cell = std::floor(at_m / kGrid_m + 0.5);
    return cell <= 0 ? 0 : cell >= n - 1 ? n - 1 : static_cast<std::int32_t>(cell);
  };
  const std::int32_t x = nearest(wanted.x_m, columns_), y = nearest(wanted.y_m, rows_);
  Stop best{wanted};
  double least_m = std::numeric_limits<double>::infinity();
  const auto offer = [&](std::int32_t i, std::int32_t j) {
    if (i < 0 || j < 0 || i >= columns_ || j >= rows_) return;
    const Point at{i * kGrid_m, j * kGrid_m};
    const double metres = Distance(wanted, at);
    const std::int32_t number = j * columns_ + i;
    if (metres > least_m || (metres == least_m && number > best.number)) return;
    if (!air().IsFree(at)) return;
    best = {at, number};
    least_m = metres;
  };
  // Rings around the nearest, until none further out can be nearer.
  for (std::int32_t r = 0; r <= std::max(columns_, rows_); ++r) {
    if (best.number >= 0 && (r - 0.5) * kGrid_m > least_m) break;
    for (std::int32_t i = -r; i <= r; ++i) {
      offer(x + i, y - r);
      if (r > 0) offer(x + i, y + r);
    }
    for (std::int32_t j = 1 - r; j < r; ++j) {
      offer(x - r, y + j);
      offer(x + r, y + j);
    }
  }
  return best;
}

Point AirWays::BentStopBefore(AgentKind kind, Point from, Point to, double share) const {
  if (kind != AgentKind::kUav) return ground_->StopBefore(kind, from, to, share);
  const double length_m = air().Length(from, to);
  if (std::isinf(length_m)) return from;
  // Near the way, and no further than the share of it.
  for (double part = share; part > 0; part -= std::max(0.01, kGrid_m / length_m)) {
    const Point stop = StopNear(kind, PlaceAfter(kind, from, to, part)).at;
    if (air().Length(from, stop) <= share * length_m) return stop;
  }
  return from;
}

std::optional<Point> AirWays::BentNumberedStop(AgentKind kind, std::int32_t number) const {
  if (kind != AgentKind::kUav) return ground_->NumberedStop(kind, number);
  if (number < 0 || number / columns_ >= rows_) return {};
  const std::int32_t row = number / columns_;
  return Point{number % columns_ * kGrid_m, row * kGrid_m};
}

std::optional<double> AirWays::BentBarredAt(AgentKind kind, Point from, Point to, double share,
                                            const Ways& now) const {
  const auto* const air_now = dynamic_cast<const AirWays*>(&now);
  if (air_now == nullptr) return {};
  if (kind != AgentKind::kUav) {
    return ground_->BarredAt(kind, from, to, share, *air_now->ground_);
  }
  const auto flight = air().FlightBetween(from, to);
  if (!flight || air_ == air_now->air_) return {};
  const double length_m = flight->reached_m.back();
  const auto enters_m = air_now->air().EntersAt(*flight, share * length_m);
  if (!enters_m) return {};
  return std::min(1.0, std::max(share, *enters_m / length_m));
}

std::shared_ptr<const Ways> AirWaysStore::Around(std::shared_ptr<const Ways> ground,
                                                 std::vector<Zone> zones) const {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<const Ways>& made = made_[{ground.get(), KeyOf(zones, margin_m_, extent_)}];
  if (made == nullptr) {
    made = std::make_shared<const AirWays>(
        std::move(ground), SharedAirspace(std::move(zones), margin_m_, extent_), extent_);
  }
  return made;
}

}  // namespace muster
