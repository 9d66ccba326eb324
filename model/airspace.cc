#include "model/airspace.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "base/index.h"

namespace muster {
namespace {

constexpr double kNowhere = std::numeric_limits<double>::infinity();
/// A flight along a piece is not in it, though its places are rounded.
constexpr double kRounding_m = 0.005;
constexpr double kHalfRoot = 0.70710678118654752;  // of 2
constexpr double kTan = 0.41421356237309505;       // of 22.5 degrees
constexpr std::size_t kMostInLeaf = 4;

/// Places that are so near to each other are the same corner.
constexpr double kSame_m = 0.001;

/// A place that is so near to the line of a side counts as lying on it: more than kRounding_m, as
/// agents that fly along a piece are asked for their way from there.
constexpr double kBeside_m = 0.006;

/// Corners of the octagon around 0 whose sides are that far away.
std::array<Point, 8> Octagon(double margin_m) {
  const double t = margin_m * kTan;
  return {{{margin_m, t},
           {t, margin_m},
           {-t, margin_m},
           {-margin_m, t},
           {-margin_m, -t},
           {-t, -margin_m},
           {t, -margin_m},
           {margin_m, -t}}};
}

Point Sum(Point a, Point b) { return {a.x_m + b.x_m, a.y_m + b.y_m}; }
Point Difference(Point a, Point b) { return {a.x_m - b.x_m, a.y_m - b.y_m}; }
double Cross(Point a, Point b) { return a.x_m * b.y_m - a.y_m * b.x_m; }
double Square(Point a) { return a.x_m * a.x_m + a.y_m * a.y_m; }

/// From that corner of a piece between two places, along its sides to the left and to the right.
std::array<Point, 2> SidesAt(Point corner, Point a, Point b, const std::array<Point, 8>& octagon) {
  std::optional<Point> left, right;
  for (const Point end : {a, b}) {
    for (const Point out : octagon) {
      const Point side = Difference(Sum(end, out), corner);
      if (std::abs(side.x_m) + std::abs(side.y_m) < kSame_m) continue;
      if (!left || Cross(*left, side) > 0) left = side;
      if (!right || Cross(*right, side) < 0) right = side;
    }
  }
  return {*left, *right};
}

}  // namespace

bool Airspace::Box::Misses(Point a, Point b) const {
  return std::max(a.x_m, b.x_m) <= x0 || std::min(a.x_m, b.x_m) >= x1 ||
         std::max(a.y_m, b.y_m) <= y0 || std::min(a.y_m, b.y_m) >= y1;
}

void Airspace::Box::Add(const Box& other) {
  *this = {std::min(x0, other.x0), std::min(y0, other.y0), std::max(x1, other.x1),
           std::max(y1, other.y1)};
}

Airspace::Piece Airspace::Widened(Point a, Point b, double margin_m) {
  Piece piece;
  piece.a = a;
  piece.b = b;
  piece.box = {std::min(a.x_m, b.x_m) - margin_m, std::min(a.y_m, b.y_m) - margin_m,
               std::max(a.x_m, b.x_m) + margin_m, std::max(a.y_m, b.y_m) + margin_m};
  std::size_t n = 0;
  const auto add = [&](double x, double y, double support_m) {
    piece.sides[n++] = {x, y, std::max(x * a.x_m + y * a.y_m, x * b.x_m + y * b.y_m) + support_m};
  };
  const double normals[8][2] = {
      {1, 0},  {kHalfRoot, kHalfRoot},   {0, 1},  {-kHalfRoot, kHalfRoot},
      {-1, 0}, {-kHalfRoot, -kHalfRoot}, {0, -1}, {kHalfRoot, -kHalfRoot}};
  for (const auto& normal : normals) add(normal[0], normal[1], margin_m);
  const double length_m = Distance(a, b);
  const double x = (b.y_m - a.y_m) / length_m, y = (a.x_m - b.x_m) / length_m;
  double support_m = 0;
  for (const Point corner : Octagon(margin_m)) {
    support_m = std::max(support_m, x * corner.x_m + y * corner.y_m);
  }
  add(x, y, support_m);
  add(-x, -y, support_m);
  return piece;
}

std::optional<double> Airspace::EntersPiece(const Piece& piece, Point a, Point b) {
  if (piece.box.Misses(a, b)) return {};
  double in = 0, out = 1;
  for (const Side& side : piece.sides) {
    const double limit = side.limit - kRounding_m;
    const double from = side.normal_x * a.x_m + side.normal_y * a.y_m - limit;
    const double to = side.normal_x * b.x_m + side.normal_y * b.y_m - limit;
    if (from >= 0 && to >= 0) return {};
    if (from < 0 && to < 0) continue;
    const double share = from / (from - to);
    if (from >= 0) {
      in = std::max(in, share);
    } else {
      out = std::min(out, share);
    }
    if (in >= out) return {};
  }
  return in;
}

Airspace::Airspace(std::vector<Zone> zones, double margin_m, Extent extent)
    : zones_(std::move(zones)),
      reach_m_(std::sqrt(1 + kTan * kTan) * margin_m + kBeside_m),
      extent_(extent) {
  for (const Zone& zone : zones_) {
    Pieces pieces{{}, {kNowhere, kNowhere, -kNowhere, -kNowhere}};
    for (const std::vector<Point>& ring : zone.rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Piece piece = Widened(ring[i], ring[(i + 1) % ring.size()], margin_m);
        pieces.box.Add(piece.box);
        pieces.pieces.push_back(piece);
      }
    }
    pieces_.push_back(std::move(pieces));
  }
  for (const Pieces& zone : pieces_) {
    for (const Piece& piece : zone.pieces) by_place_.push_back(&piece);
  }
  if (!by_place_.empty()) AddNode(0, by_place_.size());
  FindCorners(margin_m);
  std::vector<Point> places;
  for (const Corner& corner : corners_) places.push_back(corner.at);
  corner_places_.emplace(places);
  if (!places.empty()) {
    const auto [west, east] = std::minmax_element(places.begin(), places.end(),
                                                  [](Point a, Point b) { return a.x_m < b.x_m; });
    const auto [south, north] = std::minmax_element(places.begin(), places.end(),
                                                    [](Point a, Point b) { return a.y_m < b.y_m; });
    wide_m_ = Distance({west->x_m, south->y_m}, {east->x_m, north->y_m});
  }
  sights_ = std::make_unique<UpTo<Sight>[]>(corners_.size());
}

