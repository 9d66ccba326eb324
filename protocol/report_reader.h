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

/// Turns agents' reports, whole states and changes in any order, into whole states. A report may
/// come after later ones, because logs are repaired. So changes wait for the report that they rest
/// on, their base, until so many messages have followed that it will not come any more. Changes
/// whose base is missing are left out, and so are those after them until the next whole states.
class ReportReader {
 public:
  explicit ReportReader(const std::shared_ptr<const Scenario>& scenario);

  /// Called with the whole states of a report, and of each report that waited for it.
  using Visit = std::function<void(const agent_states_t&, const Packet&)>;

  /// Takes a report, agent_states_t or agent_changes_t, each once. `seqs`: the numbers of its
  /// sender's start so far, its own included. Whole states are visited at once.
  void Add(const Message& report, const Packet& packet, const IntervalSet& seqs,
           const Visit& visit);

  /// How many changes so far were impossible.
  std::int64_t impossible() const { return impossible_; }

  /// A message that is missing may still come until so many have followed it. A sender has far
  /// fewer out at a time.
  static constexpr std::int64_t kMostBack = 64;

 private:
  struct Held {
    Message report;
    Packet packet;
  };
  /// One start of a sender.
  struct Start {
    std::int64_t next = 0;  ///< every number below has come, or will not come any more
    std::int64_t newest = -1;
    std::map<std::int64_t, Held> held;  ///< by number: reports whose base has not come
    /// What was known before whole states that arrived earlier than a lower-numbered message.
    std::optional<ToldAgents> before;
    std::int64_t before_seq =
        0;  ///< number of those states; lower-numbered reports rest on `before`
  };
  /// Whether the report needs no further attention: it was visited or left out.
  bool Read(Start* start, const Message& report, const Packet& packet, const Visit& visit);
  void ReadHeld(Start* start, const Visit& visit);

  PerKind<ToldAgents> told_;
  std::map<std::pair<std::string, std::int64_t>, Start> starts_;  ///< by sender, boot_id
  std::int64_t impossible_ = 0;
};

}  // namespace muster
