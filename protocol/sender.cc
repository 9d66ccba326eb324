#include "protocol/sender.h"

#include <algorithm>
#include <utility>

namespace muster {
namespace {

/// How many of the oldest unacknowledged messages one repair sends again; more of small ones,
/// where that many may be out.
constexpr std::size_t kRepairBatch = 4;
constexpr std::size_t kRepairBytes = 8 * 1024;
constexpr TimeUs kFirstRepairUs = 20'000;
constexpr TimeUs kLongestRepairUs = 500'000;

/// Of repeats, beside what was said for the first time.
constexpr double kBurstBytes = 256 * 1024;
constexpr double kBytesPerS = 256 * 1024;
/// The least that readers are expected to take in.
constexpr double kReadBytesPerS = 20e6;

TimeUs ReadingUs(std::size_t bytes) {
  return static_cast<TimeUs>(static_cast<double>(bytes) / kReadBytesPerS * 1e6);
}

}  // namespace

void RepeatBudget::Pass(TimeUs now_us) {
  if (passed_us_ == kNever) {
    passed_us_ = now_us;
    left_bytes_ += kBurstBytes;
  }
  const double more = ToSeconds(now_us - passed_us_) * kBytesPerS;
  left_bytes_ = std::max(left_bytes_, std::min(left_bytes_ + more, kBurstBytes));
  passed_us_ = now_us;
}

void RepeatBudget::NoteFirst(std::size_t bytes, TimeUs now_us) {
  left_bytes_ += static_cast<double>(bytes);
  quiet_until_us_ = std::max(quiet_until_us_, now_us) + ReadingUs(bytes);
}

bool RepeatBudget::Take(std::size_t bytes, TimeUs now_us, TimeUs* over_us) {
  Pass(now_us);
  if (now_us < quiet_until_us_) return false;
  const auto size = static_cast<double>(bytes);
  if (left_bytes_ < size) {
    if (now_us < *over_us + kSecondUs) return false;
    *over_us = now_us;
  }
  left_bytes_ = std::max(0.0, left_bytes_ - size);
  quiet_until_us_ = now_us + ReadingUs(bytes);
  return true;
}

Sender::Sender(Identity identity, Window window)
    : identity_(std::move(identity)), window_(window) {}

header_t Sender::NextHeader(TimeUs sim_us, const Now& now) {
  header_t header;
  header.run_id = identity_.run_id;
  header.sender = identity_.name;
  header.boot_id = identity_.boot_id;
  header.seq = next_seq_++;
  header.sim_us = sim_us;
  header.wall_us = now.wall_us;
  return header;
}

SentPacket Sender::Queue(SentPacket packet) {
  kept_.push_back(packet);
  return packet;
}

void Sender::Resend(const SentPacket& packet) {
  const auto unsent = kept_.begin() + static_cast<std::ptrdiff_t>(out_);
  if (std::find(unsent, kept_.end(), packet) != kept_.end()) return;
  if (std::find(resend_.begin(), resend_.end(), packet) == resend_.end()) resend_.push_back(packet);
}

void Sender::Acknowledge(const log_status_t& status) {
  if (window_.messages == 0) return;
  for (const log_mark_t& mark : status.marks) {
    if (mark.sender != identity_.name || mark.boot_id != identity_.boot_id) continue;
    while (out_ > 0 && first_kept_seq_ < mark.next_seq) {
      out_bytes_ -= kept_.front()->bytes.size();
      acknowledged_sent_us_ = std::max(acknowledged_sent_us_, sent_us_.front());
      sent_us_.pop_front();
      kept_.pop_front();
      --out_;
      ++first_kept_seq_;
      progressed_ = true;
      repair_.Stop();
    }
  }
}

void Sender::Repeat(const std::vector<SentPacket>& packets, TimeUs now_us, TimeUs* over_us,
                    std::vector<Packet>* out) {
  std::size_t bytes = 0;
  for (const SentPacket& packet : packets) bytes += packet->bytes.size();
  if (!budget_.Take(bytes, now_us, over_us)) return;
  // What is acknowledged now tells nothing: in order, or twice.
  std::fill(sent_us_.begin(), sent_us_.end(), -1);
  for (const SentPacket& packet : packets) out->push_back(*packet);
  resent_ += static_cast<std::int64_t>(packets.size());
}

bool Sender::HasRoom() const {
  return window_.messages == 0 || out_ < static_cast<std::size_t>(window_.messages) ||
         out_bytes_ + kept_[out_]->bytes.size() <= window_.bytes;
}

void Sender::Flush(const Now& now, std::vector<Packet>* out) {
  const TimeUs now_us = now.monotonic_us;
  if (out_ == 0 || std::exchange(progressed_, false)) progress_us_ = now_us;
  if (const TimeUs sent_us = std::exchange(acknowledged_sent_us_, -1); sent_us >= 0) {
    answer_us_ = std::max(now_us - sent_us, answer_us_ - answer_us_ / 8);
  }
  if (!resend_.empty()) Repeat(std::exchange(resend_, {}), now_us, &resent_over_us_, out);
  if (repair_.Fire(now_us)) {
    std::size_t n = 0, bytes = 0;
    const std::size_t most_bytes = std::min(kRepairBytes, window_.bytes);
    for (; n < out_ && (n < kRepairBatch || bytes < most_bytes); ++n) {
      bytes += kept_[n]->bytes.size();
    }
    Repeat({kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(n)}, now_us,
           &repaired_over_us_, out);
  }
  while (out_ < kept_.size() && HasRoom()) {
    const std::size_t bytes = kept_[out_]->bytes.size();
    budget_.NoteFirst(bytes, now_us);
    out->push_back(*kept_[out_]);
    ++out_;
    out_bytes_ += bytes;
    sent_us_.push_back(now_us);
  }
  if (window_.messages == 0) {
    first_kept_seq_ += static_cast<std::int64_t>(out_);
    kept_.clear();
    sent_us_.clear();
    out_ = out_bytes_ = 0;
  } else if (out_ > 0 && repair_.due_us() == kNever) {
    repair_ =
        BackOff(std::clamp(4 * answer_us_, kFirstRepairUs, kLongestRepairUs), kLongestRepairUs);
    repair_.Start(now_us);
  }
}

}  // namespace muster
