#include "recorder/recorder_process.h"

#include <algorithm>
#include <utility>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/member_keys.h"
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
/// Ten heartbeats each of launcher and first recorder have not come.
constexpr TimeUs kFirstGoneUs = 10 * kSecondUs;
/// A second recorder on another host takes so long to start.
constexpr TimeUs kFirstWordUs = 30 * kSecondUs;

}  // namespace

RecorderProcess::RecorderProcess(const Identity& identity, int window, std::optional<Seal> seal,
                                 Part part, TimeUs patience_us)
    : Process(identity, window),
      window_(window),
      part_(part),
      patience_us_(patience_us),
      seal_(std::move(seal)),
      follower_(identity.run_id),
      copy_sender_({identity.run_id, process_name::kSecondMarks, identity.boot_id}, 0),
      idle_(kMarksIdleUs, kMarksIdleUs) {
  set_state(ProcessState::kReady);
}

bool RecorderProcess::Wants(const Packet& packet) const {
  if (packet.channel == channel::kCopy) return false;
  if (first_boot_ == 0) return true;
  Packet opened = packet;
  if (seal_ && !seal_->Open(&opened)) return true;
  const std::optional<header_t> header = DecodeHeader(opened);
  return !header || header->run_id != identity().run_id || header->boot_id >= first_boot_;
}

void RecorderProcess::OnLogged(const Packet& packet) {
  std::optional<Packet> opened;
  if (seal_) {
    opened = packet;
    if (!seal_->Open(&*opened)) return;
  }
  const std::int64_t doubles = follower_.doubles();
  const Packet& message = opened ? *opened : packet;
  const std::optional<header_t> header = follower_.Add(message);
  const Identity& own = this->identity();
  if (!header) {
    // Whoever repeats what the log has has not heard so; but for its own repeated marks.
    answer_wanted_ |= follower_.doubles() > doubles && DecodeHeader(message)->sender != own.name;
    return;
  }
  // Only the mission's key can say so; of a mission sealed per process, the launcher's.
  has_successor_ |= seal_ && header->boot_id >= first_boot_ + kLauncherApart &&
                    (!seal_->members() || header->sender == seal_->members()->launcher());
  if (part_ == Part::kFirst && message.channel == channel::kLog) NoteTold(message);
  if (header->sender != own.name) {
    news_ = true;
    Unsaid& unsaid = unsaid_[{header->sender, header->boot_id}];
    ++unsaid.messages;
    unsaid.bytes += packet.bytes.size();
    is_urgent_ |= header->sender == process_name::kWorld
                      ? unsaid.messages >= kUnsaidOfWorld && unsaid.bytes >= kUnsaidBytesOfWorld
                      : unsaid.messages >= kUnsaid;
  } else if (header->boot_id == own.boot_id && part_ != Part::kSecond) {
    AcknowledgeOwn();
  }
}

void RecorderProcess::AcknowledgeOwn() {
  const Identity& own = this->identity();
  log_status_t status{};
  log_mark_t& mark = status.marks.emplace_back();
  mark.sender = own.name;
  mark.boot_id = own.boot_id;
  mark.next_seq = NextSeqInAll(own.name, own.boot_id);
  status.n = 1;
  sender().Acknowledge(status);
}

void RecorderProcess::OnMessage(const Message& message, const Packet& packet, const Now& now) {
  Handle(
      message,
      [&](const clock_t& clock) {
        mission_ended_ |= clock.phase == ClockPhase::kEnded;
        if (clock.tick < tick_) return;
        tick_ = clock.tick;
        sim_us_ = std::max(sim_us_, clock.tick_us);
        set_sim_us(sim_us_);
        if (clock.phase == ClockPhase::kRunning && state() == ProcessState::kReady) {
          set_state(ProcessState::kRunning);
        }
      },
      [&](const log_status_t& status) {
        if (packet.channel == channel::kCopy) HearSecond(status, now);
      },
      [&](const process_status_t& status) {
        const std::string& sender = status.header.sender;
        if (sender == process_name::kLauncher || sender == process_name::kRecorder) {
          first_heard_us_ = now.monotonic_us;
        }
        const bool has_ended = status.state == ProcessState::kEnded;
        mission_ended_ |= has_ended && sender == process_name::kWorld;
        if (!counts_second() || status.header.sender != process_name::kSecondRecorder) return;
        second_.has_ended = has_ended;
        second_.until_us = std::min(second_.until_us, now.monotonic_us + patience_us_);
      });
}

