#pragma once

#include <string>
#include <vector>

#include "lcmtypes/bus/event_log.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/temporary_folder.h"
#include "tools/explain/decision_log.h"

namespace muster::tools {

/// All packets of a simulated mission.
inline std::vector<Packet> SimulatedPackets(const Scenario& scenario, const std::string& policy) {
  std::vector<Packet> packets;
  Simulate(ScenarioToJson(scenario), policy,
           [&](const Packet& packet) { packets.push_back(packet); });
  return packets;
}

/// What the decisions' reader makes of these packets, written as a log file.
inline DecisionLog Logged(const std::vector<Packet>& packets) {
  const TemporaryFolder folder;
  const std::string path = folder.File("mission.lcm");
  {
    EventLogWriter writer(path);
    for (const Packet& packet : packets) writer.Write(1, packet);
    writer.Flush();
  }
  LogSource source(path);
  return ReadDecisionLog(&source);
}

}  // namespace muster::tools
