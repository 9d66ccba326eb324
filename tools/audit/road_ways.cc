#include "tools/audit/road_ways.h"

#include <cmath>
#include <limits>
#include <list>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tools/audit/audit_scenario.h"

namespace muster::tools::audit {
namespace {

using nlohmann::json;
using Mm = std::int64_t;

constexpr Mm kNone = -1;
constexpr std::size_t kRemembered = 500;  // goals

Mm UpTo(Mm amount, Mm percent) { return (amount * 100 + percent - 1) / percent; }

Mm StraightMm(Mm dx, Mm dy) {
  const Mm square = dx * dx + dy * dy;
  auto mm = static_cast<Mm>(std::floor(std::sqrt(static_cast<double>(square)))) - 1;
  while (mm * mm < square) ++mm;
  return mm;
}

/// A straight piece of a road between two of its points.
struct Piece {
  int road, a, b;  ///< the road; its points
  Mm cost;
  bool backward;
};

/// Where a place meets the road: how far along a piece, and across how much open ground.
struct Foot {
  int piece = -1;
  Mm along = 0, aside = 0;
  Place at;
};

/// One class's roads.
class Streets {
 public:
  Streets(const json& file, const char* percent_key, bool on_foot, OpenGround ground,
          const std::vector<Place>& sites)
      : ground_(ground), sites_(sites) {
    const json& xs = file.at("x_mm");
    const json& ys = file.at("y_mm");
    for (std::size_t i = 0; i < xs.size(); ++i) {
      points_.emplace_back(xs.at(i).get<Mm>(), ys.at(i).get<Mm>());
    }
    beside_.resize(points_.size());
    int number = 0;
    for (const json& road : file.at("roads")) {
      const json& its = file.at("classes").at(road.at("class").get<std::size_t>());
      const Mm percent = its.at(percent_key).get<Mm>();
      if (percent > 0) AddRoad(road.at("points"), number, percent, on_foot || !its.at("one_way"));
      ++number;
    }
  }

  /// Cost of the way; kNone: there is none.
  Mm Cost(Place from, Place to) const {
    if (Same(from, to)) return 0;
    const auto start = FootOf(from), goal = FootOf(to);
    if (!start || !goal) return kNone;
    if (start->piece == goal->piece && start->along == goal->along) {
      const Mm direct = Aside(from, to);
      return direct != kNone ? direct : start->aside + goal->aside;
    }
    const Mm on_road = Leave(*start, *goal).cost;
    return on_road == kNone ? kNone : start->aside + on_road + goal->aside;
  }

  /// The place after so much of the cost.
  Place After(Place from, Place to, double gone) const {
    std::vector<std::pair<Place, Mm>> stops{{from, 0}};
    const auto go = [&](Place next, Mm cost) {
      stops.emplace_back(next, stops.back().second + cost);
    };
    const auto start = FootOf(from), goal = FootOf(to);
    if (Same(from, to) || !start || !goal) return to;
    const bool direct = start->piece == goal->piece && start->along == goal->along;
    if (!direct || Aside(from, to) == kNone) {
      go(start->at, start->aside);
      if (!direct) Walk(*start, *goal, go);
      go(to, goal->aside);
    } else {
      go(to, Aside(from, to));
    }
    for (std::size_t i = 1; i < stops.size(); ++i) {
      const auto [last, begins] = stops[i - 1];
      const auto [next, ends] = stops[i];
      if (gone > static_cast<double>(ends) || ends == begins) continue;
      const double part = (gone - static_cast<double>(begins)) / static_cast<double>(ends - begins);
      return {last.x_m + part * (next.x_m - last.x_m), last.y_m + part * (next.y_m - last.y_m)};
    }
    return to;
  }

