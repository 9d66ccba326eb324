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
constexpr std::size_t kMostCostBytes = std::size_t{1} << 26;         // of the costs to sites
constexpr std::ptrdiff_t kMostBytesFound = std::ptrdiff_t{1} << 29;  // of labels and searches
constexpr std::uint32_t kUnreached = RoadCosts::kUnreached;

std::atomic<std::uint64_t> next_id = 1;

}  // namespace

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
  map->IndexStops(*this, roads, kind, sites);
}

RoadNetwork::RoadNetwork(const RoadNetwork& all, const std::vector<bool>& closed)
    : map_(all.map_), closed_(all.map_->lines.size()), id_(next_id++) {
  for (std::size_t i = 0; i < closed_.size(); ++i) {
    closed_[i] = closed[At(map_->lines[i].file_road)];
  }
}

RoadNetwork::~RoadNetwork() = default;

const RoadCosts& RoadNetwork::costs() const {
  std::call_once(customized_, [&] {
    std::vector<RoadCosts::Arc> arcs;
    for (std::size_t i = 0; i < map_->lines.size(); ++i) {
      const Line& line = map_->lines[i];
      if (IsClosed(static_cast<std::int32_t>(i))) continue;
      const std::uint32_t cost_mm = Map::CostOfArc(line.cost_mm);
      arcs.push_back({line.first_node, line.last_node, cost_mm});
      if (line.backward) arcs.push_back({line.last_node, line.first_node, cost_mm});
    }
    costs_ = std::make_unique<RoadCosts>(map_->Hierarchy(), arcs);
  });
  return *costs_;
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
  return PlaceOf(place, kFrom).known->spot;
}

RoadNetwork::Place& RoadNetwork::PlaceOf(Point place, Role role) const {
  // Callers ask for the same places again and again: each thread has those at hand.
  constexpr std::size_t kAtHand = 8192;
  thread_local std::array<std::vector<Place>, 2> at_hand{std::vector<Place>(kAtHand),
                                                         std::vector<Place>(kAtHand)};
  Place& entry = at_hand[role][PointHash()(place) % kAtHand];
  if (entry.network == id_ && entry.at == place) return entry;
  {
    const std::shared_lock lock(mutex_);
    if (const auto found = known_.find(place); found != known_.end()) {
      return entry = {id_, place, found->second.get()};
    }
  }
  auto made = std::make_unique<Known>();
  made->spot = FindSpot(place);
  if (const auto site = map_->site_of.find(place); site != map_->site_of.end()) {
    made->site = site->second;
  }
  const std::unique_lock lock(mutex_);
  if (known_.size() >= kMostKnown) {
    made->is_kept = false;
    Known* const known = made.get();
    return entry = {id_, place, known, std::move(made)};
  }
  const std::size_t sites = map_->site_of.size();
  if (sites > 0 && known_.size() * sites < kMostCostBytes / 4) {
    made->to_site = std::make_unique<std::atomic<std::uint32_t>[]>(sites);
  }
  return entry = {id_, place, known_.emplace(place, std::move(made)).first->second.get()};
}

RoadNetwork::Places RoadNetwork::LookUp(std::span<const Point> places) const {
  Places found;
  for (const Point& place : places) {
    found.places_.push_back(PlaceOf(place, kTo).WithoutLabel());
    found.sites_.push_back(found.places_.back().known->site);
  }
  return found;
}

RoadNetwork::Ends RoadNetwork::EndsOf(const Spot& spot, Role role) const {
  const Line& line = map_->lines[At(spot.road)];
  const std::int64_t rest_mm = line.cost_mm - spot.along_mm;
  Ends ends;
  const auto add = [&](std::int32_t node, std::int64_t cost_mm) {
    ends.ends[ends.n++] = {node, cost_mm};
  };
  if (role == kTo || line.backward || spot.along_mm == 0) add(line.first_node, spot.along_mm);
  if (role == kFrom || line.backward || rest_mm == 0) add(line.last_node, rest_mm);
  return ends;
}

std::shared_ptr<const RoadCosts::Label> RoadNetwork::LabelOf(Known* known, Role role,
                                                             std::uint32_t until_mm) const {
  std::shared_ptr<const RoadCosts::Label>& label = known->labels[role];
  if (label != nullptr && label->until_mm >= until_mm) return label;
  // To a site others will ask from further away; and no label is made again often.
  const std::uint32_t asked_mm = label != nullptr   ? label->until_mm
                                 : known->site >= 0 ? until_mm
                                                    : 0;
  until_mm = std::max(until_mm, asked_mm < kUnreached / 4 ? 4 * asked_mm : kUnreached);
  if (label != nullptr) Count(*known, -label->Bytes());
  const Ends ends = EndsOf(*known->spot, role);
  const std::span<const RoadCosts::End> nodes(ends.ends.data(), ends.n);
  label = std::make_shared<const RoadCosts::Label>(
      role == kFrom ? costs().LabelFrom(nodes, until_mm) : costs().LabelTo(nodes, until_mm));
  Count(*known, label->Bytes());
  return label;
}

RoadSearch* RoadNetwork::SearchTo(Known* goal, std::uint32_t until_mm) const {
  if (goal->search != nullptr) {
    if (goal->search->until_mm() >= until_mm) return goal->search.get();
    Count(*goal, -goal->search->Bytes());
  }
  goal->search = std::make_unique<RoadSearch>(costs(), *LabelOf(goal, kTo, until_mm));
  Count(*goal, goal->search->Bytes());
  return goal->search.get();
}

