#include "tools/map/road_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <unordered_map>
#include <utility>

#include "base/check.h"
#include "base/units.h"

namespace muster::tools {
namespace {

/// How much of a road is closed to vehicles on each side of a barrier.
constexpr std::int64_t kBarrier_mm = 1000;

std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }

RoadPoint ToMm(Point p) {
  return {static_cast<std::int32_t>(RoundHalfAway(p.x_m * 1000)),
          static_cast<std::int32_t>(RoundHalfAway(p.y_m * 1000))};
}

std::uint64_t KeyOf(RoadPoint p) {
  return std::uint64_t{static_cast<std::uint32_t>(p.x_mm)} << 32 |
         static_cast<std::uint32_t>(p.y_mm);
}

/// The point after `done` of `all` equal steps from a to b; the same from b to a.
RoadPoint Between(RoadPoint a, RoadPoint b, std::int64_t done, std::int64_t all) {
  if (std::pair(b.x_mm, b.y_mm) < std::pair(a.x_mm, a.y_mm)) {
    std::swap(a, b);
    done = all - done;
  }
  const double share = static_cast<double>(done) / static_cast<double>(all);
  const auto step = [share](std::int32_t from, std::int32_t to) {
    const double way = static_cast<double>(to) - static_cast<double>(from);
    return from + static_cast<std::int32_t>(RoundHalfAway(way * share));
  };
  return {step(a.x_mm, b.x_mm), step(a.y_mm, b.y_mm)};
}

std::int32_t ClassIndex(const RoadClass& road_class, std::vector<RoadClass>* classes) {
  const auto known = std::find_if(classes->begin(), classes->end(), [&](const RoadClass& other) {
    return other.name == road_class.name && other.one_way == road_class.one_way &&
           other.percent.workers == road_class.percent.workers &&
           other.percent.vehicles == road_class.percent.vehicles;
  });
  const auto index = static_cast<std::int32_t>(known - classes->begin());
  if (known == classes->end()) classes->push_back(road_class);
  return index;
}

/// Numbers of the parts of a directed graph in which one gets from each node to each other.
/// Source: R. Tarjan, "Depth-first search and linear graph algorithms", SIAM J. Comput. 1 (1972).
class StrongParts {
 public:
  explicit StrongParts(const std::vector<std::vector<std::int32_t>>& next)
      : next_(next),
        part_(next.size(), -1),
        index_(next.size(), -1),
        low_(next.size()),
        taken_(next.size()) {
    for (std::size_t i = 0; i < next.size(); ++i) {
      if (index_[i] < 0) Walk(static_cast<std::int32_t>(i));
    }
  }
  const std::vector<std::int32_t>& part() const { return part_; }

 private:
  void Enter(std::int32_t node) {
    index_[At(node)] = low_[At(node)] = count_++;
    open_.push_back(node);
    path_.push_back(node);
  }

  void Walk(std::int32_t root) {
    Enter(root);
    while (!path_.empty()) {
      const std::int32_t node = path_.back();
      if (taken_[At(node)] < next_[At(node)].size()) {
        const std::int32_t other = next_[At(node)][taken_[At(node)]++];
        if (index_[At(other)] < 0) {
          Enter(other);
        } else if (part_[At(other)] < 0) {
          low_[At(node)] = std::min(low_[At(node)], index_[At(other)]);
        }
        continue;
      }
      path_.pop_back();
      if (!path_.empty()) {
        low_[At(path_.back())] = std::min(low_[At(path_.back())], low_[At(node)]);
      }
      if (low_[At(node)] == index_[At(node)]) Close(node);
    }
  }

  void Close(std::int32_t node) {
    std::int32_t last = -1;
    do {
      last = open_.back();
      open_.pop_back();
      part_[At(last)] = parts_;
    } while (last != node);
    ++parts_;
  }

  const std::vector<std::vector<std::int32_t>>& next_;
  std::vector<std::int32_t> part_, index_, low_;
  std::vector<std::size_t> taken_;  // of the node's next_
  std::vector<std::int32_t> open_, path_;
  std::int32_t count_ = 0, parts_ = 0;
};

}  // namespace

/// The network while it is made.
class RoadBuilder::Network {
 public:
  explicit Network(const RoadBuilder& from) : from_(from), classes_(from.classes_) {}

