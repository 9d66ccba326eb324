#pragma once

#include <cstdint>
#include <map>
#include <muster/answer_t.hpp>
#include <muster/event_t.hpp>
#include <muster/fault_t.hpp>
#include <muster/order_t.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "protocol/process.h"
#include "protocol/sender.h"
#include "recorder/log_follower.h"

namespace muster::recorder {

/// The launcher's part in the mission, as a pure core: what it says itself, what it sees of the
/// log, and, where lcm-logger writes that, the recorder's part: it tells everybody what the log
/// holds.
///
/// lcm-logger writes its buffer to disk only when a message arrives later than its flush interval
/// after the last flush. So while something is known to be on its way to the log (heard on the bus,
/// or said by ourselves), the recorder repeats its newest message until the log has it all. It
/// also repeats it to a sender that shows, by repairing what the log holds already, that it has not
/// heard; and now and then without a reason, for the packets that it has not heard itself.
///
/// It keeps what it has heard until the log has it: a killed start can no longer repair the log, so
/// the recorder sends those messages again in its place, byte for byte.
class Recorder {
 public:
  /// The process that tells the others what the log holds.
  enum class Marks { kOwn, kOfRecorderProcess, kOfTwoRecorders };
  explicit Recorder(Identity identity, Marks marks = Marks::kOwn);

  /// The log's next event. Returns true when it is of this run and the log did not hold it before.
  bool OnLogged(const Packet& event, const Now& now);
  /// A packet on the bus, one's own included.
  void OnHeard(const Packet& packet, const Now& now);

  /// That start of that sender has ended and will not say anything again.
  void OnEnd(const std::string& sender, std::int64_t boot_id, const Now& now);

  /// Publishes a fault_t; its header is the recorder's to fill. SendAgain sends it once more.
  SentPacket Publish(fault_t fault, const Now& now);
  void SendAgain(const SentPacket& packet) { sender_.Resend(packet); }
  /// The same for an order.
  SentPacket Publish(order_t order, const Now& now);
  /// Publishes an answer_t; its header is the recorder's to fill.
  void Answer(answer_t answer, const Now& now);
  /// Publishes an event_t; its header is the recorder's to fill.
  void Announce(event_t event, const Now& now);
  /// Publishes a process_status_t of the recorder itself.
  /// How many its bus has refused so far: they count as rejected.
  void NoteRefused(std::int64_t refused) { refused_ = refused; }
  void ReportStatus(ProcessState state, std::int64_t tick, const Usage& usage, const Now& now);
  /// Says that it ends. From here on only repeats.
  void Finish(std::int64_t tick, const Usage& usage, const Now& now);
  /// Its end is in the log, and everything it heard of.
  bool finished() const { return finishing_ && !behind(); }

  /// Appends what is to be published now to `out`.
  void Step(const Now& now, std::vector<Packet>* out);
  /// Latest monotonic time of the next Step even if nothing happens.
  TimeUs wake_us() const;

  /// Whether a message is known to be published and is not in the log yet.
  bool behind() const;
  /// Messages that one start of a sender must have sent, that the log does not hold, and that may
  /// still come, because it has not ended.
  struct Gap {
    std::string sender;
    std::int64_t boot_id = 0;
    std::int64_t messages = 0;
  };
  std::vector<Gap> gaps() const;
  /// Waits for that start's messages no more.
  void GiveUp(const Gap& gap) { given_up_.insert({gap.sender, gap.boot_id}); }
  const LogFollower& log() const { return follower_; }

 private:
  using Start = std::pair<std::string, std::int64_t>;  // sender, boot_id

  std::int64_t unrecorded_own() const;
  bool others_behind() const;
  /// When to say the newest marks again for lcm-logger's sake.
  TimeUs PokeUs() const;
  /// The earliest time to repeat the marks for a process that has not heard them.
  TimeUs AnswerUs() const;
  /// `heard`: highest seq heard of that start, plus one.
  bool IsAwaited(const Start& start, std::int64_t heard) const;
  void Repeat(const Now& now);
  /// Whether messages of processes that have ended are left to repeat.
  bool owes() const;

  const Marks marks_;
  LogFollower follower_;
  Sender sender_;
  std::int64_t heard_packets_ = 0;
  std::int64_t refused_ = 0;
  std::map<Start, std::int64_t> heard_;  ///< of others: highest seq heard, plus one
  /// By seq: heard and not in the log.
  std::map<Start, std::map<std::int64_t, Packet>> kept_;
  std::set<Start> ended_, given_up_;
  TimeUs sim_us_ = 0;         ///< latest in the log
  SentPacket newest_status_;  ///< the last log_status_t
  bool news_ = true;          ///< the marks have changed since
  bool finishing_ = false;
  bool answer_wanted_ = false;  ///< a sender has not heard the marks
  bool has_news_out_ = false;   ///< own messages beside the marks are not in the log
  TimeUs marks_us_ = 0;         ///< said at last, for the first time
  TimeUs repeated_us_ = 0;
  BackOff poke_;  ///< while behind
  BackOff repair_;
  RepeatBudget budget_;  ///< for messages of processes that have ended
  TimeUs repaired_over_us_ = -kNever / 2;
  BackOff idle_;
};

}  // namespace muster::recorder
