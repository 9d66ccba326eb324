#include "tools/scenario/window.h"

#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/check.h"

namespace muster::tools {
namespace {

constexpr double kStepM = 100;
/// Depth below the corner's tangent plane at which a place counts as beyond the horizon: 1,100 km
/// away, where ENU means nothing any more.
constexpr double kDeepestM = -100'000;

struct Square {
  long row, column;
  std::size_t count;
};

/// Corner, in the frame of `points`, of the window with the most of them.
Point DensestCorner(const std::vector<Point>& points, double width_m, double height_m) {
  std::map<std::pair<long, long>, std::size_t> counts;
  for (const Point& p : points) {
    if (std::isfinite(p.x_m)) {
      ++counts[{static_cast<long>(std::floor(p.y_m / kStepM)),
                static_cast<long>(std::floor(p.x_m / kStepM))}];
    }
  }
  std::vector<Square> squares;
  squares.reserve(counts.size());
  for (const auto& [at, count] : counts) squares.push_back({at.first, at.second, count});

  const long rows = std::max(1L, std::lround(height_m / kStepM));
  const long columns = std::max(1L, std::lround(width_m / kStepM));
  std::size_t best = 0;
  Point corner;
  std::vector<Square> band;
  // A best window can be moved north and east until its edges touch a place.
  for (auto bottom = squares.begin(); bottom != squares.end();) {
    const long row = bottom->row;
    auto top = bottom;
    while (top != squares.end() && top->row < row + rows) ++top;
    band.assign(bottom, top);
    std::stable_sort(band.begin(), band.end(),
                     [](const Square& a, const Square& b) { return a.column < b.column; });
    std::size_t inside = 0;
    std::size_t right = 0;
    for (std::size_t left = 0; left < band.size(); ++left) {
      while (right < band.size() && band[right].column < band[left].column + columns) {
        inside += band[right++].count;
      }
      if (inside > best) {
        best = inside;
        corner = {static_cast<double>(band[left].column) * kStepM,
                  static_cast<double>(row) * kStepM};
      }
      inside -= band[left].count;
    }
    while (bottom != squares.end() && bottom->row == row) ++bottom;
  }
  return corner;
}

/// Middle of the square degree with the most places: a frame to start from, whatever outliers there
/// are.
Origin DensestDegree(const std::vector<Origin>& places) {
  std::map<std::pair<double, double>, std::size_t> counts;
  for (const Origin& place : places) {
    ++counts[{std::floor(place.latitude_deg), std::floor(place.longitude_deg)}];
  }
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return {std::min(most->first.first + 0.5, 90.0), most->first.second + 0.5};
}

double RoundDegrees(double degrees) { return std::round(degrees * 1e6) / 1e6; }

}  // namespace

std::vector<Point> Project(const std::vector<Origin>& places, Origin corner) {
  const GeographicLib::LocalCartesian local(corner.latitude_deg, corner.longitude_deg);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Point> points;
  points.reserve(places.size());
  for (const Origin& place : places) {
    double z_m = 0;
    Point& p = points.emplace_back();
    local.Forward(place.latitude_deg, place.longitude_deg, 0, p.x_m, p.y_m, z_m);
    if (z_m < kDeepestM) p = {kNan, kNan};
  }
  return points;
}

Window DensestWindow(const std::vector<Origin>& places, double width_m, double height_m) {
  MUSTER_CHECK(!places.empty());
  Origin frame = DensestDegree(places);
  // The search's frame should be the window's own, which is known afterwards: repeat, keep the
  // best.
  constexpr int kRounds = 4;
  Window best;
  for (int round = 0; round < kRounds; ++round) {
    const Point corner = DensestCorner(Project(places, frame), width_m, height_m);
    Origin origin;
    double height = 0;
    GeographicLib::LocalCartesian(frame.latitude_deg, frame.longitude_deg)
        .Reverse(corner.x_m, corner.y_m, 0, origin.latitude_deg, origin.longitude_deg, height);
    frame = {RoundDegrees(origin.latitude_deg), RoundDegrees(origin.longitude_deg)};
    std::size_t count = 0;
    for (const Point& p : Project(places, frame)) count += InWindow(p, width_m, height_m) ? 1 : 0;
    if (count > best.count || round == 0) best = {frame, count};
  }
  return best;
}

}  // namespace muster::tools
