#include "tools/host/host_checks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <string_view>

#include "base/check.h"
#include "lcmtypes/bus/datagram_guard.h"
#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/bus/seal.h"
#include "lcmtypes/bus/udpm_receiver.h"
#include "lcmtypes/channels.h"
#include "tools/host/child_guard.h"
#include "tools/host/network_namespace.h"

namespace muster::tools {
namespace {

using Result = HostCheck::Result;
using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

HostCheck CheckHostMulticast(const std::string& address, bool has_private) {
  HostCheck check{"host multicast", Result::kOk, fmt::format("{} comes back", address), ""};
  const auto problem = MulticastProblem(address);
  if (!problem) return check;
  check.result = has_private ? Result::kWarn : Result::kFail;
  check.found = *problem;
  check.advice = has_private ? fmt::format("only for processes started outside 'muster run': {}",
                                           kMulticastAdvice)
                             : std::string(kMulticastAdvice);
  return check;
}

/// Bytes that the kernel gives a socket that asks for `wanted` by that option; 0: it refuses. It
/// reports twice what it counts as given, for its own bookkeeping (socket(7)).
std::int64_t GivenReceiveBuffer(std::int64_t wanted, int option) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return 0;
  const int size = static_cast<int>(wanted);
  int given = 0;
  socklen_t length = sizeof(given);
  if (setsockopt(fd, SOL_SOCKET, option, &size, sizeof(size)) != 0 ||
      getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &given, &length) != 0) {
    given = 0;
  }
  close(fd);
  return given / 2;
}

std::string InMiB(std::int64_t bytes) {
  return fmt::format("{:g} MiB", static_cast<double>(bytes) / (1 << 20));
}

/// What our own sockets get (udpm_receiver.h), and those that LCM opens: of lcm-logger, of others'
/// tools, and ours too where their own buffer would be too small. In the network that missions
/// have.
HostCheck CheckReceiveBuffer(std::int64_t lcm_wanted) {
  constexpr std::int64_t kOwn = UdpmReceiver::kBufferBytes;
  if (lcm_wanted == 0) lcm_wanted = ParseMulticastUrl(MissionUrl(1)).recv_buf_size;
  const std::int64_t largest = GivenReceiveBuffer(1 << 30, SO_RCVBUF);
  const std::int64_t forced = GivenReceiveBuffer(kOwn, SO_RCVBUFFORCE);
  const std::int64_t own = std::max(forced, std::min(largest, kOwn));
  const std::int64_t of_lcm = GivenReceiveBuffer(lcm_wanted, SO_RCVBUF);
  const bool own_reads = 2 * own >= UdpmReceiver::kLeastBufferBytes;
  const std::string lcm_gets = of_lcm < lcm_wanted
                                   ? fmt::format("{} of {}", InMiB(of_lcm), InMiB(lcm_wanted))
                                   : InMiB(of_lcm);
  HostCheck check{"receive buffer", Result::kOk, "", ""};
  check.found =
      own_reads ? fmt::format("{} on our sockets, {} on LCM's", InMiB(own), lcm_gets)
                : fmt::format("{} for ours, so LCM reads for them with {}", InMiB(own), lcm_gets);
  check.found += fmt::format("; net.core.rmem_max is {}{}", InMiB(largest),
                             forced > 0 ? ", which this user may exceed" : "");
  if (!own_reads || of_lcm < lcm_wanted) {
    check.result = Result::kWarn;
    check.found += ": bursts may be lost and sent again";
    check.advice = fmt::format("run as root: sysctl -w net.core.rmem_max={}",
                               std::max(forced > 0 ? 0 : kOwn, lcm_wanted));
  }
  return check;
}

/// Local UDP ports in use in this process's network; none when the kernel does not tell.
std::optional<std::set<int>> UdpPorts() {
  std::ifstream table("/proc/net/udp");
  std::string line;
  if (!std::getline(table, line)) return std::nullopt;
  std::set<int> ports;
  while (std::getline(table, line)) {
    // "  sl: ADDRESS:PORT ...", hexadecimal.
    const std::size_t slot = line.find(": ");
    const std::size_t colon = slot == std::string::npos ? slot : line.find(':', slot + 2);
    if (colon == std::string::npos) continue;
    ports.insert(static_cast<int>(std::strtol(line.c_str() + colon + 1, nullptr, 16)));
  }
  return ports;
}

std::uint16_t FreePort(const std::set<int>& used, std::uint16_t first) {
  int port = first;
  while (used.contains(port) && port < 65535) ++port;
  return static_cast<std::uint16_t>(port);
}

