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
constexpr std::size_t kMostPlaces = std::size_t{1} << 16;
constexpr std::size_t kMostInLeaf = 4;
/// Lengths are kept from so many places to so many goals: at most 16 MB, for each set of zones.
constexpr std::int32_t kMostRows = 2048, kMostGoals = 1024;

/// Places that are so near to each other are the same corner.
constexpr double kSame_m = 0.001;

/// A place that is so near to the line of a side counts as lying on it: more than kRounding_m, as
/// agents that fly along a piece are asked for their way from there.
constexpr double kBeside_m = 0.006;

/// Flights whose lengths differ by no more than that are equally long.
constexpr double kTie_m = 1e-7;

/// Of two places to which equally long flights lead first: whether `a` is flown to, the one further
/// away, else further west, else further south. So whoever computes flights anew, with other
/// rounding, finds the same ones.
bool IsBefore(Point from, Point a, Point b) {
  const double further_m = Distance(from, a) - Distance(from, b);
  if (std::abs(further_m) > kTie_m) return further_m > 0;
  return std::abs(a.x_m - b.x_m) > kTie_m ? a.x_m < b.x_m : a.y_m < b.y_m;
}

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

struct Airspace::Known {
  Point at;
  bool is_free = false;
  std::optional<Point> way_out;  ///< where it is not free
  std::once_flag seen_once, search_once;
  std::vector<Seen> seen;
  std::once_flag row_once, goal_once;
  std::int32_t goal = -1;                            ///< its number among the goals
  std::unique_ptr<std::atomic<double>[]> lengths_m;  ///< by goal; below 0: not known
  // As a goal, by corner.
  std::vector<double> rest_m;
  std::vector<std::int32_t> next;  ///< corner; -1: the goal itself
};

bool Airspace::Box::Misses(Point a, Point b) const {
  return std::max(a.x_m, b.x_m) <= x0 || std::min(a.x_m, b.x_m) >= x1 ||
         std::max(a.y_m, b.y_m) <= y0 || std::min(a.y_m, b.y_m) >= y1;
}

bool Airspace::Box::Meets(Point a, Point b) const {
  if (Misses(a, b)) return false;
  const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
  const double to_x = (x0 + x1) / 2 - a.x_m, to_y = (y0 + y1) / 2 - a.y_m;
  return std::abs(dx * to_y - dy * to_x) <=
         (std::abs(dx) * (y1 - y0) + std::abs(dy) * (x1 - x0)) / 2;
}

void Airspace::Box::Add(const Box& other) {
  *this = {std::min(x0, other.x0), std::min(y0, other.y0), std::max(x1, other.x1),
           std::max(y1, other.y1)};
}

Airspace::Piece Airspace::Widened(Point a, Point b, double margin_m) {
  Piece piece;
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
    : zones_(std::move(zones)), extent_(extent) {
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
  seen_from_corner_.resize(corners_.size());
  corner_once_ = std::make_unique<std::once_flag[]>(corners_.size());
}

Airspace::~Airspace() = default;

void Airspace::AddNode(std::size_t first, std::size_t end) {
  Box box = by_place_[first]->box;
  for (std::size_t i = first + 1; i < end; ++i) box.Add(by_place_[i]->box);
  const std::size_t index = nodes_.size();
  nodes_.push_back({box, first, end, 0});
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
  std::array<std::size_t, 64> left;  // more than the tree is deep
  std::size_t n_left = 0;
  left[n_left++] = 0;
  while (n_left > 0) {
    const std::size_t index = left[--n_left];
    const Node& node = nodes_[index];
    if (!node.box.Meets(a, b)) continue;
    if (node.other_half > 0) {
      left[n_left++] = node.other_half;
      left[n_left++] = index + 1;
      continue;
    }
    for (std::size_t i = node.first; i < node.end; ++i) {
      if (EntersPiece(*by_place_[i], a, b)) return false;
    }
  }
  return true;
}

std::shared_ptr<Airspace::Known> Airspace::KnownOf(Point place) const {
  {
    const std::shared_lock lock(mutex_);
    if (const auto found = known_.find(place); found != known_.end()) return found->second;
  }
  auto made = std::make_shared<Known>();
  made->at = place;
  made->is_free = IsFree(place);
  if (!made->is_free) made->way_out = WayOut(place);
  const std::unique_lock lock(mutex_);
  if (known_.size() >= kMostPlaces) known_.clear();
  return known_.emplace(place, std::move(made)).first->second;
}

std::vector<std::shared_ptr<Airspace::Known>> Airspace::KnownOf(
    std::span<const Point> places) const {
  std::vector<std::shared_ptr<Known>> known(places.size());
  {
    const std::shared_lock lock(mutex_);
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (const auto found = known_.find(places[i]); found != known_.end())
        known[i] = found->second;
    }
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (known[i] == nullptr) known[i] = KnownOf(places[i]);
  }
  return known;
}

bool Airspace::IsSeen(const Corner& corner, Point from) const {
  return corner.at != from && corner.TurnsFrom(from) && IsClear(from, corner.at);
}

