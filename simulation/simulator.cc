#include "simulation/simulator.h"

#include <deque>
#include <memory>
#include <vector>

#include "agents/core/agent_process.h"
#include "base/check.h"
#include "protocol/run_process.h"
#include "scheduler/process/scheduler_process.h"
#include "world/world_process.h"

namespace muster::tools {

void Simulate(const std::string& json, const std::string& policy,
              const std::function<void(const Packet&)>& observe) {
  const auto identity = [](const char* name) { return Identity{1, name, 0}; };
  std::vector<std::unique_ptr<Process>> processes;
  auto world =
      std::make_unique<world::WorldProcess>(identity("world"), 0, json, world::WorldOptions());
  const world::WorldProcess& clock = *world;
  processes.push_back(std::move(world));
  for (const AgentKind kind : kAgentKinds) {
    processes.push_back(std::make_unique<agents::AgentProcess>(
        identity(std::string(ToString(kind)).c_str()), 0, kind, agents::IdRange()));
  }
  processes.push_back(
      std::make_unique<scheduler::SchedulerProcess>(identity("scheduler"), 0, policy, MonotonicUs));

  struct Sent {
    std::size_t by;
    Packet packet;
  };
  std::deque<Sent> queue;
  const Now now;
  std::vector<Packet> out;
  const auto step = [&](std::size_t i, const std::vector<Packet>& arrived) {
    processes[i]->Step(arrived, now, &out);
    for (Packet& packet : out) {
      observe(packet);
      queue.push_back({i, std::move(packet)});
    }
    out.clear();
  };
  for (std::size_t i = 0; i < processes.size(); ++i) step(i, {});
  while (!queue.empty()) {
    const Sent sent = std::move(queue.front());
    queue.pop_front();
    for (std::size_t i = 0; i < processes.size(); ++i) {
      if (i != sent.by) step(i, {sent.packet});
    }
  }
  MUSTER_CHECK(clock.ended(), "nothing is under way and the mission has not ended");
}

}  // namespace muster::tools
