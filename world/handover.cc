#include "world/handover.h"

#include <utility>

#include "lcmtypes/bus/codec.h"

namespace muster::world {

void Handover::Judge(std::int64_t tick, TimeUs sim_us, std::int32_t applied) {
  tick_ = tick;
  sim_us_ = sim_us;
  applied_ = applied;
  judged_ = std::exchange(reports_, {});
  judged_told_ = std::exchange(told_, {});
  unreported_ = {};
}

std::vector<std::vector<std::uint8_t>> Handover::StatesOf(AgentKind kind, const Identity& world,
                                                          const Now& now) const {
  std::vector<std::vector<std::uint8_t>> messages;
  if (tick_ < 0) return messages;
  for (const Packet& packet : judged_[kind]) messages.push_back(packet.bytes);
  for (const agent_states_t& told : judged_told_[kind]) {
    for (const agent_states_t& part : PartsOf(told)) messages.push_back(Encode(part));
  }
  for (agent_states_t& states : StatesMessages(kind, tick_, applied_, unreported_[kind])) {
    states.header.run_id = world.run_id;
    states.header.sender = world.name;
    states.header.boot_id = world.boot_id;
    states.header.sim_us = sim_us_;
    states.header.wall_us = now.wall_us;
    messages.push_back(Encode(states));
  }
  return messages;
}

}  // namespace muster::world