const std::vector<Airspace::Seen>& Airspace::SeenFrom(Known* place) const {
  std::call_once(place->seen_once, [&] {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (!IsSeen(corners_[i], place->at)) continue;
      place->seen.push_back({static_cast<std::int32_t>(i), Distance(place->at, corners_[i].at)});
    }
  });
  return place->seen;
}

const std::vector<Airspace::Seen>& Airspace::SeenFromCorner(std::int32_t corner) const {
  std::vector<Seen>& seen = seen_from_corner_[At(corner)];
  std::call_once(corner_once_[At(corner)], [&] {
    const Corner& here = corners_[At(corner)];
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (!here.TurnsFrom(corners_[i].at) || !IsSeen(corners_[i], here.at)) continue;
      seen.push_back({static_cast<std::int32_t>(i), Distance(here.at, corners_[i].at)});
    }
  });
  return seen;
}

void Airspace::SearchTo(Known* goal) const {
  std::call_once(goal->search_once, [&] {
    using Entry = std::pair<double, std::int32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    goal->rest_m.assign(corners_.size(), kNowhere);
    goal->next.assign(corners_.size(), -1);
    const auto reach = [&](std::int32_t corner, double metres, std::int32_t next) {
      if (metres >= goal->rest_m[At(corner)]) return;
      goal->rest_m[At(corner)] = metres;
      goal->next[At(corner)] = next;
      queue.emplace(metres, corner);
    };
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (corners_[i].at == goal->at) reach(static_cast<std::int32_t>(i), 0, -1);
    }
    for (const Seen& seen : SeenFrom(goal)) reach(seen.corner, seen.metres, -1);
    std::vector<std::int32_t> reached;
    while (!queue.empty()) {
      const auto [metres, corner] = queue.top();
      queue.pop();
      if (metres > goal->rest_m[At(corner)]) continue;
      reached.push_back(corner);
      for (const Seen& seen : SeenFromCorner(corner)) {
        reach(seen.corner, metres + seen.metres, corner);
      }
    }
    for (const Seen& seen : SeenFrom(goal)) goal->next[At(seen.corner)] = -1;
    for (const std::int32_t corner : reached) {
      const double rest_m = goal->rest_m[At(corner)];
      std::int32_t* const next = &goal->next[At(corner)];
      if (*next < 0) continue;
      const Point here = corners_[At(corner)].at;
      for (const Seen& seen : SeenFromCorner(corner)) {
        const double its_m = goal->rest_m[At(seen.corner)];
        if (!(its_m < rest_m) || seen.metres + its_m > rest_m + kTie_m) continue;
        if (IsBefore(here, corners_[At(seen.corner)].at, corners_[At(*next)].at)) {
          *next = seen.corner;
        }
      }
    }
  });
}

std::optional<Point> Airspace::WayOut(Point place) const {
  std::optional<Point> nearest;
  double least_m = kNowhere;
  const auto offer = [&](Point out) {
    const double metres = Distance(place, out);
    if (metres > least_m + kTie_m || !extent_.Contains(out) || ZoneAt(out, kTie_m)) return;
    if (!nearest || metres < least_m - kTie_m || IsBefore(place, out, *nearest)) nearest = out;
    least_m = std::min(least_m, metres);
  };
  for (const Pieces& zone : pieces_) {
    for (const Piece& piece : zone.pieces) {
      for (const Side& side : piece.sides) {
        const double metres = side.limit - side.normal_x * place.x_m - side.normal_y * place.y_m;
        if (metres < 0) continue;
        offer({place.x_m + side.normal_x * metres, place.y_m + side.normal_y * metres});
      }
    }
  }
  for (const Corner& corner : corners_) offer(corner.at);
  // Where two sides meet in a corner that points inwards. Those of both are nearer than the
  // nearest.
  std::vector<const Side*> near;
  for (const Pieces& zone : pieces_) {
    for (const Piece& piece : zone.pieces) {
      const double dx = std::max({piece.box.x0 - place.x_m, place.x_m - piece.box.x1, 0.0});
      const double dy = std::max({piece.box.y0 - place.y_m, place.y_m - piece.box.y1, 0.0});
      if (!(std::sqrt(dx * dx + dy * dy) < least_m + kTie_m)) continue;
      for (const Side& side : piece.sides) {
        const double metres = side.limit - side.normal_x * place.x_m - side.normal_y * place.y_m;
        if (std::abs(metres) < least_m + kTie_m) near.push_back(&side);
      }
    }
  }
  for (std::size_t i = 0; i < near.size(); ++i) {
    // The nearest place of a side can lie outside the area: then it is where the side leaves it.
    for (const double x_m : {0.0, extent_.width_m}) {
      const double y_m = (near[i]->limit - near[i]->normal_x * x_m) / near[i]->normal_y;
      if (std::isfinite(y_m)) offer({x_m, y_m});
    }
    for (const double y_m : {0.0, extent_.height_m}) {
      const double x_m = (near[i]->limit - near[i]->normal_y * y_m) / near[i]->normal_x;
      if (std::isfinite(x_m)) offer({x_m, y_m});
    }
    for (std::size_t j = 0; j < i; ++j) {
      const Side &a = *near[i], &b = *near[j];
      const double turn = a.normal_x * b.normal_y - a.normal_y * b.normal_x;
      if (std::abs(turn) < 1e-9) continue;
      offer({(a.limit * b.normal_y - b.limit * a.normal_y) / turn,
             (b.limit * a.normal_x - a.limit * b.normal_x) / turn});
    }
  }
  return nearest;
}

