#include "tools/scenario/window.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/check.h"
#include "tools/map/local_frame.h"

namespace muster::tools {
namespace {

constexpr double kStepM = 100;

struct Square {
  long row, column;
  std::size_t count;
};

/// How many places a window holds, by the column that it begins at. Each change and each question
/// takes O(log columns).
class WindowCounts {
 public:
  explicit WindowCounts(std::size_t columns) {
    while (leaves_ < columns) leaves_ *= 2;
    most_.resize(2 * leaves_);
    added_.resize(2 * leaves_);
  }

  /// To windows that begin in [from, until].
  void Add(std::size_t from, std::size_t until, long count) {
    Add(1, 0, leaves_ - 1, from, until, count);
  }

  long most() const { return most_[1]; }

  /// The first column whose window holds the most.
  std::size_t First() const {
    std::size_t node = 1;
    while (node < leaves_) node = most_[2 * node] >= most_[2 * node + 1] ? 2 * node : 2 * node + 1;
    return node - leaves_;
  }

 private:
  void Add(std::size_t node, std::size_t low, std::size_t high, std::size_t from, std::size_t until,
           long count) {
    if (until < low || high < from) return;
    if (from <= low && high <= until) {
      most_[node] += count;
      added_[node] += count;
      return;
    }
    const std::size_t middle = low + (high - low) / 2;
    Add(2 * node, low, middle, from, until, count);
    Add(2 * node + 1, middle + 1, high, from, until, count);
    most_[node] = std::max(most_[2 * node], most_[2 * node + 1]) + added_[node];
  }

  std::size_t leaves_ = 1;
  std::vector<long> most_, added_;  // of a binary heap's nodes: below it, with what is added there
};

/// The squares that hold places, by row, then column.
std::vector<Square> SquaresOf(const std::vector<Point>& points) {
  std::vector<Square> squares;
  squares.reserve(points.size());
  for (const Point& p : points) {
    if (!std::isfinite(p.x_m)) continue;
    squares.push_back({static_cast<long>(std::floor(p.y_m / kStepM)),
                       static_cast<long>(std::floor(p.x_m / kStepM)), 1});
  }
  std::sort(squares.begin(), squares.end(), [](const Square& a, const Square& b) {
    return std::pair(a.row, a.column) < std::pair(b.row, b.column);
  });
  std::size_t kept = 0;
  for (const Square& square : squares) {
    if (kept > 0 && squares[kept - 1].row == square.row &&
        squares[kept - 1].column == square.column) {
      ++squares[kept - 1].count;
    } else {
      squares[kept++] = square;
    }
  }
  squares.resize(kept);
  return squares;
}

/// Corner, in the frame of `points`, of the window with the most of them. A band of the window's
/// height sweeps north; squares enter and leave it once.
Point DensestCorner(const std::vector<Point>& points, double width_m, double height_m) {
  const std::vector<Square> squares = SquaresOf(points);
  if (squares.empty()) return {};
  std::vector<long> columns;
  for (const Square& square : squares) columns.push_back(square.column);
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  const auto index_of = [&](long column) {  // of the first column that is not west of it
    return static_cast<std::size_t>(std::lower_bound(columns.begin(), columns.end(), column) -
                                    columns.begin());
  };
  const long band_rows = std::max(1L, std::lround(height_m / kStepM));
  const long band_columns = std::max(1L, std::lround(width_m / kStepM));
  WindowCounts counts(columns.size());
  const auto add = [&](const Square& square, long sign) {
    counts.Add(index_of(square.column - band_columns + 1), index_of(square.column),
               sign * static_cast<long>(square.count));
  };
  long best = 0, best_row = 0, best_column = 0;
  // A best window can be moved north and east until its edges touch a place.
  auto top = squares.begin();
  for (auto bottom = squares.begin(); bottom != squares.end();) {
    const long row = bottom->row;
    for (; top != squares.end() && top->row < row + band_rows; ++top) add(*top, 1);
    if (counts.most() > best) {
      best = counts.most();
      best_row = row;
      best_column = columns[counts.First()];
    }
    for (; bottom != squares.end() && bottom->row == row; ++bottom) add(*bottom, -1);
  }
  // East until its western edge touches a place of its own.
  long edge = std::numeric_limits<long>::max();
  for (const Square& square : squares) {
    if (square.row >= best_row && square.row < best_row + band_rows &&
        square.column >= best_column) {
      edge = std::min(edge, square.column);
    }
  }
  return {static_cast<double>(edge) * kStepM, static_cast<double>(best_row) * kStepM};
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
  const LocalFrame frame(corner);
  std::vector<Point> points;
  points.reserve(places.size());
  for (const Origin& place : places) points.push_back(frame.ToPoint(place));
  return points;
}

Origin RoundToMicrodegrees(Origin place) {
  return {RoundDegrees(place.latitude_deg), RoundDegrees(place.longitude_deg)};
}

Window DensestWindow(const std::vector<Origin>& places, double width_m, double height_m) {
  MUSTER_CHECK(!places.empty());
  Origin frame = DensestDegree(places);
  // The search's frame should be the window's own, which is known afterwards: repeat, keep the
  // best.
  constexpr int kRounds = 4;
  Window best;
  std::vector<Point> points = Project(places, frame);
  for (int round = 0; round < kRounds; ++round) {
    const Point corner = DensestCorner(points, width_m, height_m);
    const Origin origin = LocalFrame(frame).ToPlace(corner);
    frame = RoundToMicrodegrees(origin);
    points = Project(places, frame);
    std::size_t count = 0;
    for (const Point& p : points) count += InWindow(p, width_m, height_m) ? 1 : 0;
    if (count > best.count || round == 0) best = {frame, count};
  }
  return best;
}

}  // namespace muster::tools
