#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "base/index.h"
#include "model/airspace.h"

namespace muster {
namespace {

constexpr double kNoFlight_m = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostPlaces = std::size_t{1} << 16;
/// Lengths are kept to so many goals, from these and so many other places: at most 20 MB, for each
/// set of zones. They are from a place on from which so many have been asked for.
constexpr std::int32_t kMostGoals = 1024, kMostOthers = 1024, kOften = 128;

/// Flights whose lengths differ by no more than that are equally long.
constexpr double kTie_m = 1e-7;

/// Ways from one of so many corners are many.
constexpr std::size_t kMany = 8;
/// Corners that most searches reach.
constexpr std::size_t kManyReached = 128;

/// Of two places to which equally long flights lead first: whether `a` is flown to, the one further
/// away, else further west, else further south. So whoever computes flights anew, with other
/// rounding, finds the same ones.
bool IsBefore(Point from, Point a, Point b) {
  const double further_m = Distance(from, a) - Distance(from, b);
  if (std::abs(further_m) > kTie_m) return further_m > 0;
  return std::abs(a.x_m - b.x_m) > kTie_m ? a.x_m < b.x_m : a.y_m < b.y_m;
}

}  // namespace

/// What has been found out about a place.
struct Airspace::Known {
  Point at;
  bool is_free = false;
  std::optional<Point> way_out;  ///< where it is not free
  UpTo<Sight> sight;
  UpTo<WaysTo> ways_to;

  std::once_flag goal_once;
  std::atomic<std::int32_t> goal = -1;  ///< its number among the goals; -1: none
  /// Lengths to goals, kept as soon as many have been asked for.
  struct Lengths {
    std::vector<std::atomic<double>> metres;  ///< by the goal's number; 0: not known
    explicit Lengths(std::size_t n) : metres(n) {}
  };
  std::atomic<std::int32_t> n_asked = 0;
  std::atomic<Lengths*> kept = nullptr;
  std::unique_ptr<Lengths> kept_owner;
};

/// Where flights begin. What is known of the place is looked up, and made only when it is needed:
/// most agents are at a place once.
class Airspace::Start {
 public:
  Start(const Airspace& air, Point at)
      : air_(air),
        at_(at),
        known_(air.Find(at)),
        is_free_(known_ ? known_->is_free : air.IsFree(at)) {}
  double LengthTo(Known* goal) {
    if (at_ == goal->at) return 0;
    if (!goal->is_free) return kNoFlight_m;
    if (known_ == nullptr) {
      if (is_free_ && air_.IsClear(at_, goal->at)) return Distance(at_, goal->at);
      known_ = air_.KnownOf(at_);
    }
    return air_.LengthBetween(known_.get(), goal);
  }

 private:
  const Airspace& air_;
  Point at_;
  std::shared_ptr<Known> known_;
  bool is_free_;
};

Airspace::~Airspace() = default;

std::shared_ptr<Airspace::Known> Airspace::Find(Point place) const {
  const std::shared_lock lock(mutex_);
  const auto found = known_.find(place);
  return found == known_.end() ? nullptr : found->second;
}

std::shared_ptr<Airspace::Known> Airspace::KnownOf(Point place) const {
  if (auto known = Find(place)) return known;
  auto made = std::make_shared<Known>();
  made->at = place;
  made->is_free = IsFree(place);
  if (!made->is_free) made->way_out = WayOut(place);
  const std::unique_lock lock(mutex_);
  if (known_.size() >= kMostPlaces) known_.clear();
  return known_.emplace(place, std::move(made)).first->second;
}

std::vector<std::shared_ptr<Airspace::Known>> Airspace::GoalsAt(
    std::span<const Point> places) const {
  std::vector<std::shared_ptr<Known>> goals(places.size());
  {
    const std::shared_lock lock(mutex_);
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (const auto found = known_.find(places[i]); found != known_.end())
        goals[i] = found->second;
    }
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (goals[i] == nullptr) goals[i] = KnownOf(places[i]);
    MakeGoal(goals[i].get());
  }
  return goals;
}

const Airspace::Sight& Airspace::SightFrom(Known* place, double up_to_m) const {
  return place->sight.Get(up_to_m, [&] { return FindSight(place->at, nullptr, up_to_m); });
}

const Airspace::Sight& Airspace::SightFromCorner(std::int32_t corner, double up_to_m) const {
  const Corner& here = corners_[At(corner)];
  return sights_[At(corner)].Get(up_to_m, [&] { return FindSight(here.at, &here, up_to_m); });
}

