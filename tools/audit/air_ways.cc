#include "tools/audit/air_ways.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <stdexcept>
#include <utility>

#include "tools/audit/audit_scenario.h"

namespace muster::tools::audit {
namespace {

using nlohmann::json;

constexpr double kSlack_m = 0.005;
constexpr double kTie_m = 1e-7;  ///< lengths that differ by no more are equal
constexpr double kGrid_m = 100;
constexpr double kNever_m = std::numeric_limits<double>::infinity();

/// Twice the area of the triangle, above 0 where c is to the left of the line from a to b.
double Turn(Place a, Place b, Place c) {
  return (b.x_m - a.x_m) * (c.y_m - a.y_m) - (b.y_m - a.y_m) * (c.x_m - a.x_m);
}

/// Whether the first of two equally long flights is flown, by the place where each leads first: the
/// one further away, else further west, else further south.
bool IsBefore(Place from, Place a, Place b) {
  const double further_m = Apart(from, a) - Apart(from, b);
  if (std::abs(further_m) > kTie_m) return further_m > 0;
  return std::abs(a.x_m - b.x_m) > kTie_m ? a.x_m < b.x_m : a.y_m < b.y_m;
}

Place Between(Place a, Place b, double part) {
  return {a.x_m + part * (b.x_m - a.x_m), a.y_m + part * (b.y_m - a.y_m)};
}

/// A convex polygon, counter-clockwise.
struct Shape {
  explicit Shape(std::vector<Place> its) : corners(std::move(its)) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Place at = corners[i];
      sides_m.push_back(Apart(at, corners[(i + 1) % corners.size()]));
      low = {std::min(low.x_m, at.x_m), std::min(low.y_m, at.y_m)};
      high = {std::max(high.x_m, at.x_m), std::max(high.y_m, at.y_m)};
    }
  }
  std::vector<Place> corners;
  std::vector<double> sides_m;  ///< after each corner
  Place low{kNever_m, kNever_m}, high{-kNever_m, -kNever_m};

  /// Whether all of the line is on one side of it, to the west, east, south or north.
  bool IsBeside(Place a, Place b) const {
    return std::max(a.x_m, b.x_m) < low.x_m || std::min(a.x_m, b.x_m) > high.x_m ||
           std::max(a.y_m, b.y_m) < low.y_m || std::min(a.y_m, b.y_m) > high.y_m;
  }
  /// Metres of a place inside of the line through the side after corner i.
  double Depth(std::size_t i, Place at) const {
    return Turn(corners[i], corners[(i + 1) % corners.size()], at) / sides_m[i];
  }
  bool Has(Place at, double slack_m) const {
    if (IsBeside(at, at)) return false;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (Depth(i, at) <= slack_m) return false;
    }
    return true;
  }
  /// The part of the line after which it is inside; none: it never is.
  std::optional<double> EnteredAt(Place a, Place b) const {
    if (IsBeside(a, b)) return {};
    double from = 0, until = 1;
    for (std::size_t i = 0; i < corners.size() && from < until; ++i) {
      const double at_a = Depth(i, a) - kSlack_m, at_b = Depth(i, b) - kSlack_m;
      if (at_a <= 0 && at_b <= 0) return {};
      if (at_a > 0 && at_b > 0) continue;
      const double crossing = at_a / (at_a - at_b);
      (at_a <= 0 ? from : until) = at_a <= 0 ? std::max(from, crossing) : std::min(until, crossing);
    }
    return from < until ? std::optional(from) : std::nullopt;
  }
};

/// The convex hull (Andrew's monotone chain).
Shape HullOf(std::vector<Place> places) {
  std::sort(places.begin(), places.end(),
            [](Place a, Place b) { return std::pair(a.x_m, a.y_m) < std::pair(b.x_m, b.y_m); });
  std::vector<Place> hull;
  const auto add = [&](Place place, std::size_t keep) {
    while (hull.size() > keep && Turn(hull[hull.size() - 2], hull.back(), place) <= 1e-7) {
      hull.pop_back();
    }
    hull.push_back(place);
  };
  for (const Place place : places) add(place, 1);
  const std::size_t lower = hull.size();
  for (auto place = places.rbegin() + 1; place != places.rend(); ++place) add(*place, lower);
  hull.pop_back();
  return Shape(std::move(hull));
}

