#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "base/interval_set.h"
#include "lcmtypes/bus/bus.h"
#include "model/scenario.h"
#include "protocol/agent_changes.h"
#include "protocol/inbox.h"

namespace muster {

/// Turns agents' reports, whole states and changes in any order, into whole states. An earlier
/// report may arrive later (a log is repaired), so changes wait for their base until so many
/// reports have followed that it will not be repeated. Changes without a base are left out until
/// the next whole states.
class ReportReader {
 public:
  explicit ReportReader(const std::shared_ptr<const Scenario>& scenario);

  /// With what a report says, or the reports that waited for it.
  using Visit = std::function<void(const agent_states_t&, const Packet&)>;

  /// Takes a report, agent_states_t or agent_changes_t, each once. `seqs`: the numbers of its
  /// sender's start so far, its own included. Whole states are visited at once.
  void Add(const Message& report, const Packet& packet, const IntervalSet& seqs,
           const Visit& visit);

  /// Changes so far that cannot be.
  std::int64_t impossible() const { return impossible_; }

  /// So many messages back something may lack and still come; a sender has far fewer out at a time.
  static constexpr std::int64_t kMostBack = 64;

 private:
  struct Held {
    Message report;
    Packet packet;
  };
  /// Of a sender.
  struct Start {
    std::int64_t next = 0;  ///< every number below has come, or does not come any more
    std::int64_t newest = -1;
    std::map<std::int64_t, Held> held;  ///< by number: those whose base has not come
    /// What was known before whole states that came before something that was said earlier.
    std::optional<ToldAgents> before;
    std::int64_t before_seq = 0;  ///< of those states: what is numbered lower rests on `before`
  };
  /// Whether that report is done with.
  bool Read(Start* start, const Message& report, const Packet& packet, const Visit& visit);
  void ReadHeld(Start* start, const Visit& visit);

  PerKind<ToldAgents> told_;
  std::map<std::pair<std::string, std::int64_t>, Start> starts_;  ///< by sender, boot_id
  std::int64_t impossible_ = 0;
};

}  // namespace muster
