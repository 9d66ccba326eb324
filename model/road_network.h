#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <span>
#include <unordered_map>
#include <vector>

#include "base/geometry.h"
#include "base/grid_index.h"
#include "base/point_hash.h"
#include "model/road_hierarchy.h"
#include "model/road_ways.h"
#include "model/roads.h"
#include "model/ways.h"

namespace muster {

/// The roads as one agent class uses them. Costs are whole millimetres at the class's full speed.
class RoadNetwork {
 public:
  RoadNetwork(const Roads& roads, AgentKind kind, const OpenGround& open_ground,
              std::span<const Point> sites);
  /// The same without the closed roads. `closed`: [roads of the file].
  RoadNetwork(const RoadNetwork& all, const std::vector<bool>& closed);
  ~RoadNetwork();

  /// Where a place is in the network: on that segment (of the one road that is nearest), so far
  /// from its road's first point, across so much open ground.
  struct Spot {
    std::int32_t road = -1;     ///< index into this class's roads
    std::int64_t along_mm = 0;  ///< cost from the road's first point
    std::int64_t off_mm = 0;    ///< cost of the open ground
    Point at;                   ///< on the road
  };
  /// A way from end to end. `reached_mm[i]`: cost up to corner i; the first is 0.
  struct Way {
    std::vector<Point> corners;  ///< both ends included
    std::vector<std::int64_t> reached_mm;
    std::vector<std::int32_t> roads;  ///< that lead to corner i; -1: open ground, or none
    std::int64_t ground_mm = 0;
  };

  /// None where no road is within reach.
  std::optional<Spot> SpotOf(Point place) const;
  /// Cost from one place to the other; -1: there is no way.
  std::int64_t Cost(Point from, Point to) const;
  /// Places to which many ways are asked for.
  class Places;
  Places LookUp(std::span<const Point> places) const;
  /// Cost from there to those of the places, by index: visit(index in `which`, place, cost).
  template <class Visit>
  void Costs(Point from, const Places& to, std::span<const std::int32_t> which,
             Visit&& visit) const;
  /// Cost from each of `from` to each of `to`: visit(from's index, to's index, cost).
  template <class Visit>
  void Costs(std::span<const Point> from, std::span<const Point> to, Visit&& visit) const;
  /// The same way in full; its last reached_mm is the cost. Null: there is none.
  std::shared_ptr<const Way> WayBetween(Point from, Point to) const;

  /// After which of its millimetres, not before `begin_mm`, the way comes to a road that is closed
  /// in `now`; -1: to none. The way is of a network of the same roads.
  std::int64_t BarredAt(const Way& way, double begin_mm, const RoadNetwork& now) const;

  Ways::Stop StopNear(Point wanted) const;
  std::optional<Point> NumberedStop(std::int32_t number) const;

 private:
  struct Segment {
    RoadPoint a, b;
    std::int32_t road;
    std::int64_t begins_mm;  ///< cost along the road where it begins
    std::int64_t cost_mm;
  };
  /// One of this class's roads.
  struct Line {
    std::int32_t first_node, last_node;
    std::int32_t first_segment, end_segment;
    std::int64_t cost_mm;
    bool backward;           ///< also from its last point to its first
    std::int32_t file_road;  ///< index in the road file
  };
  /// A road as seen from one of its ends.
  struct Arc {
    std::int32_t line, other;
    std::uint32_t cost_mm;
    bool leaves, enters;  ///< may be taken from here, to here
  };
  /// Which end of a way a place is.
  enum Role { kFrom, kTo };
  /// What has been found out about a place.
  struct Known {
    std::optional<Spot> spot;
    std::int32_t site = -1;
    bool is_kept = true;  ///< by the network
    /// [sites] Of the ways from here to the sites: 0, not known yet; kUnreached, none leads there;
    /// else their cost + 1. Null: not kept. Read and written without the lock.
    std::unique_ptr<std::atomic<std::uint32_t>[]> to_site;
    std::mutex mutex;                                               ///< of what follows
    std::array<std::shared_ptr<const RoadCosts::Label>, 2> labels;  ///< by role
    std::unique_ptr<RoadSearch> search;                             ///< to it
  };
  /// An end of ways of which costs are asked.
  struct Place {
    std::uint64_t network = 0;  ///< its id; 0: none
    Point at;
    Known* known = nullptr;
    std::shared_ptr<Known> own = nullptr;                     ///< the same, if it is not kept
    std::shared_ptr<const RoadCosts::Label> label = nullptr;  ///< null: not asked for so far
    double farthest_m = 0;  ///< to the ends that are asked for now, by a straight line
    /// To copy a label takes time, and often none is needed.
    /// That end will be asked for as well.
    void AlsoTo(Point end) { farthest_m = std::max(farthest_m, Distance(at, end)); }
    Place WithoutLabel() const { return {network, at, known, own}; }
  };
  struct Ends {
    std::array<RoadCosts::End, 2> ends;
    std::size_t n = 0;
  };
  struct Pair {
    Point from, to;
    bool operator==(const Pair&) const = default;
  };
  struct PairHash {
    std::size_t operator()(const Pair& pair) const;
  };

