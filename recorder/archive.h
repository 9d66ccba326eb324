#pragma once

#include <cstdint>
#include <map>
#include <muster/answer_t.hpp>
#include <muster/request_t.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/interval_set.h"
#include "lcmtypes/bus/bus.h"
#include "model/scenario.h"
#include "protocol/order_book.h"
#include "protocol/report_reader.h"

namespace muster::recorder {

/// The state of a mission as its processes have last told it. World and agent processes keep each
/// other's state. When several have died at once, only a listener such as this one can tell their
/// states to the processes that start again.
class Archive {
 public:
  /// `goes_on`: the mission may go on without lost processes.
  Archive(const Scenario& scenario, std::int64_t run_id, bool goes_on);

  /// A packet of the mission, from the bus or the log.
  void Add(const Packet& packet);

  /// What to answer, headers not filled. Nothing until the same start of the same process has asked
  /// for two seconds: living processes know better.
  std::vector<answer_t> Answer(const request_t& request, TimeUs now_us);
  /// Whether to answer all that is known, and without delay: only a listener knows which verdicts
  /// were given without which process.
  bool AnswersAtOnce(const request_t& request) const;

 private:
  /// A message; or what one with changes stands for.
  struct Kept {
    std::vector<std::uint8_t> bytes;
    std::optional<agent_states_t> states;
  };
  using Messages = std::map<std::pair<std::int64_t, std::int64_t>, Kept>;  ///< by boot_id, seq
  using Told = std::map<std::int64_t, Messages>;                           ///< by tick
  struct Source {
    std::string channel, sender;
    auto operator<=>(const Source&) const = default;
  };

  void Keep(std::string_view channel, const header_t& header, const Kept& kept);
  void AddReport(const Packet& packet);
  /// Visits the bytes of messages that tell all of these.
  template <class Visit>
  static void ForEachMessage(const Messages& messages, Visit visit);
  void Forget(const Source& source, Told* told) const;
  /// The newest tick from which the mission can go on: everybody's states, the verdict before.
  std::optional<std::int64_t> Consistent() const;
  /// Visits (tick, messages): a sender's states of that tick, and those before if it may be lost.
  template <class Visit>
  void ForEachReport(const Told& told, std::int64_t tick, Visit visit) const;

  OrderBook book_;
  const Scenario& scenario_;  ///< with the orders heard so far
  const std::int64_t run_id_;
  const bool goes_on_;
  std::optional<Packet> schedule_;  ///< the newest decision
  std::int32_t newest_decision_ = -1;
  std::map<std::int32_t, Packet> clearances_;  ///< the newest altitudes, by decision
  std::map<Source, Told> told_;
  ReportReader reports_;
  std::map<std::pair<std::string, std::int64_t>, IntervalSet>
      seqs_;  ///< of reports, by sender, boot_id
  struct Question {
    TimeUs since_us = 0, asked_us = kNever, answered_us = -kNever / 2;
  };
  std::map<std::tuple<std::string, std::int64_t, std::string>, Question> questions_;
};

}  // namespace muster::recorder
