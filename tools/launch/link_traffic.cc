#include "tools/launch/link_traffic.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "lcmtypes/bus/codec.h"

namespace muster::tools {
namespace {

// liblcm 1.3.1, udpm_util.h: a whole message has 8 bytes before its channel, a fragment 20.
constexpr std::int64_t kShortHeader = 8, kFragmentHeader = 20;
constexpr std::int64_t kShortMost = 65499, kFragmentMost = 65487;  // channel and data
constexpr std::int64_t kUdpHeader = 8, kIpHeader = 20;
constexpr std::int64_t kEthernet = 18;  // with the checksum behind
constexpr std::int64_t kIpPayload = 1500 - kIpHeader;
/// From here on a link counts as full: what of it is left goes to waiting for answers.
constexpr double kFull = 0.7;

std::int64_t OfDatagram(std::int64_t bytes) {
  const std::int64_t fragments = (kUdpHeader + bytes + kIpPayload - 1) / kIpPayload;
  return kUdpHeader + bytes + fragments * (kIpHeader + kEthernet);
}

double MbitPerSecond(std::int64_t bytes, double seconds) {
  return seconds > 0 ? static_cast<double>(bytes) * 8e-6 / seconds : 0;
}

}  // namespace

std::int64_t WireBytes(const Packet& packet) {
  const std::int64_t content =
      static_cast<std::int64_t>(packet.channel.size() + 1 + packet.bytes.size());
  if (content <= kShortMost) return OfDatagram(kShortHeader + content);
  const std::int64_t rest = content % kFragmentMost;
  return content / kFragmentMost * OfDatagram(kFragmentHeader + kFragmentMost) +
         (rest > 0 ? OfDatagram(kFragmentHeader + rest) : 0);
}

LinkTraffic::LinkTraffic(const HostList& hosts, std::string here)
    : hosts_(hosts), here_(std::move(here)) {}

void LinkTraffic::Add(const Packet& packet, TimeUs now_us) {
  const std::optional<header_t> header = DecodeHeader(packet);
  if (!header) return;
  const Host* host = hosts_.Of(header->sender);
  const std::int64_t bytes = WireBytes(packet);
  first_us_ = std::min(first_us_, now_us);
  last_us_ = std::max(last_us_, now_us);
  Sent& sent = sent_[host == nullptr ? here_ : host->name];
  sent.bytes += bytes;
  sent.by_second[(now_us - first_us_) / kSecondUs] += bytes;
}

std::vector<LinkTraffic::Link> LinkTraffic::links() const {
  const double lasts_s = last_us_ > first_us_ ? ToSeconds(last_us_ - first_us_) : 0;
  Sent all;
  for (const auto& [host, sent] : sent_) {
    all.bytes += sent.bytes;
    for (const auto& [second, bytes] : sent.by_second) all.by_second[second] += bytes;
  }
  std::vector<Link> links = {{here_}};
  for (const Host& host : hosts_.hosts) links.push_back({host.name, host.mbit_s});
  for (Link& link : links) {
    const auto found = sent_.find(link.host);
    const Sent own = found == sent_.end() ? Sent{} : found->second;
    link.sent_bytes = own.bytes;
    link.heard_bytes = all.bytes - own.bytes;
    link.mean_mbit_s = MbitPerSecond(std::max(link.sent_bytes, link.heard_bytes), lasts_s);
    std::int64_t most = 0;
    for (const auto& [second, bytes] : all.by_second) {
      const auto of_own = own.by_second.find(second);
      const std::int64_t out = of_own == own.by_second.end() ? 0 : of_own->second;
      most = std::max({most, out, bytes - out});
    }
    // A mission of less than a second is no slower in its busiest one.
    link.busiest_mbit_s = std::max(MbitPerSecond(most, 1), link.mean_mbit_s);
  }
  return links;
}

std::string LinkTraffic::Text() const {
  std::string text;
  std::string fullest;
  double most = 0;
  bool known = false;
  for (const Link& link : links()) {
    std::string share;
    if (link.mbit_s > 0) {
      const double full = link.mean_mbit_s / link.mbit_s;
      share = fmt::format(" ({:.0f} % of its {:g})", 100 * full, link.mbit_s);
      known = true;
      if (full > most) most = full, fullest = link.host;
    }
    text += fmt::format(
        "{:<14} sent {:.1f} MB, heard {:.1f} MB; {:.1f} Mbit/s{}, busiest second {:.1f}\n",
        "link " + link.host, static_cast<double>(link.sent_bytes) * 1e-6,
        static_cast<double>(link.heard_bytes) * 1e-6, link.mean_mbit_s, share, link.busiest_mbit_s);
  }
  if (!known) return text;
  return text + (most >= kFull
                     ? fmt::format("{:<14} the link of {}, {:.0f} % full\n", "limited by", fullest,
                                   100 * most)
                     : fmt::format("{:<14} no link, but the processes and the delay of each "
                                   "tick's messages\n",
                                   "limited by"));
}

}  // namespace muster::tools