  /// What stays as it is whatever is closed.
  struct Map {
    static constexpr double kHalfSpacing_m = 50;
    /// Smallest whole number that is not below 100 `mm` / `percent`.
    static std::int64_t AtPercent(std::int64_t mm, std::int32_t percent);
    /// As arcs hold it: what does not fit is as if no way led there.
    static std::uint32_t CostOfArc(std::int64_t mm);

    OpenGround open_ground;
    std::vector<Line> lines;
    std::vector<Segment> segments;
    std::vector<Arc> arcs;             ///< by node, ascending by line
    std::vector<std::size_t> arcs_of;  ///< [nodes + 1] into arcs

    /// Points along the segments, so close that a place's distance to a segment is at most
    /// kHalfSpacing_m less than that to the nearest of its points.
    std::vector<std::int32_t> segment_of_sample;
    std::optional<GridIndex> samples;

    std::vector<std::pair<std::int32_t, Point>> stops;  ///< number and place, ascending
    std::optional<GridIndex> stop_index;
    std::unordered_map<Point, std::int32_t, PointHash> site_of;  ///< where most ways begin and end

    void AddRoads(const Roads& roads, AgentKind kind);
    void ConnectNodes(std::size_t n_nodes);
    void IndexSegments();
    void IndexStops(const RoadNetwork& network, const Roads& roads, AgentKind kind,
                    std::span<const Point> sites);
    std::span<const Arc> ArcsOf(std::int32_t node) const;
    /// Made when it is first asked for.
    std::shared_ptr<const RoadHierarchy> Hierarchy() const;

   private:
    mutable std::once_flag ordered_;
    mutable std::shared_ptr<const RoadHierarchy> hierarchy_;
  };

