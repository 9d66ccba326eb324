#pragma once

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

/// The answer to that question, its header not filled; no bytes: the mission has not begun.
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
  /// is to be published to `out`. Throws InputError on a mission that cannot be (two processes for
  /// one agent, say).
  void Step(const std::vector<Packet>& arrived, const Now& now, std::vector<Packet>* out);

  /// The same with one packet that was decoded once (DecodeMessage) for all its receivers.
  void Step(const Packet& packet, const std::optional<Message>& message, const Now& now,
            std::vector<Packet>* out);

  /// Latest monotonic time of the next Step even if nothing arrives.
  TimeUs wake_us() const;

  /// Publishes a process_status_t; the edge calls it when the state changes and about once a
  /// second.
  void ReportStatus(const Usage& usage, const Now& now);

  /// Publishes something that the edge has to say; the header is filled here.
  void Announce(event_t event, const Now& now);

  /// Packets that were no message of this mission, or an impossible one.
  std::int64_t rejected() const { return inbox_.counters().rejected + refused_; }
  /// How many its bus has refused so far: they count as rejected.
  void NoteRefused(std::int64_t refused) { refused_ = refused; }
  /// How many its bus has lost on purpose.
  void NoteDropped(std::int64_t dropped) { dropped_ = dropped; }

  ProcessState state() const { return state_; }
  const Inbox::Counters& counters() const { return inbox_.counters(); }
  const Identity& identity() const { return sender_.identity(); }

 protected:
  virtual void OnMessage(const Message& message, const Packet& packet, const Now& now) = 0;
  /// After all that has arrived.
  virtual void OnStep(const Now& now) = 0;
  virtual TimeUs OwnWakeUs() const = 0;
  virtual std::int64_t tick() const = 0;
  /// Messages of others that are known to exist and were not seen. A process that does not hear
  /// every channel knows only of those that its bus has lost.
  virtual std::int64_t lost() const { return dropped_; }

  /// Asks for the newest message of a channel.
  void Request(std::string_view channel, TimeUs sim_us, const Now& now);
  /// What was asked so far needs no answer any more.
  void ForgetQuestions() { questions_.clear(); }
  /// Whether that answers a question of this very start that still needs an answer: what was said
  /// to anybody else, or earlier, and is said again, tells nothing of the present.
  bool Answers(const answer_t& answer) const;
  /// Answers a request with that message; no bytes: the mission has not begun.
  void Answer(const request_t& request, std::int64_t tick, std::vector<std::uint8_t> message,
              TimeUs sim_us, const Now& now);

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
  std::map<std::string, std::int64_t, std::less<>> questions_;  ///< first seq, by channel
};

/// std::visit with a lambda a type; messages that no lambda names are ignored.
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
