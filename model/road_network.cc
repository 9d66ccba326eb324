#include "model/road_network.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>

#include "base/check.h"
#include "base/index.h"
#include "base/units.h"

namespace muster {
namespace {

constexpr std::size_t kMostKnown = 1 << 20;
constexpr std::size_t kMostWays = 1 << 17;
constexpr std::size_t kMostSites = 1 << 16;
constexpr std::size_t kMostCostBytes = std::size_t{1} << 26;  // of the costs to sites
constexpr std::size_t kMostSearchBytes = std::size_t{1} << 29;
constexpr std::uint32_t kUnreached = RoadSearch::kUnreached;

std::atomic<std::uint64_t> next_id = 1;

}  // namespace

struct RoadNetwork::Known {
  std::optional<Spot> spot;
  std::int32_t site = -1;
  /// [sites] Of the ways from here to the sites: 0, not known yet; kUnreached, none leads there;
  /// else their cost + 1. Null: not kept. Read and written without the lock.
  std::unique_ptr<std::atomic<std::uint32_t>[]> to_site;
  std::mutex mutex;  ///< of what follows
  std::unique_ptr<RoadSearch> search;
};

std::size_t RoadNetwork::PairHash::operator()(const Pair& pair) const {
  return Mixed(PointHash()(pair.from), PointHash()(pair.to));
}

RoadNetwork::RoadNetwork(const Roads& roads, AgentKind kind, const OpenGround& open_ground,
                         std::span<const Point> sites)
    : id_(next_id++) {
  const auto map = std::make_shared<Map>();
  map->open_ground = open_ground;
  map->AddRoads(roads, kind);
  map->IndexSegments();
  for (const Point& site : sites) {
    if (sites.size() > kMostSites) break;
    map->site_of.emplace(site, static_cast<std::int32_t>(map->site_of.size()));
  }
  map_ = map;
  LeadInward();
  map->IndexStops(*this, roads, kind, sites);
}

RoadNetwork::RoadNetwork(const RoadNetwork& all, const std::vector<bool>& closed)
    : map_(all.map_), closed_(all.map_->lines.size()), all_(&all), id_(next_id++) {
  for (std::size_t i = 0; i < closed_.size(); ++i) {
    const Line& line = map_->lines[i];
    if (!closed[At(line.file_road)]) continue;
    closed_[i] = true;
    const std::uint32_t cost_mm = Map::CostOfArc(line.cost_mm);
    closed_arcs_.push_back({line.first_node, line.last_node, cost_mm});
    if (line.backward) closed_arcs_.push_back({line.last_node, line.first_node, cost_mm});
  }
  LeadInward();
}

RoadNetwork::~RoadNetwork() = default;

void RoadNetwork::LeadInward() {
  const std::size_t n_nodes = map_->arcs_of.size() - 1;
  inward_.arcs_of = {0};
  inward_.arcs_of.reserve(n_nodes + 1);
  for (std::size_t node = 0; node < n_nodes; ++node) {
    for (const Arc& arc : map_->ArcsOf(static_cast<std::int32_t>(node))) {
      if (arc.enters && !IsClosed(arc.line)) inward_.arcs.push_back({arc.other, arc.cost_mm});
    }
    inward_.arcs_of.push_back(inward_.arcs.size());
  }
}

std::int64_t RoadNetwork::OpenCost(double metres) const {
  const std::int64_t mm = RoundHalfAway(metres * 1000);
  if (mm == 0) return 0;
  if (map_->open_ground.percent == 0 || metres > map_->open_ground.reach_m) return -1;
  return Map::AtPercent(mm, map_->open_ground.percent);
}

std::optional<RoadNetwork::Spot> RoadNetwork::FindSpot(Point place) const {
  const double x_mm = place.x_m * 1000, y_mm = place.y_m * 1000;
  double nearest_m = std::numeric_limits<double>::infinity();
  std::int32_t of = -1;
  Spot spot;
  map_->samples->Nearest(place, [&](std::int32_t sample, Point, double) {
    const std::int32_t index = map_->segment_of_sample[At(sample)];
    const Segment& segment = map_->segments[At(index)];
    if (IsClosed(segment.road)) return std::numeric_limits<double>::infinity();
    const double dx = segment.b.x_mm - double{1} * segment.a.x_mm;
    const double dy = segment.b.y_mm - double{1} * segment.a.y_mm;
    const double share = std::clamp(
        ((x_mm - segment.a.x_mm) * dx + (y_mm - segment.a.y_mm) * dy) / (dx * dx + dy * dy), 0.0,
        1.0);
    const std::int64_t mm = RoundHalfAway(share * static_cast<double>(segment.cost_mm));
    const Point at = Lerp(ToPoint(segment.a), ToPoint(segment.b),
                          static_cast<double>(mm) / static_cast<double>(segment.cost_mm));
    const double distance_m = Distance(place, at);
    if (distance_m < nearest_m || (distance_m == nearest_m && index < of)) {
      nearest_m = distance_m;
      of = index;
      spot = {segment.road, segment.begins_mm + mm, 0, at};
    }
    return distance_m + Map::kHalfSpacing_m + 1;  // 1: a place is moved by rounding
  });
  if (of < 0) return {};
  spot.off_mm = OpenCost(nearest_m);
  if (spot.off_mm < 0) return {};
  return spot;
}

std::optional<RoadNetwork::Spot> RoadNetwork::SpotOf(Point place) const {
  return KnownOf(place, false)->spot;
}

RoadNetwork::Known* RoadNetwork::KnownOf(Point place, bool is_goal) const {
  // Callers ask for the same places again and again: each thread has those at hand.
  struct Entry {
    std::uint64_t network = 0;
    Point place;
    Known* known = nullptr;
  };
  constexpr std::size_t kEntries = 8192;
  thread_local std::vector<Entry> at_hand(kEntries);
  thread_local std::array<std::unique_ptr<Known>, 2> unkept;
  Entry& entry = at_hand[PointHash()(place) % kEntries];
  if (entry.network == id_ && entry.place == place) return entry.known;
  {
    const std::shared_lock lock(mutex_);
    if (const auto found = known_.find(place); found != known_.end()) {
      entry = {id_, place, found->second.get()};
      return entry.known;
    }
  }
  auto made = std::make_unique<Known>();
  made->spot = FindSpot(place);
  if (const auto site = map_->site_of.find(place); site != map_->site_of.end()) {
    made->site = site->second;
  }
  const std::unique_lock lock(mutex_);
  if (known_.size() >= kMostKnown) {
    unkept[is_goal] = std::move(made);
    return unkept[is_goal].get();
  }
  const std::size_t sites = map_->site_of.size();
  if (sites > 0 && known_.size() * sites < kMostCostBytes / 4) {
    made->to_site = std::make_unique<std::atomic<std::uint32_t>[]>(sites);
  }
  entry = {id_, place, known_.emplace(place, std::move(made)).first->second.get()};
  return entry.known;
}

RoadSearch* RoadNetwork::SearchTo(Point to, Known* goal) const {
  if (goal->search == nullptr) {
    if (*search_bytes_ > kMostSearchBytes) DropSearches(goal);
    if (all_ != nullptr) goal->search = SearchOfAll(to, goal->spot->road);
    if (goal->search != nullptr) return goal->search.get();
    const std::size_t bytes_of_all =
        map_->site_of.size() * sizeof(std::uint32_t) * inward_.n_nodes();
    const bool far = goal->site >= 0 && bytes_of_all < kMostSearchBytes / 2;
    goal->search = std::make_unique<RoadSearch>(inward_, far, search_bytes_);
    const Spot& spot = *goal->spot;
    const Line& line = map_->lines[At(spot.road)];
    goal->search->BeginAt(line.first_node, spot.along_mm);
    if (line.backward || spot.along_mm == line.cost_mm) {
      goal->search->BeginAt(line.last_node, line.cost_mm - spot.along_mm);
    }
  }
  return goal->search.get();
}

std::unique_ptr<RoadSearch> RoadNetwork::SearchOfAll(Point to, std::int32_t road) const {
  Known* known = nullptr;
  {
    const std::shared_lock lock(all_->mutex_);
    const auto found = all_->known_.find(to);
    if (found == all_->known_.end()) return nullptr;
    known = found->second.get();
  }
  const std::lock_guard lock(known->mutex);
  if (known->search == nullptr || known->spot->road != road ||
      !known->search->StaysWithout(closed_arcs_)) {
    return nullptr;
  }
  return std::make_unique<RoadSearch>(*known->search, inward_, search_bytes_);
}

void RoadNetwork::DropSearches(const Known* but) const {
  const std::shared_lock lock(mutex_);
  // To sites many ways lead, so those come last.
  for (const bool to_sites : {false, true}) {
    for (auto& [place, known] : known_) {
      if (*search_bytes_ < kMostSearchBytes / 2) return;
      // Those that another thread works with are left.
      if (known.get() == but || (known->site >= 0) != to_sites || !known->mutex.try_lock())
        continue;
      known->search.reset();
      known->mutex.unlock();
    }
  }
}

std::int64_t RoadNetwork::RoadCost(const Spot& from, const Spot& to, RoadSearch* search,
                                   std::int32_t* first) const {
  const Line& line = map_->lines[At(from.road)];
  std::int64_t best = -1;
  const auto offer = [&](std::int64_t cost_mm, std::int32_t by) {
    if (best >= 0 && cost_mm >= best) return;
    best = cost_mm;
    *first = by;
  };
  if (from.road == to.road) {
    if (from.along_mm <= to.along_mm) offer(to.along_mm - from.along_mm, -1);
    if (from.along_mm >= to.along_mm && line.backward) offer(from.along_mm - to.along_mm, -1);
  }
  const auto offer_by = [&](std::int32_t node, std::int64_t cost_mm) {
    const std::uint32_t rest_mm = search->CostFrom(node);
    if (rest_mm != kUnreached) offer(cost_mm + rest_mm, node);
  };
  offer_by(line.last_node, line.cost_mm - from.along_mm);
  if (line.backward || from.along_mm == 0) offer_by(line.first_node, from.along_mm);
  return best;
}

std::int32_t RoadNetwork::NodeOf(const Spot& spot) const {
  const Line& line = map_->lines[At(spot.road)];
  return spot.along_mm == 0 ? line.first_node : spot.along_mm == line.cost_mm ? line.last_node : -1;
}

bool RoadNetwork::IsSame(const Spot& a, const Spot& b) const {
  if (a.road == b.road && a.along_mm == b.along_mm) return true;
  const std::int32_t node = NodeOf(a);
  return node >= 0 && node == NodeOf(b);
}

RoadNetwork::Start RoadNetwork::StartOf(Point place) const {
  Known* const known = KnownOf(place, false);
  return {known->spot, known->to_site.get()};
}

std::int64_t RoadNetwork::Cost(Point from, Point to) const {
  const Start start = StartOf(from);
  std::int64_t cost_mm = -1;
  CostsTo({&from, 1}, {&start, 1}, to, true, {&cost_mm, 1});
  return cost_mm;
}

bool RoadNetwork::CostsTo(std::span<const Point> from, std::span<const Start> starts, Point to,
                          bool waits, std::span<std::int64_t> costs) const {
  Known* const goal = KnownOf(to, true);
  std::unique_lock<std::mutex> lock(goal->mutex, std::defer_lock);
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::atomic<std::uint32_t>* const known =
        goal->site < 0 || starts[i].to_site == nullptr ? nullptr : &starts[i].to_site[goal->site];
    const std::uint32_t cost = known ? known->load(std::memory_order_relaxed) : 0;
    if (cost != 0) {
      costs[i] = cost == kUnreached ? -1 : std::int64_t{cost} - 1;
      continue;
    }
    if (!lock && waits) lock.lock();
    if (!lock && !lock.try_lock()) return false;
    costs[i] = CostTo(from[i], starts[i], to, goal);
    if (known && costs[i] < std::int64_t{kUnreached} - 1) {
      known->store(costs[i] < 0 ? kUnreached : static_cast<std::uint32_t>(costs[i] + 1),
                   std::memory_order_relaxed);
    }
  }
  return true;
}

