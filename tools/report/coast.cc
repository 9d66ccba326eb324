#include "tools/report/coast.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "base/check.h"

namespace muster::tools {
namespace {

using nlohmann::ordered_json;
using Place = ShoreGrid::Place;
using Ring = std::vector<Place>;

constexpr double kAround = 0.6;  ///< of the area's longer side: what a map shows more
constexpr double kUnits = 1e5;   ///< of the page's degrees: a metre

bool Same(const Place& a, const Place& b) { return a.x == b.x && a.y == b.y; }

/// The bins that a box touches as one rectangle, its shores joined across the bins' sides.
class Shores {
 public:
  Shores(const ShoreGrid& grid, const DegreeBox& box)
      : grid_(grid),
        column_(static_cast<int>(std::floor(box.west / grid.bin_deg))),
        row_(std::max(0, static_cast<int>(std::floor((box.south + 90) / grid.bin_deg)))) {
    const int columns = static_cast<int>(std::ceil(box.east / grid.bin_deg)) - column_;
    const int rows =
        std::min(grid.rows, static_cast<int>(std::ceil((box.north + 90) / grid.bin_deg))) - row_;
    wide_ = columns * ShoreGrid::kSide;
    high_ = rows * ShoreGrid::kSide;
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) Take(column, row);
    }
    Join();
    Close();
  }

  std::vector<std::vector<double>> degrees() const {
    std::vector<std::vector<double>> rings;
    for (const Ring& ring : rings_) {
      std::vector<double>& flat = rings.emplace_back();
      for (const Place& place : ring) {
        flat.push_back(Degrees(place.y, row_) - 90);
        flat.push_back(Degrees(place.x, column_));
      }
    }
    return rings;
  }

 private:
  double Degrees(std::int64_t at, int first) const {
    return (first + static_cast<double>(at) / ShoreGrid::kSide) * grid_.bin_deg;
  }

  void Take(int column, int row) {
    const int around = ((column_ + column) % grid_.columns + grid_.columns) % grid_.columns;
    ShoreGrid::Bin bin = grid_.read(around, row_ + row);
    if (column == 0 && row == 0) south_west_ = bin.corners[0];
    for (Ring& segment : bin.segments) {
      if (segment.size() < 2) continue;
      for (Place& place : segment) {
        place.x += column * ShoreGrid::kSide;
        place.y += row * ShoreGrid::kSide;
      }
      (Same(segment.front(), segment.back()) ? rings_ : lines_).push_back(std::move(segment));
    }
  }

  bool OnBorder(const Place& p) const {
    return p.x == 0 || p.y == 0 || p.x == wide_ || p.y == high_;
  }

  /// Joins lines that end at the same place, until each is closed or ends at the border.
  void Join() {
    std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>> ending;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      ending[{lines_[i].front().x, lines_[i].front().y}].push_back(i);
      ending[{lines_[i].back().x, lines_[i].back().y}].push_back(i);
    }
    std::vector<bool> used(lines_.size());
    const auto next = [&](const Place& at) -> std::optional<std::size_t> {
      for (const std::size_t i : ending[{at.x, at.y}]) {
        if (!used[i]) return i;
      }
      return {};
    };
    std::vector<Ring> joined;
    for (std::size_t first = 0; first < lines_.size(); ++first) {
      if (used[first]) continue;
      used[first] = true;
      Ring line = lines_[first];
      for (int end = 0; end < 2; ++end) {  // onwards, then from where it began
        while (!OnBorder(line.back())) {
          const auto more = next(line.back());
          if (!more) break;
          used[*more] = true;
          Ring part = lines_[*more];
          if (!Same(part.front(), line.back())) std::reverse(part.begin(), part.end());
          line.insert(line.end(), part.begin() + 1, part.end());
        }
        if (Same(line.front(), line.back())) break;
        std::reverse(line.begin(), line.end());
      }
      if (Same(line.front(), line.back())) {
        rings_.push_back(std::move(line));
      } else {
        if (!OnBorder(line.front()) || !OnBorder(line.back())) {
          throw InputError(grid_.source + ": a shore ends within the bins");
        }
        joined.push_back(std::move(line));
      }
    }
    lines_ = std::move(joined);
  }

  /// How far along the border, from its south-west corner eastwards.
  std::int64_t Along(const Place& p) const {
    if (p.y == 0) return p.x;
    if (p.x == wide_) return wide_ + p.y;
    if (p.y == high_) return 2 * wide_ + high_ - p.x;
    return 2 * (wide_ + high_) - p.y;
  }

  /// Makes rings of the lines and those parts of the border that are land.
  void Close() {
    struct End {
      std::int64_t along;
      std::size_t line;
      bool back;
    };
    std::vector<End> ends;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      ends.push_back({Along(lines_[i].front()), i, false});
      ends.push_back({Along(lines_[i].back()), i, true});
    }
    std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
      return std::tie(a.along, a.line, a.back) < std::tie(b.along, b.line, b.back);
    });
    const Ring corners = {{0, 0}, {wide_, 0}, {wide_, high_}, {0, high_}};
    const bool land = south_west_ % 2 == 1;
    if (ends.empty() && land) rings_.push_back(corners);
    // Land lies after the ends of even place in the order, or of odd place, as the corner says.
    const std::size_t n = ends.size();
    std::vector<std::array<std::size_t, 2>> place(lines_.size());
    for (std::size_t i = 0; i < n; ++i) place[ends[i].line][ends[i].back ? 1 : 0] = i;
    std::vector<bool> used(lines_.size());
    for (std::size_t first = 0; first < lines_.size(); ++first) {
      if (used[first]) continue;
      Ring ring;
      std::size_t line = first;
      bool forward = true;
      while (!used[line]) {
        used[line] = true;
        Ring part = lines_[line];
        if (!forward) std::reverse(part.begin(), part.end());
        ring.insert(ring.end(), part.begin(), part.end());
        const std::size_t from = place[line][forward ? 1 : 0];
        const bool onwards = (from % 2 == 1) == land;
        const std::size_t to = (from + (onwards ? 1 : n - 1)) % n;
        AddCorners(corners, ends[from].along, ends[to].along, onwards, &ring);
        line = ends[to].line;
        forward = !ends[to].back;
      }
      rings_.push_back(std::move(ring));
    }
  }

  /// The corners between two places of the border.
  void AddCorners(const Ring& corners, std::int64_t from, std::int64_t to, bool onwards,
                  Ring* ring) const {
    const std::int64_t all = 2 * (wide_ + high_);
    const auto ahead = [&](std::int64_t at) {
      return (((onwards ? at - from : from - at) % all) + all) % all;
    };
    // The way from an end to itself leads all around only when there is no other end.
    const std::int64_t whole = ahead(to);
    std::vector<std::pair<std::int64_t, Place>> between;
    for (const Place& corner : corners) {
      const std::int64_t at = ahead(Along(corner));
      if (at > 0 && at < whole) between.emplace_back(at, corner);
    }
    std::sort(between.begin(), between.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [at, corner] : between) ring->push_back(corner);
  }

  const ShoreGrid& grid_;
  int column_, row_;  // of the south-western bin
  std::int64_t wide_ = 0, high_ = 0;
  int south_west_ = 0;
  std::vector<Ring> lines_, rings_;
};