  /// The site or road point nearest to a place: where a move to no site ends.
  std::pair<Place, int> StopNear(Place wanted) const {
    std::pair<Place, int> best{wanted, -1};
    double apart = std::numeric_limits<double>::infinity();
    const auto offer = [&](Place place, int number) {
      const double away = Apart(wanted, place);
      if (away >= apart) return;
      apart = away;
      best = {place, number};
    };
    const int n = static_cast<int>(sites_.size() + points_.size());
    for (int number = 0; number < n; ++number) {
      if (const auto stop = StopOf(number)) offer(*stop, number);
    }
    return best;
  }
  std::optional<Place> StopOf(int number) const {
    const auto i = static_cast<std::size_t>(number);
    if (i < sites_.size()) return FootOf(sites_[i]) ? std::optional(sites_[i]) : std::nullopt;
    const std::size_t point = i - sites_.size();
    if (point >= points_.size() || beside_[point].empty()) return {};
    return At(static_cast<int>(point));
  }

 private:
  /// The audit reads kilometres by its own arithmetic, which may differ in the last digit.
  static bool Same(Place a, Place b) { return Apart(a, b) <= 1e-6; }
  Place At(int point) const {
    const auto& [x, y] = points_[static_cast<std::size_t>(point)];
    return {static_cast<double>(x) / 1000, static_cast<double>(y) / 1000};
  }
  const Piece& PieceAt(int i) const { return pieces_[static_cast<std::size_t>(i)]; }

  void AddRoad(const json& points, int number, Mm percent, bool backward) {
    for (std::size_t i = 1; i < points.size(); ++i) {
      const int a = points.at(i - 1), b = points.at(i);
      const auto& [ax, ay] = points_.at(static_cast<std::size_t>(a));
      const auto& [bx, by] = points_.at(static_cast<std::size_t>(b));
      const int index = static_cast<int>(pieces_.size());
      pieces_.push_back({number, a, b, UpTo(StraightMm(bx - ax, by - ay), percent), backward});
      beside_[static_cast<std::size_t>(a)].push_back(index);
      beside_[static_cast<std::size_t>(b)].push_back(index);
      for (Mm column = Cell(std::min(ax, bx)); column <= Cell(std::max(ax, bx)); ++column) {
        for (Mm row = Cell(std::min(ay, by)); row <= Cell(std::max(ay, by)); ++row) {
          cells_[{column, row}].push_back(index);
        }
      }
    }
  }

  static constexpr Mm kCell = 300'000;
  static Mm Cell(Mm mm) { return mm >= 0 ? mm / kCell : -((kCell - 1 - mm) / kCell); }

  /// Cost of open ground between two places; kNone: too far, or not to be crossed.
  Mm Aside(Place a, Place b) const {
    const double metres = Apart(a, b);
    const Mm mm = std::llround(metres * 1000);
    if (mm == 0) return 0;
    return ground_.percent == 0 || metres > ground_.reach_m ? kNone : UpTo(mm, ground_.percent);
  }

  Foot FootOn(int index, Place place) const {
    const Piece& piece = PieceAt(index);
    const Place a = At(piece.a), b = At(piece.b);
    const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
    double part = ((place.x_m - a.x_m) * dx + (place.y_m - a.y_m) * dy) / (dx * dx + dy * dy);
    part = std::min(1.0, std::max(0.0, part));
    Foot foot{index, std::llround(part * static_cast<double>(piece.cost)), 0, {}};
    const double exact = static_cast<double>(foot.along) / static_cast<double>(piece.cost);
    foot.at = {a.x_m + dx * exact, a.y_m + dy * exact};
    return foot;
  }

