#include "tools/tiles/stretch.h"

#include <algorithm>
#include <cmath>

namespace muster::tools {
namespace {

/// So far off the straight line between its ends a stretch may bend: some 5 pixels on the screen.
constexpr double kMostOff = 48;
/// So far beyond its edge a tile's shapes are drawn.
constexpr std::int32_t kBeyond = 128;
/// Of a line; longer ones are looked at up to there.
constexpr std::size_t kMostLooked = 400;

bool IsNear(std::int32_t at) { return at >= -kBeyond && at <= kTileUnits + kBeyond; }
bool IsIn(double at) { return at >= 0 && at < kTileUnits; }

/// Whether the places between those two are near the straight line between them, and none goes
/// back.
bool IsStraight(const std::vector<std::int32_t>& places, std::size_t from, std::size_t to) {
  const double x = places[2 * from], y = places[2 * from + 1];
  const double dx = places[2 * to] - x, dy = places[2 * to + 1] - y;
  const double length = std::hypot(dx, dy);
  double gone = 0;
  for (std::size_t i = from + 1; i < to; ++i) {
    const double px = places[2 * i] - x, py = places[2 * i + 1] - y;
    const double along = (px * dx + py * dy) / length;
    if (std::abs(px * dy - py * dx) / length > kMostOff || along < gone) return false;
    gone = along;
  }
  return gone <= length;
}

}  // namespace

double Stretch::Length() const { return std::hypot(dx, dy); }

std::optional<Stretch> LongestStretch(const std::vector<std::int32_t>& places) {
  std::optional<Stretch> longest;
  const std::size_t n = std::min(places.size() / 2, kMostLooked);
  const auto is_near = [&](std::size_t i) {
    return IsNear(places[2 * i]) && IsNear(places[2 * i + 1]);
  };
  for (std::size_t from = 0; from < n; ++from) {
    if (!is_near(from)) continue;
    for (std::size_t to = from + 1; to < n && is_near(to); ++to) {
      const Stretch stretch = {places[2 * from], places[2 * from + 1],
                               places[2 * to] - places[2 * from],
                               places[2 * to + 1] - places[2 * from + 1]};
      if (stretch.Length() == 0 || !IsStraight(places, from, to)) break;
      if (!IsIn(stretch.x + stretch.dx / 2.0) || !IsIn(stretch.y + stretch.dy / 2.0)) continue;
      if (!longest || stretch.Length() > longest->Length()) longest = stretch;
    }
  }
  return longest;
}

}  // namespace muster::tools
