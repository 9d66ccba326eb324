#pragma once

#include <linux/filter.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/channels.h"

namespace muster {

/// On which each process looks at the network when it starts. Not MUSTER_*: other members of the
/// mission must not count it as a stranger.
inline constexpr const char* kRoundTripChannel = "ROUND_TRIP_OF_MUSTER";

/// Which channels come through a guard.
enum class GuardedChannels {
  kOurs,         ///< the channel table's and the two on which LCM and we look at the network
  kAny,          ///< every name
  kOfWorld,      ///< of ours, those that the world hears
  kOfAgents,     ///< of ours, those that an agents' process hears
  kOfScheduler,  ///< of ours, those that the scheduler hears
};

/// Whether messages of that channel pass. A process is not woken by messages that it does not use.
bool ComesThrough(const Channel& channel, GuardedChannels channels);

/// The program (classic BPF) that looks at a datagram, from its UDP header on, before LCM reads it,
/// and drops what LCM cannot take safely or as one of our messages:
///
/// - shorter than its header, or neither LC02 (a whole message) nor LC03 (a fragment);
/// - a channel's name that is empty, longer than 63 bytes, not of printable ASCII or not ended by a
///   NUL in the datagram;
/// - a message that is empty (fragments) or larger than the channel table's largest;
/// - a fragment numbered beyond their count, or whose bytes lie beyond the message;
/// - a first fragment that does not begin the message, a last one that does not end it, and one in
///   between that is too small for so many to make up the message.
///
/// Source: udp_read_packet and _recv_message_fragment of liblcm 1.3.1, which trust all of that. It
/// keeps no state: what it cannot see is a fragment that comes twice. LCM counts fragments and then
/// hands out the message with a hole, which holds what that memory held before; it writes nowhere
/// else, and the decoders take such a message for any other damaged one.
std::vector<sock_filter> DatagramGuard(GuardedChannels channels);

/// Attaches the guard to a datagram socket; what it has queued already stays. Returns why it could
/// not, or none.
std::optional<std::string> GuardSocket(int fd, GuardedChannels channels);

/// This process's IPv4 datagram sockets that are bound to `port`. LCM does not tell its own.
std::vector<int> SocketsOnPort(std::uint16_t port);

/// Whether `fd` is an IPv4 datagram socket bound to `port`.
bool IsOnPort(int fd, std::uint16_t port);

}  // namespace muster
