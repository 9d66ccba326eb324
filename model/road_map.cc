#include <algorithm>
#include <cmath>

#include "base/index.h"
#include "model/road_network.h"

namespace muster {

std::int64_t RoadNetwork::Map::AtPercent(std::int64_t mm, std::int32_t percent) {
  return (100 * mm + percent - 1) / percent;
}

std::uint32_t RoadNetwork::Map::CostOfArc(std::int64_t mm) {
  return static_cast<std::uint32_t>(std::min<std::int64_t>(mm, RoadCosts::kUnreached));
}

void RoadNetwork::Map::AddRoads(const Roads& roads, AgentKind kind) {
  std::vector<std::int32_t> node_of(roads.points.size(), -1);
  std::int32_t n_nodes = 0;
  const auto node = [&](std::int32_t point) {
    std::int32_t& known = node_of[At(point)];
    if (known < 0) known = n_nodes++;
    return known;
  };
  for (const Road& road : roads.roads) {
    const RoadClass& its_class = roads.classes[At(road.road_class)];
    const std::int32_t percent = its_class.percent[kind];
    if (percent == 0) continue;
    Line line{};
    line.file_road = static_cast<std::int32_t>(&road - roads.roads.data());
    line.backward = kind == AgentKind::kWorker || !its_class.one_way;
    line.first_node = node(road.points.front());
    line.last_node = node(road.points.back());
    line.first_segment = static_cast<std::int32_t>(segments.size());
    for (std::size_t i = 1; i < road.points.size(); ++i) {
      Segment segment{};
      segment.a = roads.points[At(road.points[i - 1])];
      segment.b = roads.points[At(road.points[i])];
      segment.road = static_cast<std::int32_t>(lines.size());
      segment.begins_mm = line.cost_mm;
      segment.cost_mm = AtPercent(LengthMm(segment.a, segment.b), percent);
      line.cost_mm += segment.cost_mm;
      segments.push_back(segment);
    }
    line.end_segment = static_cast<std::int32_t>(segments.size());
    lines.push_back(line);
  }
  ConnectNodes(At(n_nodes));
}

void RoadNetwork::Map::ConnectNodes(std::size_t n_nodes) {
  arcs_of.assign(n_nodes + 1, 0);
  for (const Line& line : lines) {
    ++arcs_of[At(line.first_node) + 1];
    ++arcs_of[At(line.last_node) + 1];
  }
  for (std::size_t i = 0; i < n_nodes; ++i) arcs_of[i + 1] += arcs_of[i];
  std::vector<std::size_t> next(arcs_of.begin(), arcs_of.end() - 1);
  arcs.resize(2 * lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Line& line = lines[i];
    const auto index = static_cast<std::int32_t>(i);
    const std::uint32_t cost_mm = CostOfArc(line.cost_mm);
    arcs[next[At(line.first_node)]++] = {index, line.last_node, cost_mm, true, line.backward};
    arcs[next[At(line.last_node)]++] = {index, line.first_node, cost_mm, line.backward, true};
  }
}

void RoadNetwork::Map::IndexSegments() {
  std::vector<Point> places;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Point a = ToPoint(segments[i].a), b = ToPoint(segments[i].b);
    const auto pieces = static_cast<int>(std::ceil(Distance(a, b) / (2 * kHalfSpacing_m)));
    for (int k = 0; k < pieces; ++k) {
      places.push_back(Lerp(a, b, (k + 0.5) / pieces));
      segment_of_sample.push_back(static_cast<std::int32_t>(i));
    }
  }
  samples.emplace(places);
}

void RoadNetwork::Map::IndexStops(const RoadNetwork& network, const Roads& roads, AgentKind kind,
                                  std::span<const Point> sites) {
  for (std::size_t i = 0; i < sites.size(); ++i) {
    if (network.SpotOf(sites[i])) stops.emplace_back(static_cast<std::int32_t>(i), sites[i]);
  }
  std::vector<bool> usable(roads.points.size());
  for (const Road& road : roads.roads) {
    if (roads.classes[At(road.road_class)].percent[kind] == 0) continue;
    for (const std::int32_t point : road.points) usable[At(point)] = true;
  }
  for (std::size_t i = 0; i < usable.size(); ++i) {
    if (!usable[i]) continue;
    stops.emplace_back(static_cast<std::int32_t>(sites.size() + i), ToPoint(roads.points[i]));
  }
  std::vector<Point> places;
  for (const auto& [number, place] : stops) places.push_back(place);
  stop_index.emplace(places);
}

std::span<const RoadNetwork::Arc> RoadNetwork::Map::ArcsOf(std::int32_t node) const {
  const std::size_t begin = arcs_of[At(node)];
  return std::span(arcs).subspan(begin, arcs_of[At(node) + 1] - begin);
}

std::shared_ptr<const RoadHierarchy> RoadNetwork::Map::Hierarchy() const {
  std::call_once(ordered_, [&] {
    std::vector<RoadHierarchy::Edge> edges;
    for (const Line& line : lines) edges.push_back({line.first_node, line.last_node});
    hierarchy_ = std::make_shared<const RoadHierarchy>(arcs_of.size() - 1, edges);
  });
  return hierarchy_;
}

}  // namespace muster