  /// Of what is not closed; made when it is first asked for.
  const RoadCosts& costs() const;
  std::optional<Spot> FindSpot(Point place) const;
  bool IsClosed(std::int32_t line) const {
    return !closed_.empty() && closed_[static_cast<std::size_t>(line)];
  }
  /// The thread keeps it until it asks for another place in the same role.
  Place& PlaceOf(Point place, Role role) const;
  /// The nodes by which a spot is left, or reached.
  Ends EndsOf(const Spot& spot, Role role) const;
  /// For ways of so much at least. `known` has a spot, and in these two it is locked.
  std::shared_ptr<const RoadCosts::Label> LabelOf(Known* known, Role role,
                                                  std::uint32_t until_mm) const;
  RoadSearch* SearchTo(Known* goal, std::uint32_t until_mm) const;
  /// Bytes that a place has more, or less, and makes room if those are too many.
  void Count(const Known& known, std::ptrdiff_t more) const;
  /// Forgets labels and searches until half the room is free.
  void MakeRoom(const Known* but) const;
  /// The node that the spot is at; -1: it is between two.
  std::int32_t NodeOf(const Spot& spot) const;
  /// Whether they are one place. At a node that may be on different roads: rounding decides on
  /// which.
  bool IsSame(const Spot& a, const Spot& b) const;
  /// What is kept of the cost from there to a site; 0: nothing.
  static std::uint32_t Kept(const Known& from, std::int32_t site) {
    if (site < 0 || from.to_site == nullptr) return 0;
    return from.to_site[static_cast<std::size_t>(site)].load(std::memory_order_relaxed);
  }
  static std::int64_t CostOf(std::uint32_t kept) {
    return kept == RoadCosts::kUnreached ? -1 : std::int64_t{kept} - 1;
  }
  std::int64_t CostBetween(Place* from, Place* to) const;
  /// The same of places that have spots which are not the same, by road.
  std::int64_t RoadCostBetween(Place* from, Place* to) const;
  /// Cost between two spots on one road without leaving it; -1: there is no such way.
  std::int64_t AlongRoad(const Spot& from, const Spot& to) const;
  /// By road, without the open ground; -1: there is no way. `first`: the node that the way leaves
  /// the first road by; -1: it stays on that road.
  std::int64_t RoadCost(const Spot& from, const Spot& to, RoadSearch* search,
                        std::int32_t* first) const;
  /// Cost of so many metres of open ground; -1: it is none to cross.
  std::int64_t OpenCost(double metres) const;
  std::shared_ptr<const Way> FindWay(Point from, Point to) const;
  /// Appends the corners of a road between two of its places, the first left out.
  void Follow(const Line& line, std::int64_t from_mm, std::int64_t to_mm, Way* way) const;

  std::shared_ptr<const Map> map_;
  std::vector<bool> closed_;  ///< [lines]; empty: none is
  mutable std::once_flag customized_;
  mutable std::unique_ptr<const RoadCosts> costs_;

  const std::uint64_t id_;  ///< no other network of this process has it

  // What was asked before.
  mutable std::atomic<std::ptrdiff_t> bytes_ = 0;  ///< of labels and searches
  mutable std::shared_mutex mutex_;
  mutable std::unordered_map<Point, std::unique_ptr<Known>, PointHash> known_;
  mutable std::unordered_map<Pair, std::shared_ptr<const Way>, PairHash> ways_;
};

class RoadNetwork::Places {
  friend RoadNetwork;
  std::vector<Place> places_;
  std::vector<std::int32_t> sites_;  ///< [places]; -1: none
};

template <class Visit>
void RoadNetwork::Costs(Point from, const Places& to, std::span<const std::int32_t> which,
                        Visit&& visit) const {
  Place begin = PlaceOf(from, kFrom).WithoutLabel();
  const auto index = [&](std::size_t i) { return static_cast<std::size_t>(which[i]); };
  for (std::size_t i = 0; i < which.size(); ++i) begin.AlsoTo(to.places_[index(i)].at);
  for (std::size_t i = 0; i < which.size(); ++i) {
    const Place& place = to.places_[index(i)];
    std::int64_t cost_mm = 0;
    if (const std::uint32_t kept = Kept(*begin.known, to.sites_[index(i)]); kept != 0) {
      cost_mm = CostOf(kept);
    } else {
      Place end = place.WithoutLabel();
      cost_mm = CostBetween(&begin, &end);
    }
    visit(i, place.at, cost_mm);
  }
}

template <class Visit>
void RoadNetwork::Costs(std::span<const Point> from, std::span<const Point> to,
                        Visit&& visit) const {
  Places ends = LookUp(to);
  for (std::size_t i = 0; i < from.size(); ++i) {
    Place begin = PlaceOf(from[i], kFrom).WithoutLabel();
    for (const Point& place : to) begin.AlsoTo(place);
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::uint32_t kept = Kept(*begin.known, ends.sites_[j]);
      visit(i, j, kept != 0 ? CostOf(kept) : CostBetween(&begin, &ends.places_[j]));
    }
  }
}

}  // namespace muster