/// An edge of a zone, widened by the octagon whose sides are the margin away.
Shape Widened(Place a, Place b, double margin_m) {
  const double out_m = margin_m / std::cos(std::numbers::pi / 8);
  std::vector<Place> places;
  for (int k = 0; k < 8; ++k) {
    const double angle = (2 * k + 1) * std::numbers::pi / 8;
    for (const Place end : {a, b}) {
      places.push_back({end.x_m + out_m * std::cos(angle), end.y_m + out_m * std::sin(angle)});
    }
  }
  return HullOf(std::move(places));
}

/// The even-odd rule.
bool Encloses(const Rings& rings, Place at) {
  int crossed = 0;
  for (const auto& ring : rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Place a = ring[i], b = ring[(i + 1) % ring.size()];
      const bool up = a.y_m <= at.y_m && at.y_m < b.y_m, down = b.y_m <= at.y_m && at.y_m < a.y_m;
      if ((up && Turn(a, b, at) > 0) || (down && Turn(a, b, at) < 0)) ++crossed;
    }
  }
  return crossed % 2 == 1;
}

/// Where a flight may turn.
struct Corner {
  Place at;
  std::vector<std::pair<Place, Place>> beside;  ///< of each piece that has it: before and after it

  /// Whether a flight from there may turn here: the line leads past each of the pieces. One that
  /// led on into a piece would be shorter without this corner.
  bool TurnsFrom(Place from) const {
    // A side is to the left or right of the line only by more than a flight may be inside of it.
    const auto where = [&](Place end) {
      const double turn = Turn(from, at, end);
      if (std::abs(turn) <= 1.2 * kSlack_m * std::max(Apart(from, at), Apart(at, end))) return 0;
      return turn > 0 ? 1 : -1;
    };
    return std::none_of(beside.begin(), beside.end(), [&](const auto& sides) {
      return where(sides.first) * where(sides.second) < 0;
    });
  }
};

/// Pieces by square cells of the map, of which a line meets few.
class ShapeMap {
 public:
  void Add(const std::vector<Shape>& shapes) {
    shapes_ = &shapes;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      for (int x = Cell(shapes[i].low.x_m); x <= Cell(shapes[i].high.x_m); ++x) {
        for (int y = Cell(shapes[i].low.y_m); y <= Cell(shapes[i].high.y_m); ++y) {
          cells_[{y, x}].push_back(i);
        }
      }
    }
  }
  /// Whether test(shape) holds of none that may meet the line. A shape may be asked about twice.
  template <class Test>
  bool NoneNear(Place a, Place b, const Test& test) const {
    if (cells_.empty()) return true;
    if (a.y_m > b.y_m) std::swap(a, b);
    for (int y = Cell(a.y_m); y <= Cell(b.y_m); ++y) {
      // The part of the line in this row of cells.
      const auto at = [&](double y_m) {
        const double part = (y_m - a.y_m) / (b.y_m - a.y_m);
        return a.x_m + (b.x_m - a.x_m) * std::min(1.0, std::max(0.0, part));
      };
      const bool level = b.y_m == a.y_m;
      const double x0 = level ? a.x_m : at(y * kCell_m), x1 = level ? b.x_m : at((y + 1) * kCell_m);
      const auto end = cells_.upper_bound({y, Cell(std::max(x0, x1) + 1)});
      for (auto cell = cells_.lower_bound({y, Cell(std::min(x0, x1) - 1)}); cell != end; ++cell) {
        for (const std::size_t i : cell->second) {
          if (test((*shapes_)[i])) return false;
        }
      }
    }
    return true;
  }

 private:
  static constexpr double kCell_m = 500;
  static int Cell(double metres) { return static_cast<int>(std::floor(metres / kCell_m)); }

  const std::vector<Shape>* shapes_ = nullptr;
  std::map<std::pair<int, int>, std::vector<std::size_t>> cells_;  ///< by row and column
};