void Airspace::AddNode(std::size_t first, std::size_t end) {
  Box box = by_place_[first]->box;
  for (std::size_t i = first + 1; i < end; ++i) box.Add(by_place_[i]->box);
  const std::size_t index = nodes_.size();
  const Point centre{(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2};
  nodes_.push_back({centre, {box.x1 - centre.x_m, box.y1 - centre.y_m}, first, end, 0});
  if (end - first <= kMostInLeaf) return;
  const bool by_x = box.x1 - box.x0 > box.y1 - box.y0;
  const auto place = [&](const Piece* piece) {
    return by_x ? piece->box.x0 + piece->box.x1 : piece->box.y0 + piece->box.y1;
  };
  const std::size_t middle = (first + end) / 2;
  const auto begin = by_place_.begin();
  std::nth_element(begin + static_cast<std::ptrdiff_t>(first),
                   begin + static_cast<std::ptrdiff_t>(middle),
                   begin + static_cast<std::ptrdiff_t>(end),
                   [&](const Piece* a, const Piece* b) { return place(a) < place(b); });
  AddNode(first, middle);
  nodes_[index].other_half = nodes_.size();
  AddNode(middle, end);
}

void Airspace::FindCorners(double margin_m) {
  const auto octagon = Octagon(margin_m);
  for (const Zone& zone : zones_) {
    for (const std::vector<Point>& ring : zone.rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point before = ring[(i + ring.size() - 1) % ring.size()];
        const Point after = ring[(i + 1) % ring.size()];
        for (const Point out : octagon) {
          const Point at = Sum(ring[i], out);
          if (!extent_.Contains(at) || !IsFree(at)) continue;
          corners_.push_back({at,
                              {SidesAt(at, before, ring[i], octagon),  //
                               SidesAt(at, ring[i], after, octagon)}});
        }
      }
    }
  }
}

bool Airspace::Corner::TurnsFrom(Point place) const {
  const Point line = Difference(at, place);
  // Whether the side is beside the line, by more than may be between a place and that side.
  const auto is_beside = [&](double cross, Point side) {
    return cross * cross > kBeside_m * kBeside_m * std::max(Square(line), Square(side));
  };
  for (const auto& [left, right] : sides) {
    const double of_left = Cross(line, left), of_right = Cross(line, right);
    if ((of_left < 0) == (of_right < 0)) continue;
    if (is_beside(of_left, left) && is_beside(of_right, right)) return false;
  }
  return true;
}

