#include "simulation/simulator.h"

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "base/check.h"
#include "protocol/run_process.h"
#include "simulation/start_process.h"

namespace muster::tools {

void Simulate(const std::string& json, const std::string& policy,
              const std::function<void(const Packet&)>& observe,
              const std::vector<world::Outage>& outages,
              const std::vector<world::PlannedOrder>& orders) {
  simulation::ProcessSettings settings;
  settings.scenario_json = json;
  settings.policy = policy;
  settings.stopwatch = MonotonicUs;
  settings.world.outages = outages;
  settings.world.orders = orders;
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
  for (std::size_t i = 0; i < processes.size(); ++i) {
    processes[i]->Step({}, now, &out);
    publish(i);
  }
  while (!queue.empty()) {
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