  BuiltRoads Build(std::string source, const std::string& file) {
    NumberNodes();
    JoinNodes();
    Divide();
    built_.lines = CountLines();
    DropDoubles();
    const std::size_t lines = CountLines();
    KeepLargestParts();
    for (const Way& way : ways_) built_.cut_off_mm += way.is_kept ? 0 : LengthOf(way.nodes);
    std::erase_if(ways_, [](const Way& way) { return !way.is_kept; });
    built_.cut_off = lines - CountLines();
    if (ways_.empty()) {
      throw InputError(file, "roads", "one-way roads alone, from which no way leads back",
                       "a network");
    }
    ChainWays();
    Write(std::move(source));
    return std::move(built_);
  }

 private:
  /// A road between two junctions.
  struct Way {
    std::size_t line;
    std::int32_t road_class;
    std::vector<std::int32_t> nodes;
    bool is_kept = true;
  };

  std::int32_t NewNode(RoadPoint at) {
    places_.push_back(at);
    return static_cast<std::int32_t>(places_.size()) - 1;
  }

  void NumberNodes() {
    std::unordered_map<std::uint64_t, std::int32_t> node_of;
    for (const Piece& piece : from_.pieces_) {
      std::vector<std::int32_t>& nodes = pieces_.emplace_back();
      for (const Spot& spot : piece.spots) {
        if (spot.is_cut) {
          nodes.push_back(NewNode(spot.at));
          is_cut_.resize(places_.size());
          is_cut_.back() = true;
          continue;
        }
        const auto [known, is_new] =
            node_of.try_emplace(KeyOf(spot.at), static_cast<std::int32_t>(places_.size()));
        if (is_new) NewNode(spot.at);
        nodes.push_back(known->second);
      }
    }
    is_cut_.resize(places_.size());
    is_barrier_.resize(places_.size());
    for (const RoadPoint& barrier : from_.barriers_) {
      const auto node = node_of.find(KeyOf(barrier));
      if (node == node_of.end() || is_barrier_[At(node->second)]) continue;
      is_barrier_[At(node->second)] = true;
      ++built_.barriers;
    }
  }

  /// Points that are near each other become the first of them.
  void JoinNodes() {
    const auto cell_mm = static_cast<double>(from_.join_mm_);
    if (cell_mm == 0) return;
    const auto cell = [&](std::int32_t mm) {
      return static_cast<std::int32_t>(std::floor(mm / cell_mm));
    };
    std::unordered_map<std::uint64_t, std::vector<std::int32_t>> kept;  // by cell
    std::vector<std::int32_t> node_of(places_.size());
    for (std::int32_t i = 0; At(i) < places_.size(); ++i) {
      node_of[At(i)] = i;
      if (is_cut_[At(i)]) continue;
      const RoadPoint p = places_[At(i)];
      for (std::int32_t dx = -1; dx <= 1; ++dx) {
        for (std::int32_t dy = -1; dy <= 1; ++dy) {
          const auto near = kept.find(KeyOf({cell(p.x_mm) + dx, cell(p.y_mm) + dy}));
          if (near == kept.end()) continue;
          for (const std::int32_t other : near->second) {
            if (other < node_of[At(i)] &&
                static_cast<double>(LengthMm(p, places_[At(other)])) <= cell_mm) {
              node_of[At(i)] = other;
            }
          }
        }
      }
      if (node_of[At(i)] == i) {
        kept[KeyOf({cell(p.x_mm), cell(p.y_mm)})].push_back(i);
      } else {
        ++built_.joined;
        if (is_barrier_[At(i)]) is_barrier_[At(node_of[At(i)])] = true;
      }
    }
    for (std::vector<std::int32_t>& nodes : pieces_) {
      for (std::int32_t& node : nodes) node = node_of[At(node)];
    }
  }