  std::optional<Foot> FootOf(Place place) const {
    const auto known = feet_.find({place.x_m, place.y_m});
    if (known != feet_.end()) return known->second;
    std::optional<Foot> nearest;
    double apart = std::numeric_limits<double>::infinity();
    const Mm column = Cell(std::llround(place.x_m * 1000)),
             row = Cell(std::llround(place.y_m * 1000));
    const Mm rings = std::llround(ground_.reach_m * 1000) / kCell + 2;
    for (Mm ring = 0; ring <= rings; ++ring) {
      if (apart < static_cast<double>((ring - 1) * kCell) / 1000) break;
      for (Mm x = column - ring; x <= column + ring; ++x) {
        const bool edge = x == column - ring || x == column + ring;
        for (Mm y = row - ring; y <= row + ring; y += edge ? 1 : 2 * ring) {
          const auto cell = cells_.find({x, y});
          if (cell == cells_.end()) continue;
          for (const int index : cell->second) {
            const Foot foot = FootOn(index, place);
            const double away = Apart(place, foot.at);
            if (away > apart || (away == apart && nearest && index >= nearest->piece)) continue;
            apart = away;
            nearest = foot;
          }
        }
      }
    }
    if (nearest) nearest->aside = Aside(place, nearest->at);
    if (nearest && nearest->aside == kNone) nearest.reset();
    if (feet_.size() > 100'000) feet_.clear();
    feet_[{place.x_m, place.y_m}] = nearest;
    return nearest;
  }

  /// What the points around a goal cost to it, as far out as was asked.
  struct Around {
    std::map<int, Mm> known;
    std::set<std::pair<Mm, int>> rim;
  };

  Around& AroundOf(const Foot& goal) const {
    const std::pair key(goal.piece, goal.along);
    if (const auto found = around_.find(key); found != around_.end()) return found->second;
    if (around_.size() >= kRemembered) around_.clear();
    Around& around = around_[key];
    const Piece& piece = PieceAt(goal.piece);
    around.rim.emplace(goal.along, piece.a);
    if (piece.backward || goal.along == piece.cost) {
      around.rim.emplace(piece.cost - goal.along, piece.b);
    }
    return around;
  }

  Mm CostFrom(int point, Around* around) const {
    for (;;) {
      if (const auto found = around->known.find(point); found != around->known.end()) {
        return found->second;
      }
      if (around->rim.empty()) return kNone;
      const auto [cost, next] = *around->rim.begin();
      around->rim.erase(around->rim.begin());
      if (!around->known.emplace(next, cost).second) continue;
      for (const int index : beside_[static_cast<std::size_t>(next)]) {
        const Piece& piece = PieceAt(index);
        // An agent that arrives here has come from the other end of the piece.
        if (piece.b == next) around->rim.emplace(cost + piece.cost, piece.a);
        if (piece.a == next && piece.backward) around->rim.emplace(cost + piece.cost, piece.b);
      }
    }
  }

  /// How a way by road begins: on the same road only (point -1), or by that point.
  struct Beginning {
    Mm cost = kNone;
    int point = -1;
  };

  Beginning Leave(const Foot& start, const Foot& goal) const {
    Beginning best;
    const auto offer = [&](Mm cost, int point) {
      if (cost != kNone && (best.cost == kNone || cost < best.cost)) best = {cost, point};
    };
    const Piece& piece = PieceAt(start.piece);
    if (start.piece == goal.piece) {
      if (start.along <= goal.along) offer(goal.along - start.along, -1);
      if (start.along >= goal.along && piece.backward) offer(start.along - goal.along, -1);
    }
    Around& around = AroundOf(goal);
    const auto by = [&](int point, Mm first) {
      const Mm rest = CostFrom(point, &around);
      offer(rest == kNone ? kNone : first + rest, point);
    };
    const auto ahead = [&] { by(piece.b, piece.cost - start.along); };
    const auto behind = [&] {
      if (piece.backward || start.along == 0) by(piece.a, start.along);
    };
    // Of two that are as short, the one that stays on the road of its start.
    const bool goes_back =
        PieceAt(goal.piece).road == piece.road && goal.piece < start.piece && piece.backward;
    if (goes_back) behind();
    ahead();
    if (!goes_back) behind();
    return best;
  }

  /// Goes point by point. Where several ways are equally short, it takes the road that the goal is
  /// on, else the road that stands first in the file.
  template <class Go>
  void Walk(const Foot& start, const Foot& goal, const Go& go) const {
    Beginning way = Leave(start, goal);
    if (way.cost == kNone) return;
    int point = way.point;
    Mm left = way.cost;
    Around& around = AroundOf(goal);
    if (point >= 0) {
      const Piece& piece = PieceAt(start.piece);
      const Mm ahead = piece.cost - start.along;
      const Mm first =
          point == piece.b && left == ahead + CostFrom(point, &around) ? ahead : start.along;
      go(At(point), first);
      left -= first;
      const Piece& last = PieceAt(goal.piece);
      while (!(point == last.a && left == goal.along) &&
             !(point == last.b && left == last.cost - goal.along && (last.backward || left == 0))) {
        int next = -1;
        Mm cost = 0;
        for (const int index : beside_[static_cast<std::size_t>(point)]) {
          const Piece& here = PieceAt(index);
          const bool forward = here.a == point, to_goal = here.road == last.road;
          if (!forward && !here.backward) continue;
          const int other = forward ? here.b : here.a;
          if ((next >= 0 && !to_goal) || CostFrom(other, &around) != left - here.cost) continue;
          next = other;
          cost = here.cost;
          if (to_goal) break;
        }
        if (next < 0) throw std::logic_error("a way by road that ends nowhere");
        go(At(next), cost);
        left -= cost;
        point = next;
      }
    }
    go(goal.at, left);
  }

  const OpenGround ground_;
  const std::vector<Place> sites_;
  std::vector<std::pair<Mm, Mm>> points_;
  std::vector<Piece> pieces_;
  std::vector<std::vector<int>> beside_;  ///< by point: its pieces, in the order of the file
  std::map<std::pair<Mm, Mm>, std::vector<int>> cells_;
  mutable std::map<std::pair<double, double>, std::optional<Foot>> feet_;
  mutable std::map<std::pair<int, Mm>, Around> around_;
};

class RoadWays : public Ways {
 public:
  RoadWays(const json& file, const OpenGround (&ground)[3], const std::vector<Place>& sites)
      : workers_(file, "workers_percent", true, ground[kWorker], sites),
        vehicles_(file, "vehicles_percent", false, ground[kVehicle], sites) {}