class AroundZones : public Ways {
 public:
  AroundZones(std::vector<Rings> zones, double margin_m, double width_m, double height_m,
              std::shared_ptr<const Ways> ground)
      : zones_(std::move(zones)),
        width_m_(width_m),
        height_m_(height_m),
        columns_(static_cast<int>(width_m / kGrid_m) + 1),
        rows_(static_cast<int>(height_m / kGrid_m) + 1),
        ground_(std::move(ground)) {
    for (const Rings& rings : zones_) {
      for (const auto& ring : rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
          shapes_.push_back(Widened(ring[i], ring[(i + 1) % ring.size()], margin_m));
        }
      }
    }
    map_.Add(shapes_);
  }

  double Length(int kind, Place from, Place to) const override {
    return kind == kUav ? RouteOf(from, to).second : ground_->Length(kind, from, to);
  }
  Place After(int kind, Place from, Place to, double part) const override {
    if (kind != kUav) return ground_->After(kind, from, to, part);
    const auto [places, length_m] = RouteOf(from, to);
    if (std::isinf(length_m)) return from;
    double left_m = part * length_m;
    for (std::size_t i = 1; i < places.size(); ++i) {
      const double step_m = Apart(places[i - 1], places[i]);
      if (left_m < step_m) return Between(places[i - 1], places[i], left_m / step_m);
      left_m -= step_m;
    }
    return to;
  }
  std::vector<double> TurnsOf(int kind, Place from, Place to) const override {
    if (kind != kUav) return ground_->TurnsOf(kind, from, to);
    const auto [places, length_m] = RouteOf(from, to);
    std::vector<double> parts;
    double gone_m = 0;
    for (std::size_t i = 1; i + 1 < places.size() && length_m > 0; ++i) {
      gone_m += Apart(places[i - 1], places[i]);
      parts.push_back(gone_m / length_m);
    }
    return parts;
  }
  double rounding_m(int kind) const override {
    return kind == kUav ? 0.01 : ground_->rounding_m(kind);
  }
  std::pair<Place, int> StopNear(int kind, Place wanted) const override {
    if (kind != kUav) return ground_->StopNear(kind, wanted);
    std::pair<Place, int> best{wanted, -1};
    double least_m = kNever_m;
    // Columns and rows no further away than the best so far.
    for (int reach = 2;; reach *= 2) {
      const int x = static_cast<int>(wanted.x_m / kGrid_m),
                y = static_cast<int>(wanted.y_m / kGrid_m);
      for (int j = std::max(0, y - reach); j <= std::min(rows_ - 1, y + reach); ++j) {
        for (int i = std::max(0, x - reach); i <= std::min(columns_ - 1, x + reach); ++i) {
          const Place at{i * kGrid_m, j * kGrid_m};
          const double away_m = Apart(wanted, at);
          if (away_m < least_m && IsFree(at)) {
            best = {at, j * columns_ + i};
            least_m = away_m;
          }
        }
      }
      if (least_m <= (reach - 1) * kGrid_m || reach > columns_ + rows_) return best;
    }
  }
  std::optional<Place> StopOf(int kind, int number) const override {
    if (kind != kUav) return ground_->StopOf(kind, number);
    if (number < 0 || number >= columns_ * rows_) return {};
    const int row = number / columns_;
    return Place{number % columns_ * kGrid_m, row * kGrid_m};
  }
  std::optional<double> MeetsAt(int kind, Place from, Place to, double part,
                                const std::set<int>& roads, const Ways& now) const override {
    const auto* const air_now = dynamic_cast<const AroundZones*>(&now);
    if (kind != kUav) return ground_->MeetsAt(kind, from, to, part, roads, *air_now->ground_);
    if (air_now->zones_ == zones_) return {};
    const auto [places, length_m] = RouteOf(from, to);
    if (std::isinf(length_m)) return {};
    double gone_m = 0;
    for (std::size_t i = 1; i < places.size(); ++i) {
      const double step_m = Apart(places[i - 1], places[i]), before_m = gone_m;
      gone_m += step_m;
      if (gone_m <= part * length_m) continue;
      const double skipped_m = std::max(0.0, part * length_m - before_m);
      const Place a = Between(places[i - 1], places[i], skipped_m / step_m);
      double in = air_now->IsFree(a) ? kNever_m : 0;
      for (const Shape& shape : air_now->shapes_) {
        if (const auto entered = shape.EnteredAt(a, places[i])) in = std::min(in, *entered);
      }
      if (in == kNever_m) continue;
      return std::max(part, (before_m + skipped_m + in * (step_m - skipped_m)) / length_m);
    }
    return {};
  }

 private:
  bool IsFree(Place at, double slack_m = kSlack_m) const {
    return map_.NoneNear(at, at, [&](const Shape& shape) { return shape.Has(at, slack_m); }) &&
           std::none_of(zones_.begin(), zones_.end(),
                        [&](const Rings& rings) { return Encloses(rings, at); });
  }
  bool IsInArea(Place at) const {
    return 0 <= at.x_m && at.x_m <= width_m_ && 0 <= at.y_m && at.y_m <= height_m_;
  }
  bool SeesEachOther(Place a, Place b) const {
    return map_.NoneNear(a, b,
                         [&](const Shape& shape) { return shape.EnteredAt(a, b).has_value(); });
  }
  /// Found when they are asked for: where zones are added one by one, hardly anybody flies between.
  const std::vector<Corner>& Corners() const {
    if (!corners_.empty() || shapes_.empty()) return corners_;
    std::map<std::pair<double, double>, std::size_t> known;  // pieces of one zone share corners
    for (const Shape& shape : shapes_) {
      const std::size_t n = shape.corners.size();
      for (std::size_t i = 0; i < n; ++i) {
        const Place at = shape.corners[i];
        if (!IsInArea(at) || !IsFree(at)) continue;
        const auto [which, is_new] = known.try_emplace({at.x_m, at.y_m}, corners_.size());
        if (is_new) corners_.push_back({at, {}});
        corners_[which->second].beside.emplace_back(shape.corners[(i + n - 1) % n],
                                                    shape.corners[(i + 1) % n]);
      }
    }
    rows_seen_.resize(corners_.size());
    return corners_;
  }
  struct Sight {
    std::size_t corner;
    double metres;
  };
  /// The corners in sight at which a flight from there may turn. `own`: the corner that it is at.
  std::vector<Sight> ToCorners(Place at, const Corner* own = nullptr) const {
    std::vector<Sight> seen;
    for (std::size_t i = 0; i < Corners().size(); ++i) {
      const Corner& corner = Corners()[i];
      if ((own == nullptr || own->TurnsFrom(corner.at)) && corner.TurnsFrom(at) &&
          Apart(at, corner.at) > 0 && SeesEachOther(at, corner.at)) {
        seen.push_back({i, Apart(at, corner.at)});
      }
    }
    return seen;
  }
  const std::vector<Sight>& RowOf(std::size_t corner) const {
    auto& row = rows_seen_[corner];
    if (!row) row = ToCorners(Corners()[corner].at, &Corners()[corner]);
    return *row;
  }
  /// To a goal: what is left from each corner, and the corner after it; -1: the goal.
  struct Rest {
    std::vector<double> metres;
    std::vector<int> next;
  };
  const Rest& RestTo(Place goal) const {
    constexpr std::size_t kMost = 2000;
    if (rests_.size() >= kMost) rests_.clear();
    const auto [known, is_new] = rests_.try_emplace({goal.x_m, goal.y_m});
    Rest& rest = known->second;
    if (!is_new) return rest;
    rest.metres.assign(Corners().size(), kNever_m);
    rest.next.assign(Corners().size(), -1);
    std::set<std::pair<double, std::size_t>> rim;
    const auto offer = [&](std::size_t corner, double metres, int next) {
      if (metres >= rest.metres[corner]) return;
      rim.erase({rest.metres[corner], corner});
      rim.insert({metres, corner});
      rest.metres[corner] = metres;
      rest.next[corner] = next;
    };
    const std::vector<Sight> straight = ToCorners(goal);
    for (const Sight& seen : straight) offer(seen.corner, seen.metres, -1);
    while (!rim.empty()) {
      const auto [metres, least] = *rim.begin();
      rim.erase(rim.begin());
      for (const Sight& seen : RowOf(least)) {
        offer(seen.corner, metres + seen.metres, static_cast<int>(least));
      }
    }
    // From each corner straight to the goal if it is in sight, else to the first of those corners
    // that lead there equally soon.
    for (std::size_t i = 0; i < rest.next.size(); ++i) {
      if (rest.next[i] >= 0)
        rest.next[i] = FirstOf(Corners()[i].at, RowOf(i), rest, rest.metres[i]);
    }
    for (const Sight& seen : straight) rest.next[seen.corner] = -1;
    return rest;
  }
  /// Of the corners that are in sight, the first by which no more than `least_m` is left; -1: none.
  int FirstOf(Place from, const std::vector<Sight>& sight, const Rest& rest, double least_m) const {
    int first = -1;
    for (const auto& [i, metres] : sight) {
      if (!(metres + rest.metres[i] <= least_m + kTie_m)) continue;
      if (rest.metres[i] >= least_m) continue;
      const bool is_before = first < 0 || IsBefore(from, Corners()[i].at,
                                                   Corners()[static_cast<std::size_t>(first)].at);
      if (is_before) first = static_cast<int>(i);
    }
    return first;
  }
  /// Where a place that is not free is left for: the nearest free place, which is straight out of a
  /// side of a piece, a corner, where a side leaves the area, or where sides of two pieces cross.
  std::optional<Place> OutOf(Place at) const {
    std::optional<Place> nearest;
    double least_m = kNever_m;
    const auto offer = [&](Place out) {
      const double metres = Apart(at, out);
      if (metres > least_m + kTie_m || !IsInArea(out) || !IsFree(out, kTie_m)) return;
      if (!nearest || metres < least_m - kTie_m || IsBefore(at, out, *nearest)) nearest = out;
      least_m = std::min(least_m, metres);
    };
    for (const Shape& shape : shapes_) {
      for (std::size_t i = 0; i < shape.corners.size(); ++i) {
        const double depth_m = shape.Depth(i, at);
        if (depth_m < 0) continue;
        const Place a = shape.corners[i], b = shape.corners[(i + 1) % shape.corners.size()];
        const double side_m = Apart(a, b);
        offer({at.x_m + depth_m * (b.y_m - a.y_m) / side_m,
               at.y_m - depth_m * (b.x_m - a.x_m) / side_m});
      }
    }
    for (const Corner& corner : Corners()) offer(corner.at);
    for (const Shape& shape : shapes_) OfferBorders(shape, offer);
    for (std::size_t k = 0; k < shapes_.size(); ++k) {
      for (std::size_t l = 0; l < k; ++l) {
        if (shapes_[k].IsBeside(shapes_[l].low, shapes_[l].high)) continue;
        OfferCrossings(shapes_[k], shapes_[l], offer);
      }
    }
    return nearest;
  }
  /// Where its sides leave the area.
  template <class Offer>
  void OfferBorders(const Shape& shape, const Offer& offer) const {
    for (std::size_t i = 0; i < shape.corners.size(); ++i) {
      const Place a = shape.corners[i], b = shape.corners[(i + 1) % shape.corners.size()];
      for (const double x_m : {0.0, width_m_}) {
        const double part = (x_m - a.x_m) / (b.x_m - a.x_m);
        if (0 <= part && part <= 1) offer({x_m, a.y_m + part * (b.y_m - a.y_m)});
      }
      for (const double y_m : {0.0, height_m_}) {
        const double part = (y_m - a.y_m) / (b.y_m - a.y_m);
        if (0 <= part && part <= 1) offer({a.x_m + part * (b.x_m - a.x_m), y_m});
      }
    }
  }
  template <class Offer>
  static void OfferCrossings(const Shape& one, const Shape& other, const Offer& offer) {
    for (std::size_t i = 0; i < one.corners.size(); ++i) {
      const Place a = one.corners[i], b = one.corners[(i + 1) % one.corners.size()];
      for (std::size_t j = 0; j < other.corners.size(); ++j) {
        const double at_a = other.Depth(j, a), at_b = other.Depth(j, b);
        if (at_a * at_b < 0) offer(Between(a, b, at_a / (at_a - at_b)));
      }
    }
  }
  std::pair<std::vector<Place>, double> RouteOf(Place from, Place to) const {
    std::vector<Place> places{from};
    if (from.x_m == to.x_m && from.y_m == to.y_m) return {places, 0};
    if (!IsFree(to)) return {places, kNever_m};
    double metres = 0;
    if (!IsFree(from)) {
      const auto out = OutOf(from);
      if (!out) return {places, kNever_m};
      metres = Apart(from, *out);
      places.push_back(*out);
    }
    const Place begin = places.back();
    if (SeesEachOther(begin, to)) {
      places.push_back(to);
      return {places, metres + Apart(begin, to)};
    }
    const Rest& rest = RestTo(to);
    if (!sight_of_ || sight_of_->x_m != begin.x_m || sight_of_->y_m != begin.y_m) {
      sight_ = ToCorners(begin);
      sight_of_ = begin;
    }
    const std::vector<Sight>& first = sight_;
    double least_m = kNever_m;
    for (const auto& [i, metres_there] : first) {
      least_m = std::min(least_m, metres_there + rest.metres[i]);
    }
    if (std::isinf(least_m)) return {places, kNever_m};
    int best = FirstOf(begin, first, rest, least_m);
    for (; best >= 0; best = rest.next[static_cast<std::size_t>(best)]) {
      places.push_back(Corners()[static_cast<std::size_t>(best)].at);
    }
    places.push_back(to);
    return {places, metres + least_m};
  }

  std::vector<Rings> zones_;
  std::vector<Shape> shapes_;
  ShapeMap map_;
  double width_m_, height_m_;  ///< flights stay in the area
  int columns_, rows_;
  std::shared_ptr<const Ways> ground_;
  mutable std::vector<Corner> corners_;
  mutable std::vector<std::optional<std::vector<Sight>>> rows_seen_;
  mutable std::map<std::pair<double, double>, Rest> rests_;
  mutable std::optional<Place> sight_of_;  ///< whence a flight was looked for last
  mutable std::vector<Sight> sight_;       ///< from there
};