/// One side of the box: what of the ring lies within. Source: Sutherland and Hodgman, Reentrant
/// polygon clipping, 1974. `axis`: 0 latitude, 1 longitude; `sign`: 1 keeps what is larger.
std::vector<double> Clip(const std::vector<double>& ring, int axis, double limit, int sign) {
  std::vector<double> kept;
  const std::size_t n = ring.size() / 2;
  const auto at = [&](std::size_t i, int which) {
    return ring[2 * i + static_cast<std::size_t>(which)];
  };
  const auto inside = [&](std::size_t i) { return sign * (at(i, axis) - limit) >= 0; };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = (i + n - 1) % n;
    if (inside(i) != inside(before)) {
      const double share = (limit - at(before, axis)) / (at(i, axis) - at(before, axis));
      const double other = at(before, 1 - axis) + share * (at(i, 1 - axis) - at(before, 1 - axis));
      kept.push_back(axis == 0 ? limit : other);
      kept.push_back(axis == 0 ? other : limit);
    }
    if (inside(i)) {
      kept.push_back(at(i, 0));
      kept.push_back(at(i, 1));
    }
  }
  return kept;
}

}  // namespace

std::vector<std::vector<double>> LandWithin(const ShoreGrid& grid, const DegreeBox& box) {
  MUSTER_CHECK(grid.bin_deg > 0 && box.south < box.north && box.west < box.east);
  std::vector<std::vector<double>> land;
  for (std::vector<double>& ring : Shores(grid, box).degrees()) {
    ring = Clip(ring, 0, box.south, 1);
    ring = Clip(ring, 0, box.north, -1);
    ring = Clip(ring, 1, box.west, 1);
    ring = Clip(ring, 1, box.east, -1);
    if (ring.size() >= 6) land.push_back(std::move(ring));
  }
  return land;
}

ordered_json Coast(const ShoreGrid& grid, const Scenario& scenario) {
  const DegreeBox around =
      BoxAround(scenario, kAround * std::max(scenario.width_m, scenario.height_m));
  const auto whole = [](double degrees) {
    return static_cast<std::int64_t>(std::llround(degrees * kUnits));
  };
  const auto round = [&](double degrees) { return static_cast<double>(whole(degrees)) / kUnits; };
  const DegreeBox box = {round(around.south), round(around.west), round(around.north),
                         round(around.east)};
  ordered_json rings = ordered_json::array();
  for (const std::vector<double>& ring : LandWithin(grid, box)) {
    ordered_json flat = ordered_json::array();
    std::int64_t latitude = 0, longitude = 0;
    for (std::size_t i = 0; i < ring.size(); i += 2) {
      const std::int64_t north = whole(ring[i]), east = whole(ring[i + 1]);
      if (i > 0 && north == latitude && east == longitude) continue;
      flat.push_back(north - latitude);
      flat.push_back(east - longitude);
      latitude = north, longitude = east;
    }
    if (flat.size() >= 6) rings.push_back(std::move(flat));
  }
  return {{"source", grid.source},
          {"box", {whole(box.south), whole(box.west), whole(box.north), whole(box.east)}},
          {"rings", std::move(rings)}};
}

}  // namespace muster::tools