std::int64_t RoadNetwork::CostTo(Point from, const Start& begins, Point to, Known* goal) const {
  const std::optional<Spot>&start = begins.spot, &end = goal->spot;
  if (from == to) return 0;
  if (!start || !end) return -1;
  if (IsSame(*start, *end)) {
    const std::int64_t direct_mm = OpenCost(Distance(from, to));
    return direct_mm >= 0 ? direct_mm : start->off_mm + end->off_mm;
  }
  std::int32_t first = -1;
  const std::int64_t road_mm = RoadCost(*start, *end, SearchTo(to, goal), &first);
  return road_mm < 0 ? -1 : start->off_mm + road_mm + end->off_mm;
}

void RoadNetwork::Follow(const Line& line, std::int64_t from_mm, std::int64_t to_mm,
                         Way* way) const {
  const auto place = [&](const Segment& segment, std::int64_t mm) {
    return Lerp(ToPoint(segment.a), ToPoint(segment.b),
                static_cast<double>(mm - segment.begins_mm) / static_cast<double>(segment.cost_mm));
  };
  const auto go = [&](const Segment& segment, std::int64_t begin_mm, std::int64_t end_mm) {
    const std::int64_t cost_mm = std::abs(end_mm - begin_mm);
    if (cost_mm == 0) return;
    way->corners.push_back(place(segment, end_mm));
    way->roads.push_back(segment.road);
    way->reached_mm.push_back(way->reached_mm.back() + cost_mm);
    way->ground_mm += LengthMm(segment.a, segment.b) * cost_mm / segment.cost_mm;
  };
  if (from_mm <= to_mm) {
    for (std::int32_t i = line.first_segment; i < line.end_segment; ++i) {
      const Segment& s = map_->segments[At(i)];
      if (s.begins_mm + s.cost_mm <= from_mm || s.begins_mm >= to_mm) continue;
      go(s, std::max(from_mm, s.begins_mm), std::min(to_mm, s.begins_mm + s.cost_mm));
    }
  } else {
    for (std::int32_t i = line.end_segment - 1; i >= line.first_segment; --i) {
      const Segment& s = map_->segments[At(i)];
      if (s.begins_mm + s.cost_mm <= to_mm || s.begins_mm >= from_mm) continue;
      go(s, std::min(from_mm, s.begins_mm + s.cost_mm), std::max(to_mm, s.begins_mm));
    }
  }
}