void RoadNetwork::Count(const Known& known, std::ptrdiff_t more) const {
  if (!known.is_kept) return;
  bytes_ += more;
  if (bytes_ > kMostBytesFound) MakeRoom(&known);
}

void RoadNetwork::MakeRoom(const Known* but) const {
  const std::shared_lock lock(mutex_);
  // To sites many ways lead, so those come last.
  for (const bool is_site : {false, true}) {
    for (auto& [place, known] : known_) {
      if (bytes_ < kMostBytesFound / 2) return;
      // Those that another thread works with are left.
      if (known.get() == but || (known->site >= 0) != is_site || !known->mutex.try_lock()) continue;
      for (auto& label : known->labels) {
        if (label != nullptr) bytes_ -= label->Bytes();
        label.reset();
      }
      if (known->search != nullptr) bytes_ -= known->search->Bytes();
      known->search.reset();
      known->mutex.unlock();
    }
  }
}

std::int64_t RoadNetwork::AlongRoad(const Spot& from, const Spot& to) const {
  if (from.road != to.road) return -1;
  if (from.along_mm <= to.along_mm) return to.along_mm - from.along_mm;
  return map_->lines[At(from.road)].backward ? from.along_mm - to.along_mm : -1;
}

std::int64_t RoadNetwork::RoadCost(const Spot& from, const Spot& to, RoadSearch* search,
                                   std::int32_t* first) const {
  std::int64_t best = AlongRoad(from, to);
  *first = -1;
  const Ends ends = EndsOf(from, kFrom);
  // Of two equal ways the one by the road's last point.
  for (std::size_t i = ends.n; i-- > 0;) {
    const auto [node, cost_mm] = ends.ends[i];
    const std::uint32_t rest_mm = search->CostFrom(node);
    const std::int64_t by_it_mm = cost_mm + rest_mm;
    if (by_it_mm >= kUnreached || (best >= 0 && by_it_mm >= best)) continue;
    best = by_it_mm;
    *first = node;
  }
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

std::int64_t RoadNetwork::Cost(Point from, Point to) const {
  return CostBetween(&PlaceOf(from, kFrom), &PlaceOf(to, kTo));
}

std::int64_t RoadNetwork::CostBetween(Place* from, Place* to) const {
  const Known &begin = *from->known, &end = *to->known;
  if (const std::uint32_t kept = Kept(begin, end.site); kept != 0) return CostOf(kept);
  std::int64_t cost_mm = -1;
  if (from->at == to->at) {
    cost_mm = 0;
  } else if (begin.spot && end.spot) {
    const std::int64_t off_mm = begin.spot->off_mm + end.spot->off_mm;
    if (IsSame(*begin.spot, *end.spot)) {
      const std::int64_t direct_mm = OpenCost(Distance(from->at, to->at));
      cost_mm = direct_mm >= 0 ? direct_mm : off_mm;
    } else if (const std::int64_t road_mm = RoadCostBetween(from, to); road_mm >= 0) {
      cost_mm = road_mm + off_mm;
    }
  }
  if (end.site >= 0 && begin.to_site != nullptr && cost_mm < std::int64_t{kUnreached} - 1) {
    begin.to_site[At(end.site)].store(
        cost_mm < 0 ? kUnreached : static_cast<std::uint32_t>(cost_mm + 1),
        std::memory_order_relaxed);
  }
  return cost_mm;
}

std::int64_t RoadNetwork::RoadCostBetween(Place* from, Place* to) const {
  const std::int64_t along_mm = AlongRoad(*from->known->spot, *to->known->spot);
  // Most ways are less than twice as long as the straight line.
  const auto guess = [](double metres) {
    return static_cast<std::uint32_t>(std::min<double>(2000 * metres, kUnreached));
  };
  std::uint32_t until_mm = guess(Distance(from->at, to->at));
  if (from->label == nullptr && from->farthest_m > 0) {
    const std::lock_guard lock(from->known->mutex);
    from->label = LabelOf(from->known, kFrom, guess(from->farthest_m));
  }
  for (;;) {
    for (const auto& [place, role] : {std::pair(from, kFrom), std::pair(to, kTo)}) {
      if (place->label != nullptr && place->label->until_mm >= until_mm) continue;
      const std::lock_guard lock(place->known->mutex);
      place->label = LabelOf(place->known, role, until_mm);
    }
    std::uint32_t least_mm = costs().Between(*from->label, *to->label);
    if (along_mm >= 0 && along_mm < least_mm) least_mm = static_cast<std::uint32_t>(along_mm);
    if (least_mm <= std::min(from->label->until_mm, to->label->until_mm)) {
      return least_mm == kUnreached ? -1 : std::int64_t{least_mm};
    }
    until_mm = least_mm;
  }
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
  const Place begin = PlaceOf(from, kFrom), end = PlaceOf(to, kTo);
  const std::int64_t cost_mm = Cost(from, to);
  if (cost_mm < 0) return nullptr;
  const std::optional<Spot>&start = begin.known->spot, &goal = end.known->spot;
  if (IsSame(*start, *goal)) {
    if (const std::int64_t direct_mm = OpenCost(Distance(from, to)); direct_mm >= 0) {
      across(to, direct_mm);
      return finished();
    }
  }
  const std::lock_guard lock(end.known->mutex);
  RoadSearch* const search =
      SearchTo(end.known, static_cast<std::uint32_t>(std::min<std::int64_t>(cost_mm, kUnreached)));
  std::int32_t node = -1;
  std::int64_t left_mm = RoadCost(*start, *goal, search, &node);
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
