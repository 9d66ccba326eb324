#include "agents/driver/driver_session.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/random.h"
#include "tests/model/block.h"

namespace muster::agents {
namespace {

using nlohmann::json;
using Report = MeasuredReport::Kind;

constexpr const char* kHello = R"({"type":"hello","version":1,"name":"mine"})";

/// A UAV 5 km (500 s) from a task, near Cambridge.
Scenario Small() {
  Scenario scenario;
  scenario.width_m = scenario.height_m = 10'000;
  scenario.origin = Origin{52.2, 0.1};
  scenario.rules.limit_us = 3600 * kSecondUs;
  AgentSpec agent;
  agent.online_until_us = 3000 * kSecondUs;
  agent.speed_m_s = 10;
  agent.range_full_m = 20'000;
  agent.range_m = 15'000;
  agent.measured = true;
  scenario.uavs = scenario.workers = {agent};
  scenario.tasks = {{{3000, 4000}, 600}};
  scenario.tasks[0].name = "School";
  scenario.charging_points = {{{0, 1000}, 1}};
  return scenario;
}

Action Sense() {
  Action action;
  action.kind = ActionKind::kSense;
  action.uav = UavId(0);
  action.worker = WorkerId(0);
  action.task = TaskId(0);
  action.to = {3000, 4000};
  return action;
}

/// A session with a mission of its own around it, in seconds; the wall's are the mission's.
class Session {
 public:
  explicit Session(double rate = 0, AgentKind kind = AgentKind::kUav)
      : agent_(StartOf(kind, 0, scenario_.agents(kind)[0], *scenario_.ways)),
        session_(scenario_, agent_, 0, 0, {.rate = rate}) {}

  /// What it is told up to that time, as JSON.
  std::vector<json> Told() {
    std::vector<json> told;
    for (const std::string& line : session_.TakeLines()) told.push_back(json::parse(line));
    return told;
  }
  std::string Hear(const std::string& line) { return session_.Hear(line, wall_us_); }
  std::string Hear(const json& line) { return Hear(line.dump()); }
  Session& Greeted() {
    EXPECT_EQ(Hear(std::string(kHello)), "");
    Apply(0);
    return *this;
  }
  Session& Sent(TimeUs at_s = 0, std::int32_t decision = 3) {
    Begin(&agent_, Sense(), decision, at_s * kSecondUs, {}, 1);
    session_.Follow(agent_, at_s * kSecondUs, wall_us_);
    return *this;
  }
  Session& Time(TimeUs at_s) {
    wall_us_ = at_s * kSecondUs;
    session_.Tick(at_s * kSecondUs, wall_us_);
    return *this;
  }
  /// The mission takes what was reported.
  std::vector<MeasuredReport> Apply(TimeUs at_s) {
    auto reports = session_.TakeReports(at_s * kSecondUs);
    for (const MeasuredReport& report : reports) {
      EXPECT_EQ(ApplyReport(&agent_, report, at_s * kSecondUs, scenario_.tasks), "");
    }
    return reports;
  }
  Session& Settled(const Verdict& verdict, TimeUs at_s) {
    Settle(&agent_, verdict, at_s * kSecondUs, scenario_.tasks);
    session_.Follow(agent_, at_s * kSecondUs, wall_us_, "worker:0 has failed");
    return *this;
  }
  Session& At(double altitude_m, TimeUs begin_s) {
    session_.GiveAltitude({0, 3, 0, altitude_m, begin_s * kSecondUs});
    return *this;
  }
  DriverSession& operator*() { return session_; }
  DriverSession* operator->() { return &session_; }
  TimeUs& wall_us() { return wall_us_; }
  const AgentState& agent() const { return agent_; }

