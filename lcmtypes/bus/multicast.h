#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace muster {

/// The parts of an LCM URL "udpm://ADDRESS:PORT?ttl=N&recv_buf_size=N".
struct MulticastUrl {
  std::string address = "239.255.76.67";
  std::uint16_t port = 7667;
  int ttl = 0;
  std::int64_t recv_buf_size = 0;  ///< bytes; 0: the system's default
};

/// Throws InputError (naming `key`, the flag or variable that the URL came from) when `url` is not
/// of that form. Parts that are left out have LCM's defaults.
MulticastUrl ParseMulticastUrl(const std::string& url, const std::string& key = "--lcm-url");

/// The URL of a mission on `port`: ttl 0 keeps its packets on this host; the receive buffer takes a
/// whole tick's burst.
std::string MissionUrl(std::uint16_t port, int ttl = 0);

/// LCM_DEFAULT_URL when set, else MissionUrl(7667).
std::string DefaultUrl();

/// What a user can do on a host that carries no multicast.
inline constexpr std::string_view kMulticastAdvice =
    "run as root: ip link set lo up && ip route add 224.0.0.0/4 dev lo";

/// Leaves the group and joins it again, on the interface that multicast goes to now: the membership
/// that a socket had on an interface is gone with it. Where there is none now, it is no member.
void JoinAgain(int socket, const std::string& address);

/// Whether what `send` sends comes back within `limit`. It is sent again every 20 ms, also
/// while other packets arrive: when many processes start at once, a first packet may be lost.
/// `wait` waits for up to that many microseconds for arrivals, and tells whether it was among them.
bool ComesBack(const std::function<void()>& send, const std::function<bool(std::int64_t)>& wait,
               std::chrono::milliseconds limit);

/// Sends packets with ttl 0 to the multicast address on a port of its own and waits up to a second
/// for one to come back. None when it does, else what is wrong. Starts no threads.
std::optional<std::string> MulticastProblem(const std::string& address);

}  // namespace muster
