#include "recorder/recorder_process.h"

#include <algorithm>
#include <utility>

#include "lcmtypes/channels.h"
#include "protocol/sender.h"

namespace muster::recorder {
namespace {

/// Each log_status_t wakes all processes. It is sent at once when a sender has so much out that it
/// could come to the end of its window (kMemberWindow messages for most processes; for the world
/// kWorldWindow or kWorldWindowBytes, whichever is more). Otherwise it is sent after a moment that
/// is too short to cause repairs.
constexpr int kUnsaid = kMemberWindow - 2;
constexpr int kUnsaidOfWorld = kWorldWindow - 2;
constexpr std::size_t kUnsaidBytesOfWorld = kWorldWindowBytes / 2;
constexpr TimeUs kUnsaidUs = 5'000;

}  // namespace

RecorderProcess::RecorderProcess(const Identity& identity, int window, std::optional<Seal> seal)
    : Process(identity, window),
      window_(window),
      seal_(seal),
      follower_(identity.run_id),
      idle_(kMarksIdleUs, kMarksIdleUs) {
  set_state(ProcessState::kReady);
}

void RecorderProcess::OnLogged(const Packet& packet) {
  std::optional<Packet> opened;
  if (seal_) {
    opened = packet;
    if (!seal_->Open(&*opened)) return;
  }
  const std::int64_t doubles = follower_.doubles();
  const std::optional<header_t> header = follower_.Add(opened ? *opened : packet);
  if (!header) {
    answer_wanted_ |= follower_.doubles() > doubles;
    return;
  }
  const Identity& own = this->identity();
  if (header->sender != own.name) {
    news_ = true;
    Unsaid& unsaid = unsaid_[{header->sender, header->boot_id}];
    ++unsaid.messages;
    unsaid.bytes += packet.bytes.size();
    is_urgent_ |= header->sender == process_name::kWorld
                      ? unsaid.messages >= kUnsaidOfWorld && unsaid.bytes >= kUnsaidBytesOfWorld
                      : unsaid.messages >= kUnsaid;
  } else if (header->boot_id == own.boot_id) {
    log_status_t status{};
    log_mark_t& mark = status.marks.emplace_back();
    mark.sender = own.name;
    mark.boot_id = own.boot_id;
    mark.next_seq = follower_.next_seq(own.name, own.boot_id);
    status.n = 1;
    sender().Acknowledge(status);
  }
}

void RecorderProcess::OnMessage(const Message& message, const Packet&, const Now&) {
  Handle(message, [&](const clock_t& clock) {
    if (clock.tick < tick_) return;
    tick_ = clock.tick;
    sim_us_ = std::max(sim_us_, clock.tick_us);
    set_sim_us(sim_us_);
    if (clock.phase == ClockPhase::kRunning && state() == ProcessState::kReady) {
      set_state(ProcessState::kRunning);
    }
  });
}

void RecorderProcess::OnStep(const Now& now) {
  const Identity& own = this->identity();
  const std::int64_t out = sender().next_seq() - follower_.next_seq(own.name, own.boot_id);
  const TimeUs time_us = now.monotonic_us;
  if (news_ && news_us_ == kNever) news_us_ = time_us;
  has_room_ = out < window_;
  if (news_ && has_room_ && (is_urgent_ || time_us >= news_us_ + kUnsaidUs)) {
    marks_ = sender().Send(channel::kLog, follower_.Status(), sim_us_, now);
    news_ = is_urgent_ = answer_wanted_ = false;
    news_us_ = kNever;
    unsaid_.clear();
  } else if (marks_ && time_us >= AgainUs()) {
    sender().Resend(marks_);
    answer_wanted_ = false;
  } else {
    return;
  }
  said_us_ = time_us;
  idle_.Start(time_us);
}

TimeUs RecorderProcess::OwnWakeUs() const {
  // Room comes with a message of its own in the log.
  const bool waits = news_us_ != kNever && has_room_;
  return waits ? std::min(AgainUs(), news_us_ + kUnsaidUs) : AgainUs();
}

TimeUs RecorderProcess::AgainUs() const {
  return answer_wanted_ ? std::min(idle_.due_us(), said_us_ + kMarksAgainUs) : idle_.due_us();
}

}  // namespace muster::recorder
