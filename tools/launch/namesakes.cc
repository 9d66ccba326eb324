#include "tools/launch/namesakes.h"

#include <fmt/format.h>

#include "lcmtypes/bus/codec.h"

namespace muster::tools {

std::optional<std::string> Namesakes::OnHeard(const Packet& packet) {
  const auto status = DecodeValid<process_status_t>(packet.bytes);
  if (!status || status->name != status->header.sender) return {};
  const std::pair start(status->name, status->header.boot_id);
  if (first_.size() >= kMost && !first_.contains(start)) return {};
  const Self self = {status->host, status->pid};
  const Self& first = first_.try_emplace(start, self).first->second;
  if (first == self || !said_.insert(status->name).second) return {};
  return fmt::format(
      "two processes speak as {}: pid {} on {} and pid {} on {}: one of them is not of this "
      "mission, and what it says may be believed",
      status->name, first.pid, first.host, self.pid, self.host);
}

}  // namespace muster::tools