Airspace::Sight Airspace::FindSight(Point place, const Corner* here, double up_to_m) const {
  Sight sight{up_to_m, {}};
  corner_places_->Within(place, up_to_m, [&](std::int32_t i, Point at, double metres) {
    if (at == place || !corners_[At(i)].TurnsFrom(place)) return;
    if (here != nullptr && !here->TurnsFrom(at)) return;
    if (IsClear(place, at)) sight.corners.push_back({i, metres});
  });
  std::sort(sight.corners.begin(), sight.corners.end(),
            [](const Seen& a, const Seen& b) { return a.corner < b.corner; });
  return sight;
}

const Airspace::WaysTo& Airspace::WaysToGoal(Known* goal, double up_to_m) const {
  return goal->ways_to.Get(up_to_m, [&] {
    // To one of a few distances, so that it serves for others, and to any beyond the last corner.
    double step_m = 1000;
    while (step_m < up_to_m && step_m < wide_m_) step_m *= 2;
    return FindWaysTo(goal, step_m < wide_m_ ? step_m : kNoFlight_m);
  });
}

Airspace::WaysTo Airspace::FindWaysTo(Known* goal, double up_to_m) const {
  // By corner. They are kept for the next search of this thread, as most of them is not touched.
  thread_local std::vector<double> metres;
  thread_local std::vector<std::int32_t> next;
  if (metres.size() < corners_.size()) {
    metres.resize(corners_.size(), kNoFlight_m);
    next.resize(corners_.size());
  }
  using Entry = std::pair<double, std::int32_t>;
  std::vector<Entry> entries;
  entries.reserve(kManyReached);
  std::priority_queue queue(std::greater<Entry>{}, std::move(entries));
  std::vector<std::int32_t> reached;
  reached.reserve(kManyReached);
  const auto reach = [&](std::int32_t corner, std::int32_t its_next, double its_m) {
    double* const least_m = &metres[At(corner)];
    if (its_m > up_to_m || its_m >= *least_m) return;
    // Straight to a goal in sight, whatever rounding makes of another way.
    if (*least_m == kNoFlight_m) {
      reached.push_back(corner);
      next[At(corner)] = its_next;
    } else if (next[At(corner)] != WaysTo::kGoal) {
      next[At(corner)] = its_next;
    }
    *least_m = its_m;
    queue.emplace(its_m, corner);
  };
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    if (corners_[i].at == goal->at) reach(static_cast<std::int32_t>(i), WaysTo::kGoal, 0);
  }
  for (const Seen& seen : SightFrom(goal, up_to_m).corners) {
    reach(seen.corner, WaysTo::kGoal, seen.metres);
  }
  while (!queue.empty()) {
    const auto [rest_m, corner] = queue.top();
    queue.pop();
    if (rest_m > metres[At(corner)]) continue;
    const Point here = corners_[At(corner)].at;
    std::int32_t* const best = &next[At(corner)];
    for (const Seen& seen : SightFromCorner(corner, up_to_m).corners) {
      reach(seen.corner, corner, rest_m + seen.metres);
      const double its_m = metres[At(seen.corner)];
      if (*best == WaysTo::kGoal || !(its_m < rest_m) || seen.metres + its_m > rest_m + kTie_m) {
        continue;
      }
      if (IsBefore(here, corners_[At(seen.corner)].at, corners_[At(*best)].at)) *best = seen.corner;
    }
  }
  WaysTo found{up_to_m, {}, {}};
  if (reached.size() * kMany > corners_.size()) {
    found.metres.assign(metres.begin(), metres.begin() + std::ssize(corners_));
  }
  std::sort(reached.begin(), reached.end());
  found.ways.reserve(reached.size());
  for (const std::int32_t corner : reached) {
    found.ways.push_back({corner, next[At(corner)], metres[At(corner)]});
    metres[At(corner)] = kNoFlight_m;
  }
  return found;
}

const Airspace::WaysTo::Way& Airspace::WaysTo::From(std::int32_t corner) const {
  return *std::lower_bound(ways.begin(), ways.end(), corner,
                           [](const Way& way, std::int32_t before) { return way.corner < before; });
}

