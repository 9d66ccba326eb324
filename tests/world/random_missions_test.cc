// Random missions, judged without messages. Ways, sensing, charging and failures take whole tens of
// seconds, so that much happens at the same microsecond and at a tick. What happens may not depend
// on how long a tick is, nor on a restart in between; and it is what it was when this was written
// (where a change is meant to move it, the new lines belong in its commit).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "base/random.h"
#include "model/feasibility.h"
#include "world/referee.h"

namespace muster::world {
namespace {

constexpr TimeUs kInterval = 600 * kSecondUs;

struct Drawn {
  Scenario scenario;
  std::vector<Outage> outages;
};

/// Everything on a line, at whole 500 m.
/// timed: tasks are reported while the mission runs, and expire.
Drawn DrawMission(std::uint64_t seed, bool timed = false) {
  Random random(seed, Stream::kTest);
  const auto below = [&](int n) {
    return static_cast<int>(random.Below(static_cast<std::uint32_t>(n)));
  };
  const auto at = [&] { return Point{500.0 * below(12), 0}; };
  Drawn drawn;
  Scenario& s = drawn.scenario;
  s.seed = seed;
  s.width_m = s.height_m = 6000;
  s.rules.interval_us = kInterval;
  s.rules.limit_us = 6 * kInterval;
  s.rules.start_on_meeting = seed % 3 == 1;
  s.rules.availability = seed % 2 == 0 ? Availability::kStrict : Availability::kOverrun;
  if (seed % 5 == 2) s.disturbances.agent_failure = {0.02, 0.1};
  if (seed % 5 == 3) s.disturbances.match_failure = {0.2, 0.4};
  if (seed % 7 == 4) s.disturbances.wind = {1, 1};
  const auto agent = [&](double speed_m_s) {
    AgentSpec spec;
    spec.at = at();
    spec.speed_m_s = speed_m_s;
    spec.online_from_us = 300 * kSecondUs * (below(3) == 0 ? below(4) : 0);
    spec.online_until_us =
        spec.online_from_us + 300 * kSecondUs * (below(12) == 0 ? 0 : 6 + below(9));
    return spec;
  };
  for (int i = 0; i < 5; ++i) {
    AgentSpec uav = agent(10);
    uav.range_full_m = 8000;
    uav.range_m = 500.0 * (2 + below(15));
    s.uavs.push_back(uav);
    s.workers.push_back(agent(i % 2 == 0 ? 5 : 10));
  }
  for (int i = 0; i < 3; ++i) {
    AgentSpec vehicle = agent(10);
    vehicle.charge_rate_m_s = 25;
    s.vehicles.push_back(vehicle);
  }
  for (int x = 0; x < 10; ++x) s.tasks.push_back({at(), 100.0 * (5 * below(5))});
  for (int y = 0; y < 3; ++y) {
    s.charging_points.push_back({at(), y == 0 ? std::optional<int>() : std::optional<int>(y)});
  }
  for (int i = below(9); i > 0; --i) {
    const auto kind = static_cast<AgentKind>(below(3));
    const TimeUs from = 50 * kSecondUs * below(60);
    const TimeUs until = below(4) == 0 ? kNever : from + 50 * kSecondUs * (12 + below(12));
    drawn.outages.push_back({kind,
                             below(static_cast<int>(s.agents(kind).size())),
                             from,
                             until,
                             {FailureReason::Cause::kFault, fmt::format("f{}", i)}});
  }
  if (!timed) return drawn;
  for (Task& task : s.tasks) {
    task.reported_us = 50 * kSecondUs * (below(2) == 0 ? below(30) : 0);
    if (below(3) != 0) task.expires_us = task.reported_us + 50 * kSecondUs * (4 + below(30));
  }
  return drawn;
}

using CommandOf = std::function<std::vector<Action>(std::int32_t, const Agents&,
                                                    const std::vector<TaskStatus>&, TimeUs)>;

/// Pairs and moves of those that are idle; now and then of one half only, of those that the other
/// half never hears of.
std::vector<Action> Commands(const Drawn& drawn, std::int32_t decision, const Agents& agents,
                             const std::vector<TaskStatus>& tasks, TimeUs now) {
  Random random(drawn.scenario.seed, Stream::kTest, 1, static_cast<std::uint32_t>(decision));
  const auto pick = [&](AgentKind kind) {
    std::vector<std::int32_t> idle;
    for (const AgentState& agent : agents[kind]) {
      if (agent.idle(now)) idle.push_back(agent.id);
    }
    return idle.empty() ? -1 : idle[random.Below(static_cast<std::uint32_t>(idle.size()))];
  };
  std::vector<Action> actions;
  PerKind<std::vector<std::int32_t>> used;
  const auto is_free = [&](AgentKind kind, std::int32_t id) {
    return std::find(used[kind].begin(), used[kind].end(), id) == used[kind].end();
  };
  std::vector<TaskStatus> open = tasks;
  for (int i = 0; i < 12; ++i) {
    const bool senses = random.Below(3) != 0;
    const AgentKind other = senses ? AgentKind::kWorker : AgentKind::kVehicle;
    const std::int32_t u = pick(AgentKind::kUav), p = pick(other);
    if (u < 0 || p < 0 || !is_free(AgentKind::kUav, u) || !is_free(other, p)) continue;
    Action action;
    action.uav = UavId(u);
    if (senses) {
      const std::size_t x = random.Below(static_cast<std::uint32_t>(open.size()));
      if (open[x] != TaskStatus::kOpen) continue;
      open[x] = TaskStatus::kReserved;
      action.kind = ActionKind::kSense;
      action.worker = WorkerId(p);
      action.task = TaskId(x);
      action.to = drawn.scenario.tasks[x].at;
    } else {
      const std::size_t y =
          random.Below(static_cast<std::uint32_t>(drawn.scenario.charging_points.size()));
      action.kind = ActionKind::kCharge;
      action.vehicle = VehicleId(p);
      action.charge = ChargeId(y);
      action.to = drawn.scenario.charging_points[y].at;
    }
    used.uavs.push_back(u);
    used[other].push_back(p);
    actions.push_back(action);
  }
  for (const AgentKind kind : kAgentKinds) {
    const std::int32_t id = pick(kind);
    if (id < 0 || !is_free(kind, id)) continue;
    Action go;
    go.kind = ActionKind::kGoTo;
    if (kind == AgentKind::kUav) go.uav = UavId(id);
    if (kind == AgentKind::kWorker) go.worker = WorkerId(id);
    if (kind == AgentKind::kVehicle) go.vehicle = VehicleId(id);
    go.to = {500.0 * random.Below(12), 0};
    actions.push_back(go);
  }
  return actions;
}

struct Outcome {
  std::vector<std::string> events;  ///< by time
  std::string end;                  ///< tasks and agents
};

/// restart_at: a referee that starts again goes on from there; -1: none. one_half: of every fifth
/// pair only the partner hears.
Outcome Play(const Drawn& drawn, TimeUs tick, TimeUs restart_at, bool one_half) {
  const Scenario& s = drawn.scenario;
  Agents agents;
  for (const AgentKind kind : kAgentKinds) {
    for (const AgentSpec& spec : s.agents(kind)) {
      agents[kind].push_back(
          StartOf(kind, static_cast<std::int32_t>(agents[kind].size()), spec, StraightWays()));
    }
  }
  auto referee = std::make_unique<Referee>(s);
  for (const Outage& outage : drawn.outages) referee->Add(outage);
  std::vector<Event> events;
  TimeUs previous = -1;
  std::int32_t decided = -1;
  for (TimeUs t = 0; t <= s.rules.limit_us; t += tick) {
    for (const AgentKind kind : kAgentKinds) {
      for (AgentState& agent : agents[kind]) {
        if (previous >= 0) Settle(&agent, referee->verdict(), previous, s.tasks);
      }
    }
    if (decided >= 0) {
      const auto actions = Commands(drawn, decided, agents, referee->task_status(), previous);
      referee->Take(decided, actions);
      int pairs = 0;
      for (const Action& action : actions) {
        if (IsPair(action.kind) && MatchFails(action, decided, s.disturbances, s.seed)) continue;
        const bool half = one_half && IsPair(action.kind) && ++pairs % 5 == 0;
        for (const AgentKind kind : kAgentKinds) {
          const std::int32_t id = MemberOf(action, kind);
          if (id < 0 || (half && kind == AgentKind::kUav)) continue;
          Begin(&agents.at(kind, id), action, decided, previous, s.disturbances, s.seed);
        }
      }
    }
    if (t == restart_at) {
      auto again = std::make_unique<Referee>(s);
      for (const Outage& outage : drawn.outages) again->Add(outage);
      again->Restore(previous, referee->task_status(), referee->verdict());
      for (const Event& event : referee->TakeEvents()) events.push_back(event);
      referee = std::move(again);
    }
    decided =
        t < s.rules.limit_us && t % kInterval == 0 ? static_cast<std::int32_t>(t / kInterval) : -1;
    Agents reported = agents;
    referee->Judge(t, decided, &reported);
    for (const Event& event : referee->TakeEvents()) events.push_back(event);
    previous = t;
  }
  Outcome outcome;
  for (const Event& e : events) {
    outcome.events.push_back(fmt::format(
        "{:06d} {} {} {} {} {} {} {} {}", e.at_us / 1'000'000, ToString(e.kind), e.uav.value,
        e.worker.value, e.vehicle.value, e.task.value, e.charge.value, e.detail, e.by_fault));
  }
  std::sort(outcome.events.begin(), outcome.events.end());
  for (const TaskStatus status : referee->task_status()) outcome.end += ToString(status)[0];
  for (const AgentKind kind : kAgentKinds) {
    for (AgentState& agent : agents[kind]) {
      Settle(&agent, referee->verdict(), previous, s.tasks);
      outcome.end +=
          fmt::format(" {}:{:.6g},{:.6g}", ToString(StatusAt(agent, previous))[0],
                      PositionAt(agent, previous).x_m, RangeAt(agent, previous, s.tasks));
    }
  }
  return outcome;
}

/// FNV-1a, 32 bits.
std::uint32_t HashOf(const std::string& text) {
  std::uint32_t hash = 2166136261u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

std::string Told(const Outcome& outcome) {
  std::string text;
  for (const std::string& event : outcome.events) text += event + "\n";
  return text + outcome.end;
}

/// The first event that one has and the other has not.
std::string Difference(const Outcome& a, const Outcome& b) {
  std::vector<std::string> different;
  std::set_symmetric_difference(a.events.begin(), a.events.end(), b.events.begin(), b.events.end(),
                                std::back_inserter(different));
  if (!different.empty()) return different.front();
  return a.end == b.end ? "" : a.end + "\n" + b.end;
}

class RandomMissions : public ::testing::TestWithParam<bool> {};

TEST_P(RandomMissions, DoNotDependOnTheTickNorOnARestart) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    const Drawn drawn = DrawMission(seed, GetParam());
    // Of several outages of one agent in one tick, not each is told of.
    Drawn once = drawn;
    once.outages.clear();
    for (const Outage& outage : drawn.outages) {
      if (std::none_of(once.outages.begin(), once.outages.end(), [&](const Outage& other) {
            return other.kind == outage.kind && other.agent == outage.agent;
          })) {
        once.outages.push_back(outage);
      }
    }
    const Outcome of_once = Play(once, 50 * kSecondUs, -1, false);
    const Outcome expected = Play(drawn, 50 * kSecondUs, -1, false);
    for (const int tick : {10, 30, 100}) {
      EXPECT_EQ(Difference(Play(once, tick * kSecondUs, -1, false), of_once), "")
          << "seed " << seed << " tick " << tick;
    }
    for (const int restart : {50, 450, 600, 650, 1250, 1800, 2500, 3600}) {
      const Outcome outcome = Play(drawn, 50 * kSecondUs, restart * kSecondUs, false);
      EXPECT_EQ(Difference(outcome, expected), "") << "seed " << seed << " restart " << restart;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Tasks, RandomMissions, ::testing::Bool(),
                         [](const auto& timed) { return timed.param ? "InTime" : "FromTheStart"; });

TEST(RandomMissionsOfOld, ComeToWhatTheyCameTo) {
  const char* known[] = {"777 events, 3d9da66f", "776 events, e9e0db5d", "741 events, bb4b3e99",
                         "757 events, a7547b4e", "772 events, 6232d072", "738 events, fcc397f7",
                         "781 events, ec6934c2", "767 events, 0970d5a2", "739 events, b5c591f2",
                         "736 events, fe2b3b5d"};
  std::uint64_t seed = 0;
  for (const char* line : known) {
    std::string text;
    std::size_t events = 0;
    for (int i = 0; i < 15; ++i) {
      const Outcome outcome = Play(DrawMission(seed++), 50 * kSecondUs, -1, true);
      text += Told(outcome) + "\n";
      events += outcome.events.size();
    }
    EXPECT_EQ(fmt::format("{} events, {:08x}", events, HashOf(text)), line) << text.substr(0, 3000);
  }
}

}  // namespace
}  // namespace muster::world