void RecorderProcess::HearSecond(const log_status_t& status, const Now& now) {
  if (!counts_second()) return;
  for (const log_mark_t& mark : status.marks) {
    std::int64_t& next_seq = second_.marks[{mark.sender, mark.boot_id}];
    next_seq = std::max(next_seq, mark.next_seq);
  }
  const TimeUs until_us = now.monotonic_us + patience_us_;
  second_.until_us = SecondLacksTold() ? std::min(second_.until_us, until_us) : until_us;
  news_ = is_urgent_ = true;
  AcknowledgeOwn();
}

void RecorderProcess::NoteTold(const Packet& packet) {
  const auto status = DecodeValid<log_status_t>(packet.bytes);
  for (const log_mark_t& mark : status ? status->marks : std::vector<log_mark_t>()) {
    std::int64_t& told = told_marks_[{mark.sender, mark.boot_id}];
    told = std::max(told, mark.next_seq);
  }
}

bool RecorderProcess::SecondLacksTold() const {
  return std::any_of(told_marks_.begin(), told_marks_.end(), [this](const auto& told) {
    const auto& [start, next_seq] = told;
    if (start.first == process_name::kSecondRecorder) return false;
    const auto there = second_.marks.find(start);
    return there == second_.marks.end() || there->second < next_seq;
  });
}

void RecorderProcess::SeeToSecond(const Now& now) {
  if (!counts_second()) return;
  if (second_.until_us == kNever) second_.until_us = now.monotonic_us + kFirstWordUs;
  if (now.monotonic_us < second_.until_us && !(second_.has_ended && mission_ended_)) return;
  second_.gone = news_ = is_urgent_ = true;
}

void RecorderProcess::SeeToFirst(const Now& now) {
  if (part_ != Part::kSecond || first_heard_us_ == kNever ||
      now.monotonic_us < first_heard_us_ + kFirstGoneUs) {
    return;
  }
  throw SystemError(
      "nothing has been heard of launcher and first recorder for 10 s: this one ends");
}

std::int64_t RecorderProcess::NextSeqInAll(const std::string& sender, std::int64_t boot_id) const {
  const std::int64_t here = follower_.next_seq(sender, boot_id);
  if (!counts_second() || sender == process_name::kSecondRecorder) return here;
  const auto there = second_.marks.find({sender, boot_id});
  return std::min(here, there == second_.marks.end() ? 0 : there->second);
}

log_status_t RecorderProcess::Marks() const {
  log_status_t status = follower_.Status();
  for (log_mark_t& mark : status.marks) mark.next_seq = NextSeqInAll(mark.sender, mark.boot_id);
  return status;
}

std::map<RecorderProcess::Start, std::int64_t> RecorderProcess::MarksOfOthers() const {
  std::map<Start, std::int64_t> marks;
  for (const log_mark_t& mark : Marks().marks) {
    if (mark.sender != identity().name) marks[{mark.sender, mark.boot_id}] = mark.next_seq;
  }
  return marks;
}

void RecorderProcess::OnStep(const Now& now) {
  SeeToSecond(now);
  SeeToFirst(now);
  const Identity& own = this->identity();
  const std::int64_t out = sender().next_seq() - follower_.next_seq(own.name, own.boot_id);
  const TimeUs time_us = now.monotonic_us;
  if (counts_second() && news_) news_ = MarksOfOthers() != said_marks_;
  if (news_ && news_us_ == kNever) news_us_ = time_us;
  has_room_ = out < window_;
  if (part_ == Part::kSecond || has_successor_) return;
  if (IsNewsDue(time_us)) {
    marks_ = sender().Send(channel::kLog, Marks(), sim_us_, now);
    if (part_ == Part::kFirst) said_marks_ = MarksOfOthers();
  } else if (marks_ && time_us >= AgainUs()) {
    sender().Resend(marks_);
  } else {
    return;
  }
  NoteSaid(time_us);
}

void RecorderProcess::SayUnlogged(const Now& now, std::vector<Packet>* out) {
  if (part_ != Part::kSecond || has_successor_) return;
  if (!IsNewsDue(now.monotonic_us) && now.monotonic_us < AgainUs()) return;
  copy_sender_.Send(channel::kCopy, Marks(), sim_us_, now);
  copy_sender_.Flush(now, out);
  NoteSaid(now.monotonic_us);
}

bool RecorderProcess::IsNewsDue(TimeUs now_us) const {
  return news_ && has_room_ && (is_urgent_ || now_us >= news_us_ + kUnsaidUs);
}

void RecorderProcess::NoteSaid(TimeUs now_us) {
  if (IsNewsDue(now_us)) {
    news_ = is_urgent_ = false;
    news_us_ = kNever;
    unsaid_.clear();
  }
  answer_wanted_ = false;
  said_us_ = now_us;
  idle_.Start(now_us);
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
