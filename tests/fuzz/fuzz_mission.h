#pragma once

#include <memory>
#include <string>
#include <vector>

#include "agents/core/agent_process.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "scheduler/process/scheduler_process.h"
#include "world/world_process.h"

namespace muster::fuzz {

/// A mission so small that all of it is over in some hundred packets.
inline std::string SmallMission() {
  GeneratorSettings settings = PresetByName("Random_10");
  settings.uavs = settings.workers = settings.vehicles = 2;
  settings.tasks = 4;
  settings.charging_points = 2;
  Scenario scenario = Generate(settings, 1);
  scenario.rules.limit_us = 30 * kMinuteUs;
  scenario.rules.interval_us = scenario.rules.tick_us = 10 * kMinuteUs;
  return ScenarioToJson(scenario);
}

inline std::vector<std::unique_ptr<Process>> StartSmallMission(const std::string& json) {
  std::vector<std::unique_ptr<Process>> processes;
  processes.push_back(std::make_unique<world::WorldProcess>(Identity{1, "world", 0}, 0, json,
                                                            world::WorldOptions()));
  for (const AgentKind kind : kAgentKinds) {
    processes.push_back(std::make_unique<agents::AgentProcess>(
        Identity{1, std::string(ToString(kind)), 0}, 0, kind, agents::IdRange()));
  }
  processes.push_back(std::make_unique<scheduler::SchedulerProcess>(
      Identity{1, "scheduler", 0}, 0, "greedy-nearest", [] { return TimeUs{0}; }));
  return processes;
}

/// Packets as a fuzzer's input: per packet the channel's index, two bytes of length (low first),
/// the bytes.
inline void AppendPacket(const Packet& packet, std::string* text) {
  for (std::size_t i = 0; i < std::size(kChannels); ++i) {
    if (kChannels[i].name == packet.channel) *text += static_cast<char>(i);
  }
  *text += static_cast<char>(packet.bytes.size() & 0xff);
  *text += static_cast<char>(packet.bytes.size() >> 8);
  text->append(packet.bytes.begin(), packet.bytes.end());
}

inline std::vector<Packet> ParsePackets(const std::uint8_t* data, std::size_t size) {
  std::vector<Packet> packets;
  std::size_t at = 0;
  while (at + 3 <= size) {
    const Channel& channel = kChannels[data[at] % std::size(kChannels)];
    const std::size_t length =
        std::min(size - at - 3, data[at + 1] + static_cast<std::size_t>(data[at + 2]) * 256);
    at += 3;
    packets.push_back({std::string(channel.name), {data + at, data + at + length}});
    at += length;
  }
  return packets;
}

}  // namespace muster::fuzz
