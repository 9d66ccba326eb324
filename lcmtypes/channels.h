#pragma once

#include <cstdint>
#include <string_view>

#include "lcmtypes/words.h"

namespace muster {

/// The part of a process, as its bus knows it. A channel is heard by a set of parts.
enum class Hearer : unsigned { kWorld = 1, kAgents = 2, kScheduler = 4 };

/// The publisher of proposals.
inline constexpr std::string_view kSeveralSchedulers = "each of several schedulers";

/// The channel table: name, type, publisher, how often, largest encoded message that is accepted,
/// and the parts that use it.
struct Channel {
  std::string_view name;
  std::string_view type;
  std::string_view publisher;
  std::string_view rate;
  std::int64_t max_bytes;
  unsigned hearers = 7;  ///< of Hearer; launcher and recorder hear all

  constexpr bool IsHeardBy(Hearer hearer) const {
    return (hearers & static_cast<unsigned>(hearer)) != 0;
  }
  /// Whether that sender may publish on it. Where the publisher is one process, it is that
  /// process's name; any other sender is an intruder.
  constexpr bool AcceptsFrom(std::string_view sender) const {
    const bool one = publisher == process_name::kWorld || publisher == process_name::kScheduler ||
                     publisher == process_name::kRecorder ||
                     publisher == process_name::kSecondMarks;
    if (publisher == kSeveralSchedulers) return process_name::IsOneOfSchedulers(sender);
    // The world publishes what it takes of the proposals of several schedulers.
    const bool relays = publisher == process_name::kScheduler && sender == process_name::kWorld;
    return !one || relays || sender == publisher;
  }
};

namespace channel {
inline constexpr std::string_view kScenario = "MUSTER_SCENARIO";
inline constexpr std::string_view kRoads = "MUSTER_ROADS";
inline constexpr std::string_view kClock = "MUSTER_CLOCK";
inline constexpr std::string_view kWorld = "MUSTER_WORLD";
inline constexpr std::string_view kRulings = "MUSTER_RULINGS";
inline constexpr std::string_view kUavs = "MUSTER_UAVS";
inline constexpr std::string_view kWorkers = "MUSTER_WORKERS";
inline constexpr std::string_view kVehicles = "MUSTER_VEHICLES";
inline constexpr std::string_view kUavChanges = "MUSTER_UAV_CHANGES";
inline constexpr std::string_view kWorkerChanges = "MUSTER_WORKER_CHANGES";
inline constexpr std::string_view kVehicleChanges = "MUSTER_VEHICLE_CHANGES";
inline constexpr std::string_view kSchedule = "MUSTER_SCHEDULE";
inline constexpr std::string_view kClearances = "MUSTER_CLEARANCES";
inline constexpr std::string_view kProposal = "MUSTER_PROPOSAL";
inline constexpr std::string_view kEvent = "MUSTER_EVENT";
inline constexpr std::string_view kDriver = "MUSTER_DRIVER";
inline constexpr std::string_view kFault = "MUSTER_FAULT";
inline constexpr std::string_view kProcess = "MUSTER_PROCESS";
inline constexpr std::string_view kOrder = "MUSTER_ORDER";
inline constexpr std::string_view kOrders = "MUSTER_ORDERS";
inline constexpr std::string_view kLog = "MUSTER_LOG";
inline constexpr std::string_view kCopy = "MUSTER_COPY";
inline constexpr std::string_view kRequest = "MUSTER_REQUEST";
inline constexpr std::string_view kRestore = "MUSTER_RESTORE";
inline constexpr std::string_view kAnswer = "MUSTER_ANSWER";
}  // namespace channel

inline constexpr std::int64_t kMiB = 1 << 20;
inline constexpr unsigned kNobody = 0;
inline constexpr unsigned kWorldAlone = static_cast<unsigned>(Hearer::kWorld);
inline constexpr unsigned kWorldAndScheduler =
    kWorldAlone | static_cast<unsigned>(Hearer::kScheduler);
inline constexpr unsigned kWorldAndAgents = kWorldAlone | static_cast<unsigned>(Hearer::kAgents);
inline constexpr Channel kChannels[] = {
    {channel::kScenario, "scenario_t", process_name::kWorld, "at start, on request", 64 * kMiB},
    {channel::kRoads, "roads_t", process_name::kWorld, "after the scenario that names roads",
     64 * kMiB},
    {channel::kClock, "clock_t", process_name::kWorld, "every tick", 1024},
    {channel::kWorld, "world_state_t", process_name::kWorld, "every tick", 16 * kMiB},
    {channel::kRulings, "rulings_t", process_name::kWorld, "every tick", 4 * kMiB},
    {channel::kUavs, "agent_states_t", "UAV processes", "every tick; large classes less often",
     1 * kMiB, kWorldAndScheduler},
    {channel::kWorkers, "agent_states_t", "worker processes",
     "every tick; large classes less often", 1 * kMiB, kWorldAndScheduler},
    {channel::kVehicles, "agent_states_t", "vehicle processes",
     "every tick; large classes less often", 1 * kMiB, kWorldAndScheduler},
    {channel::kUavChanges, "agent_changes_t", "UAV processes", "all other ticks", 1 * kMiB,
     kWorldAlone},
    {channel::kWorkerChanges, "agent_changes_t", "worker processes", "all other ticks", 1 * kMiB,
     kWorldAlone},
    {channel::kVehicleChanges, "agent_changes_t", "vehicle processes", "all other ticks", 1 * kMiB,
     kWorldAlone},
    {channel::kSchedule, "schedule_t", process_name::kScheduler, "every decision", 16 * kMiB,
     kWorldAndAgents},
    {channel::kClearances, "clearances_t", process_name::kScheduler,
     "before the schedule, in a mission that keeps UAVs apart", 16 * kMiB},
    {channel::kProposal, "proposal_t", kSeveralSchedulers,
     "every decision of a mission with several schedulers", 32 * kMiB, kWorldAlone},
    {channel::kEvent, "event_t", "world, launcher, scheduler", "when it happens", 4096, kNobody},
    {channel::kDriver, "event_t", "processes with drivers", "until the world rules", 4096,
     kWorldAlone},
    {channel::kFault, "fault_t", "fault injector", "when it is due", 4096},
    {channel::kProcess, "process_status_t", "every process", "at start and end, every second",
     4096},
    {channel::kOrder, "order_t", "a sender of orders", "until answered", 64 * 1024, kWorldAlone},
    {channel::kOrders, "orders_t", process_name::kWorld,
     "every tick of a mission that takes orders", 4 * kMiB},
    {channel::kLog, "log_status_t", process_name::kRecorder, "when the log grew", 64 * 1024},
    {channel::kCopy, "log_status_t", process_name::kSecondMarks,
     "when the second log grew; in no log itself", 64 * 1024, kNobody},
    {channel::kRequest, "request_t", "a process that starts again", "until answered", 1024,
     kWorldAndAgents},
    {channel::kRestore, "restore_t", "a process that holds the message", "until version 0.1.0",
     64 * kMiB, kNobody},
    {channel::kAnswer, "answer_t", "a process that holds the message", "when requested", 64 * kMiB},
};

/// Whether agents' processes report on that channel, whole states or changes.
constexpr bool IsReports(std::string_view name) {
  return name == channel::kUavs || name == channel::kWorkers || name == channel::kVehicles ||
         name == channel::kUavChanges || name == channel::kWorkerChanges ||
         name == channel::kVehicleChanges;
}

/// The table's row of that name, or nullptr.
constexpr const Channel* FindChannel(std::string_view name) {
  for (const Channel& row : kChannels) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

}  // namespace muster