 private:
  Scenario scenario_ = Small();
  AgentState agent_;
  DriverSession session_;
  TimeUs wall_us_ = 0;
};

TEST(DriverSession, GreetsWithWhatTheDriverNeedsToKnow) {
  Session session;
  const std::vector<json> told = session.Told();
  ASSERT_EQ(told.size(), 1U);
  const json& hello = told[0];
  EXPECT_EQ(hello["type"], "hello");
  EXPECT_EQ(hello["agent"], "uav:0");
  EXPECT_EQ(hello["speed_m_s"], 10.0);
  EXPECT_EQ(hello["full_range_m"], 20'000.0);
  EXPECT_EQ(hello["at"]["x_m"], 0.0);
  EXPECT_NEAR(hello["at"]["latitude_deg"], 52.2, 1e-9);
  EXPECT_EQ(hello["origin"]["longitude_deg"], 0.1);
  EXPECT_TRUE(hello["rate"].is_null());
  EXPECT_EQ(hello["online_until_s"], 3000.0);
  EXPECT_FALSE(json::parse(Session(2, AgentKind::kWorker)->TakeLines().at(0)).contains("range_m"));
}

TEST(DriverSession, TellsHowHighToFlyAndWhenToSetOut) {
  Session session;
  session.Told();
  session.Greeted();
  const json sent = session.At(70, 45).Sent(30).Told().at(0);
  EXPECT_EQ(sent["type"], "goto");
  EXPECT_EQ(sent["altitude_m"], 70.0);
  EXPECT_EQ(sent["set_out_s"], 45.0);
  EXPECT_EQ(sent["expected_s"], 545.0);  // 5000 m at 10 m/s, from 45 s on
  // Of one that is sent nowhere by that decision.
  const auto told = session.At(90, 60).Settled(Verdict(), 60).Told();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0], (json{{"type", "altitude"}, {"mission_s", 60.0}, {"altitude_m", 90.0}}));
  EXPECT_TRUE(session.Settled(Verdict(), 90).Told().empty()) << "once";
  Session without;
  without.Told();
  without.Greeted();
  EXPECT_FALSE(without.Sent().Told().at(0).contains("altitude_m"));
}

TEST(DriverSession, GreetsWithTheAltitudesOfAMissionThatKeepsUavsApart) {
  Scenario scenario = Small();
  ScenarioAir air;
  air.separation = Separation{50, 20, 40, 119};
  UseAir(std::move(air), &scenario);
  const auto hello = [&](AgentKind kind) {
    DriverSession session(scenario, StartOf(kind, 0, scenario.agents(kind)[0], *scenario.ways), 0,
                          0, {});
    return json::parse(session.TakeLines().at(0));
  };
  EXPECT_EQ(hello(AgentKind::kUav)["altitudes"], (json{{"lowest_m", 40.0}, {"highest_m", 100.0}}));
  EXPECT_FALSE(hello(AgentKind::kWorker).contains("altitudes"));
}

TEST(DriverSession, TellsAUavWhichZonesToKeepOutOf) {
  Scenario scenario = Small();
  UseAir(ScenarioAir(), &scenario);
  const auto told = [&](AgentKind kind) {
    return std::make_unique<DriverSession>(
        scenario, StartOf(kind, 0, scenario.agents(kind)[0], *scenario.ways), 0, 0,
        DriverSession::Rules{});
  };
  const auto uav = told(AgentKind::kUav), worker = told(AgentKind::kWorker);
  const auto tell = [&](DriverSession* session, AgentKind kind, TimeUs at_s) {
    session->TakeLines();
    session->Follow(StartOf(kind, 0, scenario.agents(kind)[0], *scenario.ways), at_s * kSecondUs,
                    0);
    std::vector<json> lines;
    for (const std::string& line : session->TakeLines()) lines.push_back(json::parse(line));
    return lines;
  };
  EXPECT_TRUE(tell(uav.get(), AgentKind::kUav, 0).empty());
  Zone zone;
  zone.rings = {{{1000, 1000}, {2000, 1000}, {2000, 2000}}};
  Closure& heli = scenario.closures.emplace_back();
  heli.order = "heli";
  heli.zone = std::make_shared<const Zone>(std::move(zone));
  const json corners = json::parse(
      R"([[{"x_m":1000.0,"y_m":1000.0},{"x_m":2000.0,"y_m":1000.0},{"x_m":2000.0,"y_m":2000.0}]])");
  const auto added = tell(uav.get(), AgentKind::kUav, 30);
  ASSERT_EQ(added.size(), 1U);
  EXPECT_EQ(added[0],
            (json{{"type", "zone"}, {"mission_s", 30.0}, {"id", "heli"}, {"rings", corners}}));
  EXPECT_TRUE(tell(uav.get(), AgentKind::kUav, 60).empty()) << "once";
  EXPECT_TRUE(tell(worker.get(), AgentKind::kWorker, 60).empty());
  scenario.closures.clear();
  const auto lifted = tell(uav.get(), AgentKind::kUav, 90);
  ASSERT_EQ(lifted.size(), 1U);
  EXPECT_EQ(lifted[0], (json{{"type", "zone_lift"}, {"mission_s", 90.0}, {"id", "heli"}}));
}

TEST(DriverSession, TellsAUavHowToComeHomeAroundZonesAsFarAsThatIsNew) {
  Scenario scenario = Small();
  UseAir(ScenarioAir(), &scenario);
  AgentState uav = StartOf(AgentKind::kUav, 0, scenario.uavs[0], *scenario.ways);
  AgentState worker = StartOf(AgentKind::kWorker, 0, scenario.workers[0], *scenario.ways);
  const Point home = uav.to;
  DriverSession session(scenario, uav, 0, 0, {}), other(scenario, worker, 0, 0, {});
  const auto told = [](DriverSession* to, AgentState* agent, Point at, int seconds) {
    agent->from = agent->to = at;
    to->Follow(*agent, seconds * kSecondUs, 0);
    to->TakeLines();
    to->Tick(seconds * kSecondUs, 0);
    std::vector<json> lines;
    for (const std::string& line : to->TakeLines()) lines.push_back(json::parse(line));
    EXPECT_EQ(lines.back()["type"], "time");
    lines.pop_back();
    return lines;
  };
  ASSERT_EQ(home, (Point{0, 0}));
  EXPECT_TRUE(told(&session, &uav, {2000, 0}, 30).empty()) << "its way is straight";
  Zone zone;
  zone.rings = {{{900, 0}, {1100, 0}, {1100, 100}, {900, 100}}};
  scenario.closures.emplace_back().zone = std::make_shared<const Zone>(std::move(zone));
  ChangeWays(0, &scenario);
  const std::vector<json> around = told(&session, &uav, {2000, 0}, 60);
  ASSERT_EQ(around.size(), 1U);
  EXPECT_EQ(around[0]["type"], "way_home");
  EXPECT_EQ(around[0]["mission_s"], 60.0);
  // A corner of the zone is widened by an octagon, whose corners are 12.426 and 30 m away from it.
  const double x_m[] = {1112.426, 887.574};
  ASSERT_EQ(around[0]["via"].size(), 2U) << around[0];
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(around[0]["via"][i]["x_m"], x_m[i], 0.01);
    EXPECT_NEAR(around[0]["via"][i]["y_m"], 130, 0.01);
  }
  EXPECT_TRUE(told(&session, &uav, {2100, 0}, 90).empty()) << "the corners are the same";
  const std::vector<json> straight = told(&session, &uav, {500, 0}, 120);
  ASSERT_EQ(straight.size(), 1U);
  EXPECT_TRUE(straight[0]["via"].empty());
  EXPECT_TRUE(told(&other, &worker, {2000, 0}, 60).empty());
  session.Bye("over");
  EXPECT_EQ(json::parse(session.TakeLines().at(0)), (json{{"type", "bye"}, {"reason", "over"}}));
}

