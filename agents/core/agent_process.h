#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "agents/core/driver_port.h"
#include "model/scenario.h"
#include "protocol/agent_changes.h"
#include "protocol/convert.h"
#include "protocol/follower.h"

namespace muster::agents {

/// First and last id, both included; none: all agents of the class.
using IdRange = std::optional<std::pair<std::int32_t, std::int32_t>>;

/// Some or all agents of one class in lockstep (docs/reference/mission.md). It advances when it
/// holds the clock, the world's verdict on its present tick and the decision that must be in force,
/// publishes its states, or what of them has changed, and publishes them again when the clock is
/// repeated.
class AgentProcess : public Follower {
 public:
  /// A class of up to `most_whole` agents always sends whole states, which are one message and need
  /// no other message to be read. What counts is the size of the class, not of the process's share.
  /// `drivers` speak for measured agents; null: all agents are computed.
  AgentProcess(const Identity& identity, int window, AgentKind kind, IdRange ids,
               std::size_t most_whole = kMostWhole, std::unique_ptr<DriverPort> drivers = nullptr);
  static constexpr std::size_t kMostWhole = 256;

 protected:
  void OnScenario() override;
  void OnMissionMessage(const Message& message, const Packet& packet, const Now& now) override;
  void OnMissionStep(const Now& now) override;
  TimeUs OwnWakeUs() const override { return std::min(Follower::OwnWakeUs(), listen_us_); }
  std::int64_t tick() const override { return tick_; }

 private:
  AgentState& Agent(std::int32_t id) {
    return agents_[static_cast<std::size_t>(id - agents_.front().id)];
  }
  void BeginDriving();
  /// Tells drivers what has become of their agents, and the time of the present tick.
  void TellDrivers(TimeUs before);
  /// Listens to the drivers, and reports the present tick when none has to be waited for any more.
  void HearDrivers(const Now& now);
  void ApplyReports();
  /// Publishes why agents cannot go on, until the world has ruled that they have failed.
  /// What drivers have said that the mission should know in words.
  void SayOfDrivers(const Now& now);
  void SayOfDriver(EventKind kind, std::int32_t id, const std::string& words, const Now& now);
  void ReportTick(const Now& now);
  void Take(const clock_t& clock);
  void Take(const world_state_t& world);
  void Take(const rulings_t& rulings);
  void Take(const schedule_t& schedule);
  void Take(const clearances_t& clearances, const Packet& packet);
  void Take(const answer_t& answer);
  void TakeGoals(const schedule_t& schedule);
  void GoOn();
  /// The world is not ahead after all: the message that said so was damaged or forged.
  void TrustOwnStates();
  void Answer(const request_t& request, const Now& now);
  bool CanAdvance() const;
  void Advance(const Now& now);
  /// Whether it needs the altitudes of a decision to carry it out.
  bool NeedsClearances() const;
  void Apply(const std::vector<Action>& actions, std::int32_t decision, TimeUs t);
  /// What agents do by themselves at tick_, as that decision is not in force.
  void ActAlone(std::int32_t decision);
  /// How much later than at t an agent of ours sets out on what it is sent to do.
  TimeUs HoldOf(std::int32_t id, TimeUs t) const;
  /// Whether whole states have to be sent at tick_.
  bool SpeaksWhole() const;
  void Publish(std::vector<agent_t> wires, bool whole, const Now& now);

  const AgentKind kind_;
  const IdRange ids_;
  const std::size_t most_whole_;
  const std::unique_ptr<DriverPort> drivers_;
  std::vector<AgentState> agents_;
  std::vector<std::int32_t> driven_;              ///< ids
  std::map<std::int32_t, std::string> failures_;  ///< what drivers have said, by agent
  /// What drivers of agents that are not ready wait for, by agent, as far as it is not said yet.
  std::map<std::int32_t, std::string> unsaid_waits_;
  bool is_driving_ = false;
  bool awaits_drivers_ = false;  ///< the present tick is not reported yet
  TimeUs listen_us_ = kNever;    ///< monotonic: when drivers are heard again

  std::int64_t tick_ = -1;  ///< of the published states
  TimeUs tick_us_ = 0;
  std::int32_t applied_decision_ = -1;
  bool restored_ = false;                 ///< has a state to go on from
  std::int64_t lacks_orders_of_ = -1;     ///< tick of a state that needs orders which are missing
  std::int64_t restore_from_ = 0;         ///< an older tick's state is not enough
  std::set<std::int32_t> still_unknown_;  ///< ids not restored yet
  std::vector<agent_t> restored_states_;  ///< to be published again
  /// Ids of agents on a free move: a report tells its goal only up to rounding, the schedule
  /// exactly.
  std::set<std::int32_t> goalless_;
  TimeUs goals_asked_us_ = kNever;  ///< monotonic

  /// What was published for one tick. The last two are kept, because a world that starts again may
  /// ask for the earlier one.
  struct Published {
    std::int64_t tick = -1;
    std::vector<SentPacket> words;  ///< why driven agents cannot go on, or set out yet
    std::vector<SentPacket> packets;
    /// If the packets are changes: the whole states, with the header of the first packet.
    std::optional<agent_states_t> states;
  };
  void Answer(const request_t& request, const Published& published, const Now& now);
  void Resend(const Published& published);
  Published published_, published_before_;
  std::optional<ToldAgents> told_;  ///< what the receivers know
  bool says_whole_ = false;         ///< the next time: a receiver may lack them
  /// The verdict that led to tick_, for a world that starts again.
  struct Consumed {
    std::int64_t tick = -1;
    Packet world, rulings;
  };
  Consumed consumed_;
  Packet world_packet_, rulings_packet_;  ///< of the verdict on tick_

  std::optional<clock_t> clock_;                     ///< newest
  std::int64_t repeat_tick_ = -1;                    ///< of a clock heard again; -1: none
  std::optional<std::vector<Activity>> activities_;  ///< of the verdict on tick_
  std::int64_t verdict_boot_ = 0;                    ///< of the world that gave it
  int outdated_verdicts_ = 0;                        ///< the same tick's, of earlier starts of it
  std::optional<std::vector<Ruling>> rulings_;       ///< of the verdict on tick_
  std::optional<std::vector<Action>> schedule_;      ///< of the decision made at tick_
  std::int32_t schedule_decision_ = -1;
  std::map<std::int32_t, Clearance> clearances_;  ///< by UAV, the newest
  std::int32_t clearances_decision_ = -1;         ///< whose they are
  /// The same as it came, and the one before, for a scheduler that starts again.
  std::map<std::int32_t, Packet> clearances_packets_;
};

}  // namespace muster::agents
