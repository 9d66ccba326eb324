#pragma once

#include <memory>
#include <vector>

#include "base/random.h"
#include "scheduler/situation.h"

namespace muster::scheduler::testing {

/// Builds a Situation from agents written by hand. Defaults: decision 0 at time 0 of a mission of
/// 180 min with decisions every 10 min, an area of 30 km x 30 km, everybody online to the end;
/// UAVs 10 m/s with 30 of 30 km left, workers 5 m/s, vehicles 10 m/s charging 100 m of range a
/// second. Ids count from 0 in the order of the calls.
class SituationBuilder {
 public:
  SituationBuilder() {
    scenario_.name = "built";
    scenario_.seed = 1;
    scenario_.width_m = scenario_.height_m = 30e3;
  }

  SituationBuilder& Uav(Point at, double range_m = 30e3) {
    AgentSpec spec = Spec(at, 10);
    spec.range_full_m = 30e3;
    spec.range_m = range_m;
    scenario_.uavs.push_back(spec);
    return *this;
  }
  SituationBuilder& Worker(Point at) {
    scenario_.workers.push_back(Spec(at, 5));
    return *this;
  }
  SituationBuilder& Vehicle(Point at) {
    AgentSpec spec = Spec(at, 10);
    spec.charge_rate_m_s = 100;
    scenario_.vehicles.push_back(spec);
    return *this;
  }
  SituationBuilder& Task(Point at, double cost_m = 3000) {
    scenario_.tasks.push_back({at, cost_m});
    return *this;
  }
  SituationBuilder& Charge(Point at, std::optional<int> capacity = 1) {
    scenario_.charging_points.push_back({at, capacity});
    return *this;
  }
  SituationBuilder& Decision(std::int32_t decision) {
    decision_ = decision;
    return *this;
  }
  /// Everything else is free to change before Build.
  Scenario& scenario() { return scenario_; }

  Situation Build() const {
    Situation situation;
    situation.site = std::make_shared<const Site>(scenario_);
    situation.decision = decision_;
    situation.now_us = decision_ * scenario_.rules.interval_us;
    for (const AgentKind kind : kAgentKinds) {
      auto& agents = ByKind(kind, situation.uavs, situation.workers, situation.vehicles);
      std::int32_t id = 0;
      for (const AgentSpec& spec : scenario_.agents(kind)) {
        const AgentState agent = StartOf(kind, id++, spec, *scenario_.ways);
        if (agent.online(situation.now_us)) agents.push_back(agent);
      }
    }
    situation.task_status.assign(scenario_.tasks.size(), TaskStatus::kOpen);
    situation.charging_load.assign(scenario_.charging_points.size(), 0);
    return situation;
  }

 private:
  AgentSpec Spec(Point at, double speed_m_s) const {
    AgentSpec spec;
    spec.at = at;
    spec.speed_m_s = speed_m_s;
    spec.online_until_us = scenario_.rules.limit_us;
    return spec;
  }

  Scenario scenario_;
  std::int32_t decision_ = 0;
};

/// How large a random situation is.
struct RandomSize {
  int uavs = 3;
  int workers = 4;
  int vehicles = 2;
  int tasks = 5;
  int charging_points = 2;
  double area_km = 12;
  bool times = false;  ///< every other task is due or expires within the next 40 min
};

/// A random situation from a seed alone: places on a grid of 1 km (so that distances tie), some
/// agents busy, near their downtime, or of another speed; some UAVs full, some nearly empty; tasks
/// in all states; charging points with 1, 2 or unlimited places, some taken; a random decision.
inline Situation RandomSituation(std::uint64_t seed, const RandomSize& size = {},
                                 const Rules& rules = {}) {
  Random random(seed, Stream::kTest);
  const auto below = [&random](int n) {
    return static_cast<int>(random.Below(static_cast<std::uint32_t>(n)));
  };
  const auto place = [&] {
    const int n = static_cast<int>(size.area_km);
    return Point{(below(n) + 0.5) * 1e3, (below(n) + 0.5) * 1e3};
  };
  SituationBuilder builder;
  builder.scenario().rules = rules;
  builder.scenario().seed = seed;
  builder.scenario().width_m = builder.scenario().height_m = size.area_km * 1e3;
  for (int i = 0; i < size.uavs; ++i) {
    const int energy = below(4);
    // Each draw is a statement: compilers differ in the order of a call's arguments.
    const double range_m = energy == 0 ? 30e3 : energy == 1 ? below(5000) : 30e3 * random.Uniform();
    builder.Uav(place(), range_m);
  }
  for (int i = 0; i < size.workers; ++i) builder.Worker(place());
  for (int i = 0; i < size.vehicles; ++i) builder.Vehicle(place());
  for (int i = 0; i < size.tasks; ++i) {
    const double cost_m = 500.0 * (1 + below(6));
    builder.Task(place(), cost_m);
  }
  for (int i = 0; i < size.charging_points; ++i) {
    const int capacity = below(4);
    builder.Charge(place(), capacity < 2    ? std::optional<int>(1)
                            : capacity == 2 ? std::optional<int>(2)
                                            : std::nullopt);
  }
  const TimeUs now = rules.interval_us * below(builder.scenario().decisions());
  builder.Decision(static_cast<std::int32_t>(now / rules.interval_us));
  if (size.times) {
    Random times(seed, Stream::kTest, 1);
    for (muster::Task& task : builder.scenario().tasks) {
      const TimeUs soon = now + kMinuteUs * static_cast<TimeUs>(1 + times.Below(40));
      task.priority = static_cast<Priority>(times.Below(4));
      if (times.Below(2) == 0) task.expires_us = soon;
      if (times.Below(2) == 0) task.due_us = std::min(soon, task.expires_us);
    }
  }
  const auto vary = [&](std::vector<AgentSpec>& specs) {
    for (AgentSpec& spec : specs) {
      if (below(4) == 0) spec.speed_m_s *= 0.5 + random.Uniform();
      spec.online_until_us = now + kMinuteUs * (5 + below(70));
    }
  };
  vary(builder.scenario().uavs);
  vary(builder.scenario().workers);
  vary(builder.scenario().vehicles);
  Situation situation = builder.Build();
  const auto occupy = [&](std::vector<AgentState>& agents) {
    for (AgentState& agent : agents) {
      if (below(6) != 0) continue;
      agent.to = place();  // under way for another 100 s
      agent.depart_us = now - 100 * kSecondUs;
      agent.arrive_us = agent.busy_until_us = now + 100 * kSecondUs;
      agent.action =
          agent.kind == AgentKind::kVehicle ? ActionKind::kVehicleToCharge : ActionKind::kGoTo;
    }
  };
  occupy(situation.uavs);
  occupy(situation.workers);
  occupy(situation.vehicles);
  for (TaskStatus& status : situation.task_status) {
    if (below(5) == 0) status = static_cast<TaskStatus>(1 + below(3));
  }
  for (std::int32_t& load : situation.charging_load) load = below(5) == 0 ? 1 : 0;
  return situation;
}

}  // namespace muster::scheduler::testing