HostCheck CheckPort(std::uint16_t port) {
  HostCheck check{fmt::format("port {}", port), Result::kOk, "free on the host", ""};
  const auto used = UdpPorts();
  if (!used) {
    check.result = Result::kWarn;
    check.found = "unknown: /proc/net/udp cannot be read";
    check.advice = "make sure that no other mission uses the port";
  } else if (used->contains(port)) {
    check.result = Result::kWarn;
    check.found = "in use on the host";
    check.advice =
        fmt::format("missions that share the host's network need a port each: --lcm-url '{}'",
                    MissionUrl(FreePort(*used, port)));
  }
  return check;
}

/// Median of 200 one-way trips between two buses, and a message of several fragments. On a port
/// that nobody uses: a mission under way must not hear it.
HostCheck CheckLcm(std::uint16_t port) {
  HostCheck check{"LCM " + LcmVersion(), Result::kOk, "", ""};
  try {
    const std::string url = MissionUrl(FreePort(UdpPorts().value_or(std::set<int>{}), port));
    LcmBus sender(url);
    LcmBus receiver(url);
    const auto arrives = [&](const Packet& packet) {
      sender.Publish(packet);
      const auto deadline = Clock::now() + std::chrono::seconds(2);
      while (Clock::now() < deadline) {
        for (const Packet& got : receiver.Receive(100'000)) {
          if (got == packet) return true;
        }
      }
      return false;
    };
    std::array<double, 200> trips_ms;
    for (std::size_t i = 0; i < trips_ms.size(); ++i) {
      const Packet small{std::string(channel::kScenario),
                         std::vector<std::uint8_t>(200, static_cast<std::uint8_t>(i))};
      const auto start = Clock::now();
      if (!arrives(small)) throw SystemError(fmt::format("message {} of 200 bytes was lost", i));
      trips_ms[i] = MillisecondsSince(start);
    }
    const Packet large{std::string(channel::kScenario), std::vector<std::uint8_t>(300'000, 7)};
    if (!arrives(large)) throw SystemError("a message of 300 kB in fragments was lost");
    std::nth_element(trips_ms.begin(), trips_ms.begin() + trips_ms.size() / 2, trips_ms.end());
    check.found = fmt::format("200 messages there in {:.3f} ms (median), 300 kB in fragments",
                              trips_ms[trips_ms.size() / 2]);
  } catch (const SystemError& error) {
    check.result = Result::kFail;
    check.found = error.what();
    check.advice = "see the checks above; a firewall must let multicast on this host pass";
  }
  return check;
}

/// A child that has a socket on a port, which it finds itself, until it is killed.
pid_t StartListener(std::uint16_t* port) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return -1;
  const pid_t child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in local{};
    local.sin_family = AF_INET;
    socklen_t size = sizeof local;
    if (bind(fd, reinterpret_cast<sockaddr*>(&local), size) != 0 ||
        getsockname(fd, reinterpret_cast<sockaddr*>(&local), &size) != 0 ||
        write(ends[1], &local.sin_port, sizeof local.sin_port) < 0) {
      _exit(1);
    }
    while (true) pause();
  }
  close(ends[1]);
  std::uint16_t bound = 0;
  if (read(ends[0], &bound, sizeof bound) != sizeof bound) bound = 0;
  close(ends[0]);
  *port = ntohs(bound);
  return child;
}

HostCheck CheckGuard() {
  HostCheck check{"datagram guard", Result::kOk, "on our sockets and on lcm-logger's", ""};
  std::uint16_t port = 0;
  const pid_t child = StartListener(&port);
  std::string problem;
  try {
    if (child < 0 || port == 0) throw SystemError("no process with a socket to try it on");
    if (!GuardSocketsOf(child, port)) throw SystemError("its socket is not found");
  } catch (const SystemError& error) {
    problem = error.what();
  }
  if (child > 0) {
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
  }
  const int own = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const auto own_problem = GuardSocket(own, GuardedChannels::kOurs);
  close(own);
  if (own_problem) problem = *own_problem;
  if (problem.empty()) return check;
  check.result = Result::kWarn;
  check.found = fmt::format("{} ({})", own_problem ? "none" : "not on lcm-logger's", problem);
  check.advice = "one malformed datagram on a mission's port ends every process without a guard";
  return check;
}

HostCheck CheckSeal() {
  HostCheck check{"seal", Result::kOk, "", ""};
  const Seal seal(SealKey::Fresh(1));
  const Packet message{std::string(channel::kClock), std::vector<std::uint8_t>(1024, 7)};
  Packet opened = seal.Closed(message);
  Packet damaged = opened;
  damaged.bytes.front() ^= 1;
  constexpr int kTimes = 1000;
  const auto start = Clock::now();
  for (int i = 0; i < kTimes; ++i) opened = seal.Closed(message);
  const double each_us = MillisecondsSince(start) * 1e3 / kTimes;
  if (seal.Open(&opened) && opened == message && !seal.Open(&damaged)) {
    check.found = fmt::format("libsodium {}, {:.1f} us for 1 kB", SodiumVersion(), each_us);
    return check;
  }
  check.result = Result::kFail;
  check.found = fmt::format("libsodium {} takes what is damaged for sound", SodiumVersion());
  check.advice = "install libsodium23 again; until then run without --seal";
  return check;
}

std::optional<std::string> FindInPath(std::string_view program) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path != nullptr ? path : "";
  while (!rest.empty()) {
    const std::size_t colon = std::min(rest.find(':'), rest.size());
    const std::string candidate = fmt::format("{}/{}", rest.substr(0, colon), program);
    rest.remove_prefix(std::min(colon + 1, rest.size()));
    if (access(candidate.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(candidate)) {
      return candidate;
    }
  }
  return std::nullopt;
}

HostCheck CheckProgram(std::string_view program, std::string_view purpose, Result if_missing) {
  HostCheck check{std::string(program), Result::kOk, "", ""};
  if (const auto path = FindInPath(program)) {
    check.found = *path;
  } else {
    check.result = if_missing;
    check.found = fmt::format("not in PATH; {}", purpose);
    check.advice = "Debian has it in the package liblcm-bin";
  }
  return check;
}

/// lcm-gen is the only one of LCM's programs that tells its version.
HostCheck CheckGenerator() {
  HostCheck check = CheckProgram("lcm-gen", "needed to build tools of your own", Result::kWarn);
  if (check.result != Result::kOk) return check;
  struct Close {
    void operator()(FILE* pipe) const { pclose(pipe); }
  };
  const std::unique_ptr<FILE, Close> pipe(popen("lcm-gen --version 2>/dev/null", "re"));
  std::array<char, 128> line{};
  std::string version;
  if (pipe && std::fgets(line.data(), line.size(), pipe.get()) != nullptr) version = line.data();
  while (!version.empty() && version.back() == '\n') version.pop_back();
  if (version == "lcm-gen " + LcmVersion()) {
    check.found += ", version " + LcmVersion();
  } else {
    check.result = Result::kWarn;
    check.found +=
        fmt::format(", says '{}', but Muster was built with LCM {}", version, LcmVersion());
    check.advice = "install liblcm-bin and liblcm-dev of one version";
  }
  return check;
}

}  // namespace

