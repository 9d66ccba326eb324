#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "model/scenario.h"
#include "model/scenario_json.h"
#include "protocol/agent_changes.h"
#include "protocol/convert.h"
#include "protocol/process.h"
#include "world/answer_time.h"
#include "world/attendance.h"
#include "world/ballot.h"
#include "world/driver_words.h"
#include "world/handover.h"
#include "world/hidden_closures.h"
#include "world/mission_clock.h"
#include "world/order_desk.h"
#include "world/referee.h"
#include "world/restoring.h"

namespace muster::world {

/// With more, each decision would be much the same proposal many times over.
inline constexpr int kMostSchedulers = 9;

/// "scheduler", or the names of several.
std::set<std::string> SchedulerNames(int schedulers);

struct WorldOptions {
  double rate = 0;        ///< mission seconds per wall second; 0: as fast as it goes
  bool recorded = false;  ///< a recorder takes part: start only when it is there
  /// How many decide. Several are named scheduler-1, scheduler-2, ..., and the world takes one of
  /// their proposals for each decision.
  int schedulers = 1;
  /// true: the mission goes on without an agent process or scheduler that is silent for
  /// lost_after_us, or does not answer for three times as long. Until it is back, its agents count
  /// as failed, or no decision is in force. false: the mission waits for every process.
  bool goes_on = false;
  TimeUs lost_after_us = 5 * kSecondUs;
  WorldFaults faults = {};
  /// Orders that are known before the mission begins.
  std::vector<PlannedOrder> orders = {};
};

/// The world: clock and referee of a mission in lockstep (docs/reference/mission.md). No other
/// process repeats a question: while the world waits, it repeats what the others may have missed,
/// and each of them answers a repeated clock.
class WorldProcess : public Process {
 public:
  /// `text` is published as it is.
  WorldProcess(const Identity& identity, Window window, ScenarioText text,
               const WorldOptions& options);

  bool ended() const { return clock_.phase() == MissionClock::Phase::kEnded; }

 protected:
  void OnMessage(const Message& message, const Packet& packet, const Now& now) override;
  void OnStep(const Now& now) override;
  TimeUs OwnWakeUs() const override;
  std::int64_t tick() const override { return clock_.tick(); }

 private:
  enum class Wait { kRestore, kStates, kSchedule, kClock, kLog, kNothing };
  using Phase = MissionClock::Phase;
  /// `packet`: the message itself; null: it came as changes.
  void Take(const agent_states_t& states, const Packet* packet);
  void Take(const agent_changes_t& changes, const Packet& packet);
  void Take(const answer_t& answer);
  /// Whether its driver has said that it has failed, and no verdict has said so yet.
  bool SaysToFail(const AgentState& agent) const;
  /// Takes a report's state. A failure that a driver reports is judged like any other.
  void TakeIn(AgentState agent);
  bool IsForTick(std::int64_t tick) const;
  void Take(const schedule_t& schedule, const Packet& packet, const Now& now);
  void Take(const clearances_t& clearances, const Packet& packet);
  void Take(const proposal_t& proposal, const Now& now);
  bool IsSound(const proposal_t& proposal, const Now& now) const;
  /// Takes one of the proposals, if it is time, and publishes it as the decision.
  void CloseBallot(const Now& now);
  void SayOfDispute(const std::string& dispute, const Now& now);
  /// What the schedule commands; none: it is impossible.
  std::optional<std::vector<Action>> ActionsOf(const schedule_t& schedule) const;
  void PutInForce(std::int32_t decision, std::vector<Action> actions, const Now& now);
  void Answer(const request_t& request, const Now& now);
  void AskForState(const Now& now);
  bool RestoreState(const Now& now);
  /// An agent whose process was lost before this one started again.
  void RestoreLost(const Restoring::Lost& lost);
  void TellScenario(const Now& now);
  void TellScenarioAgain();
  void Begin(const Now& now);
  /// Takes those steps of the lockstep that need no further input; if there is none, asks again for
  /// the input.
  void GoOn(const Now& now);
  void StartTick(const Now& now);
  void PublishClock(const Now& now);
  /// In a mission that takes orders: takes those that are there, and publishes them.
  void TakeOrders(const Now& now);
  /// Closes by order the roads of which it becomes known at the tick that they are closed.
  void FindClosures();
  /// Confirms the faults that close roads, or make a zone, or end since the last tick.
  void SayOfClosures(const Now& now);
  void Judge(const Now& now);
  void PublishEvents(const Now& now);
  void Repeat(const Now& now);
  /// Gives up processes whose answer has been due for too long.
  void FindLost(const Now& now);
  /// Whether the log holds the mission up: nothing reaches it, or no recorder reports that it does.
  bool LogHolds(const Now& now) const;
  void Lose(const std::string& name, const Now& now);
  void SayOfProcess(Event::Kind kind, const std::string& name, const Now& now);
  void WaitFor(Wait wait, const Now& now);
  /// How long it takes until all processes have sent whole states.
  TimeUs AllWholeUs() const;
  void StopWaiting();

  const ScenarioText text_;
  OrderDesk desk_;
  const Scenario& scenario_;  ///< with the orders taken so far
  const WireLimits limits_;
  const WorldOptions options_;
  Referee referee_;
  MissionClock clock_;
  Attendance attendance_;
  Handover handover_;
  Restoring restoring_;  ///< while this process starts again

  Wait wait_ = Wait::kStates;
  bool recorder_ready_ = false;
  TimeUs recorder_heard_us_ = 0;
  Agents agents_;  ///< reports for the tick, then settled
  PerKind<ToldAgents> told_;
  DriverWords driver_words_;
  bool has_news_ = false;  ///< somebody has reported since the last step
  PerKind<bool>
      base_lacks_{};  ///< changes for the tick rest on states that this process has not heard
  SentPacket scenario_packet_, roads_packet_, clock_packet_, world_packet_, rulings_packet_;
  SentPacket orders_packet_;                    ///< of the tick
  std::map<std::int64_t, SentPacket> answers_;  ///< to orders, by tick
  SentPacket schedule_packet_;                  ///< the decision in force, as the scheduler sent it
  /// What goes with it, if UAVs are kept apart, and whose it is; that of the next decision may have
  /// come already.
  SentPacket clearances_packet_, next_clearances_packet_;
  std::int32_t clearances_decision_ = -1, next_clearances_decision_ = -1;
  BackOff repeat_;
  AnswerTime states_time_, schedule_time_;
  TimeUs asked_us_ = 0;              ///< since when it waits for the present answer
  std::int64_t schedule_tick_ = -1;  ///< of schedule_packet_
  const std::set<std::string> schedulers_;
  Ballot ballot_;  ///< of several schedulers
  TimeUs look_us_ = 0;
  std::vector<Action> commanded_;  ///< by schedule_packet_
};

}  // namespace muster::world
