#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace muster {

// The wire's words: what the numbers of the types' fields mean, and the names that reports, plans
// and exports use for them. docs/reference/wire.md lists the same. Numbers and names do not change.

/// An agent class: agent_states_t.kind, agent_changes_t.kind, ruling_t.agent_kind.
enum class AgentKind : std::int8_t { kUav = 0, kWorker = 1, kVehicle = 2 };
inline constexpr AgentKind kAgentKinds[] = {AgentKind::kUav, AgentKind::kWorker,
                                            AgentKind::kVehicle};

/// agent_t.status
enum class AgentStatus : std::int8_t {
  kOffline = 0,
  kIdle = 1,
  kMoving = 2,
  kWaiting = 3,  ///< for its partner
  kSensing = 4,
  kCharging = 5,
  kFailed = 6,
  kNotReady = 7,  ///< its driver says that it cannot set out yet
};

/// action_t.kind, agent_t.action: the nine node types of the conflict graph (paper section 4.1.1)
/// and the free move of policies that work by cells. Their names are the paper's symbols.
enum class ActionKind : std::int8_t {
  kNone = -1,            ///< agent_t only
  kUavStays = 0,         ///< Ui
  kWorkerStays = 1,      ///< Wj
  kVehicleStays = 2,     ///< Vk
  kUavToTask = 3,        ///< UiTx
  kWorkerToTask = 4,     ///< WjTx
  kUavToCharge = 5,      ///< UiCy
  kVehicleToCharge = 6,  ///< VkCy
  kSense = 7,            ///< UiTxWj
  kCharge = 8,           ///< UiCyVk
  kGoTo = 9,             ///< one agent goes to a point
};

/// activity_t.kind
enum class ActivityKind : std::int8_t { kSensing = 0, kCharging = 1 };

/// world_state_t.task_status
enum class TaskStatus : std::int8_t {
  kOpen = 0,
  kReserved = 1,  ///< a pair is on its way
  kSensing = 2,
  kDone = 3,
  kUnreported = 4,  ///< not known to the mission yet
  kExpired = 5,     ///< sensing had not begun in time
  kCancelled = 6,   ///< by an order
  kHeld = 7,        ///< by an order, until another one: no agent is sent
};
/// Whether it may still be done, as far as is known.
constexpr bool IsToDo(TaskStatus status) {
  return status == TaskStatus::kOpen || status == TaskStatus::kReserved ||
         status == TaskStatus::kSensing;
}

/// ruling_t.kind
enum class RulingKind : std::int8_t {
  kFailed = 0,    ///< failed at at_us; holds as long as the ruling is listed
  kReleased = 1,  ///< its action ended at at_us without effect
  kLost = 2,      ///< as kFailed, because its process is lost: it returns with that process
};

/// clock_t.phase
enum class ClockPhase : std::int8_t { kReady = 0, kRunning = 1, kEnded = 2 };

/// event_t.kind
enum class EventKind : std::int8_t {
  kAgentOnline = 0,
  kAgentOffline = 1,
  kAgentFailed = 2,
  kAgentBack = 3,
  kSensingStarted = 4,
  kSensingDone = 5,
  kSensingAborted = 6,
  kChargingStarted = 7,
  kChargingDone = 8,
  kChargingAborted = 9,
  kMatchFailed = 10,
  kProcessLost = 11,
  kProcessBack = 12,
  kFaultApplied = 13,
  kFaultEnded = 14,
  kTaskReported = 15,
  kTaskExpired = 16,
  kAnswerRefused = 17,  ///< an outside scheduler's; everybody stays
  // By orders.
  kTaskCancelled = 18,
  kTaskHeld = 19,
  kTaskResumed = 20,
  kTaskChanged = 21,
  kAgentJoined = 22,
  kAgentLeaves = 23,
  kDriverFailed = 24,     ///< what the driver of a measured agent says, or what is wrong with it
  kStateUnknown = 25,     ///< after a restart of the world: a lost process's last state is lost
  kDirectiveUnkept = 26,  ///< the commander's word that a decision could not keep, and why
  kActionWithheld = 27,   ///< a UAV stays, as no altitude is free for what it was to do
  kDecisionsDiffer = 28,  ///< schedulers of a mission do not agree on a decision
  kDriverWaits = 29,      ///< what the driver of an agent that is not ready waits for
  kDriverSays = 30,       ///< a message of a measured agent's driver to people
  kDriverCalls = 31,      ///< the same, which calls for help
};

/// fault_t.kind. Each has a row in protocol/fault_kinds.cc.
enum class FaultKind : std::int8_t {
  kAgentFails = 0,
  kAgentSilent = 1,
  kProcessKilled = 2,
  kProcessStopped = 3,
  kPartition = 4,
  kLoss = 5,
  kDuplication = 6,
  kDelay = 7,
  kReordering = 8,
  kCorruption = 9,
  kDiskFull = 10,
  kForeign = 11,
  kRoadClosed = 12,
  kZoneUnknown = 13,
};

/// process_status_t.state
enum class ProcessState : std::int8_t {
  kStarting = 0,
  kReady = 1,
  kRunning = 2,
  kDegraded = 3,
  kEnded = 4,
  kDeciding = 5,  ///< it runs, and a decision takes it long: alive, though it does not answer
};