std::vector<HostCheck> CheckHost(const MulticastUrl& url) {
  std::vector<HostCheck> checks;
  const std::string refused = NamespaceProblem();
  const bool has_private = refused.empty();
  // The host's own network first: there is no way back to it.
  const HostCheck multicast = CheckHostMulticast(url.address, has_private);
  const HostCheck port = CheckPort(url.port);

  HostCheck own{"private network", Result::kOk, "", ""};
  if (has_private) {
    const auto start = Clock::now();
    const Network network = EnterPrivateNetwork();
    if (network.kind == Network::Kind::kPrivate) {
      own.found = fmt::format("ready in {:.1f} ms", MillisecondsSince(start));
    } else {
      own.result = Result::kFail;
      own.found = network.detail;
      own.advice = std::string(kMulticastAdvice);
    }
  } else {
    own.result = Result::kWarn;
    own.found = fmt::format("refused ({}): missions share the host's network", refused);
    own.advice =
        "allow user namespaces (sysctl user.max_user_namespaces, user.max_net_namespaces), or "
        "give each mission a port of its own";
  }
  checks.push_back(own);
  checks.push_back(multicast);
  checks.push_back(port);
  checks.push_back(CheckReceiveBuffer(url.recv_buf_size));
  checks.push_back(CheckGuard());
  checks.push_back(CheckLcm(url.port));
  checks.push_back(CheckSeal());
  checks.push_back(
      CheckProgram("lcm-logger", "'muster run --logger lcm' records with it", Result::kWarn));
  checks.push_back(CheckProgram("lcm-logplayer", "plays a log back", Result::kWarn));
  checks.push_back(CheckGenerator());
  return checks;
}

}  // namespace muster::tools