Place InMillimetres(double x_m, double y_m) {
  return {std::round(x_m * 1000) / 1000, std::round(y_m * 1000) / 1000};
}

}  // namespace

Rings ReadZone(const std::string& text) {
  const json zone = json::parse(text);
  Rings rings;
  if (zone.contains("circle_km")) {
    const json& circle = zone.at("circle_km");
    const double out_m = circle.at(2).get<double>() * 1000 / std::cos(std::numbers::pi / 16);
    std::vector<Place> ring;
    for (int k = 0; k < 16; ++k) {
      const double angle = k * std::numbers::pi / 8;
      ring.push_back(InMillimetres(circle.at(0).get<double>() * 1000 + out_m * std::cos(angle),
                                   circle.at(1).get<double>() * 1000 + out_m * std::sin(angle)));
    }
    return {ring};
  }
  const auto add = [&](const json& corners) {
    std::vector<Place> ring;
    for (const json& corner : corners) {
      ring.push_back(
          InMillimetres(corner.at(0).get<double>() * 1000, corner.at(1).get<double>() * 1000));
    }
    const auto same = [](Place a, Place b) { return a.x_m == b.x_m && a.y_m == b.y_m; };
    ring.erase(std::unique(ring.begin(), ring.end(), same), ring.end());
    while (ring.size() > 1 && same(ring.front(), ring.back())) ring.pop_back();
    if (ring.size() < 3) throw std::invalid_argument("a ring has fewer than 3 corners");
    rings.push_back(std::move(ring));
  };
  add(zone.at("area_km"));
  for (const json& hole : zone.value("holes_km", json::array())) add(hole);
  return rings;
}

std::shared_ptr<const Ways> FlyAround(std::vector<Rings> zones, double margin_m, double width_m,
                                      double height_m, std::shared_ptr<const Ways> ground) {
  return std::make_shared<const AroundZones>(std::move(zones), margin_m, width_m, height_m,
                                             std::move(ground));
}

}  // namespace muster::tools::audit