std::shared_ptr<const RoadNetwork::Way> RoadNetwork::FindWay(Point from, Point to) const {
  auto way = std::make_shared<Way>();
  way->corners = {from};
  way->reached_mm = {0};
  way->roads = {-1};
  const auto across = [&](Point end, std::int64_t cost_mm) {
    if (cost_mm == 0) return;
    way->ground_mm += RoundHalfAway(Distance(way->corners.back(), end) * 1000);
    way->corners.push_back(end);
    way->roads.push_back(-1);
    way->reached_mm.push_back(way->reached_mm.back() + cost_mm);
  };
  const auto finished = [&] {
    if (way->corners.size() == 1) {
      way->corners.push_back(to);
      way->reached_mm.push_back(0);
      way->roads.push_back(-1);
    }
    way->corners.back() = to;
    return way;
  };
  if (from == to) return finished();
  const std::optional<Spot>& start = KnownOf(from, false)->spot;
  Known* const known_goal = KnownOf(to, true);
  const std::optional<Spot>& goal = known_goal->spot;
  if (!start || !goal) return nullptr;
  if (IsSame(*start, *goal)) {
    if (const std::int64_t direct_mm = OpenCost(Distance(from, to)); direct_mm >= 0) {
      across(to, direct_mm);
      return finished();
    }
  }
  const std::lock_guard lock(known_goal->mutex);
  RoadSearch* const search = SearchTo(to, known_goal);
  std::int32_t node = -1;
  std::int64_t left_mm = RoadCost(*start, *goal, search, &node);
  if (left_mm < 0) return nullptr;
  across(start->at, start->off_mm);
  const Line& last = map_->lines[At(goal->road)];
  if (node < 0) {
    Follow(last, start->along_mm, goal->along_mm, way.get());
  } else {
    const Line& line = map_->lines[At(start->road)];
    // A loop has both its ends in one node.
    const std::int64_t ahead_mm = line.cost_mm - start->along_mm;
    const bool forward = node == line.last_node && left_mm == ahead_mm + search->CostFrom(node);
    Follow(line, start->along_mm, forward ? line.cost_mm : 0, way.get());
    left_mm -= forward ? ahead_mm : start->along_mm;
    for (;;) {
      if (node == last.first_node && left_mm == goal->along_mm) {
        Follow(last, 0, goal->along_mm, way.get());
        break;
      }
      // At a junction it is there, whatever the direction of the road that it was found on.
      if (node == last.last_node && left_mm == last.cost_mm - goal->along_mm &&
          (last.backward || left_mm == 0)) {
        Follow(last, last.cost_mm, goal->along_mm, way.get());
        break;
      }
      const auto arcs = map_->ArcsOf(node);
      const auto next = std::find_if(arcs.begin(), arcs.end(), [&](const Arc& arc) {
        return arc.leaves && !IsClosed(arc.line) && arc.cost_mm <= left_mm &&
               search->CostFrom(arc.other) == left_mm - arc.cost_mm;
      });
      MUSTER_CHECK(next != arcs.end(), "node {} has {} mm left", node, left_mm);
      const Line& taken = map_->lines[At(next->line)];
      const bool ahead = taken.first_node == node;
      Follow(taken, ahead ? 0 : taken.cost_mm, ahead ? taken.cost_mm : 0, way.get());
      left_mm -= next->cost_mm;
      node = next->other;
    }
  }
  across(to, goal->off_mm);
  return finished();
}

