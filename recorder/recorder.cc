#include "recorder/recorder.h"

#include <algorithm>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::recorder {
namespace {

/// Own messages that may be out and not in the log. Small: they share lcm-logger's queue of 30 with
/// everybody else's.
constexpr int kWindow = 3;

// lcm-logger's shortest flush interval is 1 ms.
constexpr TimeUs kFirstPokeUs = 1'200;
constexpr TimeUs kLongestPokeUs = 20'000;
constexpr TimeUs kRarestPokeUs = 500'000;
constexpr TimeUs kOwnMarksUs = 10'000;
constexpr TimeUs kFirstRepairUs = 5'000;
constexpr TimeUs kLongestRepairUs = 200'000;
constexpr std::size_t kRepairBatch = 8;  ///< messages

}  // namespace

Recorder::Recorder(Identity identity, Marks marks)
    : marks_(marks),
      follower_(identity.run_id),
      sender_(std::move(identity), kWindow),
      poke_(kFirstPokeUs, kLongestPokeUs, kRarestPokeUs),
      repair_(kFirstRepairUs, kLongestRepairUs, kSecondUs),
      idle_(kMarksIdleUs, kMarksIdleUs) {}

bool Recorder::OnLogged(const Packet& event, const Now& now) {
  const std::optional<header_t> header = follower_.Add(event);
  if (!header) return false;
  sim_us_ = std::max(sim_us_, header->sim_us);
  if (header->sender == sender_.identity().name) {
    if (marks_ != Marks::kOfTwoRecorders) sender_.Acknowledge(follower_.Status());
    if (unrecorded_own() == 0) has_news_out_ = false;
  } else {
    news_ = true;
    const auto kept = kept_.find({header->sender, header->boot_id});
    if (kept != kept_.end()) kept->second.erase(header->seq);
  }
  poke_.Start(now.monotonic_us);
  return true;
}

void Recorder::OnEnd(const std::string& sender, std::int64_t boot_id, const Now& now) {
  ended_.insert({sender, boot_id});
  repair_.Start(now.monotonic_us);
}

SentPacket Recorder::Publish(fault_t fault, const Now& now) {
  poke_.Start(now.monotonic_us);
  has_news_out_ = true;
  return sender_.Send(channel::kFault, std::move(fault), sim_us_, now);
}

SentPacket Recorder::Publish(order_t order, const Now& now) {
  poke_.Start(now.monotonic_us);
  has_news_out_ = true;
  return sender_.Send(channel::kOrder, std::move(order), sim_us_, now);
}

void Recorder::Answer(answer_t answer, const Now& now) {
  sender_.Send(channel::kAnswer, std::move(answer), sim_us_, now);
  has_news_out_ = true;
  poke_.Start(now.monotonic_us);
}

void Recorder::Announce(event_t event, const Now& now) {
  sender_.Send(channel::kEvent, std::move(event), sim_us_, now);
  has_news_out_ = true;
  poke_.Start(now.monotonic_us);
}

bool Recorder::owes() const {
  return std::any_of(ended_.begin(), ended_.end(), [this](const Start& start) {
    const auto kept = kept_.find(start);
    return kept != kept_.end() && !kept->second.empty();
  });
}

void Recorder::OnHeard(const Packet& packet, const Now& now) {
  const std::optional<header_t> header = DecodeHeader(packet);
  if (!header || header->run_id != sender_.identity().run_id ||
      header->seq >= LogFollower::kMostSeq || header->sender == sender_.identity().name ||
      IsOfEarlierLauncher(header->boot_id, sender_.identity().boot_id)) {
    return;
  }
  ++heard_packets_;
  if (marks_ == Marks::kOfTwoRecorders && packet.channel == channel::kLog) {
    // The second log may lack what the first one has.
    if (const auto marks = DecodeValid<log_status_t>(packet.bytes)) sender_.Acknowledge(*marks);
  }
  const Start start(header->sender, header->boot_id);
  if (!follower_.Contains(*header)) kept_[start].try_emplace(header->seq, packet);
  std::int64_t& heard = heard_[start];
  if (header->seq >= heard) {
    heard = header->seq + 1;
    poke_.Start(now.monotonic_us);
  } else if (header->seq < follower_.next_seq(header->sender, header->boot_id)) {
    answer_wanted_ = true;
  }
}

