#pragma once

#include <functional>
#include <memory>
#include <string>

#include "model/scenario.h"
#include "protocol/mission_reader.h"
#include "tools/log/log_source.h"

namespace muster::tools {

/// What a run's log tells before its messages are looked at one by one.
struct MissionHead {
  std::int64_t run_id = 0;
  Scenario scenario;
  /// Wall time of mission time 0, microseconds since the Unix epoch: that of the first clock_t of
  /// phase 1. 0 for a simulated mission.
  std::int64_t epoch_us = 0;
};

/// Reads a log up to its first clock_t of phase 1. Throws InputError when it has no scenario.
MissionHead ReadMissionHead(MessageSource* source);

/// Visits every message of the mission, as MissionReader does, each with the scenario and the
/// orders so far. Returns the scenario with all of them; null: there is none.
std::shared_ptr<const Scenario> ForEachMessage(
    MessageSource* source, std::int64_t run_id,
    const std::function<void(const Message&, const Packet&, const Scenario&)>& visit);

/// "2024-09-01T12:00:00.250Z"
std::string IsoTime(std::int64_t unix_us);

}  // namespace muster::tools