  double Length(int kind, Place from, Place to) const override {
    if (kind == kUav) return Apart(from, to);
    const Mm cost = StreetsOf(kind).Cost(from, to);
    if (cost == kNone) return std::numeric_limits<double>::infinity();
    return std::max(static_cast<double>(cost) / 1000, Apart(from, to));
  }
  Place After(int kind, Place from, Place to, double part) const override {
    if (kind == kUav) return Ways::After(kind, from, to, part);
    const Streets& streets = StreetsOf(kind);
    return streets.After(from, to, part * static_cast<double>(streets.Cost(from, to)));
  }
  double rounding_m(int kind) const override { return kind == kUav ? 0 : 0.01; }
  std::pair<Place, int> StopNear(int kind, Place wanted) const override {
    return kind == kUav ? Ways::StopNear(kind, wanted) : StreetsOf(kind).StopNear(wanted);
  }
  std::optional<Place> StopOf(int kind, int number) const override {
    return kind == kUav || number < 0 ? std::nullopt : StreetsOf(kind).StopOf(number);
  }

 private:
  const Streets& StreetsOf(int kind) const { return kind == kWorker ? workers_ : vehicles_; }

  Streets workers_, vehicles_;
};

}  // namespace

std::shared_ptr<const Ways> ReadRoadWays(const std::string& text, const OpenGround (&ground)[3],
                                         const std::vector<Place>& sites) {
  return std::make_shared<const RoadWays>(json::parse(text), ground, sites);
}

}  // namespace muster::tools::audit