TEST(DriverSession, TakesMessagesToPeople) {
  Session session;
  session.Greeted();
  const auto says = [&](const char* line) { return session.Hear(std::string(line)); };
  EXPECT_EQ(says(R"({"type":"message","text":"the way is\nblocked"})"), "");
  EXPECT_EQ(says(R"({"type":"message","text":"trapped","help":true})"), "");
  const std::vector<DriverMessage> messages = session->TakeMessages();
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[0].agent, 0);
  EXPECT_EQ(messages[0].text.find('\n'), std::string::npos) << messages[0].text;
  EXPECT_FALSE(messages[0].calls_help);
  EXPECT_EQ(messages[1].text, "trapped");
  EXPECT_TRUE(messages[1].calls_help);
  EXPECT_TRUE(session->TakeMessages().empty());
  for (const char* wrong : {R"({"type":"message"})", R"({"type":"message","text":""})",
                            R"({"type":"message","text":"x","help":1})",
                            R"({"type":"message","text":"x","to":"all"})"}) {
    EXPECT_NE(says(wrong), "") << wrong;
  }
  for (int i = 0; i < 50; ++i) EXPECT_EQ(says(R"({"type":"message","text":"again"})"), "");
  EXPECT_EQ(says(R"({"type":"message","text":"trapped","help":true})"), "");
  const std::vector<DriverMessage> many = session->TakeMessages();
  ASSERT_EQ(many.size(), 21U);
  EXPECT_TRUE(many.back().calls_help) << "many words do not hide it";
  EXPECT_EQ(says(R"({"type":"failed","id":null,"reason":"hurt"})"), "");
  EXPECT_EQ(says("nonsense"), "") << "nothing is wrong any more";
  EXPECT_EQ(says(R"({"type":"message","text":"I bleed","help":true})"), "");
  EXPECT_EQ(session->TakeMessages().size(), 1U) << "though it takes no part any more";
}

TEST(DriverSession, TellsHowUrgentATaskIs) {
  Scenario scenario = Small();
  scenario.tasks[0].priority = Priority::kEmergency;
  scenario.tasks[0].due_us = 900 * kSecondUs;
  scenario.tasks[0].note = "third floor";
  AgentState agent = StartOf(AgentKind::kUav, 0, scenario.uavs[0], *scenario.ways);
  DriverSession session(scenario, agent, 0, 0, {});
  ASSERT_EQ(session.Hear(std::string_view(R"({"type":"hello","version":1})"), 0), "");
  session.TakeLines();
  Begin(&agent, Sense(), 0, 0, {}, 1);
  session.Follow(agent, 0, 0);
  const json sent = json::parse(session.TakeLines().at(0));
  EXPECT_EQ(sent["priority"], 3);
  EXPECT_EQ(sent["due_s"], 900.0);
  EXPECT_EQ(sent["task_note"], "third floor");
}

