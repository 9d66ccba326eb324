#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <vector>

#include "base/random.h"
#include "lcmtypes/bus/event_log.h"
#include "model/generator.h"
#include "tools/explain/decision_log.h"
#include "tools/faults/fault_plan.h"
#include "tools/trials/draws.h"
#include "world/planned_orders.h"

namespace muster::tools {

/// Small missions with room, revisits and disturbances.
inline Scenario Draw(std::uint64_t seed) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.width_km = settings.height_km = 12;
  settings.uavs = 6;
  settings.workers = 9;
  settings.vehicles = 4;
  settings.tasks = 15;
  settings.charging_points = 4;
  settings.rules.limit_us = 100 * kMinuteUs;
  if (seed % 2 == 1) settings.rules.availability = Availability::kOverrun;
  if (seed % 3 == 1) settings.disturbances = {{0.1, 0.5}, {100, 900}, {0.005, 0.02}, {0.05, 0.2}};
  if (seed % 5 == 1) settings.rules.tick_us = 10 * kSecondUs;
  Scenario scenario = Generate(settings, seed);
  if (seed % 4 == 0) {
    for (Task& task : scenario.tasks) task.revisit_us = 25 * kMinuteUs;
  }
  AddRoom({seed % 4 == 0 ? 60u : 25u, {3, 3, 3}}, &scenario);
  return scenario;
}

/// Of all kinds, possible or not.
inline std::vector<world::PlannedOrder> DrawOrders(std::uint64_t seed) {
  Random random(seed, Stream::kTest, 7);
  return DrawTaskOrders(Draw(seed), &random);
}

/// Packets in memory, as a log.
class Packets : public MessageSource {
 public:
  std::vector<Packet> all;
  void Rewind() override { next_ = 0; }
  std::optional<LogEvent> NextEvent() override {
    if (next_ == all.size()) return {};
    LogEvent event;
    event.packet = all[next_++];
    return event;
  }
  std::string name() const override { return "packets"; }

 private:
  std::size_t next_ = 0;
};

inline const char* PolicyOf(std::uint64_t seed) {
  constexpr const char* kPolicies[] = {"mpq", "kwta", "horizon", "greedy-nearest", "rollout"};
  return kPolicies[seed % 5];
}

/// Processes die and stand still.
inline FaultPlan DrawFaults(std::uint64_t seed) {
  FaultPlan faults;
  Random random(seed, Stream::kTest, 9);
  const char* const names[] = {"world", "uav", "worker", "vehicle", "scheduler"};
  for (int i = 0; i < 4; ++i) {
    PlannedFault& fault = faults.emplace_back();
    fault.id = fmt::format("f{}", i);
    fault.kind = random.Below(3) == 0 ? FaultKind::kProcessStopped : FaultKind::kProcessKilled;
    fault.target = i == 0 ? "world" : names[random.Below(5)];
    fault.at_us = kMinuteUs * TimeUs{5 + random.Below(90)};
    if (fault.kind == FaultKind::kProcessStopped) fault.for_real_us = kSecondUs / 5;
  }
  return faults;
}

}  // namespace muster::tools
