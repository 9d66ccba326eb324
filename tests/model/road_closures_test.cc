#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/random.h"
#include "model/agent.h"
#include "model/made_up.h"
#include "model/order.h"
#include "model/road_area.h"
#include "model/scenario_json.h"
#include "tests/model/block.h"

namespace muster {
namespace {

using muster::testing::Block;
using muster::testing::OnTheBlock;

constexpr AgentKind kOnFoot = AgentKind::kWorker;

std::vector<std::int32_t> In(const std::string& area) {
  const JsonValue tree = ParseJson("{" + area + "}", "order");
  const RoadArea read = ReadRoadArea(ObjectReader(tree, "", "order"));
  // What is written is read again.
  const JsonValue again = ParseJson("{" + RoadAreaToJson(read) + "}", "order");
  EXPECT_EQ(RoadsIn(Block(), read),
            RoadsIn(Block(), ReadRoadArea(ObjectReader(again, "", "order"))));
  return RoadsIn(Block(), read);
}

using Ids = std::vector<std::int32_t>;

TEST(RoadArea, NamesRoadsByHand) {
  EXPECT_EQ(In("\"roads\": [11, 23, 99]"), (Ids{1, 4}));
  EXPECT_EQ(In("\"near_km\": [0.2, 0.149]"), (Ids{0}));
  EXPECT_EQ(In("\"near_km\": [0.2, 0.151]"), (Ids{3}));
  // A circle's border counts.
  EXPECT_EQ(In("\"circle_km\": [0.7, 0.2, 0.2]"), (Ids{1}));
  EXPECT_EQ(In("\"circle_km\": [0.7, 0.2, 0.199]"), Ids{});
  // Across a road, around one, and only at its end.
  EXPECT_EQ(In("\"area_km\": [[0.5, -1], [0.6, -1], [0.6, 1], [0.5, 1]]"), (Ids{1}));
  EXPECT_EQ(In("\"area_km\": [[-1, 0.2], [0.1, 0.2], [0.1, 1], [-1, 1]]"), (Ids{3, 4}));
  EXPECT_EQ(In("\"area_km\": [[1, 0], [1.1, 0], [1.1, 0.1]]"), (Ids{1}));
  // In a bay of the area is outside.
  EXPECT_EQ(In("\"area_km\": [[0.5, -0.1], [0.9, -0.1], [0.9, 0.1], [0.7, -0.05], [0.5, 0.1]]"),
            (Ids{1}));
  EXPECT_EQ(In("\"area_km\": [[0.5, -0.2], [0.9, -0.2], [0.9, -0.1], [0.7, -0.15], [0.5, -0.1]]"),
            Ids{});
}

TEST(RoadArea, WrongOnesAreRefusedByName) {
  const auto error = [](const std::string& area) -> std::string {
    try {
      In(area);
    } catch (const InputError& refused) {
      return refused.what();
    }
    return "";
  };
  EXPECT_NE(error("\"name\": 1").find("exactly one of area_km, circle_km, roads, near_km"),
            std::string::npos);
  EXPECT_NE(error("\"roads\": [1], \"near_km\": [1, 2]").find("exactly one"), std::string::npos);
  EXPECT_NE(error("\"area_km\": [[1, 2], [3, 4]]").find("3 to 1000 corners"), std::string::npos);
  EXPECT_NE(error("\"area_km\": [[1, 2], [3, 4], [5]]").find("[x_km, y_km]"), std::string::npos);
  EXPECT_NE(error("\"circle_km\": [1, 2]").find("radius_km"), std::string::npos);
  EXPECT_NE(error("\"circle_km\": [1, 2, -1]").find("circle_km"), std::string::npos);
  EXPECT_NE(error("\"near_km\": [1, \"2\"]").find("near_km"), std::string::npos);
  EXPECT_NE(error("\"roads\": []").find("ids of roads"), std::string::npos);
  EXPECT_TRUE(CircleFrom("1/2/0.5").has_value());
  for (const char* text : {"", "1/2", "1/2/3/4", "1/2/x", "1/2/-1", "1/2/nan", "1,2,3"}) {
    EXPECT_FALSE(CircleFrom(text).has_value()) << text;
  }
}

TEST(RoadClosures, AClosedRoadIsGoneRound) {
  const Scenario scenario = OnTheBlock();
  const auto closed = scenario.roads->ways->Without({0});
  EXPECT_EQ(closed->Length(kOnFoot, {0, 0}, {1000, 0}), 300 + 400 + 300 + 600);
  EXPECT_EQ(scenario.ways->Length(kOnFoot, {0, 0}, {1000, 0}), 1000);
  // From a place on it: across 150 m of fields to the street that is nearest, at half speed.
  EXPECT_EQ(closed->Length(kOnFoot, {150, 0}, {1000, 0}), 2 * 150 + 300 + 400 + 300 + 600);
  EXPECT_EQ(closed->Length(kOnFoot, {250, 0}, {1000, 0}), 2 * 150 + 600);
  // What is closed twice is the same network.
  EXPECT_EQ(scenario.roads->ways->Without({0}), closed);
  // Without any road within reach there is no way.
  const auto apart = scenario.roads->ways->Without({0, 2, 3, 4});
  EXPECT_EQ(apart->Length(kOnFoot, {0, 300}, {1000, 0}), std::numeric_limits<double>::infinity());
  // Stops stay, by number and place.
  EXPECT_EQ(closed->StopNear(kOnFoot, {10, 5}).at, (Point{0, 0}));
}

/// A worker on the way from the west end to the task at the east end.
AgentState OnItsWay(const Scenario& scenario) {
  AgentState worker = StartOf(kOnFoot, 0, scenario.workers[0], *scenario.ways);
  worker.online_until_us = kNever;
  Action action;
  action.kind = ActionKind::kWorkerToTask;
  action.worker = WorkerId(0);
  action.task = TaskId(0);
  action.to = {1000, 0};
  Begin(&worker, action, 0, 0, {}, 0);
  return worker;
}

Scenario Closing(const std::string& order, TimeUs t, Scenario scenario) {
  Order parsed = ParseOrder(order, "order");
  parsed.id = "c1";
  TakeInto(&scenario, parsed, t);
  return scenario;
}

TEST(RoadClosures, AnAgentGoesRoundFromWhereItIs) {
  const Scenario before = OnTheBlock();
  AgentState worker = OnItsWay(before);
  EXPECT_EQ(worker.arrive_us, 1000 * kSecondUs);
  const Scenario after =
      Closing(R"({"order": "road_close", "roads": [10]})", 100 * kSecondUs, before);
  GoRound(&worker, 100 * kSecondUs, 100 * kSecondUs, *after.ways);
  // It stands in the middle of what was closed: across 100 m of fields back to the west end.
  EXPECT_EQ(worker.from, (Point{100, 0}));
  EXPECT_EQ(worker.to, (Point{1000, 0}));
  EXPECT_EQ(worker.arrive_us, (100 + 2 * 100 + 300 + 400 + 300 + 600) * kSecondUs);
  EXPECT_EQ(worker.busy_until_us, worker.arrive_us);
}

TEST(RoadClosures, AnAgentWhoseWayIsOpenGoesOnAsIfNothingHadHappened) {
  const Scenario before = OnTheBlock();
  const AgentState worker = OnItsWay(before);
  for (const char* roads : {"[20, 21, 23]", "[10]"}) {
    // 450 m on its way, it has the first street behind it.
    const Scenario after = Closing(
        std::string(R"({"order": "road_close", "roads": )") + roads + "}", 450 * kSecondUs, before);
    AgentState goes_on = worker;
    GoRound(&goes_on, 450 * kSecondUs, 450 * kSecondUs, *after.ways);
    EXPECT_EQ(goes_on.depart_us, 0) << roads;
    EXPECT_EQ(goes_on.arrive_us, worker.arrive_us);
    EXPECT_EQ(goes_on.ways, after.ways.get());
    EXPECT_EQ(PositionAt(goes_on, 700 * kSecondUs), (Point{700, 0}));
  }
}

TEST(RoadClosures, AnAgentStandsBeforeARoadThatWasClosedBeforeItCame) {
  const Scenario before = OnTheBlock();
  AgentState worker = OnItsWay(before);
  const Scenario after =
      Closing(R"({"order": "road_close", "roads": [11]})", 430 * kSecondUs, before);
  // Closed since 390 s: it came to the crossing at 400 s.
  EXPECT_EQ(BarredAt(worker, 390 * kSecondUs, *after.ways), 400 * kSecondUs);
  GoRound(&worker, 390 * kSecondUs, 430 * kSecondUs, *after.ways);
  EXPECT_EQ(worker.from, (Point{400, 0}));
  EXPECT_EQ(worker.depart_us, 430 * kSecondUs);
  // The task's nearest road is now the crossing itself, 600 m away, further than it goes.
  EXPECT_EQ(worker.action, ActionKind::kNone);
  EXPECT_EQ(worker.busy_until_us, 430 * kSecondUs);
  EXPECT_TRUE(std::isinf(worker.WayM(worker.to, {1000, 0})));
}

TEST(RoadClosures, OrdersCloseAndOpen) {
  Scenario scenario = OnTheBlock();
  const auto take = [&](const std::string& text, TimeUs t, const std::string& id) -> std::string {
    try {
      Order order = ParseOrder(text, "order");
      order.id = id;
      TakeInto(&scenario, order, t);
      return "";
    } catch (const InputError& refused) {
      return refused.what();
    }
  };
  const TimeUs t = 10 * kMinuteUs;
  EXPECT_EQ(take(R"({"order": "road_close", "roads": [10, 21], "name": "flood"})", t, "a"), "");
  EXPECT_EQ(take(R"({"order": "road_close", "roads": [10]})", t, "b"),
            "all of these roads are closed already");
  EXPECT_EQ(take(R"({"order": "road_close", "roads": [10, 11]})", t + kMinuteUs, "c"), "");
  EXPECT_EQ(scenario.WaysAt(t - 1).Length(kOnFoot, {0, 0}, {400, 0}), 400);
  EXPECT_EQ(scenario.WaysAt(t).Length(kOnFoot, {600, 0}, {1000, 0}), 400);
  EXPECT_TRUE(std::isinf(scenario.WaysAt(t + kMinuteUs).Length(kOnFoot, {0, 0}, {1000, 0})));
  // A road is open when every order that closed it has ended.
  EXPECT_EQ(take(R"({"order": "road_open", "closure": "a"})", t + 2 * kMinuteUs, "d"), "");
  EXPECT_EQ(scenario.ways->Length(kOnFoot, {400, 0}, {400, 300}), 300);
  EXPECT_GT(scenario.ways->Length(kOnFoot, {0, 0}, {400, 0}), 400);
  EXPECT_EQ(take(R"({"order": "road_open", "circle_km": [0.4, 0, 0.01]})", t + 3 * kMinuteUs, "e"),
            "");
  EXPECT_TRUE(scenario.closures.empty());
  EXPECT_EQ(scenario.ways->Length(kOnFoot, {0, 0}, {1000, 0}), 1000);
  EXPECT_EQ(take(R"({"order": "road_open", "roads": [10]})", t, "f"),
            "none of these roads is closed");
  EXPECT_EQ(take(R"({"order": "road_open", "closure": "a"})", t, "g"),
            "no roads are closed by an order a");
  EXPECT_NE(
      take(R"({"order": "road_close", "roads": [77]})", t, "h").find("a place where roads are"),
      std::string::npos);
  EXPECT_NE(
      take(R"({"order": "road_close", "roads": [10], "until_min": 10})", t, "i").find("until_min"),
      std::string::npos);
  EXPECT_NE(
      take(R"({"order": "road_close", "roads": [10], "since_min": 1})", t, "j").find("since_min"),
      std::string::npos);
  EXPECT_NE(
      take(R"({"order": "road_open", "closure": "a", "roads": [10]})", t, "k").find("closure"),
      std::string::npos);
  scenario.roads = nullptr;
  EXPECT_EQ(take(R"({"order": "road_close", "roads": [10]})", t, "l"), "the scenario has no roads");
}

TEST(RoadClosures, APlannedClosureOfNoRoadIsRefused) {
  Scenario scenario = OnTheBlock();
  ScenarioRoads roads = *scenario.roads;
  roads.closures = {{{RoadArea::Circle{{1500, 1500}, 10}}, "", 0, kNever}};
  EXPECT_THROW(UseRoads(roads, "block.roads.json", &scenario), InputError);
}

TEST(RoadClosures, ClosingNeverShortensAWayAndOpeningGivesItBack) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Roads roads = StreetGrid(7, 300, seed);
    Random random(seed, Stream::kTest);
    std::vector<Point> places(30);
    for (Point& place : places) place = {random.Uniform() * 2100, random.Uniform() * 2100};
    const std::vector<Point> sites(places.begin(), places.begin() + 10);
    const auto open = std::make_shared<RoadWays>(
        std::make_shared<const Roads>(roads), PerKind<OpenGround>{{}, {50, 400}, {25, 300}}, sites);
    const auto draw = [&] { return places[random.Below(30)]; };
    // Some ways are known before roads close.
    for (int i = 0; i < 40; ++i) {
      const Point from = draw(), to = draw();
      for (const AgentKind kind : {kOnFoot, AgentKind::kVehicle}) open->Length(kind, from, to);
    }
    std::vector<std::int32_t> closed;
    const std::uint32_t one_of = seed % 2 == 0 ? 5 : 40;
    for (std::size_t i = 0; i < roads.roads.size(); ++i) {
      if (random.Below(one_of) == 0) closed.push_back(static_cast<std::int32_t>(i));
    }
    const auto rest = open->Without(closed);
    // The same network as one that never had those roads.
    Roads without = roads;
    without.roads.clear();
    for (std::size_t i = 0; i < roads.roads.size(); ++i) {
      if (!std::binary_search(closed.begin(), closed.end(), static_cast<std::int32_t>(i))) {
        without.roads.push_back(roads.roads[i]);
      }
    }
    const RoadWays plain(std::make_shared<const Roads>(without), {{}, {50, 400}, {25, 300}}, {});
    for (int i = 0; i < 100; ++i) {
      const Point from = draw(), to = draw();
      for (const AgentKind kind : {kOnFoot, AgentKind::kVehicle}) {
        EXPECT_EQ(rest->Length(kind, from, to), plain.Length(kind, from, to));
        EXPECT_EQ(rest->Corners(kind, from, to), plain.Corners(kind, from, to));
        const auto barred = open->BarredAt(kind, from, to, 0, *rest);
        if (!barred && std::isfinite(open->Length(kind, from, to))) {
          // Both ends have the same nearest road as before, or a nearer end of an open one.
          EXPECT_LE(open->Length(kind, from, to), rest->Length(kind, from, to));
        }
      }
    }
  }
}

