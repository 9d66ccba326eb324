#pragma once

#include <cstdint>
#include <map>
#include <muster/answer_t.hpp>
#include <muster/order_book_t.hpp>
#include <muster/rulings_t.hpp>
#include <muster/world_state_t.hpp>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "model/scenario.h"
#include "protocol/convert.h"

namespace muster::world {

/// Gathers what the other processes still know of a mission, for a world that starts again.
class Restoring {
 public:
  /// `scenario` must outlive this object.
  Restoring(const Scenario& scenario, std::int64_t run_id);

  /// Takes one answer; false: it is not a possible message of this mission.
  [[nodiscard]] bool Take(const answer_t& answer);

  /// An agent without which the mission went on, as the verdicts since its last report leave it.
  struct Lost {
    AgentState agent;
    TimeUs from_us = 0;
    bool returns = false;  ///< its process has reported it again, for `tick`
  };
  struct State {
    std::int64_t tick = 0;  ///< to go on with; 0: from the beginning, there is no verdict yet
    std::int32_t applied_decision = -1;
    /// The decision in force one tick later, if a report says so: that due at `tick` may have been
    /// skipped.
    std::optional<std::int32_t> next_decision;
    /// The verdict on the tick before.
    std::vector<TaskStatus> task_status;
    Verdict verdict;
    std::vector<Packet> reports;  ///< those of the states at `tick`
    std::vector<Lost> lost;
    bool is_certain = true;  ///< false: an agent's last report, or that of `tick`, may still come
    std::set<std::string> given_up;  ///< processes with agents of Gap::kAccept
  };
  /// The newest tick at which the states of all agents are known; none: something is still missing.
  std::optional<State> Newest() const;
  /// What to do with a lost agent if no living process has heard its last ticks.
  enum class Gap {
    kWait,    ///< another process may still answer
    kAccept,  ///< it stands where it was last heard of
  };
  /// The same for a mission that goes on without lost processes. In lockstep, a process that is
  /// waited for is at most one tick behind the others, and never behind a verdict.
  std::optional<State> NewestWithoutLost(Gap gap = Gap::kWait) const;
  /// The longest book of orders in any answer; none: no process has one.
  const std::optional<order_book_t>& book() const { return book_; }
  /// The process that has reported the agent; "": none yet.
  const std::string& OwnerOf(AgentKind kind, std::int32_t id) const {
    return told_[kind][static_cast<std::size_t>(id)].owner;
  }

 private:
  struct Told {
    std::map<std::int64_t, AgentState> states;  ///< by tick
    std::string owner;                          ///< of the newest
    std::int64_t newest() const { return states.empty() ? -1 : states.rbegin()->first; }
  };
  using Verdicts = std::map<std::int64_t, Verdict>;  ///< by tick

  bool IsTick(std::int64_t tick) const { return tick >= 0 && tick <= scenario_.rules.last_tick(); }
  std::optional<State> At(std::int64_t tick) const;
  Verdict VerdictOn(std::int64_t tick) const;
  Verdicts AllVerdicts() const;
  /// What that verdict, if it is known, says of the agent's failure; none: it has not failed.
  static std::optional<Ruling> FailureOf(const AgentState& agent, const Verdicts& verdicts,
                                         std::int64_t tick);
  /// None: something is still missing.
  std::optional<Lost> LostAgent(const Told& told, const std::optional<Ruling>& failure,
                                std::int64_t tick, const Verdicts& verdicts, Gap gap) const;

  std::optional<order_book_t> book_;
  const Scenario& scenario_;
  const WireLimits limits_;
  const std::int64_t run_id_;
  bool not_begun_ = false;
  PerKind<std::vector<Told>> told_;
  using Message = std::tuple<std::string, std::int64_t, std::int64_t>;  // sender, boot_id, seq
  std::map<std::int64_t, std::map<Message, Packet>> reports_;           ///< by tick
  std::map<std::int64_t, std::int32_t> applied_;  ///< by tick: the decision in force
  std::int64_t clock_ = -1;                       ///< newest tick
  std::map<std::int64_t, world_state_t> worlds_;
  std::map<std::int64_t, rulings_t> rulings_;
};

/// How long a restarted world listens before it goes on from `state`. All living processes have
/// answered by then.
TimeUs ListenUs(const Restoring::State& state, bool goes_on, TimeUs lost_after_us);
/// How long it waits at most for what another process may still answer.
TimeUs GiveUpUs(TimeUs lost_after_us);

}  // namespace muster::world
