#include "protocol/sender.h"

#include <algorithm>
#include <utility>

namespace muster {
namespace {

/// How many of the oldest unacknowledged messages one repair sends again.
constexpr std::size_t kRepairBatch = 4;

}  // namespace

Sender::Sender(Identity identity, int window)
    : identity_(std::move(identity)), window_(static_cast<std::size_t>(window)) {}

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
  resend_.push_back(packet);
}

void Sender::Acknowledge(const log_status_t& status) {
  if (window_ == 0) return;
  for (const log_mark_t& mark : status.marks) {
    if (mark.sender != identity_.name || mark.boot_id != identity_.boot_id) continue;
    while (out_ > 0 && first_kept_seq_ < mark.next_seq) {
      kept_.pop_front();
      --out_;
      ++first_kept_seq_;
      progressed_ = true;
      repair_.Stop();
    }
  }
}

void Sender::Flush(const Now& now, std::vector<Packet>* out) {
  if (out_ == 0 || std::exchange(progressed_, false)) progress_us_ = now.monotonic_us;
  for (const SentPacket& packet : resend_) out->push_back(*packet);
  resent_ += static_cast<std::int64_t>(resend_.size());
  resend_.clear();
  if (repair_.Fire(now.monotonic_us)) {
    for (std::size_t i = 0; i < std::min(out_, kRepairBatch); ++i) {
      out->push_back(*kept_[i]);
      ++resent_;
    }
  }
  while (out_ < kept_.size() && (window_ == 0 || out_ < window_)) {
    out->push_back(*kept_[out_]);
    ++out_;
  }
  if (window_ == 0) {
    first_kept_seq_ += static_cast<std::int64_t>(out_);
    kept_.clear();
    out_ = 0;
  } else if (out_ > 0 && repair_.due_us() == kNever) {
    repair_.Start(now.monotonic_us);
  }
}

}  // namespace muster