TEST(DriverSession, LeadsAnAgentToATaskAndThroughIt) {
  Session session;
  session.Told();
  session.Greeted();
  EXPECT_EQ(session->name(), "mine");
  EXPECT_TRUE(session->answered());
  const json sent = session.Sent().Told().at(0);
  EXPECT_EQ(sent["type"], "goto");
  EXPECT_EQ(sent["id"], 1);
  EXPECT_EQ(sent["then"], "sense");
  EXPECT_EQ(sent["partner"], "worker:0");
  EXPECT_EQ(sent["task"], 0);
  EXPECT_EQ(sent["task_name"], "School");
  EXPECT_TRUE(sent["charging_point"].is_null());
  EXPECT_EQ(sent["expected_s"], 500.0);
  EXPECT_DOUBLE_EQ(sent["on_to_charge_m"], std::hypot(3000, 3000));
  session.Time(510);
  EXPECT_FALSE(session->answered());
  EXPECT_EQ(session.Hear({{"type", "arrived"}, {"id", 1}}), "");
  EXPECT_EQ(session.Hear({{"type", "arrived"}, {"id", 1}}), "");  // twice does no harm
  EXPECT_FALSE(session->asked());
  EXPECT_FALSE(session->answered());
  const json there = {{"x_m", 3000}, {"y_m", 4000}};
  EXPECT_EQ(session.Hear({{"type", "state"}, {"at", there}, {"mission_s", 480}}), "");
  EXPECT_FALSE(session->answered());  // of a time before
  EXPECT_EQ(session.Hear({{"type", "state"}, {"at", there}, {"mission_s", 510}}), "");
  EXPECT_TRUE(session->answered());
  ASSERT_EQ(session.Apply(510).size(), 2U);
  session.Told();
  const Activity sensing{ActivityKind::kSensing, UavId(0), 0, 0, 500 * kSecondUs, 560 * kSecondUs};
  const json sense = session.Settled(Verdict({sensing}, {}), 510).Told().at(0);
  EXPECT_EQ(sense["type"], "sense");
  EXPECT_EQ(sense["id"], 2);
  EXPECT_EQ(sense["mission_s"], 500.0);
  EXPECT_EQ(sense["for_s"], 60.0);
  session.Time(570);
  EXPECT_EQ(session.Hear({{"type", "done"}, {"id", 2}, {"range_m", 9000}}), "");
  const auto reports = session.Apply(570);
  ASSERT_EQ(reports.size(), 1U);
  EXPECT_EQ(reports[0].kind, Report::kDone);
  EXPECT_EQ(reports[0].decision, 3);
  EXPECT_EQ(reports[0].range_m, 9000);
  session.Told();
  EXPECT_TRUE(session.Settled(Verdict({sensing}, {}), 570).Told().empty());  // nothing to cancel
  session->Bye("the mission is over");
  EXPECT_EQ(session.Told().at(0)["type"], "bye");
  EXPECT_EQ(session.Hear(std::string("nonsense")), "");
}

TEST(DriverSession, TellsWhenBothAreExpectedToBeThere) {
  Session session;
  session.Greeted().Sent().Time(30);
  session.Told();
  const auto settled = [&](TimeUs start_s, TimeUs at_s) {
    const Activity sensing{ActivityKind::kSensing,    UavId(0), 0, 0, start_s * kSecondUs,
                           (start_s + 60) * kSecondUs};
    return session.Settled(Verdict({sensing}, {}), at_s).Told();
  };
  const std::vector<json> first = settled(700, 30);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0],
            (json{{"type", "meeting"}, {"id", 1}, {"mission_s", 30.0}, {"expected_s", 700.0}}));
  EXPECT_TRUE(settled(700, 60).empty()) << "once";
  EXPECT_EQ(settled(800, 90).at(0)["expected_s"], 800.0);
}

TEST(DriverSession, CancelsWhatIsOffAndPassesOverWordsOnIt) {
  Session session;
  session.Greeted().Sent().Time(30);
  session.Told();
  const Verdict released({}, {{AgentKind::kUav, 0, RulingKind::kReleased, 20 * kSecondUs}});
  const json cancel = session.Settled(released, 30).Told().at(0);
  EXPECT_EQ(cancel["type"], "cancel");
  EXPECT_EQ(cancel["id"], 1);
  EXPECT_EQ(cancel["reason"], "worker:0 has failed");
  EXPECT_FALSE(session->asked());
  EXPECT_EQ(session.Hear({{"type", "arrived"}, {"id", 1}}), "");
  EXPECT_TRUE(session.Apply(30).empty());
  EXPECT_EQ(session.Sent(60, 4).Told().at(0)["id"], 2);
  EXPECT_EQ(session.Hear({{"type", "arrived"}, {"id", 1}}), "");
  EXPECT_TRUE(session.Apply(60).empty());
}

TEST(DriverSession, PlacesMayBeInDegrees) {
  Session session;
  session.Greeted().Sent().Time(100);
  json there = DriverPlaces(Small()).ToJson({600, 800});
  there.erase("x_m");
  there.erase("y_m");
  EXPECT_EQ(session.Hear({{"type", "state"}, {"at", there}, {"expected_s", 700}}), "");
  const auto reports = session.Apply(100);
  ASSERT_EQ(reports.size(), 1U);
  EXPECT_NEAR(reports[0].at.x_m, 600, 1e-4);
  EXPECT_NEAR(reports[0].at.y_m, 800, 1e-4);
  EXPECT_EQ(reports[0].at_us, 100 * kSecondUs);
  EXPECT_EQ(reports[0].expected_us, 700 * kSecondUs);
}