double Airspace::FreeLength(Known* from, Known* to, std::int32_t* first) const {
  *first = -1;
  if (IsClear(from->at, to->at)) return Distance(from->at, to->at);
  SearchTo(to);
  double least_m = kNowhere;
  for (const Seen& seen : SeenFrom(from)) {
    const double metres = seen.metres + to->rest_m[At(seen.corner)];
    least_m = std::min(least_m, metres);
  }
  if (least_m == kNowhere) return kNowhere;
  for (const Seen& seen : SeenFrom(from)) {
    if (seen.metres + to->rest_m[At(seen.corner)] > least_m + kTie_m) continue;
    if (*first < 0 || IsBefore(from->at, corners_[At(seen.corner)].at, corners_[At(*first)].at)) {
      *first = seen.corner;
    }
  }
  // Rounding may not make it shorter than the straight line.
  return std::max(least_m, Distance(from->at, to->at));
}

double Airspace::Length(Point from, Point to) const {
  if (from == to) return 0;
  const std::shared_ptr<Known> goal = KnownOf(to), start = KnownOf(from);
  KeepLengthsTo(goal.get());
  KeepLengthsFrom(start.get());
  return LengthBetween(start.get(), goal.get());
}

void Airspace::Lengths(std::span<const Point> from, std::span<const Point> to,
                       std::span<double> lengths_m) const {
  const std::vector<std::shared_ptr<Known>> goals = KnownOf(to);
  for (const auto& goal : goals) KeepLengthsTo(goal.get());
  std::size_t i = 0;
  for (const std::shared_ptr<Known>& start : KnownOf(from)) {
    KeepLengthsFrom(start.get());
    for (const std::shared_ptr<Known>& goal : goals) {
      lengths_m[i++] = start->at == goal->at ? 0 : LengthBetween(start.get(), goal.get());
    }
  }
}

void Airspace::KeepLengthsTo(Known* goal) const {
  std::call_once(goal->goal_once, [&] {
    if (!goal->is_free || n_goals_ >= kMostGoals) return;
    const std::int32_t number = n_goals_++;
    if (number < kMostGoals) goal->goal = number;
  });
}

void Airspace::KeepLengthsFrom(Known* place) const {
  std::call_once(place->row_once, [&] {
    if (n_rows_ >= kMostRows || n_rows_++ >= kMostRows) return;
    place->lengths_m = std::make_unique<std::atomic<double>[]>(At(kMostGoals));
    for (std::int32_t i = 0; i < kMostGoals; ++i) place->lengths_m[At(i)] = -1;
  });
}

double Airspace::LengthBetween(Known* from, Known* to) const {
  if (!to->is_free) return kNowhere;
  if (to->goal < 0 || !from->lengths_m) return FindLength(from, to);
  std::atomic<double>& kept = from->lengths_m[At(to->goal)];
  double length_m = kept.load(std::memory_order_relaxed);
  if (length_m < 0) {
    length_m = FindLength(from, to);
    kept.store(length_m, std::memory_order_relaxed);
  }
  return length_m;
}

double Airspace::FindLength(Known* from, Known* to) const {
  std::int32_t first = -1;
  if (from->is_free) return FreeLength(from, to, &first);
  if (!from->way_out) return kNowhere;
  const std::shared_ptr<Known> out = KnownOf(*from->way_out);
  return std::max(Distance(from->at, out->at) + FreeLength(out.get(), to, &first),
                  Distance(from->at, to->at));
}

std::shared_ptr<const Airspace::Flight> Airspace::FlightBetween(Point from, Point to) const {
  const double length_m = Length(from, to);
  if (std::isinf(length_m)) return nullptr;
  auto flight = std::make_shared<Flight>();
  flight->corners = {from};
  flight->reached_m = {0};
  const std::shared_ptr<Known> start = KnownOf(from), goal = KnownOf(to);
  std::shared_ptr<Known> begin = start;
  if (!start->is_free && from != to) {
    begin = KnownOf(*start->way_out);
    flight->corners.push_back(begin->at);
    flight->reached_m.push_back(std::min(Distance(from, begin->at), length_m));
  }
  std::int32_t corner = -1;
  if (from != to) FreeLength(begin.get(), goal.get(), &corner);
  for (; corner >= 0; corner = goal->next[At(corner)]) {
    const Point at = corners_[At(corner)].at;
    if (at == to) break;
    flight->corners.push_back(at);
    flight->reached_m.push_back(
        std::max(flight->reached_m.back(), length_m - goal->rest_m[At(corner)]));
  }
  flight->corners.push_back(to);
  flight->reached_m.push_back(length_m);
  return flight;
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
