#pragma once

#include <set>
#include <string>
#include <vector>

#include "model/scenario.h"
#include "protocol/convert.h"
#include "protocol/process.h"
#include "world/peers.h"
#include "world/referee.h"
#include "world/restoring.h"

namespace muster::world {

struct WorldOptions {
  double rate = 0;        ///< mission seconds per wall second; 0: as fast as it goes
  bool recorded = false;  ///< a recorder takes part: start only when it is there
  /// Without agent processes and scheduler that are silent for lost_after_us, or that do not answer
  /// for three times as long, the mission goes on: their agents count as failed until they are
  /// back, their decisions are not in force. Else it waits for everybody.
  bool goes_on = false;
  TimeUs lost_after_us = 5 * kSecondUs;
  /// Agents that fail by order; `detail` is the fault's id.
  std::vector<Outage> outages = {};
};

/// The world: clock and referee of a mission in lockstep (docs/mission.md). It alone asks again:
/// while it waits, it repeats what the others may lack, and each answers a repeated clock with its
/// answer.
class WorldProcess : public Process {
 public:
  /// `json` is the scenario's file text, published as it is.
  WorldProcess(Identity identity, int window, std::string json, const WorldOptions& options);

  bool ended() const { return phase_ == Phase::kEnded; }

 protected:
  void OnMessage(const Message& message, const Packet& packet, const Now& now) override;
  void OnStep(const Now& now) override;
  TimeUs OwnWakeUs() const override;
  std::int64_t tick() const override { return tick_; }

 private:
  using Phase = ClockPhase;
  enum class Wait { kRestore, kStates, kSchedule, kClock, kLog, kNothing };
  enum class Heard : char { kNot, kYes, kNotAwaited };
  void Take(const agent_states_t& states, const Packet& packet);
  void Take(const schedule_t& schedule, const Packet& packet, const Now& now);
  void Answer(const request_t& request, const Now& now);
  void AskForState(const Now& now);
  bool RestoreState(const Now& now);
  /// An agent whose process was lost before this one started again.
  void RestoreLost(const Restoring::Lost& lost);
  void Begin(const Now& now);
  void PublishClock(const Now& now);
  void Judge(const Now& now);
  void PublishEvents(const Now& now);
  void Repeat();
  void StartTick(const Now& now);
  /// Gives up those whose answer has been due for too long.
  void FindLost(const Now& now);
  void Lose(const std::string& name, const Now& now);
  /// Takes back those returning processes whose agents have all been heard for this tick.
  void TakeBack(const Now& now);
  void SayOfProcess(Event::Kind kind, const std::string& name, const Now& now);
  template <class Visit>
  void ForEachAgentOf(const std::string& owner, Visit visit);
  /// The states that the verdict on judged_tick_ left of the agents of that class that nobody
  /// reported, as messages; for their process when it comes back.
  std::vector<std::vector<std::uint8_t>> StatesOfLost(AgentKind kind, const Now& now) const;
  bool StatesComplete() const { return missing_ == 0; }
  TimeUs tick_us(std::int64_t tick) const { return scenario_.rules.TimeOf(tick); }
  /// The decision due at that tick, -1: none.
  std::int32_t DecisionAt(std::int64_t tick) const { return scenario_.rules.DecisionAt(tick); }
  void WaitFor(Wait wait, const Now& now);

  const std::string json_;
  const Scenario scenario_;
  const WireLimits limits_;
  const WorldOptions options_;
  Referee referee_;

  Phase phase_ = Phase::kReady;
  Wait wait_ = Wait::kStates;
  std::int64_t tick_ = 0;
  std::int64_t last_tick_ = 0;
  std::int64_t judged_tick_ = -1;
  std::int32_t required_decision_ = -1;
  std::int32_t passed_over_ = -1;  ///< a decision that an earlier start did without
  bool recorder_ready_ = false;
  TimeUs started_us_ = 0;

  Agents agents_;                       ///< reports for tick_, then settled
  std::vector<std::string> owners_[3];  ///< [n_agents] who reports that agent; "" not known yet
  std::vector<Heard> heard_[3];         ///< [n_agents] for tick_
  std::vector<agent_t> unreported_[3];  ///< of judged_tick_, after the verdict: nobody said them
  std::size_t missing_ = 0;
  std::set<std::string> members_;  ///< processes whose end is awaited
  /// Agent states by class: those of tick_ so far, and those of the newest judged tick.
  std::vector<Packet> reports_[3], judged_reports_[3];
  SentPacket scenario_packet_, clock_packet_, world_packet_, rulings_packet_;
  SentPacket schedule_packet_;  ///< the decision in force, as the scheduler sent it
  BackOff repeat_{2'000, 40'000};
  Peers peers_;
  std::string scheduler_name_{process_name::kScheduler};
  TimeUs look_us_ = 0;
  std::int32_t judged_applied_ = -1;  ///< decision in force at judged_tick_

  Restoring restoring_;  ///< while this process starts again
};

}  // namespace muster::world
