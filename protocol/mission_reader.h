#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/interval_set.h"
#include "lcmtypes/bus/bus.h"
#include "model/scenario.h"
#include "protocol/inbox.h"
#include "protocol/order_book.h"
#include "protocol/report_reader.h"
#include "protocol/scenario_reader.h"

namespace muster {

/// The one reader of a mission's packets, whether they come from a log, a live capture or the bus
/// in memory. It decodes them, leaves out other runs and repeats, and holds back messages that come
/// before the scenario. A scenario that names roads counts as there when its roads are there, too.
/// A scenario_t that does not parse is ignored. Memory grows with agents and gaps, and before the
/// scenario with the messages that are held back.
class MissionReader {
 public:
  /// Called with each message, that is, each (sender, boot_id, seq), once, the scenario first. An
  /// agent_changes_t comes as the agent_states_t that it stands for, once that is known.
  using Visit = std::function<void(const Message&, const Packet&)>;

  /// Messages are of run `run_id`; none: of the run of the first scenario.
  explicit MissionReader(std::optional<std::int64_t> run_id = {}) : run_id_(run_id) {}

  /// Takes any packet, in any order, as often as it comes. Visits its message, if it is one of the
  /// mission; with the scenario also, in their order, all messages that waited for it. A message on
  /// a channel on which its sender may not publish is counted but not visited.
  void Add(const Packet& packet, const Visit& visit);

  struct Counts {
    std::int64_t messages = 0;     ///< distinct messages of this run
    std::int64_t duplicates = 0;   ///< same sender, boot and seq again
    std::int64_t strangers = 0;    ///< of another run
    std::int64_t undecodable = 0;  ///< on a channel of ours, but no possible message of its type
    std::int64_t foreign = 0;      ///< on channels that are not ours
    bool operator==(const Counts&) const = default;
  };
  const Counts& counts() const { return counts_; }
  /// The caller has found a message impossible for the scenario.
  void Reject() { ++counts_.undecodable; }

  /// With the orders that have been read; it changes in place. Null before there is one.
  std::shared_ptr<const Scenario> scenario() const { return book_ ? book_->scenario() : nullptr; }
  /// With a scenario.
  const OrderBook& orders() const { return *book_; }
  /// The same, to keep; afterwards nothing more can be read.
  OrderBook TakeOrders() { return std::move(*book_); }
  std::optional<std::int64_t> run_id() const { return run_id_; }
  /// Run of the newest message of any run, the scenario known or not; none before the first.
  std::optional<std::int64_t> heard_run_id() const { return heard_run_id_; }
  /// Wall time of mission time 0 by the first clock_t that runs, microseconds since the Unix epoch;
  /// 0 in a simulated mission; none before that clock.
  std::optional<std::int64_t> epoch_us() const { return epoch_us_; }
  /// Numbers of the messages so far, by sender and boot_id.
  const std::map<std::pair<std::string, std::int64_t>, IntervalSet>& seqs() const { return seqs_; }

  /// At most so many messages are held back; a sound log needs a few.
  static constexpr std::size_t kMostHeldBack = 20'000;
  /// Whether more than that came before the scenario, so that some were left out.
  bool overflowed() const { return overflowed_; }

 private:
  /// Called when the scenario is complete.
  void Begin(Message message, const Packet& packet, const Visit& visit);
  void Take(const Message& message, const Packet& packet, const Visit& visit);

  std::optional<std::int64_t> run_id_;
  std::optional<std::int64_t> heard_run_id_;
  ScenarioReader scenario_reader_;  ///< until there is a book
  std::optional<OrderBook> book_;   ///< with the scenario
  std::optional<std::int64_t> epoch_us_;
  std::vector<std::pair<Message, Packet>> held_back_;
  bool overflowed_ = false;
  std::map<std::pair<std::string, std::int64_t>, IntervalSet> seqs_;
  Counts counts_;
  std::optional<ReportReader> reports_;  ///< with the scenario
};

}  // namespace muster
