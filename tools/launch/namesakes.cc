#include "tools/launch/namesakes.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <string_view>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "protocol/inbox.h"

namespace muster::tools {
namespace {

std::size_t HashOf(const Packet& packet) {
  const std::string_view bytes(reinterpret_cast<const char*>(packet.bytes.data()),
                               packet.bytes.size());
  return std::hash<std::string_view>()(packet.channel) * 31 + std::hash<std::string_view>()(bytes);
}

}  // namespace

std::string Namesakes::Contradiction(const Packet& packet, const header_t& header,
                                     const Known& known, Start* start) {
  if (header.boot_id >= known.starts) {
    return fmt::format("it claims start {}, which never happened", header.boot_id);
  }
  const std::int64_t logged = std::max(known.logged, start->logged);
  if (header.seq >= kFar && header.seq - kFar >= logged) {
    return fmt::format("message {} is far ahead of its message {}, which the log awaits",
                       header.seq, logged);
  }
  const std::size_t hash = HashOf(packet);
  const auto [said, is_new] = start->recent.try_emplace(header.seq, hash);
  if (!is_new) {
    const bool contradicts = said->second != hash && DecodeMessage(packet);
    return contradicts ? fmt::format("its message {} says two things", header.seq) : "";
  }
  if (start->recent.size() > kRecent) start->recent.erase(start->recent.begin());
  if (header.seq > start->newest_seq) {
    start->newest_seq = header.seq;
    start->newest_wall_us = header.wall_us;
  } else if (header.seq < start->newest_seq - kFar && header.wall_us > start->newest_wall_us) {
    return fmt::format("its message {} is older than its message {}", start->newest_seq,
                       header.seq);
  }
  return "";
}

void Namesakes::NoteMarks(const Packet& packet) {
  const auto status = DecodeValid<log_status_t>(packet.bytes);
  if (!status) return;
  for (const log_mark_t& mark : status->marks) {
    const auto start = starts_.find({mark.sender, mark.boot_id});
    if (start == starts_.end()) continue;
    start->second.logged = std::max(start->second.logged, mark.next_seq);
  }
}

std::optional<std::string> Namesakes::OnHeard(const Packet& packet, const header_t& header,
                                              const Known& known) {
  const std::pair key(header.sender, header.boot_id);
  if (starts_.size() >= kMost && !starts_.contains(key)) return {};
  Start& start = starts_[key];
  if (packet.channel == channel::kLog && header.sender == process_name::kRecorder) {
    NoteMarks(packet);
  }
  if (packet.channel == channel::kProcess) {
    const auto status = DecodeValid<process_status_t>(packet.bytes);
    if (status && status->name == header.sender) {
      const Self self = {status->host, status->pid};
      if (!start.self) start.self = self;
      if (*start.self != self && said_pids_.insert(header.sender).second) {
        said_.insert(header.sender);
        return fmt::format(
            "two processes send as {}: pid {} on {} and pid {} on {}. One of them does not belong "
            "to "
            "this mission, and what it says may be believed",
            status->name, start.self->pid, start.self->host, self.pid, self.host);
      }
    }
  }
  const std::string contradiction = Contradiction(packet, header, known, &start);
  if (contradiction.empty() || !said_.insert(header.sender).second) return {};
  return fmt::format(
      "another process sends as {}, too: {}. What it says may be believed (with --seal only "
      "members "
      "of the mission are)",
      header.sender, contradiction);
}

}  // namespace muster::tools
