// Whole missions of which agents are measured: rule book, referee and policies without messages,
// and the example's program for one of them. As over messages, the world knows agents by what goes
// over the wire and by the reports that it took; it must come to the agents' own states.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "agents/driver/driver_program.h"
#include "base/random.h"
#include "base/spawn.h"
#include "model/generator.h"
#include "scheduler/policies/registry.h"
#include "tests/world/measured_flight.h"

namespace muster {
namespace {

using agents::DriverProgram;
using agents::DriverSession;
using world::Agents;
using world::Event;
using world::FailureReason;
using world::Referee;
using world::testing::Shown;

/// What agents say for a tick at t, given what they know of themselves.
using Speaker = std::function<std::vector<MeasuredReport>(const Agents& agents, TimeUs t)>;

struct Outcome {
  std::vector<Event> events;
  std::vector<std::string> actions;  ///< all that were decided
  int reports = 0;
  std::vector<std::string> refused;
  int done = 0;

  std::vector<std::string> Told() const {
    std::vector<std::string> told;
    for (const Event& e : events) {
      told.push_back(fmt::format("{} {} uav:{} worker:{} vehicle:{} task:{} charge:{} {}",
                                 static_cast<int>(e.kind), e.at_us, e.uav.value, e.worker.value,
                                 e.vehicle.value, e.task.value, e.charge.value, e.detail));
    }
    return told;
  }
};

class Mission {
 public:
  Mission(Scenario scenario, std::string_view policy, Speaker speaker)
      : scenario_(std::move(scenario)),
        limits_(scenario_),
        site_(std::make_shared<const scheduler::Site>(scenario_)),
        referee_(scenario_),
        policy_(scheduler::MakePolicy(policy)),
        speaker_(std::move(speaker)) {
    for (const AgentKind kind : kAgentKinds) {
      for (std::size_t i = 0; i < scenario_.agents(kind).size(); ++i) {
        own_[kind].push_back(
            StartOf(kind, static_cast<std::int32_t>(i), scenario_.agents(kind)[i]));
      }
    }
    world_ = own_;
  }

  Outcome Run() {
    for (std::int64_t tick = 0; tick <= scenario_.rules.last_tick(); ++tick) Tick(tick);
    outcome_.done = referee_.done();
    return std::move(outcome_);
  }

 private:
  template <class Visit>
  void ForEach(Visit visit) {
    for (const AgentKind kind : kAgentKinds) {
      for (std::size_t i = 0; i < own_[kind].size(); ++i) visit(own_[kind][i], world_[kind][i]);
    }
  }

  void Tick(std::int64_t tick) {
    const TimeUs t = scenario_.rules.TimeOf(tick);
    const std::int32_t decision = scenario_.rules.DecisionAt(tick);
    ForEach([&](const AgentState& own, AgentState& known) {
      auto reported = FromWire(ToWire(own, t, scenario_.tasks), own.kind, t, limits_);
      ASSERT_TRUE(reported);
      KeepMeasured(known, &*reported);
      known = *reported;
    });
    for (const MeasuredReport& report : speaker_(own_, t)) Take(report, t);
    ForEach([&](AgentState& own, AgentState& known) {
      ExpectOnward(&own, t, scenario_.rules.TickAfter(t));
      ExpectOnward(&known, t, scenario_.rules.TickAfter(t));
    });
    referee_.Judge(t, decision, &world_);
    ForEach([&](AgentState& own, const AgentState& known) {
      Settle(&own, referee_.verdict(), t, scenario_.tasks);
      AgentState shown =
          known;  // a free move's goal is told but for rounding, by the schedule exactly
      if (own.action == ActionKind::kGoTo) shown.to = own.to;
      if (own.measured || !own.failed) {
        ASSERT_EQ(Shown(own), Shown(shown)) << t;
      }
    });
    for (Event& event : referee_.TakeEvents()) outcome_.events.push_back(std::move(event));
    if (decision >= 0) Decide(t, decision);
  }

  void Take(const MeasuredReport& report, TimeUs t) {
    ++outcome_.reports;
    const std::string why =
        ApplyReport(&world_.at(report.agent_kind, report.agent), report, t, scenario_.tasks);
    if (!why.empty()) return outcome_.refused.push_back(why);
    EXPECT_EQ(ApplyReport(&own_.at(report.agent_kind, report.agent), report, t, scenario_.tasks),
              "");
    if (report.kind != MeasuredReport::Kind::kFailed) return;
    referee_.Add(
        {report.agent_kind, report.agent, t, kNever, {FailureReason::Cause::kSaid, report.reason}});
  }

