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
  std::vector<world::PlannedOrder> orders;
  const std::uint32_t n = 10 + random.Below(40);
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto place = [&] {
      return fmt::format(R"("x_km": {:.3f}, "y_km": {:.3f})", random.Uniform() * 12.2,
                         random.Uniform() * 12);
    };
    const std::uint32_t task = random.Below(30);
    const char* const kinds[] = {"uav", "worker", "vehicle"};
    const std::string kind = kinds[random.Below(3)];
    std::string body;
    switch (random.Below(8)) {
      case 0:
      case 1:
      case 2:
        body =
            fmt::format(R"("order": "task_add", "task": {{{}, "priority": {}, "cost_km": {:.1f})",
                        place(), random.Below(4), 1 + 2 * random.Uniform());
        if (random.Below(2) == 0) body += fmt::format(R"(, "due_in_min": {})", random.Below(40));
        if (random.Below(3) == 0) {
          body += fmt::format(R"(, "expires_in_min": {})", 40 + random.Below(30));
        }
        if (random.Below(3) == 0) body += fmt::format(R"(, "reported_min": {})", random.Below(90));
        body += "}";
        break;
      case 3:
        body = fmt::format(R"("order": "task_cancel", "task": {})", task);
        break;
      case 4:
        body = fmt::format(R"("order": "task_{}", "task": {})",
                           random.Below(2) == 0 ? "hold" : "resume", task);
        break;
      case 5:
        body = fmt::format(
            R"("order": "task_change", "task": {}, "priority": {}{})", task, random.Below(4),
            random.Below(2) == 0 ? fmt::format(R"(, "expires_in_min": {})", 1 + random.Below(30))
                                 : "");
        break;
      case 6:
        body = fmt::format(
            R"("order": "agent_join", "class": "{}", "agent": {{{}, "speed_km_per_min": 0.8{}}})",
            kind, place(),
            kind == "uav"       ? R"(, "full_range_km": 20)"
            : kind == "vehicle" ? R"(, "charge_km_per_min": 8)"
                                : "");
        break;
      default:
        body = fmt::format(R"("order": "agent_{}", "agent": "{}:{}")",
                           random.Below(2) == 0 ? "leave" : "recall", kind, random.Below(8));
    }
    const TimeUs at_us = kMinuteUs * TimeUs{random.Below(100)};
    const std::string json = fmt::format(R"({{"at_min": {}, {}}})", at_us / kMinuteUs, body);
    world::PlannedOrder planned{ParseOrder(json, "order"), json};
    planned.order.id = fmt::format("o{}", i);
    planned.order.issuer = "test";
    orders.push_back(std::move(planned));
  }
  return orders;
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
