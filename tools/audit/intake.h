#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/interval_set.h"
#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/codec.h"
#include "tools/audit/audit_scenario.h"
#include "tools/audit/findings.h"

namespace muster::tools::audit {

/// What a process says of an agent at a tick.
struct Report {
  std::int64_t tick = 0;
  int kind = kUav;
  agent_t agent;                ///< not listed: nothing but its id
  std::int64_t base_tick = -1;  ///< not listed: it goes on as told for that; -1: listed
  std::int32_t applied_decision = -1;
  std::string sender;
  std::int64_t boot_id = 0;
};

/// What the log says of a tick.
struct TickFacts {
  std::optional<clock_t> clock;
  std::optional<world_state_t> world;
  std::optional<rulings_t> rulings;
  std::optional<orders_t> orders;  ///< of the latest start of the world
  std::vector<std::optional<Report>> reports[3];
  /// What later starts of an agent's process said of the tick, by class and id. The log may have it
  /// after the world's verdict on it.
  std::map<std::pair<int, int>, std::vector<Report>> again;
};

/// What the log says beside its ticks.
struct Heard {
  std::optional<Scenario> scenario;
  std::string sha256;
  std::int64_t messages = 0, duplicates = 0;
  std::int64_t undecodable = 0;  ///< packets on our channels that are no valid message
  std::map<std::int32_t, schedule_t> schedules;
  std::map<std::int32_t, clearances_t> clearances;
  /// What several schedulers proposed: digests, by decision and scheduler.
  std::map<std::int32_t, std::map<std::string, std::set<std::size_t>>> proposals;
  std::vector<event_t> events;  ///< after Intake::Finish() sorted and without repeats
  std::string clock_sender;     ///< which process sends the clock
};

/// Hash of a decision without headers and the time that it took; `clearances`: null where UAVs are
/// not kept apart.
std::size_t DecisionHash(schedule_t schedule, const clearances_t* clearances);

/// Takes the messages of a log, each once, and puts together what they say of each tick. A tick is
/// dropped when it has been checked.
class Intake {
 public:
  explicit Intake(Findings* findings) : findings_(findings) {}

  /// The scenario's message comes first.
  void Take(const Packet& packet);
  /// The next tick, if everything that it needs is here; else null. If too many ticks wait for an
  /// earlier one, that is a violation and ends the audit.
  const TickFacts* Next();
  /// The schedule of the decision due at the next tick; null: none is, or the world went on without
  /// it, as the scheduler was lost.
  const schedule_t* ScheduleOfNext() const;
  /// The altitudes that go with it; null: UAVs are not kept apart.
  const clearances_t* ClearancesOfNext() const;
  /// The next tick has been checked.
  void Drop();
  /// No further tick is wanted.
  void Stop();
  /// To call after the last packet: ticks, ends and numbers that are missing are violations.
  void Finish();

  const Heard& heard() const { return heard_; }
  std::int64_t next_tick() const { return next_tick_; }
  /// The scenario is there and names roads, which are not.
  bool waits_for_roads() const { return waits_for_roads_.has_value(); }
  bool stopped() const { return stopped_; }
  /// After Finish: the log ends before the mission's end, and holds nothing of later ticks.
  bool breaks_off() const { return breaks_off_; }
  /// Reports of ticks that have been checked: a lost process that is back says where it stood.
  std::vector<Report> TakeLate() { return std::exchange(late_, {}); }

 private:
  struct Sender {
    IntervalSet seqs;
    std::int64_t last_sim_us = 0;
  };
  using MessageKey = std::tuple<std::string, std::int64_t, std::int64_t>;  // sender, start, seq

  template <class Message>
  std::optional<Message> Admit(const Packet& packet);
  void TakeScenario(const scenario_t& message);
  void TakeRoads(const roads_t& message);
  void TakeStates(const agent_states_t& message, int kind);
  void TakeChanges(const agent_changes_t& message, int kind);
  void TakeReport(const Report& report, TickFacts* facts);
  /// Whether a report of that class and tick is possible on the channel of class `kind`.
  bool CanReport(int said, int kind, std::int64_t tick, TickFacts** facts);
  void TakeClearances(const clearances_t& message);
  void TakeOrders(orders_t message);
  bool HasOrders(std::int64_t tick) const;
  /// Whether that decision is made at that tick, as far as it is known.
  bool IsDue(std::int32_t decision, std::int64_t tick) const;
  void TakeSchedule(const schedule_t& message);
  /// Null if the tick is impossible or has been checked.
  TickFacts* FactsOf(std::int64_t tick);
  bool Complete(const TickFacts& facts) const;
  /// Whether the clock after the next tick requires the decision due at it; none: that is not known
  /// yet.
  std::optional<bool> InForce() const;
  std::string WhatIsMissing() const;

  Findings* findings_;
  Heard heard_;
  std::optional<scenario_t> waits_for_roads_;
  std::optional<roads_t> roads_;
  std::optional<std::int64_t> run_id_;
  std::map<std::pair<std::string, std::int64_t>, Sender> senders_;
  std::map<MessageKey, std::size_t> recent_;
  std::deque<MessageKey> recent_order_;
  std::map<std::int64_t, TickFacts> pending_;
  std::vector<Report> late_;
  /// By tick whose orders have not been read.
  std::map<std::int64_t, std::pair<std::vector<schedule_t>, std::vector<clearances_t>>> early_;
  std::int64_t next_tick_ = 0, now_us_ = 0;
  bool stopped_ = false, ended_ = false, breaks_off_ = false;
};

}  // namespace muster::tools::audit
