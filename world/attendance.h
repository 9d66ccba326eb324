#pragma once

#include <set>
#include <string>
#include <vector>

#include "model/scenario.h"
#include "world/peers.h"

namespace muster::world {

/// The processes that take part: which one reports which agent, which ones the present tick waits
/// for, which are lost and which return.
class Attendance {
 public:
  Attendance(const Scenario& scenario, Peers peers);

  Peers& peers() { return peers_; }
  const Peers& peers() const { return peers_; }

  /// Whether the agent may be that process's, as far as is known. It is not if another process
  /// reports the agent and no process of that name has introduced itself: the name was damaged on
  /// the way. Throws InputError when two processes report the agent.
  bool MayReport(AgentKind kind, std::int32_t id, const std::string& process) const;
  /// `process` has reported that agent for this tick. False: it was known, or the agent is awaited
  /// only from the next tick on.
  [[nodiscard]] bool Report(AgentKind kind, std::int32_t id, const std::string& process);
  /// The present tick waits for no process.
  bool complete() const { return missing_ == 0; }
  bool reported(AgentKind kind, std::int32_t id) const {
    return SeatOf(kind, id).heard == Heard::kYes;
  }
  /// Begins the next tick: awaits every agent but those of lost processes.
  void StartTick();
  /// The processes whose agents are awaited.
  std::set<std::string> Owing() const;

  /// Goes on without that process: its agents are not awaited. True: until now it was there.
  bool Lose(const std::string& process);
  /// The returning processes all of whose agents have been reported for this tick. They are back.
  std::vector<std::string> TakeBack();

  /// "": not known yet.
  const std::string& OwnerOf(AgentKind kind, std::int32_t id) const {
    return SeatOf(kind, id).owner;
  }
  void SetOwner(AgentKind kind, std::int32_t id, std::string process) {
    SeatOf(kind, id).owner = std::move(process);
  }
  /// That agent is not awaited in this tick.
  void Excuse(AgentKind kind, std::int32_t id);
  /// Calls visit(kind, id) for each agent of that process.
  template <class Visit>
  void ForEachAgentOf(const std::string& process, Visit visit) const {
    for (const AgentKind kind : kAgentKinds) {
      for (std::size_t id = 0; id < seats_[kind].size(); ++id) {
        if (seats_[kind][id].owner == process) visit(kind, static_cast<std::int32_t>(id));
      }
    }
  }

  /// The end of that process is awaited at the mission's end.
  void Join(const std::string& process) {
    members_.insert(process);
    newest_member_ = process;
  }
  void Leave(const std::string& process) {
    members_.erase(process);
    newest_member_.clear();
  }
  /// All processes that joined have left.
  bool deserted() const { return members_.empty(); }

 private:
  enum class Heard : char { kNot, kYes, kNotAwaited };
  struct Seat {
    std::string owner;
    Heard heard = Heard::kNot;  ///< for this tick
  };
  Seat& SeatOf(AgentKind kind, std::int32_t id) {
    return seats_[kind][static_cast<std::size_t>(id)];
  }
  const Seat& SeatOf(AgentKind kind, std::int32_t id) const {
    return seats_[kind][static_cast<std::size_t>(id)];
  }

  PerKind<std::vector<Seat>> seats_;  ///< [n_agents]
  std::size_t missing_ = 0;
  Peers peers_;
  std::set<std::string> members_;
  std::string newest_member_;  ///< the last to join of those present
};

}  // namespace muster::world
