#pragma once

#include <functional>
#include <map>
#include <memory>
#include <muster/answer_t.hpp>
#include <muster/event_t.hpp>
#include <muster/process_status_t.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "lcmtypes/words.h"
#include "protocol/inbox.h"
#include "protocol/sender.h"

namespace muster {

/// What the operating system knows of a process; measured at the edge, only reported.
struct Usage {
  std::string host;
  std::int32_t pid = 0;
  double cpu_s = 0;
  std::int64_t rss_bytes = 0;
};

/// The answer to that request, its header not filled. `message`: empty if the mission has not
/// begun.
answer_t AnswerTo(const request_t& request, std::int64_t tick, std::vector<std::uint8_t> message);

/// One participant of a mission as a pure core: packets and times in, packets out. No socket,
/// clock, file or thread; RunProcess() drives it over LCM, the simulator in memory.
class Process {
 public:
  /// window: see Sender.
  Process(const Identity& identity, Window window);
  virtual ~Process() = default;
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Takes everything that has arrived (possibly nothing), does what has become due, appends what
  /// is to be published to `out`. Throws InputError on an impossible mission (for example, two
  /// processes for one agent).
  void Step(const std::vector<Packet>& arrived, const Now& now, std::vector<Packet>* out);

  /// The same with one packet that was decoded once (DecodeMessage) for all its receivers.
  void Step(const Packet& packet, const std::optional<Message>& message, const Now& now,
            std::vector<Packet>* out);

  /// Latest monotonic time of the next Step even if nothing arrives.
  TimeUs wake_us() const;

  /// Publishes a process_status_t; the edge calls it when the state changes and about once a
  /// second.
  void ReportStatus(const Usage& usage, const Now& now);

  /// How the process runs a computation that may take long: to its end, and meanwhile the edge may
  /// call Beat, nothing else. Without it Step just takes as long.
  using RunLong = std::function<void(const std::function<void()>& computation)>;
  void set_run_long(RunLong run_long) { run_long_ = std::move(run_long); }
  /// During a long computation: reports that the process lives, and appends to `out` what may be
  /// sent. Of what has arrived it takes, and removes, only what the log says that it holds.
  void Beat(std::vector<Packet>* arrived, const Usage& usage, const Now& now,
            std::vector<Packet>* out);

  /// Publishes an event that the edge has seen; the header is filled here.
  void Announce(event_t event, const Now& now);

  /// Nobody would believe what this process repeats of others when it is asked.
  void StopRepeatingOthers() { repeats_others_ = false; }

  /// Packets that were not a possible message of this mission.
  std::int64_t rejected() const { return inbox_.counters().rejected + refused_; }
  /// How many packets its bus has refused so far; they count as rejected.
  void NoteRefused(std::int64_t refused) { refused_ = refused; }
  /// How many packets its bus has lost on purpose so far.
  void NoteDropped(std::int64_t dropped) { dropped_ = dropped; }

  ProcessState state() const { return state_; }
  const Inbox::Counters& counters() const { return inbox_.counters(); }
  const Identity& identity() const { return sender_.identity(); }

 protected:
  virtual void OnMessage(const Message& message, const Packet& packet, const Now& now) = 0;
  /// Called after all that has arrived was handed to OnMessage.
  virtual void OnStep(const Now& now) = 0;
  /// What it publishes besides what it numbers, and no log has.
  virtual void SayUnlogged(const Now&, std::vector<Packet>*) {}
  virtual TimeUs OwnWakeUs() const = 0;
  virtual std::int64_t tick() const = 0;
  /// Messages of others that exist but did not arrive. A process that does not hear every channel
  /// can count only those that its bus has lost.
  virtual std::int64_t lost() const { return dropped_; }

  /// Runs a computation that may take long (see RunLong). It may touch nothing that Beat does.
  void Compute(const std::function<void()>& computation);

  /// Asks for the newest message of a channel.
  void Request(std::string_view channel, TimeUs sim_us, const Now& now);
  /// The requests so far need no answer any more.
  void ForgetQuestions() { questions_.clear(); }
  /// Whether this answers a request of this start of the process that still needs an answer. An
  /// answer to another process, or an old one that is repeated, tells nothing of the present.
  bool Answers(const answer_t& answer) const;
  /// Answers a request with that message; empty: the mission has not begun.
  void Answer(const request_t& request, std::int64_t tick, std::vector<std::uint8_t> message,
              TimeUs sim_us, const Now& now);

  bool repeats_others() const { return repeats_others_; }

  Sender& sender() { return sender_; }
  const Sender& sender() const { return sender_; }
  Inbox& inbox() { return inbox_; }
  void set_state(ProcessState state) { state_ = state; }
  void set_sim_us(TimeUs sim_us) { sim_us_ = sim_us; }

 private:
  void Take(const Message& message, const Packet& packet, const Now& now);

  Sender sender_;
  Inbox inbox_;
  ProcessState state_ = ProcessState::kStarting;
  TimeUs sim_us_ = 0;
  std::int64_t refused_ = 0, dropped_ = 0;
  bool repeats_others_ = true;
  RunLong run_long_;
  std::map<std::string, std::int64_t, std::less<>> questions_;  ///< first seq, by channel
};

/// std::visit with one lambda for each type; messages that no lambda takes are ignored.
template <class... Handlers>
struct Overloaded : Handlers... {
  using Handlers::operator()...;
};
template <class... Handlers>
void Handle(const Message& message, Handlers... handlers) {
  std::visit(
      [overloaded = Overloaded<Handlers...>{handlers...}](const auto& m) {
        if constexpr (requires { overloaded(m); }) overloaded(m);
      },
      message);
}

}  // namespace muster
