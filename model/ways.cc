#include "model/ways.h"

#include <utility>

#include "base/index.h"

namespace muster {
namespace {

std::shared_ptr<const Ways>& Default() {
  static std::shared_ptr<const Ways> ways(&StraightWays(), [](const Ways*) {});
  return ways;
}

}  // namespace

void Ways::Lengths(AgentKind kind, std::span<const Point> from, std::span<const Point> to,
                   std::span<double> lengths_m) const {
  if (!straight(kind)) return BentLengths(kind, from, to, lengths_m);
  std::size_t i = 0;
  for (const Point& begin : from) {
    for (const Point& end : to) lengths_m[i++] = Distance(begin, end);
  }
}

double Ways::BentLength(AgentKind, Point from, Point to) const { return Distance(from, to); }

void Ways::BentLengths(AgentKind kind, std::span<const Point> from, std::span<const Point> to,
                       std::span<double> lengths_m) const {
  std::size_t i = 0;
  for (const Point& begin : from) {
    for (const Point& end : to) lengths_m[i++] = BentLength(kind, begin, end);
  }
}

std::unique_ptr<const Ways::Destinations> Ways::BentDestinations(
    AgentKind kind, std::span<const Point> places) const {
  struct Places final : Destinations {
    Places(const Ways& by, AgentKind by_kind, std::span<const Point> at)
        : ways(by), kind(by_kind), places(at.begin(), at.end()) {}
    void LengthsFrom(Point from, std::span<const std::int32_t> which,
                     std::span<double> lengths_m) const override {
      std::vector<Point> to;
      to.reserve(which.size());
      for (const std::int32_t i : which) to.push_back(places[At(i)]);
      ways.Lengths(kind, {&from, 1}, to, lengths_m);
    }
    const Ways& ways;
    const AgentKind kind;
    const std::vector<Point> places;
  };
  return std::make_unique<const Places>(*this, kind, places);
}

std::vector<Ways::Corner> Ways::BentCorners(AgentKind, Point, Point) const { return {}; }

Point Ways::BentPlaceAfter(AgentKind kind, Point from, Point to, double share) const {
  if (share >= 1) return to;
  Corner last{from, 0};
  std::vector<Corner> corners = BentCorners(kind, from, to);
  corners.push_back({to, 1});
  for (const Corner& corner : corners) {
    if (share < corner.share) {
      return Lerp(last.at, corner.at, (share - last.share) / (corner.share - last.share));
    }
    last = corner;
  }
  return to;
}

double Ways::BentGroundLength(AgentKind kind, Point from, Point to) const {
  return BentLength(kind, from, to);
}

Ways::Stop Ways::BentStopNear(AgentKind, Point wanted) const { return {wanted}; }

Point Ways::BentStopBefore(AgentKind kind, Point from, Point to, double share) const {
  return BentPlaceAfter(kind, from, to, share);
}

std::optional<Point> Ways::BentNumberedStop(AgentKind, std::int32_t) const { return {}; }

std::optional<double> Ways::BentBarredAt(AgentKind, Point, Point, double, const Ways&) const {
  return {};
}

const Ways& StraightWays() {
  static const Ways ways;
  return ways;
}

std::shared_ptr<const Ways> DefaultWays() { return Default(); }

ScopedDefaultWays::ScopedDefaultWays(std::shared_ptr<const Ways> ways)
    : before_(std::exchange(Default(), std::move(ways))) {}

ScopedDefaultWays::~ScopedDefaultWays() { Default() = std::move(before_); }

}  // namespace muster
