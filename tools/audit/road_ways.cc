#include "tools/audit/road_ways.h"

#include <algorithm>
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
constexpr Mm kTooFar = (Mm{1} << 31) - 1;  // from junction to junction
constexpr std::size_t kRemembered = 500;   // goals

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
    if (IsSame(*start, *goal)) {
      const Mm direct = Aside(from, to);
      return direct != kNone ? direct : start->aside + goal->aside;
    }
    const Mm on_road = Leave(*start, *goal).cost;
    return on_road == kNone ? kNone : start->aside + on_road + goal->aside;
  }

  /// A place on a way, what the way to it costs, and the road that leads to it; -1: open ground.
  struct Step {
    Place at;
    Mm cost = 0;
    int road = -1;
  };

  /// From one end to the other, both included; only the first place: there is no way.
  std::vector<Step> Steps(Place from, Place to) const {
    std::vector<Step> steps{{from, 0, -1}};
    const auto go = [&](Place next, Mm cost, int road) {
      steps.push_back({next, steps.back().cost + cost, road});
    };
    const auto start = FootOf(from), goal = FootOf(to);
    if (Same(from, to) || !start || !goal) return steps;
    const bool direct = IsSame(*start, *goal);
    if (!direct || Aside(from, to) == kNone) {
      go(start->at, start->aside, -1);
      if (!direct) Walk(*start, *goal, go);
      go(to, goal->aside, -1);
    } else {
      go(to, Aside(from, to), -1);
    }
    return steps;
  }

  /// The place after so much of the cost.
  Place After(Place from, Place to, double gone) const {
    const std::vector<Step> steps = Steps(from, to);
    for (std::size_t i = 1; i < steps.size(); ++i) {
      const auto& [last, begins, ignored] = steps[i - 1];
      const auto& [next, ends, road] = steps[i];
      if (gone > static_cast<double>(ends) || ends == begins) continue;
      const double part = (gone - static_cast<double>(begins)) / static_cast<double>(ends - begins);
      return {last.x_m + part * (next.x_m - last.x_m), last.y_m + part * (next.y_m - last.y_m)};
    }
    return to;
  }

  std::optional<double> MeetsAt(Place from, Place to, double part,
                                const std::set<int>& roads) const {
    const std::vector<Step> steps = Steps(from, to);
    const auto whole = static_cast<double>(steps.back().cost);
    for (std::size_t i = 1; i < steps.size(); ++i) {
      const bool is_long = steps[i].cost > steps[i - 1].cost;
      if (static_cast<double>(steps[i].cost) <= part * whole || !is_long ||
          !roads.contains(steps[i].road)) {
        continue;
      }
      return std::max(part, static_cast<double>(steps[i - 1].cost) / whole);
    }
    return {};
  }

  /// Takes these roads away.
  void Close(const std::set<int>& roads) {
    const auto is_closed = [&](int piece) { return roads.contains(PieceAt(piece).road); };
    for (std::size_t point = 0; point < beside_.size(); ++point) {
      std::erase_if(beside_[point], is_closed);
    }
    for (auto& [cell, pieces] : cells_) std::erase_if(pieces, is_closed);
    feet_.clear();
    around_.clear();
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
  /// Of the piece's two ends the one that it is at; -1: neither.
  int PointOf(const Foot& foot) const {
    const Piece& piece = PieceAt(foot.piece);
    return foot.along == 0 ? piece.a : foot.along == piece.cost ? piece.b : -1;
  }
  bool IsSame(const Foot& one, const Foot& other) const {
    if (one.piece == other.piece && one.along == other.along) return true;
    return PointOf(one) >= 0 && PointOf(one) == PointOf(other);
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
      offer(rest == kNone || first + rest >= kTooFar ? kNone : first + rest, point);
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
      go(At(point), first, piece.road);
      left -= first;
      const Piece& last = PieceAt(goal.piece);
      while (!(point == last.a && left == goal.along) &&
             !(point == last.b && left == last.cost - goal.along && (last.backward || left == 0))) {
        int next = -1, road = -1;
        Mm cost = 0;
        for (const int index : beside_[static_cast<std::size_t>(point)]) {
          const Piece& here = PieceAt(index);
          const bool forward = here.a == point, to_goal = here.road == last.road;
          if (!forward && !here.backward) continue;
          const int other = forward ? here.b : here.a;
          if ((next >= 0 && !to_goal) || CostFrom(other, &around) != left - here.cost) continue;
          next = other;
          road = here.road;
          cost = here.cost;
          if (to_goal) break;
        }
        if (next < 0) throw std::logic_error("a way by road that ends nowhere");
        go(At(next), cost, road);
        left -= cost;
        point = next;
      }
    }
    go(goal.at, left, PieceAt(goal.piece).road);
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

/// The roads as lines on the ground, for orders that name some of them.
class Lines {
 public:
  explicit Lines(const json& file) {
    std::vector<std::pair<Mm, Mm>> points;
    for (std::size_t i = 0; i < file.at("x_mm").size(); ++i) {
      points.emplace_back(file.at("x_mm").at(i).get<Mm>(), file.at("y_mm").at(i).get<Mm>());
    }
    for (const json& road : file.at("roads")) {
      ids_.push_back(road.at("id").get<std::int64_t>());
      std::vector<std::pair<Mm, Mm>>& line = lines_.emplace_back();
      for (const json& point : road.at("points"))
        line.push_back(points.at(point.get<std::size_t>()));
    }
  }

  std::set<int> Named(const json& order) const {
    if (order.contains("roads")) {
      const auto wanted = order.at("roads").get<std::set<std::int64_t>>();
      return Those([&](std::size_t i) { return wanted.contains(ids_[i]); });
    }
    if (order.contains("area_km")) {
      std::vector<std::pair<Mm, Mm>> area;
      for (const json& corner : order.at("area_km")) area.push_back(MmOf(corner));
      return Those([&](std::size_t i) { return Meets(lines_[i], area); });
    }
    const bool circle = order.contains("circle_km");
    const json& where = order.at(circle ? "circle_km" : "near_km");
    const Place centre{where.at(0).get<double>() * 1000, where.at(1).get<double>() * 1000};
    if (circle) {
      const double radius_m = where.at(2).get<double>() * 1000;
      return Those([&](std::size_t i) { return Away(lines_[i], centre) <= radius_m; });
    }
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < lines_.size(); ++i) {
      if (Away(lines_[i], centre) < Away(lines_[nearest], centre)) nearest = i;
    }
    return {static_cast<int>(nearest)};
  }

 private:
  using Spot = std::pair<Mm, Mm>;
  using Exact = long double;  // its 64 bits hold the products of such numbers

  static Spot MmOf(const json& corner) {
    return {std::llround(corner.at(0).get<double>() * 1e6),
            std::llround(corner.at(1).get<double>() * 1e6)};
  }

  template <class Is>
  std::set<int> Those(const Is& is) const {
    std::set<int> found;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (is(i)) found.insert(static_cast<int>(i));
    }
    return found;
  }

  /// Twice the area of the triangle, above 0 when it turns to the left.
  static Exact Turn(Spot a, Spot b, Spot c) {
    const auto part = [](Mm x, Mm y) { return static_cast<Exact>(x - y); };
    return part(b.first, a.first) * part(c.second, a.second) -
           part(b.second, a.second) * part(c.first, a.first);
  }
  static bool InBox(Spot a, Spot b, Spot c) {
    return std::min(a.first, b.first) <= c.first && c.first <= std::max(a.first, b.first) &&
           std::min(a.second, b.second) <= c.second && c.second <= std::max(a.second, b.second);
  }
  static bool Cross(Spot a, Spot b, Spot c, Spot d) {
    const Exact abc = Turn(a, b, c), abd = Turn(a, b, d), cda = Turn(c, d, a), cdb = Turn(c, d, b);
    const bool ab_parts = (abc < 0 && abd > 0) || (abc > 0 && abd < 0);
    const bool cd_parts = (cda < 0 && cdb > 0) || (cda > 0 && cdb < 0);
    return (ab_parts && cd_parts) || (abc == 0 && InBox(a, b, c)) || (abd == 0 && InBox(a, b, d)) ||
           (cda == 0 && InBox(c, d, a)) || (cdb == 0 && InBox(c, d, b));
  }

  /// A line meets an area when it crosses its border or begins inside: when a ray to the east from
  /// there crosses the border an odd number of times.
  static bool Meets(const std::vector<Spot>& line, const std::vector<Spot>& area) {
    int crossings = 0;
    const Spot first = line.front();
    for (std::size_t k = 0; k < area.size(); ++k) {
      const Spot c = area[k], d = area[k + 1 == area.size() ? 0 : k + 1];
      for (std::size_t i = 1; i < line.size(); ++i) {
        if (Cross(line[i - 1], line[i], c, d)) return true;
      }
      const Spot low = c.second <= d.second ? c : d, high = c.second <= d.second ? d : c;
      if (low.second <= first.second && first.second < high.second) {
        crossings += Turn(low, high, first) > 0 ? 1 : 0;
      }
    }
    return crossings % 2 == 1;
  }

  static double Away(const std::vector<Spot>& line, Place from) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < line.size(); ++i) {
      const auto place = [](Spot s) {
        return Place{static_cast<double>(s.first) / 1000, static_cast<double>(s.second) / 1000};
      };
      const Place a = place(line[i - 1]), b = place(line[i]);
      const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
      const double part = ((from.x_m - a.x_m) * dx + (from.y_m - a.y_m) * dy) / (dx * dx + dy * dy);
      const double on = std::min(1.0, std::max(0.0, part));
      least = std::min(least, Apart(from, {a.x_m + on * dx, a.y_m + on * dy}));
    }
    return least;
  }

  std::vector<std::int64_t> ids_;
  std::vector<std::vector<Spot>> lines_;
};