std::optional<std::size_t> Airspace::ZoneAt(Point place, double rounding_m) const {
  for (std::size_t z = 0; z < zones_.size(); ++z) {
    if (pieces_[z].box.Misses(place, place)) continue;
    const auto is_in = [&](const Piece& piece) {
      return std::all_of(piece.sides.begin(), piece.sides.end(), [&](const Side& side) {
        return side.normal_x * place.x_m + side.normal_y * place.y_m < side.limit - rounding_m;
      });
    };
    if (IsInside(zones_[z], place) ||
        std::any_of(pieces_[z].pieces.begin(), pieces_[z].pieces.end(), is_in)) {
      return z;
    }
  }
  return {};
}

std::optional<std::size_t> Airspace::ZoneAt(Point place) const {
  return ZoneAt(place, kRounding_m);
}

bool Airspace::IsFree(Point place) const { return !ZoneAt(place); }

bool Airspace::IsClear(Point a, Point b) const {
  if (nodes_.empty()) return true;
  const Point line = Difference(b, a);
  const Point middle{(a.x_m + b.x_m) / 2, (a.y_m + b.y_m) / 2};
  const Point across{std::abs(line.x_m), std::abs(line.y_m)};
  const double reach = reach_m_ * reach_m_ * Square(line);
  // Whether the line may lead through the box. All at once: a branch each would take longer.
  const auto may_meet = [&](const Node& node) {
    const Point to = Difference(node.centre, middle);
    const bool near_x = std::abs(to.x_m) <= node.half.x_m + across.x_m / 2 + kBeside_m;
    const bool near_y = std::abs(to.y_m) <= node.half.y_m + across.y_m / 2 + kBeside_m;
    const bool through = std::abs(Cross(line, to)) <= across.x_m * (node.half.y_m + kBeside_m) +
                                                          across.y_m * (node.half.x_m + kBeside_m);
    return (static_cast<int>(near_x) & static_cast<int>(near_y) & static_cast<int>(through)) != 0;
  };
  // Whether both ends of its edge are so far away on the same side of the line that it is, too.
  const auto is_beside = [&](const Piece& piece) {
    const double of_a = Cross(line, Difference(piece.a, a));
    const double of_b = Cross(line, Difference(piece.b, a));
    return of_a * of_b > 0 && std::min(of_a * of_a, of_b * of_b) > reach;
  };
  std::array<std::size_t, 64> left;  // more than the tree is deep
  std::size_t n_left = 0;
  left[n_left++] = 0;
  while (n_left > 0) {
    const std::size_t index = left[--n_left];
    const Node& node = nodes_[index];
    if (!may_meet(node)) continue;
    if (node.other_half > 0) {
      left[n_left++] = node.other_half;
      left[n_left++] = index + 1;
      continue;
    }
    for (std::size_t i = node.first; i < node.end; ++i) {
      const Piece& piece = *by_place_[i];
      if (!is_beside(piece) && EntersPiece(piece, a, b)) return false;
    }
  }
  return true;
}

std::optional<double> Airspace::EntersAt(const Flight& flight, double begin_m) const {
  for (std::size_t i = 1; i < flight.corners.size(); ++i) {
    const double step_m = flight.reached_m[i] - flight.reached_m[i - 1];
    if (flight.reached_m[i] <= begin_m || step_m <= 0) continue;
    const double share = std::max(0.0, (begin_m - flight.reached_m[i - 1]) / step_m);
    const Point a = Lerp(flight.corners[i - 1], flight.corners[i], share), b = flight.corners[i];
    const double left_m = step_m * (1 - share);
    if (!IsFree(a)) return std::max(begin_m, flight.reached_m[i] - left_m);
    double first = kNowhere;
    for (const Pieces& zone : pieces_) {
      if (zone.box.Misses(a, b)) continue;
      for (const Piece& piece : zone.pieces) {
        if (const auto enters = EntersPiece(piece, a, b)) first = std::min(first, *enters);
      }
    }
    if (first < kNowhere) {
      return std::max(begin_m, flight.reached_m[i] - left_m * (1 - first));
    }
  }
  return {};
}

}  // namespace muster
