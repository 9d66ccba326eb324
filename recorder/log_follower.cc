#include "recorder/log_follower.h"

#include "lcmtypes/bus/codec.h"
#include "protocol/inbox.h"

namespace muster::recorder {

std::optional<header_t> LogFollower::Add(const Packet& event) {
  // lcm-logger records all of LCM: self-tests, and what users' own tools say.
  if (!event.channel.starts_with("MUSTER_")) return std::nullopt;
  std::optional<header_t> header = DecodeHeader(event);
  if (!header || header->run_id != run_id_ || header->seq >= kMostSeq) {
    ++strangers_;
    return std::nullopt;
  }
  const auto bytes = static_cast<std::int64_t>(event.bytes.size());
  if (!starts_[{header->sender, header->boot_id}].Add(header->seq)) {
    ++doubles_;
    double_bytes_ += bytes;
    return std::nullopt;
  }
  ++messages_;
  message_bytes_ += bytes;
  return header;
}

std::int64_t LogFollower::next_seq(const std::string& sender, std::int64_t boot_id) const {
  const auto start = starts_.find({sender, boot_id});
  return start == starts_.end() ? 0 : start->second.next();
}

bool LogFollower::Contains(const header_t& header) const {
  const auto start = starts_.find({header.sender, header.boot_id});
  return start != starts_.end() && start->second.Contains(header.seq);
}

std::int64_t LogFollower::missing_below(const std::string& sender, std::int64_t boot_id,
                                        std::int64_t seq) const {
  const auto start = starts_.find({sender, boot_id});
  if (start == starts_.end()) return seq;
  std::int64_t sum = 0;
  for (const IntervalSet::Range& range : start->second.Missing(0, seq - 1)) {
    sum += range.last - range.first + 1;
  }
  return sum;
}

std::int64_t LogFollower::missing() const {
  std::int64_t sum = 0;
  for (const auto& [start, seqs] : starts_) sum += GapsIn(seqs);
  return sum;
}

log_status_t LogFollower::Status() const {
  log_status_t status{};
  for (const auto& [start, seqs] : starts_) {
    log_mark_t& mark = status.marks.emplace_back();
    mark.sender = start.first;
    mark.boot_id = start.second;
    mark.next_seq = seqs.next();
  }
  status.n = static_cast<std::int32_t>(status.marks.size());
  return status;
}

}  // namespace muster::recorder