  /// Makes the ways, divided at junctions and barriers.
  void Divide() {
    std::vector<Way> parts;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const std::size_t line = from_.pieces_[i].line;
      const std::int32_t road_class = from_.lines_[line].road_class;
      std::vector<std::int32_t> nodes = std::move(pieces_[i]);
      nodes.erase(std::unique(nodes.begin(), nodes.end(),
                              [&](std::int32_t a, std::int32_t b) {
                                return places_[At(a)] == places_[At(b)];
                              }),
                  nodes.end());
      if (nodes.size() < 2) continue;
      if (classes_[At(road_class)].percent.vehicles == 0) {
        parts.push_back({line, road_class, std::move(nodes)});
      } else {
        CloseBarriers({line, road_class, std::move(nodes)}, &parts);
      }
    }
    std::vector<std::int32_t> uses(places_.size());
    for (const Way& part : parts) {
      for (const std::int32_t node : part.nodes) ++uses[At(node)];
    }
    for (const Way& part : parts) {
      Way way{part.line, part.road_class, {part.nodes.front()}};
      for (std::size_t k = 1; k < part.nodes.size(); ++k) {
        way.nodes.push_back(part.nodes[k]);
        if (k + 1 < part.nodes.size() && uses[At(part.nodes[k])] == 1) continue;
        ways_.push_back(std::exchange(way, {part.line, part.road_class, {part.nodes[k]}}));
      }
    }
  }

  /// Appends the parts of a way of which a metre at each barrier is closed to vehicles.
  void CloseBarriers(const Way& way, std::vector<Way>* parts) {
    RoadClass closed_class = classes_[At(way.road_class)];
    closed_class.percent.vehicles = 0;
    closed_class.one_way = false;
    closed_class.name += ", barrier";
    std::size_t first = parts->size();
    const auto add = [&](std::int32_t to, bool is_closed) {
      const std::int32_t from =
          parts->size() == first ? way.nodes.front() : parts->back().nodes.back();
      const std::int32_t road_class =
          is_closed ? ClassIndex(closed_class, &classes_) : way.road_class;
      if (parts->size() == first || parts->back().road_class != road_class) {
        parts->push_back({way.line, road_class, {from}});
      }
      parts->back().nodes.push_back(to);
    };
    for (std::size_t k = 1; k < way.nodes.size(); ++k) {
      const std::int32_t a = way.nodes[k - 1], b = way.nodes[k];
      const bool closes_a = is_barrier_[At(a)], closes_b = is_barrier_[At(b)];
      const std::int64_t length_mm = LengthMm(places_[At(a)], places_[At(b)]);
      if ((closes_a || closes_b) && length_mm <= 3 * kBarrier_mm) {
        add(b, true);
        continue;
      }
      const auto split = [&](std::int64_t done_mm) {
        const std::int32_t node =
            NewNode(Between(places_[At(a)], places_[At(b)], done_mm, length_mm));
        is_barrier_.push_back(false);
        return node;
      };
      if (closes_a) add(split(kBarrier_mm), true);
      if (closes_b) add(split(length_mm - kBarrier_mm), false);
      add(b, closes_b);
    }
  }

  void DropDoubles() {
    std::set<std::pair<std::int32_t, std::vector<std::int32_t>>> seen;
    std::erase_if(ways_, [&](const Way& way) {
      std::vector<std::int32_t> nodes = way.nodes;
      if (!classes_[At(way.road_class)].one_way) {
        nodes = std::min(nodes, {nodes.rbegin(), nodes.rend()});
      }
      return !seen.emplace(way.road_class, std::move(nodes)).second;
    });
  }

  std::int64_t LengthOf(const std::vector<std::int32_t>& nodes) const {
    std::int64_t length_mm = 0;
    for (std::size_t k = 1; k < nodes.size(); ++k) {
      length_mm += LengthMm(places_[At(nodes[k - 1])], places_[At(nodes[k])]);
    }
    return length_mm;
  }

  /// Whether the way is in the class's largest part, for each way.
  std::vector<bool> LargestPart(AgentKind kind) const {
    std::vector<std::vector<std::int32_t>> next(places_.size());
    const auto percent = [&](const Way& way) { return classes_[At(way.road_class)].percent[kind]; };
    for (const Way& way : ways_) {
      if (percent(way) == 0) continue;
      next[At(way.nodes.front())].push_back(way.nodes.back());
      if (kind == AgentKind::kVehicle && classes_[At(way.road_class)].one_way) continue;
      next[At(way.nodes.back())].push_back(way.nodes.front());
    }
    const std::vector<std::int32_t> part = StrongParts(next).part();  // by node
    const auto part_of = [&](const Way& way) {  // -1: a way from one part to another
      const std::int32_t first = part[At(way.nodes.front())];
      return percent(way) > 0 && first == part[At(way.nodes.back())] ? first : -1;
    };
    std::vector<std::int64_t> length_mm(places_.size());
    for (const Way& way : ways_) {
      if (part_of(way) >= 0) length_mm[At(part_of(way))] += LengthOf(way.nodes);
    }
    std::int32_t largest = -1;
    for (const Way& way : ways_) {
      const std::int32_t its = part_of(way);
      if (its >= 0 && (largest < 0 || length_mm[At(its)] > length_mm[At(largest)])) largest = its;
    }
    std::vector<bool> is_in;
    is_in.reserve(ways_.size());
    for (const Way& way : ways_) is_in.push_back(largest >= 0 && part_of(way) == largest);
    return is_in;
  }

  void KeepLargestParts() {
    const std::vector<bool> workers = LargestPart(AgentKind::kWorker);
    const std::vector<bool> vehicles = LargestPart(AgentKind::kVehicle);
    for (std::size_t i = 0; i < ways_.size(); ++i) {
      RoadClass kept = classes_[At(ways_[i].road_class)];
      ways_[i].is_kept = workers[i] || vehicles[i];
      if (kept.percent.workers > 0 && !workers[i]) {
        kept.percent.workers = 0;
        kept.name += ", cut off on foot";
      }
      if (kept.percent.vehicles > 0 && !vehicles[i]) {
        kept.percent.vehicles = 0;
        kept.one_way = false;
        kept.name += ", cut off for vehicles";
      }
      if (ways_[i].is_kept) ways_[i].road_class = ClassIndex(kept, &classes_);
    }
  }

  /// Lines that any way is of.
  std::size_t CountLines() const {
    std::vector<bool> seen(from_.lines_.size());
    for (const Way& way : ways_) seen[way.line] = true;
    return static_cast<std::size_t>(std::count(seen.begin(), seen.end(), true));
  }

  /// Joins ways of one class that meet where no other way ends.
  void ChainWays() {
    ends_.assign(places_.size(), {});
    for (std::size_t i = 0; i < ways_.size(); ++i) {
      ends_[At(ways_[i].nodes.front())].push_back(i);
      ends_[At(ways_[i].nodes.back())].push_back(i);
    }
    std::vector<Way> chains;
    std::vector<bool> done(ways_.size());
    for (std::size_t i = 0; i < ways_.size(); ++i) {
      if (done[i]) continue;
      done[i] = true;
      Way chain = ways_[i];
      Extend(true, &chain, &done);
      std::reverse(chain.nodes.begin(), chain.nodes.end());
      Extend(false, &chain, &done);
      std::reverse(chain.nodes.begin(), chain.nodes.end());
      chains.push_back(std::move(chain));
    }
    for (const std::vector<std::size_t>& ends : ends_) built_.junctions += ends.size() > 2 ? 1 : 0;
    ways_ = std::move(chains);
  }

  /// Appends what follows the chain's last point. `ahead`: its points run as its traffic does.
  void Extend(bool ahead, Way* chain, std::vector<bool>* done) const {
    for (;;) {
      const std::int32_t node = chain->nodes.back();
      const std::vector<std::size_t>& ends = ends_[At(node)];
      if (ends.size() != 2) return;
      const std::size_t i = (*done)[ends[0]] ? ends[1] : ends[0];
      const Way& other = ways_[i];
      if ((*done)[i] || other.road_class != chain->road_class) return;
      const bool begins_here = other.nodes.front() == node;
      if (classes_[At(other.road_class)].one_way && begins_here != ahead) return;
      std::vector<std::int32_t> nodes = other.nodes;
      if (!begins_here) std::reverse(nodes.begin(), nodes.end());
      chain->nodes.insert(chain->nodes.end(), nodes.begin() + 1, nodes.end());
      (*done)[i] = true;
    }
  }

  void Write(std::string source) {
    Roads& roads = built_.roads;
    roads.source = std::move(source);
    std::vector<std::int32_t> class_of(classes_.size(), -1), point_of(places_.size(), -1);
    const auto add = [&](RoadPoint at) {
      roads.points.push_back(at);
      return static_cast<std::int32_t>(roads.points.size()) - 1;
    };
    const auto point = [&](std::int32_t node) {
      std::int32_t& known = point_of[At(node)];
      if (known < 0) known = add(places_[At(node)]);
      return known;
    };
    for (const Way& way : ways_) {
      std::int32_t& road_class = class_of[At(way.road_class)];
      if (road_class < 0) {
        road_class = static_cast<std::int32_t>(roads.classes.size());
        roads.classes.push_back(classes_[At(way.road_class)]);
      }
      Road road{from_.lines_[way.line].id, road_class, {point(way.nodes.front())}};
      for (std::size_t k = 1; k < way.nodes.size(); ++k) {
        const RoadPoint a = places_[At(way.nodes[k - 1])], b = places_[At(way.nodes[k])];
        const std::int64_t steps = (LengthMm(a, b) + kMostStep_mm - 1) / kMostStep_mm;
        for (std::int64_t step = 1; step < steps; ++step) {
          road.points.push_back(add(Between(a, b, step, steps)));
        }
        road.points.push_back(point(way.nodes[k]));
      }
      const std::int64_t length_mm = LengthOf(way.nodes);
      built_.length_mm += length_mm;
      if (classes_[At(way.road_class)].percent.vehicles > 0) built_.driven_mm += length_mm;
      roads.roads.push_back(std::move(road));
    }
  }

  const RoadBuilder& from_;
  std::vector<RoadClass> classes_;
  std::vector<RoadPoint> places_;                  // by node
  std::vector<bool> is_cut_, is_barrier_;          // by node
  std::vector<std::vector<std::int32_t>> pieces_;  // nodes of each
  std::vector<Way> ways_;
  std::vector<std::vector<std::size_t>> ends_;  // by node: the ways that end there
  BuiltRoads built_;
};

