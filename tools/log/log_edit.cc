#include "tools/log/log_edit.h"

#include <filesystem>
#include <map>
#include <tuple>

#include "base/check.h"
#include "base/interval_set.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "tools/files/pending_file.h"

namespace muster::tools {
namespace {

EditResult Copy(LogSource* source, const std::string& out,
                const std::function<bool(const LoggedMessage&)>& keeps) {
  if (std::filesystem::exists(out)) {
    throw InputError("command line", "--out", out, "a file that does not exist");
  }
  PendingFile pending(out);
  EditResult result;
  {
    EventLogWriter writer(pending.temporary());
    while (const auto message = source->Next()) {
      ++result.read;
      if (!keeps(*message)) continue;
      writer.Write(message->received_us, WithTag(message->packet, message->tag));
      ++result.written;
    }
    writer.Flush();
  }
  pending.Commit();
  return result;
}

}  // namespace

EditResult RepairLog(LogSource* source, const std::string& out) {
  std::map<std::tuple<std::int64_t, std::string, std::int64_t>, IntervalSet> seen;
  return Copy(source, out, [&](const LoggedMessage& message) {
    // Channels of others are kept as they are; on ours, only what is a message.
    if (FindChannel(message.packet.channel) == nullptr) return true;
    if (!message.header) return false;
    const header_t& h = *message.header;
    return seen[{h.run_id, h.sender, h.boot_id}].Add(h.seq);
  });
}

EditResult CutLog(LogSource* source, std::int64_t from_us, std::int64_t to_us,
                  const std::string& out) {
  std::int64_t at_us = 0;
  return Copy(source, out, [&](const LoggedMessage& message) {
    if (message.header) at_us = message.header->sim_us;
    // Without the orders before it nobody knew what it is about.
    return message.packet.channel == channel::kScenario ||
           message.packet.channel == channel::kRoads ||
           (message.packet.channel == channel::kOrders && at_us <= to_us) ||
           (from_us <= at_us && at_us <= to_us);
  });
}

}  // namespace muster::tools
