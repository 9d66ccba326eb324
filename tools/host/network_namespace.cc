#include "tools/host/network_namespace.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <net/if.h>
#include <net/route.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string_view>

#include "base/check.h"
#include "lcmtypes/bus/multicast.h"

namespace muster::tools {
namespace {

bool WriteFile(const char* path, std::string_view text) {
  const int fd = open(path, O_WRONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const ssize_t written = write(fd, text.data(), text.size());
  const int error = errno;
  close(fd);
  errno = error;
  return written == static_cast<ssize_t>(text.size());
}

/// What could not be done and errno, or none.
using Failure = std::optional<std::string>;

Failure Failed(std::string_view what) { return fmt::format("{}: {}", what, std::strerror(errno)); }

Failure UnshareNetwork() {
  if (unshare(CLONE_NEWNET) == 0) return std::nullopt;  // root, where root may
  const uid_t user = geteuid();
  const gid_t group = getegid();
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return Failed("unshare");
  if (!WriteFile("/proc/self/setgroups", "deny")) return Failed("/proc/self/setgroups");
  if (!WriteFile("/proc/self/uid_map", fmt::format("{0} {0} 1", user))) {
    return Failed("/proc/self/uid_map");
  }
  if (!WriteFile("/proc/self/gid_map", fmt::format("{0} {0} 1", group))) {
    return Failed("/proc/self/gid_map");
  }
  return std::nullopt;
}

Failure RouteMulticastToLoopback() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return Failed("socket");
  struct Closer {
    int fd;
    ~Closer() { close(fd); }
  } const closer{fd};

  std::array<char, IFNAMSIZ> device{"lo"};
  ifreq interface {};
  std::memcpy(interface.ifr_name, device.data(), device.size());
  if (ioctl(fd, SIOCGIFFLAGS, &interface) != 0) return Failed("flags of lo");
  interface.ifr_flags = static_cast<short>(interface.ifr_flags | IFF_UP | IFF_MULTICAST);
  if (ioctl(fd, SIOCSIFFLAGS, &interface) != 0) return Failed("bring lo up");

  const auto address = [](const char* text) {
    sockaddr_in in{};
    in.sin_family = AF_INET;
    inet_pton(AF_INET, text, &in.sin_addr);
    sockaddr generic;
    std::memcpy(&generic, &in, sizeof(generic));
    return generic;
  };
  rtentry route{};
  route.rt_dst = address("224.0.0.0");
  route.rt_genmask = address("240.0.0.0");
  route.rt_flags = RTF_UP;
  route.rt_dev = device.data();
  if (ioctl(fd, SIOCADDRT, &route) != 0) return Failed("route 224.0.0.0/4 to lo");
  return std::nullopt;
}

Failure EnterAndSetUp() {
  if (Failure failure = UnshareNetwork()) return failure;
  return RouteMulticastToLoopback();
}

}  // namespace

std::string NamespaceProblem() {
  std::array<int, 2> pipe_fds;
  if (pipe2(pipe_fds.data(), O_CLOEXEC) != 0) {
    throw SystemError(fmt::format("cannot make a pipe: {}", std::strerror(errno)));
  }
  const pid_t child = fork();
  if (child < 0) {
    const std::string reason = std::strerror(errno);
    close(pipe_fds[0]);
    close(pipe_fds[1]);
    throw SystemError(fmt::format("cannot fork: {}", reason));
  }
  if (child == 0) {
    const Failure failure = EnterAndSetUp();
    ssize_t written = 0;
    if (failure) written = write(pipe_fds[1], failure->data(), failure->size());
    _exit(written >= 0 ? 0 : 1);
  }
  close(pipe_fds[1]);
  std::array<char, 512> text;
  std::string problem;
  for (;;) {
    const ssize_t got = read(pipe_fds[0], text.data(), text.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    problem.append(text.data(), static_cast<std::size_t>(got));
  }
  close(pipe_fds[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (problem.empty() && status != 0) problem = "the trial ended abnormally";
  return problem;
}

Network HostNetwork(const std::string& reason) {
  const std::string refused = fmt::format("no private network ({})", reason);
  if (const auto problem = MulticastProblem(MulticastUrl().address)) {
    return {Network::Kind::kNone, fmt::format("{}, no multicast on this host ({}); {}", refused,
                                              *problem, kMulticastAdvice)};
  }
  return {Network::Kind::kHost, refused};
}

Network EnterPrivateNetwork() {
  // There is no way back out of a namespace that turned out to be useless: a child tries it first.
  const std::string problem = NamespaceProblem();
  if (!problem.empty()) return HostNetwork(problem);
  if (const Failure failure = EnterAndSetUp()) return HostNetwork(*failure);
  if (const auto trouble = MulticastProblem(MulticastUrl().address)) {
    return {Network::Kind::kNone, fmt::format("private network without multicast ({})", *trouble)};
  }
  return {Network::Kind::kPrivate, ""};
}

}  // namespace muster::tools
