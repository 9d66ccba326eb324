#include "tools/log/log_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/text.h"
#include "base/units.h"
#include "lcmtypes/channels.h"

namespace muster::tools {

void LogInfo::Add(const LoggedMessage& message) {
  Channel& channel = channels[message.packet.channel];
  ++channel.messages;
  channel.bytes += static_cast<std::int64_t>(message.packet.bytes.size() + message.tag.size());
  if (messages == 0) first_received_us = message.received_us;
  last_received_us = std::max(last_received_us, message.received_us);
  ++messages;
  ours += FindChannel(message.packet.channel) != nullptr;
  sealed += !message.tag.empty();
  if (!message.header) {
    if (FindChannel(message.packet.channel) != nullptr) ++channel.undecodable;
    return;
  }
  const header_t& header = *message.header;
  if (channel.first_sim_us < 0) channel.first_sim_us = header.sim_us;
  channel.last_sim_us = std::max(channel.last_sim_us, header.sim_us);
  Sender& sender = senders[{header.run_id, header.sender, header.boot_id}];
  if (sender.seqs.Add(header.seq)) {
    ++sender.messages;
  } else {
    ++sender.repeats;
  }
}

LogInfo ReadLogInfo(const std::string& run) {
  LogInfo info;
  LogSource source(run);
  source.ShowProgress("info");
  while (const auto message = source.Next()) info.Add(*message);
  info.files = source.files();
  info.garbage_bytes = source.garbage_bytes();
  info.refused = source.refused();
  return info;
}

std::string ToText(const LogInfo& info) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (const std::string& file : info.files) fmt::format_to(out, "{}\n", file);
  fmt::format_to(out, "{} messages in {:.3f} s of wall time, {} bytes of garbage\n\n",
                 info.messages, ToSeconds(info.last_received_us - info.first_received_us),
                 info.garbage_bytes);
  if (info.sealed > 0) {
    fmt::format_to(out, "sealed: {} of {} messages have a tag{}\n\n", info.sealed, info.ours,
                   info.refused > 0
                       ? fmt::format(", {} without the right one are left out", info.refused)
                       : "");
  }
  fmt::format_to(out, "{:<20} {:>10} {:>12} {:>12} {:>12} {:>11}\n", "channel", "messages", "bytes",
                 "first s", "last s", "undecodable");
  for (const auto& [name, c] : info.channels) {
    const auto seconds = [](std::int64_t us) {
      return us < 0 ? std::string("-") : fmt::format("{:.1f}", ToSeconds(us));
    };
    fmt::format_to(out, "{:<20} {:>10} {:>12} {:>12} {:>12} {:>11}\n", Printable(name), c.messages,
                   c.bytes, seconds(c.first_sim_us), seconds(c.last_sim_us), c.undecodable);
  }
  fmt::format_to(out, "\n{:<20} {:>5} {:>10} {:>8} {:>10}  {}\n", "sender", "start", "messages",
                 "repeats", "missing", "run");
  for (const auto& [key, s] : info.senders) {
    const auto& [run, name, start] = key;
    std::int64_t missing = 0;
    for (const IntervalSet::Range& gap : s.Gaps()) missing += gap.last - gap.first + 1;
    fmt::format_to(out, "{:<20} {:>5} {:>10} {:>8} {:>10}  {}\n", name, start, s.messages,
                   s.repeats, missing, run);
  }
  return text;
}

nlohmann::ordered_json ToJson(const LogInfo& info) {
  nlohmann::ordered_json channels = nlohmann::ordered_json::array();
  for (const auto& [name, c] : info.channels) {
    channels.push_back({{"name", name},
                        {"messages", c.messages},
                        {"bytes", c.bytes},
                        {"undecodable", c.undecodable},
                        {"first_sim_us", c.first_sim_us},
                        {"last_sim_us", c.last_sim_us}});
  }
  nlohmann::ordered_json senders = nlohmann::ordered_json::array();
  for (const auto& [key, s] : info.senders) {
    nlohmann::ordered_json gaps = nlohmann::ordered_json::array();
    for (const IntervalSet::Range& gap : s.Gaps()) {
      gaps.push_back({{"first_seq", gap.first}, {"last_seq", gap.last}});
    }
    senders.push_back({{"run_id", std::get<0>(key)},
                       {"name", std::get<1>(key)},
                       {"boot_id", std::get<2>(key)},
                       {"messages", s.messages},
                       {"repeats", s.repeats},
                       {"gaps", std::move(gaps)}});
  }
  return {{"files", info.files},
          {"messages", info.messages},
          {"sealed", info.sealed},
          {"refused", info.refused},
          {"garbage_bytes", info.garbage_bytes},
          {"first_received_us", info.first_received_us},
          {"last_received_us", info.last_received_us},
          {"channels", std::move(channels)},
          {"senders", std::move(senders)}};
}

}  // namespace muster::tools