  void Decide(TimeUs t, std::int32_t decision) {
    scheduler::Situation situation;
    situation.site = site_;
    situation.decision = decision;
    situation.now_us = t;
    situation.task_status = referee_.task_status();
    situation.charging_load.assign(scenario_.charging_points.size(), 0);
    const auto add = [&](AgentKind kind, std::vector<AgentState>* list) {
      for (const AgentState& agent : own_[kind]) {
        if (agent.failed || (!agent.online(t) && agent.busy_until_us <= t)) continue;
        list->push_back(agent);
      }
    };
    add(AgentKind::kUav, &situation.uavs);
    add(AgentKind::kWorker, &situation.workers);
    add(AgentKind::kVehicle, &situation.vehicles);
    for (const AgentState& uav : situation.uavs) {
      if (uav.action != ActionKind::kCharge) continue;
      ++situation.charging_load[static_cast<std::size_t>(uav.target)];
    }
    const auto actions = policy_->Decide(situation).actions;
    referee_.Take(decision, actions);
    for (const Action& action : actions) {
      outcome_.actions.push_back(fmt::format("{} {}", decision, ToString(action)));
      for (const AgentKind kind : kAgentKinds) {
        const std::int32_t id = MemberOf(action, kind);
        if (id < 0 || !own_.at(kind, id).idle(t)) continue;
        Begin(&own_.at(kind, id), action, decision, t, scenario_.disturbances, scenario_.seed);
      }
    }
  }

  const Scenario scenario_;
  const WireLimits limits_;
  const std::shared_ptr<const scheduler::Site> site_;
  Referee referee_;
  const std::unique_ptr<scheduler::Policy> policy_;
  const Speaker speaker_;
  Agents own_, world_;
  Outcome outcome_;
};

constexpr std::int32_t kDriven = 3;

/// Random_1 of seed 1 with UAV 3 driven by the example with those options; nullptr: computed.
Outcome Fly(const char* arguments) {
  const Scenario scenario = Generate(PresetByName("Random_1"), 1);
  std::unique_ptr<DriverProgram> program;
  bool failed = false;
  const Speaker speaker = [&](const Agents& agents, TimeUs t) {
    std::vector<MeasuredReport> reports;
    if (arguments == nullptr || failed) return reports;
    const AgentState& agent = agents.uavs[kDriven];
    DriverSession::Rules rules;
    rules.lost_after_us = kSecondUs;
    if (!program) {
      program = std::make_unique<DriverProgram>(
          agents::DriverCommand(fmt::format("python3 {} {}", MUSTER_EXAMPLES "/uav.py", arguments)),
          scenario, agent, t, rules);
    }
    // What it was commanded at the tick before.
    program->session().Follow(agent, std::max<TimeUs>(0, t - scenario.rules.tick_us),
                              DriverProgram::WallUs());
    program->session().Tick(t, DriverProgram::WallUs());
    const std::string problem =
        program->Pump(true, DriverProgram::Clock::now() + std::chrono::minutes(1));
    reports = program->session().TakeReports(t);
    if (!problem.empty()) {
      failed = true;
      reports.push_back({.agent = kDriven,
                         .kind = MeasuredReport::Kind::kFailed,
                         .reason = "its driver: " + problem});
    }
    return reports;
  };
  return Mission(scenario, "horizon", speaker).Run();
}

/// Its failures, as events tell them.
std::vector<std::string> FailuresOf(const Outcome& outcome) {
  std::vector<std::string> list;
  for (const Event& event : outcome.events) {
    if (event.kind == EventKind::kAgentFailed) {
      list.push_back(fmt::format("uav:{} {}", event.uav.value, event.detail));
    }
  }
  return list;
}

/// When the driven one's sensing began, and with whom.
std::vector<TimeUs> StartsOf(const Outcome& outcome) {
  std::vector<TimeUs> list;
  for (const Event& event : outcome.events) {
    if (event.kind == EventKind::kSensingStarted && event.uav.value == kDriven) {
      list.push_back(event.at_us);
    }
  }
  return list;
}

class DrivenMission : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!FindProgram("python3")) GTEST_SKIP() << "no python3";
  }
};

TEST_F(DrivenMission, OnTimeItsOutcomesAreTheComputedOnes) {
  const Outcome computed = Fly(nullptr), driven = Fly("");
  EXPECT_GT(driven.reports, 300);
  EXPECT_TRUE(driven.refused.empty()) << driven.refused.front();
  EXPECT_GE(StartsOf(computed).size(), 2U);
  EXPECT_EQ(driven.Told(), computed.Told());
  EXPECT_EQ(driven.actions, computed.actions);
}

TEST_F(DrivenMission, LateItMovesWhatItTakesPartIn) {
  const Outcome computed = Fly(nullptr), driven = Fly("--late 20");
  EXPECT_TRUE(driven.refused.empty()) << driven.refused.front();
  EXPECT_TRUE(FailuresOf(driven).empty());
  EXPECT_GE(StartsOf(driven).size(), 2U);
  EXPECT_NE(driven.Told(), computed.Told());
  EXPECT_GE(StartsOf(driven).front(), StartsOf(computed).front());
}