TEST(RoadClosures, AScenarioKeepsItsPlannedClosures) {
  Scenario scenario = OnTheBlock();
  scenario.rules.limit_us = 60 * kMinuteUs;
  for (auto* list : {&scenario.uavs, &scenario.workers, &scenario.vehicles}) {
    for (AgentSpec& agent : *list) agent.online_until_us = scenario.rules.limit_us;
  }
  ScenarioRoads roads = *scenario.roads;
  roads.closures = {
      {{RoadArea::Polygon{{{0, -10}, {100, -10}, {50, 20}}}}, "the \"north\"", kMinuteUs, kNever},
      {{RoadArea::Ids{{11, 21}}}, "", 0, 90 * kSecondUs}};
  UseRoads(std::move(roads), "block.roads.json", &scenario);
  const ScenarioText text = TextOf(scenario);
  const Scenario again = ParseScenario(text, "file");
  EXPECT_EQ(ScenarioToJson(again), text.json);
  ASSERT_EQ(again.roads->closures.size(), 2);
  EXPECT_EQ(again.roads->closures[0].name, "the \"north\"");
  EXPECT_EQ(again.roads->closures[0].until_us, kNever);
  EXPECT_EQ(again.roads->closures[1].until_us, 90 * kSecondUs);
  std::string wrong = text.json;
  wrong.replace(wrong.find("\"until_min\": 1.5"), 16, "\"until_min\": 0");
  EXPECT_THROW(ParseScenario({wrong, text.roads}, "file"), InputError);
}

}  // namespace
}  // namespace muster