TEST(DriverSession, TheMissionsTimeGoesOnBetweenTicksAtARate) {
  Session session(60);
  session.Greeted().Sent().Time(30);
  session.wall_us() += kSecondUs;  // the mission's minute
  EXPECT_EQ(session.Hear({{"type", "state"}, {"at", {{"x_m", 480}, {"y_m", 640}}}}), "");
  EXPECT_EQ(session->TakeReports(200 * kSecondUs).at(0).at_us, 90 * kSecondUs);
  EXPECT_EQ(
      session.Hear({{"type", "state"}, {"at", {{"x_m", 480}, {"y_m", 640}}}, {"mission_s", 200}}),
      "its state is of 200.0 s, and it is 90.0 s");
  // What it said before it heard of the present command.
  session.Hear({{"type", "state"}, {"at", {{"x_m", 0}, {"y_m", 0}}}, {"mission_s", 10}});
  EXPECT_TRUE(session->TakeReports(200 * kSecondUs).empty());
}

TEST(DriverSession, WhatIsSaidBetweenTicksIsOfItsTime) {
  Session session(60);
  session.Greeted().Sent().Time(480);
  session.wall_us() += kSecondUs / 2;
  EXPECT_EQ(session.Hear({{"type", "arrived"}, {"id", 1}}), "");
  session.wall_us() += kSecondUs / 10;
  EXPECT_EQ(session.Hear({{"type", "state"}, {"at", {{"x_m", 3000}, {"y_m", 4000}}}}), "");
  EXPECT_EQ(session.Apply(540).size(), 2U);
}

TEST(DriverSession, APlaceOfATimeToComeWaitsForItsTick) {
  Session session(60);
  session.Greeted().Sent().Time(30);
  const auto state = [](double way_m, double at_s) {
    return json{{"type", "state"},
                {"at", {{"x_m", 0.6 * way_m}, {"y_m", 0.8 * way_m}}},
                {"mission_s", at_s}};
  };
  EXPECT_EQ(session.Hear(state(300, 30)), "");
  EXPECT_EQ(session.Hear(state(400, 40)), "");  // 100 m in no time, were it of 30 s
  EXPECT_EQ(session.Hear(state(430, 43)), "");
  ASSERT_EQ(session.Apply(30).size(), 1U);
  session.Time(60);
  EXPECT_EQ(session.Hear(state(600, 60)), "");
  const auto reports = session.Apply(60);
  ASSERT_EQ(reports.size(), 3U);
  EXPECT_EQ(reports[0].at_us, 40 * kSecondUs);
  EXPECT_EQ(reports[2].at_us, 60 * kSecondUs);
  // A failure does not wait.
  EXPECT_EQ(session.Hear(state(700, 70)), "");
  EXPECT_EQ(session.Hear({{"type", "failed"}, {"id", 1}, {"reason", "a rotor"}}), "");
  const auto failed = session->TakeReports(60 * kSecondUs);
  ASSERT_EQ(failed.size(), 1U);
  EXPECT_EQ(failed[0].kind, Report::kFailed);
}

TEST(DriverSession, AnArrivalThatCannotBeByTheTickIsOneOfTheNext) {
  Session session(60);
  session.Greeted().Sent().Time(480);
  session.wall_us() += kSecondUs / 2;
  EXPECT_EQ(session.Hear({{"type", "arrived"}, {"id", 1}}), "");  // 500 s away, at 510 s
  EXPECT_TRUE(session.Apply(480).empty());
  const auto reports = session.Apply(540);
  ASSERT_EQ(reports.size(), 1U);
  EXPECT_EQ(reports[0].kind, Report::kArrived);
  EXPECT_EQ(reports[0].at_us, 510 * kSecondUs);
}

TEST(DriverSession, WordsOnWhatIsOffByTheTickAreLeftOut) {
  Session session(60);
  session.Greeted().Sent().Time(480);
  session.Apply(480);
  session.wall_us() += kSecondUs / 2;
  EXPECT_EQ(session.Hear({{"type", "arrived"}, {"id", 1}}), "");
  // Meanwhile its partner has failed.
  const Verdict released({}, {{AgentKind::kUav, 0, RulingKind::kReleased, 480 * kSecondUs}});
  session.Settled(released, 480).Time(540);
  EXPECT_TRUE(session.Apply(540).empty());
}

TEST(DriverSession, WhoMayBeSilentForLongMayGreetAsLate) {
  const Scenario scenario = Small();
  const AgentState uav = StartOf(AgentKind::kUav, 0, scenario.uavs[0], *scenario.ways);
  const DriverSession session(scenario, uav, 0, 0, {.lost_after_us = 30 * kSecondUs});
  EXPECT_EQ(session.Silence(30 * kSecondUs), "");
  EXPECT_EQ(session.Silence(30 * kSecondUs + 1), "no hello within 30 s");
}