TEST_F(DrivenMission, WhenItDiesItFailsWithTheReason) {
  const Outcome driven = Fly("--dies 25");
  EXPECT_EQ(FailuresOf(driven),
            std::vector<std::string>{"uav:3 its driver: its program exited with code 1"});
}

TEST_F(DrivenMission, WhenItIsSilentTheMissionDoesNotWaitForLong) {
  const auto failures = FailuresOf(Fly("--silent 25:35"));
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_EQ(failures[0].find("uav:3 its driver: silent for 1 s while it was "), 0U) << failures[0];
}

/// Agents that tell the truth, late and not always.
class Truthful {
 public:
  explicit Truthful(std::uint64_t seed) : random_(seed, Stream::kTest) {}

  std::vector<MeasuredReport> operator()(const Agents& agents, TimeUs t) {
    std::vector<MeasuredReport> reports;
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentState& agent : agents[kind]) {
        if (!agent.failed) Speak(agent, t, &reports);
      }
    }
    previous_us_ = t;
    return reports;
  }

 private:
  struct Body {
    bool is_measured = false;
    double slowness = 1;
    Point at;
    bool is_there = false;
    std::int32_t decision = -1;
  };

  void Speak(const AgentState& agent, TimeUs t, std::vector<MeasuredReport>* reports) {
    const auto say = [&](MeasuredReport report) {
      report.agent_kind = agent.kind;
      report.agent = agent.id;
      report.decision = agent.decision;
      report.at_us = t;
      reports->push_back(std::move(report));
    };
    auto [entry, is_new] = bodies_.try_emplace({agent.kind, agent.id});
    Body& body = entry->second;
    if (is_new) {
      body.is_measured = random_.Below(2) == 0;
      body.slowness = random_.Below(3) == 0 ? 1 : random_.Uniform(1, 2.5);
      body.at = agent.to;
      if (body.is_measured) say({.kind = MeasuredReport::Kind::kJoins});
    }
    if (!body.is_measured || agent.action == ActionKind::kNone) return;
    if (agent.decision != body.decision) body.is_there = false, body.decision = agent.decision;
    if (!body.is_there) {
      const double way = Distance(body.at, agent.to);
      const double step = agent.speed_m_s / body.slowness * ToSeconds(t - previous_us_);
      body.is_there = step >= way;
      body.at = body.is_there ? agent.to : Lerp(body.at, agent.to, step / way);
    }
    if (random_.Below(2000) == 0) say({.kind = MeasuredReport::Kind::kFailed, .reason = "tired"});
    if (random_.Below(4) == 0) return;  // silent
    if (body.is_there) {
      if (!agent.measured->arrived) say({.kind = MeasuredReport::Kind::kArrived});
      const auto& activity = agent.activity;
      if (!activity || activity->start_us > t || agent.measured->done) return;
      if (t >= activity->end_us || random_.Below(20) == 0) {
        say({.kind = MeasuredReport::Kind::kDone});
      }
      return;
    }
    const double left_s = Distance(body.at, agent.to) / agent.speed_m_s * body.slowness;
    std::optional<TimeUs> expected_us;
    if (random_.Below(2) == 0) expected_us = t + ToUs(left_s);
    say({.at = body.at, .expected_us = expected_us});
  }

  Random random_;
  std::map<std::pair<AgentKind, std::int32_t>, Body> bodies_;
  TimeUs previous_us_ = 0;
};

TEST(MeasuredMissions, WhoTellsTheTruthIsNeverRefused) {
  int late = 0, done = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    Scenario scenario = Generate(PresetByName("Random_1"), seed);
    scenario.uavs.resize(6);
    scenario.workers.resize(8);
    scenario.vehicles.resize(4);
    scenario.tasks.resize(30);
    if (seed % 3 == 0) scenario.disturbances.wind = {0.1, 0.4};
    if (seed % 4 == 0) scenario.tasks[5].expires_us = 70 * kMinuteUs;
    const Outcome outcome = Mission(scenario, "mpq", Truthful(seed)).Run();
    EXPECT_TRUE(outcome.refused.empty()) << outcome.refused.front();
    std::map<std::pair<std::int32_t, std::int32_t>, int> under_way;
    int sensed = 0;
    for (const Event& event : outcome.events) {
      int& open = under_way[{event.uav.value, event.task.value}];
      if (event.kind == EventKind::kSensingStarted) {
        EXPECT_EQ(open++, 0);
      }
      if (event.kind == EventKind::kSensingDone) {
        EXPECT_EQ(open--, 1);
        ++sensed;
      }
      if (event.kind == EventKind::kSensingAborted) {
        EXPECT_EQ(open, event.detail == "under way" ? 1 : 0);
        open = 0;
        late += event.detail.find(" late") != std::string::npos ? 1 : 0;
      }
    }
    EXPECT_EQ(outcome.done, sensed);
    done += sensed;
  }
  EXPECT_GT(done, 500);
  EXPECT_GT(late, 10);
}

}  // namespace
}  // namespace muster
