#include "lcmtypes/bus/multicast.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "base/check.h"
#include "base/text.h"

namespace muster {
namespace {

template <class Number>
bool ParseNumber(std::string_view text, Number low, Number high, Number* value) {
  const auto number = ToInteger(text, low, high);
  if (number) *value = static_cast<Number>(*number);
  return number.has_value();
}

class Socket {
 public:
  Socket() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~Socket() {
    if (fd_ >= 0) close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

std::string Problem(const std::string& address, const char* what) {
  return fmt::format("{} {}: {}", what, address, std::strerror(errno));
}

}  // namespace

MulticastUrl ParseMulticastUrl(const std::string& url, const std::string& key) {
  const auto fail = [&](std::string_view expected) {
    throw InputError("LCM URL", key, fmt::format("'{}'", url), expected);
  };
  constexpr std::string_view kScheme = "udpm://";
  std::string_view rest = url;
  if (!rest.starts_with(kScheme)) fail("udpm://ADDRESS:PORT?ttl=0");
  rest.remove_prefix(kScheme.size());
  const std::size_t question = rest.find('?');
  std::string_view options;
  if (question != std::string_view::npos) {
    options = rest.substr(question + 1);
    rest = rest.substr(0, question);
  }
  MulticastUrl parts;
  const std::size_t colon = rest.find(':');
  if (colon != std::string_view::npos) {
    if (!ParseNumber<std::uint16_t>(rest.substr(colon + 1), 1, 65535, &parts.port)) {
      fail("a port from 1 to 65535");
    }
    rest = rest.substr(0, colon);
  }
  if (!rest.empty()) parts.address = rest;
  in_addr group{};
  if (inet_pton(AF_INET, parts.address.c_str(), &group) != 1 ||
      !IN_MULTICAST(ntohl(group.s_addr))) {
    fail("an address from 224.0.0.0 to 239.255.255.255");
  }
  while (!options.empty()) {
    const std::size_t end = options.find('&');
    const std::string_view option = options.substr(0, end);
    options = end == std::string_view::npos ? "" : options.substr(end + 1);
    const std::size_t equals = option.find('=');
    const std::string_view name = option.substr(0, equals);
    const std::string_view value =
        equals == std::string_view::npos ? "" : option.substr(equals + 1);
    if (name == "ttl") {
      if (!ParseNumber(value, 0, 255, &parts.ttl)) fail("ttl from 0 to 255");
    } else if (name == "recv_buf_size") {
      if (!ParseNumber<std::int64_t>(value, 1, 1 << 30, &parts.recv_buf_size)) {
        fail("recv_buf_size from 1 to 2^30 bytes");
      }
    } else {
      fail("no options but ttl and recv_buf_size");
    }
  }
  return parts;
}

std::string MissionUrl(std::uint16_t port, int ttl) {
  return fmt::format("udpm://239.255.76.67:{}?ttl={}&recv_buf_size=2097152", port, ttl);
}

std::string DefaultUrl() {
  const char* url = std::getenv("LCM_DEFAULT_URL");
  return url != nullptr && *url != '\0' ? url : MissionUrl(MulticastUrl().port);
}

void JoinAgain(int socket, const std::string& address) {
  ip_mreq membership{};
  membership.imr_interface.s_addr = htonl(INADDR_ANY);
  if (inet_pton(AF_INET, address.c_str(), &membership.imr_multiaddr) != 1) return;
  for (const int option : {IP_DROP_MEMBERSHIP, IP_ADD_MEMBERSHIP}) {
    setsockopt(socket, IPPROTO_IP, option, &membership, sizeof membership);
  }
}

bool ComesBack(const std::function<void()>& send, const std::function<bool(std::int64_t)>& wait,
               std::chrono::milliseconds limit) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::microseconds kAgain = std::chrono::milliseconds(20);
  const auto end = Clock::now() + limit;
  for (auto again = Clock::now(); Clock::now() < end;) {
    if (Clock::now() >= again) {
      send();
      again = Clock::now() + kAgain;
    }
    const auto left = std::chrono::duration_cast<std::chrono::microseconds>(again - Clock::now());
    if (wait(std::max<std::int64_t>(left.count(), 0))) return true;
  }
  return wait(0);  // who was frozen meanwhile may find it there
}

std::optional<std::string> MulticastProblem(const std::string& address) {
  const Socket receiver;
  const Socket sender;
  if (receiver.fd() < 0 || sender.fd() < 0) return Problem(address, "cannot open a socket for");

  sockaddr_in local{};
  local.sin_family = AF_INET;
  local.sin_addr.s_addr = htonl(INADDR_ANY);
  socklen_t length = sizeof(local);
  if (bind(receiver.fd(), reinterpret_cast<const sockaddr*>(&local), length) != 0 ||
      getsockname(receiver.fd(), reinterpret_cast<sockaddr*>(&local), &length) != 0) {
    return Problem(address, "cannot bind a port for");
  }
  ip_mreq membership{};
  membership.imr_interface.s_addr = htonl(INADDR_ANY);
  if (inet_pton(AF_INET, address.c_str(), &membership.imr_multiaddr) != 1) {
    errno = EINVAL;
    return Problem(address, "cannot join");
  }
  if (setsockopt(receiver.fd(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) !=
      0) {
    return Problem(address, "cannot join");
  }
  const unsigned char ttl = 0;
  if (setsockopt(sender.fd(), IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof(ttl)) != 0) {
    return Problem(address, "cannot set the ttl for");
  }
  sockaddr_in group = local;
  group.sin_addr = membership.imr_multiaddr;
  const std::string text = fmt::format("muster {} {}", getpid(),
                                       std::chrono::steady_clock::now().time_since_epoch().count());
  bool sent = true;
  const auto send = [&] {
    sent &= sendto(sender.fd(), text.data(), text.size(), 0,
                   reinterpret_cast<const sockaddr*>(&group), sizeof(group)) >= 0;
  };
  const auto wait = [&](std::int64_t timeout_us) {
    if (!sent) return true;
    pollfd waiting{receiver.fd(), POLLIN, 0};
    const timespec timeout{0, timeout_us * 1000};
    if (ppoll(&waiting, 1, &timeout, nullptr) <= 0) return false;
    std::array<char, 128> buffer;
    const ssize_t got = recv(receiver.fd(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    return got >= 0 && std::string_view(buffer.data(), static_cast<std::size_t>(got)) == text;
  };
  if (ComesBack(send, wait, std::chrono::seconds(1))) {
    return sent ? std::nullopt : std::optional(Problem(address, "cannot send to"));
  }
  return fmt::format("packets to {} do not come back, a firewall may drop them", address);
}

}  // namespace muster