RoadBuilder::RoadBuilder(double width_m, double height_m, double join_m)
    : east_m_(std::min(width_m + kRoadMargin_m, kFarthestRoad_mm / 1000.0)),
      north_m_(std::min(height_m + kRoadMargin_m, kFarthestRoad_mm / 1000.0)),
      join_mm_(RoundHalfAway(join_m * 1000)) {}

bool RoadBuilder::Clip(Point a, Point b, double* enters, double* leaves) const {
  *enters = 0;
  *leaves = 1;
  // Source: Y. Liang, B. Barsky, "A new concept and method for line clipping", ACM TOG 3 (1984).
  const auto side = [&](double way, double room) {  // inside while share * way <= room
    if (way == 0) return room >= 0;
    if (way < 0) {
      *enters = std::max(*enters, room / way);
    } else {
      *leaves = std::min(*leaves, room / way);
    }
    return *enters < *leaves;
  };
  const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
  return std::isfinite(dx) && std::isfinite(dy) && side(-dx, a.x_m + kRoadMargin_m) &&
         side(dx, east_m_ - a.x_m) && side(-dy, a.y_m + kRoadMargin_m) &&
         side(dy, north_m_ - a.y_m);
}

void RoadBuilder::Keep(std::vector<Spot> spots) {
  // Rounding may move a cut to the point beside it, which other lines may meet. Of points in one
  // place the first is kept.
  if (spots.size() > 1 && spots[0].is_cut && spots[0].at == spots[1].at) spots.erase(spots.begin());
  if (spots.size() > 1) pieces_.push_back({lines_.size() - 1, std::move(spots)});
}

void RoadBuilder::AddLine(std::int64_t id, const RoadClass& road_class,
                          const std::vector<Point>& places) {
  lines_.push_back({id, ClassIndex(road_class, &classes_)});
  std::vector<Spot> spots;
  for (std::size_t i = 1; i < places.size(); ++i) {
    const Point a = places[i - 1], b = places[i];
    double enters = 0, leaves = 1;
    if (!Clip(a, b, &enters, &leaves)) {
      Keep(std::exchange(spots, {}));
      continue;
    }
    if (enters > 0) Keep(std::exchange(spots, {}));
    if (spots.empty()) spots.push_back({ToMm(Lerp(a, b, enters)), enters > 0});
    spots.push_back({ToMm(leaves < 1 ? Lerp(a, b, leaves) : b), leaves < 1});
    if (leaves < 1) Keep(std::exchange(spots, {}));
  }
  Keep(std::move(spots));
}

void RoadBuilder::AddBarrier(Point place) {
  double enters = 0, leaves = 1;
  if (Clip(place, place, &enters, &leaves)) barriers_.push_back(ToMm(place));
}

BuiltRoads RoadBuilder::Build(std::string source, const std::string& file) const {
  return Network(*this).Build(std::move(source), file);
}

}  // namespace muster::tools