/// Whether it happened to agents and tasks, rather than to processes and faults. Outcomes make a
/// mission's digest.
constexpr bool IsOutcome(EventKind kind) {
  return kind <= EventKind::kMatchFailed || kind == EventKind::kTaskReported ||
         kind == EventKind::kTaskExpired ||
         (kind >= EventKind::kTaskCancelled && kind <= EventKind::kAgentLeaves);
}
/// Whether it is what a driver says to people while its agent goes on taking part.
constexpr bool IsOfDriver(EventKind kind) {
  return kind >= EventKind::kDriverWaits && kind <= EventKind::kDriverCalls;
}
/// Whether a report leaves the kind out where nothing of it happened: kinds of few missions.
constexpr bool IsSpecial(EventKind kind) { return kind >= EventKind::kTaskReported; }

/// Names of the processes of which a mission has one. Those of agents are named by their class,
/// "uav", or several "uav-1", "uav-2", ... Several schedulers are named in the same way.
namespace process_name {
inline constexpr const char* kWorld = "world";
inline constexpr const char* kScheduler = "scheduler";
inline constexpr const char* kRecorder = "recorder";
inline constexpr const char* kSecondRecorder = "recorder-2";     ///< with a log of its own
inline constexpr const char* kSecondMarks = "recorder-2-marks";  ///< its word on its log
inline constexpr const char* kLauncher = "launcher";             ///< a sender with --logger muster
inline constexpr const char* kLogger = "lcm-logger";             ///< in a fault's target; no sender

/// Whether it is the name of one of several schedulers.
constexpr bool IsOneOfSchedulers(std::string_view name) { return name.starts_with("scheduler-"); }
constexpr bool IsScheduler(std::string_view name) {
  return name == kScheduler || IsOneOfSchedulers(name);
}
}  // namespace process_name

/// A word's names, in the order of its numbers, which begin at 0.
template <class Word>
inline constexpr std::array<std::string_view, 0> kNames = {};
template <>
inline constexpr std::array<std::string_view, 3> kNames<AgentKind> = {"uav", "worker", "vehicle"};
template <>
inline constexpr std::array<std::string_view, 8> kNames<AgentStatus> = {
    "offline", "idle", "moving", "waiting", "sensing", "charging", "failed", "not_ready"};
template <>
inline constexpr std::array<std::string_view, 10> kNames<ActionKind> = {
    "Ui", "Wj", "Vk", "UiTx", "WjTx", "UiCy", "VkCy", "UiTxWj", "UiCyVk", "go"};
template <>
inline constexpr std::array<std::string_view, 2> kNames<ActivityKind> = {"sensing", "charging"};
template <>
inline constexpr std::array<std::string_view, 8> kNames<TaskStatus> = {
    "open", "reserved", "sensing", "done", "unreported", "expired", "cancelled", "held"};
template <>
inline constexpr std::array<std::string_view, 3> kNames<RulingKind> = {"failed", "released",
                                                                       "lost"};
template <>
inline constexpr std::array<std::string_view, 3> kNames<ClockPhase> = {"ready", "running", "ended"};
template <>
inline constexpr std::array<std::string_view, 32> kNames<EventKind> = {
    "agent_online",  "agent_offline",    "agent_failed",     "agent_back",       "sensing_started",
    "sensing_done",  "sensing_aborted",  "charging_started", "charging_done",    "charging_aborted",
    "match_failed",  "process_lost",     "process_back",     "fault_applied",    "fault_ended",
    "task_reported", "task_expired",     "answer_refused",   "task_cancelled",   "task_held",
    "task_resumed",  "task_changed",     "agent_joined",     "agent_leaves",     "driver_failed",
    "state_unknown", "directive_unkept", "action_withheld",  "decisions_differ", "driver_waits",
    "driver_says",   "driver_calls"};
template <>
inline constexpr std::array<std::string_view, 14> kNames<FaultKind> = {
    "agent_fails", "agent_silent", "process_killed", "process_stopped", "partition",
    "loss",        "duplication",  "delay",          "reordering",      "corruption",
    "disk_full",   "foreign",      "road_closed",    "zone_unknown"};
template <>
inline constexpr std::array<std::string_view, 6> kNames<ProcessState> = {
    "starting", "ready", "running", "degraded", "ended", "deciding"};

template <class T>
concept WireWord = std::is_enum_v<T> && !kNames<T>.empty();

/// As in a message's field.
template <WireWord Word>
constexpr std::int8_t NumberOf(Word word) {
  return static_cast<std::int8_t>(word);
}
/// A field's number may be compared with its word as it stands.
template <std::integral Number, WireWord Word>
constexpr bool operator==(Number number, Word word) {
  return std::cmp_equal(number, NumberOf(word));
}

/// Whether the number is one of the words that have names.
template <WireWord Word>
constexpr bool IsWord(std::int64_t number) {
  return number >= 0 && std::cmp_less(number, kNames<Word>.size());
}

/// The name of a field's number; "unknown" for one that is no word.
template <WireWord Word>
constexpr std::string_view ToString(std::int64_t number) {
  if constexpr (std::is_same_v<Word, ActionKind>) {
    if (number == ActionKind::kNone) return "none";
  }
  return IsWord<Word>(number) ? kNames<Word>[static_cast<std::size_t>(number)] : "unknown";
}
template <WireWord Word>
constexpr std::string_view ToString(Word word) {
  return ToString<Word>(std::int64_t{NumberOf(word)});
}

/// The word of that name, exactly.
template <WireWord Word>
constexpr std::optional<Word> FromString(std::string_view name) {
  for (std::size_t i = 0; i < kNames<Word>.size(); ++i) {
    if (kNames<Word>[i] == name) return static_cast<Word>(i);
  }
  return std::nullopt;
}

/// A name as words of a sentence: "sensing done".
inline std::string Spaced(std::string_view name) {
  std::string words(name);
  for (char& c : words) {
    if (c == '_') c = ' ';
  }
  return words;
}

}  // namespace muster
