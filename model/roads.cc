#include "model/roads.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <utility>

#include "base/json_tree.h"
#include "base/object_reader.h"

namespace muster {
namespace {

std::vector<std::int32_t> ReadIntegers(const ObjectReader& object, std::string_view list,
                                       std::int64_t low, std::int64_t high) {
  const std::vector<JsonValue>& items = object.Array(list);
  std::vector<std::int32_t> numbers;
  numbers.reserve(items.size());
  for (const JsonValue& item : items) {
    numbers.push_back(static_cast<std::int32_t>(object.ReadInteger(list, item, low, high)));
  }
  return numbers;
}

RoadClass ReadClass(const ObjectReader& object) {
  object.AllowOnly({"name", "workers_percent", "vehicles_percent", "one_way"});
  RoadClass read;
  read.name = object.String("name");
  const auto percent = [&](std::string_view key) {
    return static_cast<std::int32_t>(object.Integer(key, 0, 100));
  };
  read.percent = {0, percent("workers_percent"), percent("vehicles_percent")};
  read.one_way = object.Boolean("one_way", false);
  return read;
}

/// Checks how the roads meet.
class Meetings {
 public:
  explicit Meetings(std::size_t n_points) : user_(n_points, kNobody) {}

  void Take(const ObjectReader& object, const std::vector<RoadPoint>& points, const Road& road,
            std::int32_t index) {
    for (std::size_t i = 1; i < road.points.size(); ++i) {
      if (points[At(road.points[i - 1])] == points[At(road.points[i])]) {
        object.Fail("points",
                    fmt::format("points {} and {}, which are one place", road.points[i - 1],
                                road.points[i]),
                    "a way from place to place");
      }
    }
    for (std::size_t i = 0; i < road.points.size(); ++i) {
      const std::int32_t point = road.points[i];
      const bool is_end = i == 0 || i + 1 == road.points.size();
      std::int32_t& user = user_[At(point)];
      if (is_end ? user >= 0 : user != kNobody) {
        object.Fail("points",
                    fmt::format("point {} of roads[{}] and of roads[{}]", point, index,
                                user >= 0 ? user : -2 - user),
                    "that roads meet at their ends only");
      }
      user = is_end ? (user == kNobody ? -2 - index : user) : index;
    }
  }

 private:
  static std::size_t At(std::int32_t point) { return static_cast<std::size_t>(point); }

  static constexpr std::int32_t kNobody = -1;
  /// By point: the road that passes it, -2 - the road that ends there first, or nobody.
  std::vector<std::int32_t> user_;
};

std::string Joined(const std::vector<std::int32_t>& numbers) {
  return fmt::format("[{}]", fmt::join(numbers, ","));
}

}  // namespace

std::int64_t LengthMm(RoadPoint a, RoadPoint b) {
  const std::int64_t dx = std::int64_t{a.x_mm} - b.x_mm, dy = std::int64_t{a.y_mm} - b.y_mm;
  const std::int64_t square = dx * dx + dy * dy;  // at most 8e18
  auto root = static_cast<std::int64_t>(std::sqrt(static_cast<double>(square)));
  while (root * root < square) ++root;
  while (root > 0 && (root - 1) * (root - 1) >= square) --root;
  return root;
}

Roads ParseRoads(std::string_view json, std::string_view file) {
  const JsonValue tree = ParseJson(json, file);
  const ObjectReader top(tree, "", file);
  top.Expect("version", 1);
  top.AllowOnly({"version", "source", "classes", "x_mm", "y_mm", "roads"});
  Roads read;
  read.source = top.String("source");
  const std::vector<JsonValue>& classes = top.Array("classes");
  for (std::size_t i = 0; i < classes.size(); ++i) {
    read.classes.push_back(ReadClass(top.Element("classes", classes[i], i)));
  }
  const auto x_mm = ReadIntegers(top, "x_mm", -kFarthestRoad_mm, kFarthestRoad_mm);
  const auto y_mm = ReadIntegers(top, "y_mm", -kFarthestRoad_mm, kFarthestRoad_mm);
  if (x_mm.size() != y_mm.size()) {
    top.Fail("y_mm", fmt::format("{} numbers", y_mm.size()),
             fmt::format("as many as x_mm has ({})", x_mm.size()));
  }
  read.points.reserve(x_mm.size());
  for (std::size_t i = 0; i < x_mm.size(); ++i) read.points.push_back({x_mm[i], y_mm[i]});
  const std::vector<JsonValue>& roads = top.Array("roads");
  if (roads.empty()) top.Fail("roads", "no road", "at least one road");
  read.roads.reserve(roads.size());
  Meetings meetings(read.points.size());
  for (std::size_t i = 0; i < roads.size(); ++i) {
    const ObjectReader object = top.Element("roads", roads[i], i);
    object.AllowOnly({"id", "class", "points"});
    Road road;
    road.id = object.Integer("id", INT64_MIN, INT64_MAX);
    road.road_class = static_cast<std::int32_t>(
        object.Integer("class", 0, static_cast<std::int64_t>(read.classes.size()) - 1));
    road.points =
        ReadIntegers(object, "points", 0, static_cast<std::int64_t>(read.points.size()) - 1);
    if (road.points.size() < 2) {
      object.Fail("points", fmt::format("{} of them", road.points.size()), "two or more");
    }
    meetings.Take(object, read.points, road, static_cast<std::int32_t>(i));
    read.roads.push_back(std::move(road));
  }
  return read;
}

std::string RoadsToJson(const Roads& roads) {
  std::string text = fmt::format("{{\n  \"version\": 1,\n  \"source\": {},\n  \"classes\": [",
                                 JsonText(roads.source));
  const auto add = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
  };
  for (const RoadClass& one : roads.classes) {
    add("{}\n    {{\"name\": {}, \"workers_percent\": {}, \"vehicles_percent\": {}, "
        "\"one_way\": {}}}",
        &one == roads.classes.data() ? "" : ",", JsonText(one.name), one.percent.workers,
        one.percent.vehicles, one.one_way);
  }
  std::vector<std::int32_t> x_mm, y_mm;
  for (const RoadPoint& point : roads.points) {
    x_mm.push_back(point.x_mm);
    y_mm.push_back(point.y_mm);
  }
  add("\n  ],\n  \"x_mm\": {},\n  \"y_mm\": {},\n  \"roads\": [", Joined(x_mm), Joined(y_mm));
  for (const Road& road : roads.roads) {
    add("{}\n    {{\"id\": {}, \"class\": {}, \"points\": {}}}",
        &road == roads.roads.data() ? "" : ",", road.id, road.road_class, Joined(road.points));
  }
  return text + "\n  ]\n}\n";
}

}  // namespace muster