class WaysOnRoads : public RoadWays {
 public:
  WaysOnRoads(const json& file, const OpenGround (&ground)[3], const std::vector<Place>& sites)
      : lines_(std::make_shared<const Lines>(file)),
        workers_(std::make_shared<Streets>(file, "workers_percent", true, ground[kWorker], sites)),
        vehicles_(
            std::make_shared<Streets>(file, "vehicles_percent", false, ground[kVehicle], sites)),
        all_workers_(workers_),
        all_vehicles_(vehicles_) {}

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
    return kind == kUav ? Ways::StopNear(kind, wanted) : AllStreetsOf(kind).StopNear(wanted);
  }
  std::optional<Place> StopOf(int kind, int number) const override {
    return kind == kUav || number < 0 ? std::nullopt : AllStreetsOf(kind).StopOf(number);
  }
  std::optional<double> MeetsAt(int kind, Place from, Place to, double part,
                                const std::set<int>& roads, const Ways&) const override {
    return kind == kUav ? std::nullopt : StreetsOf(kind).MeetsAt(from, to, part, roads);
  }
  std::shared_ptr<const RoadWays> Without(const std::set<int>& roads) const override {
    auto rest = std::make_shared<WaysOnRoads>(*this);
    const auto close = [&](const Streets& all) {
      auto streets = std::make_shared<Streets>(all);
      streets->Close(roads);
      return streets;
    };
    rest->workers_ = close(*all_workers_);
    rest->vehicles_ = close(*all_vehicles_);
    return rest;
  }
  std::set<int> RoadsIn(const std::string& order) const override {
    std::set<int> found = lines_->Named(json::parse(order));
    if (found.empty()) throw std::invalid_argument("it names no road");
    return found;
  }

 private:
  const Streets& StreetsOf(int kind) const { return kind == kWorker ? *workers_ : *vehicles_; }
  const Streets& AllStreetsOf(int kind) const {
    return kind == kWorker ? *all_workers_ : *all_vehicles_;
  }

  std::shared_ptr<const Lines> lines_;
  std::shared_ptr<const Streets> workers_, vehicles_;
  std::shared_ptr<const Streets> all_workers_, all_vehicles_;  ///< while no road is closed
};

}  // namespace

std::shared_ptr<const RoadWays> ReadRoadWays(const std::string& text, const OpenGround (&ground)[3],
                                             const std::vector<Place>& sites) {
  return std::make_shared<const WaysOnRoads>(json::parse(text), ground, sites);
}

}  // namespace muster::tools::audit