std::optional<Point> Airspace::WayOut(Point place) const {
  std::optional<Point> nearest;
  double least_m = kNoFlight_m;
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

double Airspace::FreeLength(Known* from, Known* to, Turn* turn) const {
  *turn = {};
  const double straight_m = Distance(from->at, to->at);
  if (IsClear(from->at, to->at)) return straight_m;
  // Calls visit(corner, metres of the whole way) for each corner that it can turn at first.
  const auto turns = [](const Sight& sight, const WaysTo& on, const auto& visit) {
    if (!on.metres.empty()) {
      for (const Seen& seen : sight.corners) {
        visit(seen.corner, seen.metres + on.metres[At(seen.corner)]);
      }
      return;
    }
    auto way = on.ways.begin();
    for (const Seen& seen : sight.corners) {
      while (way != on.ways.end() && way->corner < seen.corner) ++way;
      if (way == on.ways.end()) break;
      if (way->corner == seen.corner) visit(seen.corner, seen.metres + way->metres);
    }
  };
  double least_m = kNoFlight_m;
  // Ways that are no longer than that are looked at.
  for (double up_to_m = straight_m + kTie_m;;) {
    const WaysTo& on = WaysToGoal(to, up_to_m);
    const Sight& sight = SightFrom(from, on.up_to_m);
    turns(sight, on, [&](std::int32_t, double metres) { least_m = std::min(least_m, metres); });
    if (least_m == kNoFlight_m && on.up_to_m == kNoFlight_m) return kNoFlight_m;
    up_to_m = least_m == kNoFlight_m ? 2 * on.up_to_m : least_m + kTie_m;
    if (up_to_m > on.up_to_m) continue;
    turns(sight, on, [&](std::int32_t corner, double metres) {
      if (metres > least_m + kTie_m) return;
      const Point at = corners_[At(corner)].at;
      if (turn->on == nullptr || IsBefore(from->at, at, corners_[At(turn->corner)].at)) {
        *turn = {corner, &on};
      }
    });
    // Rounding may not make it shorter than the straight line.
    return std::max(least_m, straight_m);
  }
}

double Airspace::Length(Point from, Point to) const {
  if (from == to) return 0;
  const std::shared_ptr<Known> goal = KnownOf(to);
  MakeGoal(goal.get());
  return Start(*this, from).LengthTo(goal.get());
}

void Airspace::Lengths(std::span<const Point> from, std::span<const Point> to,
                       std::span<double> lengths_m) const {
  const std::vector<std::shared_ptr<Known>> goals = GoalsAt(to);
  std::size_t i = 0;
  for (const Point begin : from) {
    Start start(*this, begin);
    for (const std::shared_ptr<Known>& goal : goals) lengths_m[i++] = start.LengthTo(goal.get());
  }
}

Airspace::Goals::Goals(const Airspace& air, std::span<const Point> places)
    : air_(air), goals_(air.GoalsAt(places)) {}

void Airspace::Goals::LengthsFrom(Point from, std::span<const std::int32_t> which,
                                  std::span<double> lengths_m) const {
  Start start(air_, from);
  for (std::size_t i = 0; i < which.size(); ++i) {
    lengths_m[i] = start.LengthTo(goals_[At(which[i])].get());
  }
}

void Airspace::MakeGoal(Known* place) const {
  std::call_once(place->goal_once, [&] {
    if (place->is_free && n_goals_ < kMostGoals) place->goal = n_goals_++;
  });
}

double Airspace::LengthBetween(Known* from, Known* to) const {
  if (!to->is_free) return kNoFlight_m;
  Known::Lengths* const lengths = from->kept.load(std::memory_order_acquire);
  if (lengths == nullptr) {
    if (from->n_asked < kOften && ++from->n_asked == kOften &&
        (from->goal >= 0 || n_others_++ < kMostOthers)) {
      // Room for the goals that there are, and for some that come later.
      from->kept_owner = std::make_unique<Known::Lengths>(At(n_goals_ + n_goals_ / 4));
      from->kept.store(from->kept_owner.get(), std::memory_order_release);
    }
    return FindLength(from, to);
  }
  const std::int32_t number = to->goal;
  if (number < 0 || At(number) >= lengths->metres.size()) return FindLength(from, to);
  std::atomic<double>& kept_m = lengths->metres[At(number)];
  double length_m = kept_m.load(std::memory_order_relaxed);
  if (length_m == 0) {
    length_m = FindLength(from, to);
    kept_m.store(length_m, std::memory_order_relaxed);
  }
  return length_m;
}

double Airspace::FindLength(Known* from, Known* to) const {
  Turn turn;
  if (from->is_free) return FreeLength(from, to, &turn);
  if (!from->way_out) return kNoFlight_m;
  const std::shared_ptr<Known> out = KnownOf(*from->way_out);
  return std::max(Distance(from->at, out->at) + FreeLength(out.get(), to, &turn),
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
  Turn turn;
  if (from != to) FreeLength(begin.get(), goal.get(), &turn);
  while (turn.corner != WaysTo::kGoal) {
    const Point at = corners_[At(turn.corner)].at;
    if (at == to) break;
    const WaysTo::Way& way = turn.on->From(turn.corner);
    flight->corners.push_back(at);
    flight->reached_m.push_back(std::max(flight->reached_m.back(), length_m - way.metres));
    turn.corner = way.next;
  }
  flight->corners.push_back(to);
  flight->reached_m.push_back(length_m);
  return flight;
}

}  // namespace muster
