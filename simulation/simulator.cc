#include "simulation/simulator.h"

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "base/check.h"
#include "protocol/run_process.h"

namespace muster::tools {

void Simulate(const ScenarioText& scenario, const std::string& policy,
              const std::function<void(const Packet&)>& observe, const world::WorldFaults& faults,
              const std::vector<world::PlannedOrder>& orders,
              const simulation::DriversOf& drivers) {
  simulation::ProcessSettings settings;
  settings.scenario = scenario;
  settings.policy = policy;
  settings.stopwatch = MonotonicUs;
  settings.world.faults = faults;
  settings.world.orders = orders;
  settings.drivers = drivers;
  std::vector<std::unique_ptr<Process>> processes;
  for (const std::string& name : simulation::ProcessNames()) {
    processes.push_back(simulation::StartProcess({1, name, 0}, settings));
  }
  const Process& world = *processes.front();

  struct Sent {
    std::size_t by;
    Packet packet;
  };
  std::deque<Sent> queue;
  const Now now;
  std::vector<Packet> out;
  const auto publish = [&](std::size_t by) {
    for (Packet& packet : out) {
      observe(packet);
      queue.push_back({by, std::move(packet)});
    }
    out.clear();
  };
  // Processes that want a turn without a packet: those that begin, and those that wait for drivers.
  const auto wake = [&](bool all) {
    bool any = false;
    for (std::size_t i = 0; i < processes.size(); ++i) {
      if (!all && processes[i]->wake_us() > now.monotonic_us) continue;
      processes[i]->Step({}, now, &out);
      publish(i);
      any = true;
    }
    return any;
  };
  wake(true);
  while (!queue.empty() || wake(false)) {
    if (queue.empty()) continue;
    const Sent sent = std::move(queue.front());
    queue.pop_front();
    const std::optional<Message> message = DecodeMessage(sent.packet);
    for (std::size_t i = 0; i < processes.size(); ++i) {
      if (i == sent.by) continue;
      processes[i]->Step(sent.packet, message, now, &out);
      publish(i);
    }
  }
  MUSTER_CHECK(world.state() == ProcessState::kEnded,
               "nothing is under way and the mission has not ended");
}

}  // namespace muster::tools