TEST(DriverSession, SilenceCountsFromWhenItOwesAnAnswer) {
  Session session(1);
  EXPECT_EQ(session->Silence(10 * kSecondUs), "");
  EXPECT_EQ(session->Silence(10 * kSecondUs + 1), "no hello within 10 s");
  session.Greeted().Time(60);
  EXPECT_EQ(session->Silence(3600 * kSecondUs), "");  // nothing is asked
  session.Sent(60).Time(90);
  EXPECT_EQ(session->Silence(65 * kSecondUs), "");
  EXPECT_EQ(session->Silence(66 * kSecondUs), "silent for 5 s while it was on its way");
  const json state = {{"type", "state"}, {"at", {{"x_m", 0}, {"y_m", 0}}}};
  EXPECT_EQ(session.Hear(state), "");
  EXPECT_EQ(session->Silence(3600 * kSecondUs), "");
  session.Time(3600);
  EXPECT_NE(session->Silence(3606 * kSecondUs), "");

  // As fast as it goes, the mission waits for it at each tick.
  Session fast;
  fast.Greeted().Time(60);
  EXPECT_FALSE(fast->answered());
  EXPECT_EQ(fast->Silence(66 * kSecondUs), "silent for 5 s while it was waiting");
  EXPECT_EQ(fast.Hear(state), "");
  EXPECT_TRUE(fast->answered());
  EXPECT_EQ(fast->Silence(3600 * kSecondUs), "");
}

TEST(DriverSession, WhileItIsNotReadyItsAgentIsNotFree) {
  Session mission;
  EXPECT_EQ(mission.Hear(json{{"type", "hello"}, {"version", 1}, {"not_ready", "a fix (4 seen)"}}),
            "");
  auto reports = mission.Apply(0);
  ASSERT_EQ(reports.size(), 1);
  EXPECT_EQ(reports[0].kind, Report::kNotReady);
  EXPECT_EQ(reports[0].reason, "a fix (4 seen)");
  EXPECT_TRUE(mission.agent().not_ready());
  EXPECT_EQ(StatusAt(mission.agent(), 0), AgentStatus::kNotReady);

  EXPECT_TRUE(mission.Settled(Verdict({}, {}), 0).Time(30).Apply(30).empty());
  EXPECT_EQ(mission.Hear(json{{"type", "not_ready"}, {"reason", "a fix (6 seen)"}}), "");
  reports = mission.Apply(30);
  ASSERT_EQ(reports.size(), 1);
  EXPECT_EQ(reports[0].reason, "a fix (6 seen)");
  EXPECT_EQ(mission.Hear(json{{"type", "state"}, {"at", {{"x_m", 2}, {"y_m", 0}}}}), "");
  mission.Apply(30);
  EXPECT_TRUE(mission.agent().not_ready()) << "wherever it stands";

  EXPECT_EQ(mission.Hear(json{{"type", "ready"}}), "");
  reports = mission.Apply(60);
  ASSERT_EQ(reports.size(), 1);
  EXPECT_EQ(reports[0].kind, Report::kReady);
  EXPECT_TRUE(mission.agent().idle(60 * kSecondUs));
}

TEST(DriverSession, WhatBeginsWhileItIsUnderWayCountsFromItsEnd) {
  Session mission;
  mission.Greeted().Sent().Time(30);
  EXPECT_EQ(mission.Hear(json{{"type", "not_ready"}, {"reason", "another battery"}}), "");
  EXPECT_TRUE(mission.Apply(30).empty());
  EXPECT_EQ(mission.agent().action, ActionKind::kSense);
  mission.Settled(Verdict({}, {{AgentKind::kUav, 0, RulingKind::kReleased, 30 * kSecondUs}}), 30);
  const auto reports = mission.Time(60).Apply(60);
  ASSERT_EQ(reports.size(), 1);
  EXPECT_EQ(reports[0].kind, Report::kNotReady);
  EXPECT_TRUE(mission.agent().not_ready());
}

TEST(DriverSession, AnAgentOfWhichTheTimeIsOverIsNotWaitedFor) {
  Session mission;
  mission.Greeted().Time(2990);
  EXPECT_EQ(mission.Hear(json{{"type", "not_ready"}, {"reason", "a fix"}}), "");
  EXPECT_EQ(mission.Apply(2990).size(), 1);
  AgentState agent = mission.agent();
  ExpectOnward(&agent, 2990 * kSecondUs, 3000 * kSecondUs);
  EXPECT_TRUE(agent.not_ready());
  ExpectOnward(&agent, 3000 * kSecondUs, 3030 * kSecondUs);
  EXPECT_EQ(StatusAt(agent, 3000 * kSecondUs), AgentStatus::kOffline);
  mission.Settled(Verdict({}, {}), 2990);
  EXPECT_TRUE(mission.Time(3030).Apply(3030).empty());
}

TEST(DriverSession, WhatItWaitsForHasToBeSaid) {
  for (const char* line :
       {R"({"type":"not_ready"})", R"({"type":"not_ready","reason":""})",
        R"({"type":"not_ready","reason":3})", R"({"type":"ready","reason":"x"})"}) {
    Session mission;
    mission.Greeted();
    EXPECT_NE(mission.Hear(std::string(line)), "") << line;
    EXPECT_FALSE(mission.agent().not_ready());
  }
  EXPECT_NE(Session().Hear(std::string(R"({"type":"hello","version":1,"not_ready":""})")), "");
}

