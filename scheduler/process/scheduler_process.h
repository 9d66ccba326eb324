#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/follower.h"
#include "scheduler/fusion.h"
#include "scheduler/policies/registry.h"

namespace muster::scheduler {

/// Monotonic time in microseconds, for reports of how long a decision took; the pure core gets it
/// as an argument since only the edge may look at a clock.
using Stopwatch = TimeUs (*)();

/// The scheduler in lockstep (docs/reference/mission.md): on a decision tick it fuses what it
/// heard, decides and publishes; when the clock is repeated it publishes the same again. It keeps
/// nothing that it could not make again or ask for. One of several, as its name says, publishes
/// proposals (docs/reference/schedulers.md).
class SchedulerProcess : public Follower {
 public:
  /// `policy_name` is what its decisions bear.
  SchedulerProcess(const Identity& identity, int window, std::string policy_name,
                   std::unique_ptr<Policy> policy, Stopwatch stopwatch);
  /// One of our policies. deadline_ms: of each decision, see MakePolicy; none: decisions can be
  /// repeated.
  SchedulerProcess(const Identity& identity, int window, const std::string& policy,
                   Stopwatch stopwatch, std::optional<double> deadline_ms = {});

 protected:
  void OnScenario() override;
  void OnMissionMessage(const Message& message, const Packet& packet, const Now& now) override;
  void OnMissionStep(const Now& now) override;
  std::int64_t tick() const override { return tick_; }

 private:
  void Take(const clock_t& clock);
  void Take(const clearances_t& clearances);
  /// Altitudes or reports that it has asked for.
  void Take(const answer_t& answer);
  /// Whether what is reported counts for a decision.
  bool Collects() const;
  /// Whether it knows the altitudes that the decision rests on, if UAVs are kept apart.
  bool HasClearances() const;
  void Decide(const Now& now);
  /// What is to be told of a decision.
  std::vector<event_t> EventsOf(const Decision& decision);
  event_t MakeEvent(EventKind kind) const;
  void Publish(schedule_t schedule, std::optional<clearances_t> clearances,
               std::vector<event_t> events, const Now& now);

  const std::string policy_name_;
  const std::unique_ptr<Policy> policy_;
  const Stopwatch stopwatch_;
  std::optional<Fusion> fusion_;
  std::int64_t world_boot_ = 0;  ///< start of the world that goes on
  int outdated_ = 0;             ///< clocks in a row of earlier starts of the world
  std::int64_t tick_ = -1;       ///< of its newest clock
  TimeUs tick_us_ = 0;
  std::int32_t in_force_ = -1;     ///< decision in force at tick_
  std::int32_t named_ = -1;        ///< decision that the last clock of tick_ named
  std::int32_t due_ = -1;          ///< decision to make at tick_; -1: none, or made
  std::int64_t repeat_tick_ = -1;  ///< of a clock heard again; -1: none
  int n_repeats_ = 0;              ///< so often while it collects for a decision
  SentPacket schedule_packet_;     ///< the newest, or the newest proposal
  SentPacket clearances_packet_;   ///< that goes with it; null: none does, or it is in the proposal
  std::map<std::int32_t, clearances_t> clearances_;  ///< the newest, by decision
  std::int64_t schedule_tick_ = -1;
  std::vector<std::string> unkept_;  ///< directives, as the last decision says
};

}  // namespace muster::scheduler