void Recorder::ReportStatus(ProcessState state, std::int64_t tick, const Usage& usage,
                            const Now& now) {
  process_status_t status{};
  status.name = sender_.identity().name;
  status.host = usage.host;
  status.pid = usage.pid;
  status.state = static_cast<std::int8_t>(state);
  status.tick = tick;
  status.received = heard_packets_;
  status.lost = follower_.missing();
  status.rejected = follower_.strangers() + refused_;
  status.resent = sender_.resent();
  status.cpu_s = usage.cpu_s;
  status.rss_bytes = usage.rss_bytes;
  sender_.Send(channel::kProcess, std::move(status), sim_us_, now);
  has_news_out_ = true;
  poke_.Start(now.monotonic_us);
}

void Recorder::Finish(std::int64_t tick, const Usage& usage, const Now& now) {
  finishing_ = true;
  ReportStatus(ProcessState::kEnded, tick, usage, now);
}

std::int64_t Recorder::unrecorded_own() const {
  if (marks_ == Marks::kOfTwoRecorders) return sender_.drained() ? 0 : 1;
  const Identity& own = sender_.identity();
  return sender_.next_seq() - follower_.next_seq(own.name, own.boot_id);
}

bool Recorder::behind() const { return unrecorded_own() > 0 || others_behind(); }

bool Recorder::others_behind() const {
  const bool lacks = std::any_of(heard_.begin(), heard_.end(), [this](const auto& entry) {
    return IsAwaited(entry.first, entry.second);
  });
  return lacks || owes();
}

bool Recorder::IsAwaited(const Start& start, std::int64_t heard) const {
  // Messages of a start that has ended and that no process has heard are lost.
  return heard > follower_.next_seq(start.first, start.second) && !ended_.contains(start) &&
         !given_up_.contains(start);
}

std::vector<Recorder::Gap> Recorder::gaps() const {
  std::vector<Gap> gaps;
  for (const auto& [start, heard] : heard_) {
    if (!IsAwaited(start, heard)) continue;
    const auto& [sender, boot_id] = start;
    gaps.push_back({sender, boot_id, follower_.missing_below(sender, boot_id, heard)});
  }
  return gaps;
}

void Recorder::Repeat(const Now& now) {
  sender_.Resend(newest_status_);
  answer_wanted_ = false;
  repeated_us_ = now.monotonic_us;
  idle_.Start(now.monotonic_us);
}

void Recorder::Step(const Now& now, std::vector<Packet>* out) {
  const TimeUs time_us = now.monotonic_us;
  if (marks_ != Marks::kOwn) {
    // It writes what it hears, and says so.
  } else if (news_ && !finishing_ && unrecorded_own() < kWindow) {
    newest_status_ = sender_.Send(channel::kLog, follower_.Status(), sim_us_, now);
    news_ = answer_wanted_ = false;
    marks_us_ = time_us;
    poke_.Start(time_us);
    idle_.Start(time_us);
  } else if (newest_status_) {
    const bool poke = time_us >= PokeUs() && poke_.Fire(time_us);
    const bool answer = answer_wanted_ && time_us >= AnswerUs();
    if (poke || answer || idle_.Fire(time_us)) Repeat(now);
  }
  if (owes() && repair_.Fire(time_us)) {
    std::vector<const Packet*> batch;
    std::size_t bytes = 0;
    for (const Start& start : ended_) {
      const auto kept = kept_.find(start);
      if (kept == kept_.end()) continue;
      for (const auto& [seq, packet] : kept->second) {
        if (batch.size() == kRepairBatch) break;
        batch.push_back(&packet);
        bytes += packet.bytes.size();
      }
    }
    if (budget_.Take(bytes, time_us, &repaired_over_us_)) {
      for (const Packet* packet : batch) out->push_back(*packet);
    }
  }
  sender_.Flush(now, out);
}

TimeUs Recorder::PokeUs() const {
  if (!behind()) return kNever;
  // That the last marks are in the log nobody awaits but the next ones.
  const bool is_urgent =
      has_news_out_ || finishing_ || unrecorded_own() + 1 >= kWindow || others_behind();
  return is_urgent ? poke_.due_us() : std::max(poke_.due_us(), marks_us_ + kOwnMarksUs);
}

TimeUs Recorder::AnswerUs() const { return std::max(repeated_us_, marks_us_) + kMarksAgainUs; }

TimeUs Recorder::wake_us() const {
  TimeUs wake = sender_.wake_us();
  if (owes()) wake = std::min(wake, repair_.due_us());
  if (marks_ != Marks::kOwn) return wake;
  wake = std::min({wake, idle_.due_us(), PokeUs()});
  if (answer_wanted_) wake = std::min(wake, AnswerUs());
  return wake;
}

}  // namespace muster::recorder