std::shared_ptr<const RoadNetwork::Way> RoadNetwork::WayBetween(Point from, Point to) const {
  {
    const std::shared_lock lock(mutex_);
    if (const auto known = ways_.find({from, to}); known != ways_.end()) return known->second;
  }
  std::shared_ptr<const Way> found = FindWay(from, to);
  const std::unique_lock lock(mutex_);
  if (ways_.size() >= kMostWays) ways_.clear();
  ways_.emplace(Pair{from, to}, found);
  return found;
}

std::int64_t RoadNetwork::BarredAt(const Way& way, double begin_mm, const RoadNetwork& now) const {
  for (std::size_t i = 1; i < way.roads.size(); ++i) {
    const bool is_behind = static_cast<double>(way.reached_mm[i]) <= begin_mm;
    if (!is_behind && way.roads[i] >= 0 && now.IsClosed(way.roads[i])) return way.reached_mm[i - 1];
  }
  return -1;
}

Ways::Stop RoadNetwork::StopNear(Point wanted) const {
  Ways::Stop nearest{wanted};
  double distance_m = std::numeric_limits<double>::infinity();
  map_->stop_index->Nearest(wanted, [&](std::int32_t i, Point place, double away_m) {
    const std::int32_t number = map_->stops[At(i)].first;
    if (away_m < distance_m || (away_m == distance_m && number < nearest.number)) {
      nearest = {place, number};
      distance_m = away_m;
    }
    return away_m;
  });
  return nearest;
}

std::optional<Point> RoadNetwork::NumberedStop(std::int32_t number) const {
  const auto stop =
      std::lower_bound(map_->stops.begin(), map_->stops.end(), number,
                       [](const auto& entry, std::int32_t n) { return entry.first < n; });
  if (stop == map_->stops.end() || stop->first != number) return {};
  return stop->second;
}

}  // namespace muster