TEST(DriverSession, SaysItselfThatItCannotGoOn) {
  Session session;
  session.Greeted().Sent();
  EXPECT_EQ(session.Hear({{"type", "failed"}, {"id", nullptr}, {"reason", "a rotor\n"}}), "");
  EXPECT_TRUE(session->over());
  const auto reports = session->TakeReports(0);
  ASSERT_EQ(reports.size(), 1U);
  EXPECT_EQ(reports[0].kind, Report::kFailed);
  EXPECT_EQ(reports[0].reason, "a rotor\\x0a");
}

/// Its line that is fine in the situation of the test below, by kind.
json Fine(int i) {
  switch (i) {
    case 0:
      return {{"type", "state"},
              {"at", {{"x_m", 600}, {"y_m", 800}}},
              {"range_m", 13'990},
              {"expected_s", 520},
              {"mission_s", 100}};
    case 1:
      return {{"type", "arrived"}, {"id", 1}};
    case 2:
      return {{"type", "done"}, {"id", 2}, {"range_m", 9000}};
    default:
      return {{"type", "failed"}, {"id", 1}, {"reason", "a rotor"}};
  }
}

/// Makes the line one that cannot be. `sensing`: it is at its task, else on its way.
std::string Spoil(Random* random, bool sensing) {
  const auto below = [&](int n) { return static_cast<int>(random->Uniform() * n); };
  const int kind = below(4);
  json line = Fine(kind);
  if (sensing && kind == 0) line["at"] = {{"x_m", 3000}, {"y_m", 4000}};
  const json odd[] = {nullptr, true, "text", json::array({1}), json::object(), -1, 1e300, 0.5};
  switch (below(12)) {
    case 0: {  // cut short
      const std::string text = line.dump();
      return text.substr(0, static_cast<std::size_t>(below(static_cast<int>(text.size()))));
    }
    case 1: {  // a byte that is no text
      std::string text = line.dump();
      text[static_cast<std::size_t>(below(static_cast<int>(text.size())))] =
          static_cast<char>(128 + below(128));
      return text;
    }
    case 2:
      line["type"] = odd[below(8)];
      return line.dump();
    case 3: {  // a key is missing that must be there
      const char* keys[] = {"at", "id", "id", "reason"};
      line.erase(keys[kind]);
      return line.dump();
    }
    case 4:
      line[fmt::format("key{}", below(1000))] = below(1000);
      return line.dump();
    case 5: {  // a value of another kind
      const char* keys[] = {"at", "id", "id", "reason"};
      const json value = odd[kind == 3 ? (below(2) == 0 ? 1 : 3 + below(5)) : below(5)];
      line[keys[kind]] = value;
      return line.dump();
    }
    case 6:  // an id that was never given
      line = Fine(1 + below(3));
      line["id"] = 3 + below(1'000'000'000);
      return line.dump();
    case 7:  // outside the area
      line = Fine(0);
      line["at"] = {{"x_m", 10'011 + below(1'000'000)}, {"y_m", below(10'000)}};
      return line.dump();
    case 8:  // further than its speed allows
      line = Fine(0);
      line.erase("range_m");
      line["at"] = sensing ? json{{"x_m", 9000 + below(1000)}, {"y_m", below(1000)}}
                           : json{{"x_m", 1100 + below(8000)}, {"y_m", below(9000)}};
      line["mission_s"] = sensing ? 570 : 100;
      return line.dump();
    case 9:  // range from nowhere
      line = Fine(0);
      if (sensing) line["at"] = {{"x_m", 3000}, {"y_m", 4000}};
      line["mission_s"] = sensing ? 570 : 100;
      line["range_m"] = 14'020 + below(1'000'000);
      return line.dump();
    case 10:  // a word on the wrong command, or a second greeting
      if (below(2) == 0) return kHello;
      return sensing ? R"({"type":"arrived","id":2})" : R"({"type":"done","id":1})";
    default:  // not yet there, or a time to come
      if (!sensing && below(2) == 0) return R"({"type":"arrived","id":1})";
      line = Fine(0);
      line["mission_s"] = 1000 + below(100'000);
      return line.dump();
  }
}

TEST(DriverSession, RefusesTenThousandLinesThatCannotBe) {
  const Activity sensing{ActivityKind::kSensing, UavId(0), 0, 0, 500 * kSecondUs, 560 * kSecondUs};
  for (std::uint64_t seed = 1; seed <= 10'000; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed, Stream::kPolicy);
    const bool senses = seed % 2 == 0;
    Session session;
    session.Greeted().Sent().Time(senses ? 510 : 100);
    if (senses) {
      ASSERT_EQ(session.Hear(Fine(1)), "");
      session.Apply(510);
      session.Settled(Verdict({sensing}, {}), 510).Time(570);
    }
    ASSERT_EQ(session->TakeReports(0).size(), 0U);
    const std::string line = Spoil(&random, senses);
    const std::string why = session.Hear(line);
    ASSERT_NE(why, "") << line;
    ASSERT_LT(why.size(), 1000U);
    ASSERT_TRUE(session->TakeReports(0).empty()) << line;
    // As if it had not been said.
    ASSERT_EQ(session.Hear(Fine(senses ? 2 : 0)), "") << line;
    ASSERT_EQ(session->TakeReports(570 * kSecondUs).size(), 1U);
  }
}

/// A measured worker at the west end of a street, sent to the task at its east end.
struct OnStreets {
  OnStreets() {
    scenario.workers[0].measured = true;
    scenario.workers[0].online_until_us = scenario.rules.limit_us;
    agent.emplace(StartOf(AgentKind::kWorker, 0, scenario.workers[0], *scenario.ways));
    session.emplace(scenario, *agent, 0, 0, DriverSession::Rules{.rate = 1});
    EXPECT_EQ(session->Hear(kHello, 0), "");
    Action sense = Sense();
    sense.to = scenario.tasks[0].at;
    Begin(&*agent, sense, 3, 0, {}, 1);
    session->Follow(*agent, 0, 0);
  }
  json LastTold() {
    json last;
    for (const std::string& line : session->TakeLines()) last = json::parse(line);
    return last;
  }

  Scenario scenario = muster::testing::OnTheBlock();
  std::optional<AgentState> agent;
  std::optional<DriverSession> session;
};

std::vector<Point> Via(const json& told) {
  std::vector<Point> via;
  for (const json& place : told["via"]) via.push_back({place["x_m"], place["y_m"]});
  return via;
}

TEST(DriverSession, IsSentAnewRoundARoadThatIsClosed) {
  OnStreets box;
  const json first = box.LastTold();
  EXPECT_EQ(first["type"], "goto");
  EXPECT_EQ(Via(first), (std::vector<Point>{{400, 0}}));
  // Road 10, on which it is, is closed at 60 s.
  const auto* roads = static_cast<const RoadWays*>(box.scenario.ways.get());
  const std::shared_ptr<const RoadWays> now = roads->Without({0});
  GoRound(&*box.agent, 30 * kSecondUs, 60 * kSecondUs, *now);
  box.session->Follow(*box.agent, 60 * kSecondUs, 60 * kSecondUs);
  const json second = box.LastTold();
  EXPECT_EQ(second["type"], "goto");
  EXPECT_EQ(second["id"], 2);
  EXPECT_EQ(second["task"], first["task"]);
  const std::vector<Point> via = Via(second);
  ASSERT_GE(via.size(), 3u);
  EXPECT_EQ(std::vector<Point>(via.end() - 3, via.end()),
            (std::vector<Point>{{0, 300}, {400, 300}, {400, 0}}));
  EXPECT_GT(second["expected_s"], first["expected_s"]);
  // Nothing has changed since: it is not told again.
  box.session->Follow(*box.agent, 90 * kSecondUs, 90 * kSecondUs);
  EXPECT_TRUE(box.session->TakeLines().empty());
  // It went by the street all the same, and says so of the first goto: the goal is the same.
  box.session->Tick(1000 * kSecondUs, 1000 * kSecondUs);
  EXPECT_EQ(box.session->Hear(R"({"type":"arrived","id":1})", 1000 * kSecondUs), "");
  const auto reports = box.session->TakeReports(1000 * kSecondUs);
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_EQ(reports[0].kind, Report::kArrived);
  EXPECT_EQ(reports[0].decision, 3);
}

TEST(DriverSession, IsBelievedBesideTheRoadAndWhereNoneIsNear) {
  OnStreets box;
  // By road it would be 200 m and, at half the pace, 20 m of open ground: more than 1 m/s.
  box.session->Tick(200 * kSecondUs, 200 * kSecondUs);
  EXPECT_EQ(box.session->Hear(R"({"type":"state","at":{"x_m":200,"y_m":20},"mission_s":200})",
                              200 * kSecondUs),
            "");
  // 1200 m from any road.
  constexpr TimeUs kThen = 1700 * kSecondUs;
  box.session->Tick(kThen, kThen);
  EXPECT_EQ(
      box.session->Hear(R"({"type":"state","at":{"x_m":200,"y_m":1500},"mission_s":1700})", kThen),
      "");
  AgentState agent = *box.agent;
  for (const MeasuredReport& report : box.session->TakeReports(kThen)) {
    EXPECT_EQ(ApplyReport(&agent, report, kThen, box.scenario.tasks), "");
  }
  EXPECT_EQ(agent.from, (Point{200, 1500}));
  // What is left, in a straight line: sqrt(800^2 + 1500^2) m at 1 m/s.
  EXPECT_NEAR(ToSeconds(agent.arrive_us), 1700 + 1700, 0.1);
  // Faster than its speed stays faster.
  EXPECT_EQ(
      box.session->Hear(R"({"type":"state","at":{"x_m":260,"y_m":1500},"mission_s":1701})", kThen),
      "60 m in 1 s are faster than its 1 m/s");
}

}  // namespace
}  // namespace muster::agents
