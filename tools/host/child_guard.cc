#include "tools/host/child_guard.h"

#include <fmt/format.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <string>

#include "base/check.h"
#include "lcmtypes/bus/datagram_guard.h"
#include "lcmtypes/bus/multicast.h"

namespace muster::tools {
namespace {

/// A program that has just started has few open files.
constexpr int kMostFiles = 64;

struct OwnedFile {
  int fd;
  ~OwnedFile() {
    if (fd >= 0) close(fd);
  }
};

/// Calls `visit` with a descriptor of ours of each such socket; whether there is one.
template <class Visit>
bool ForEachSocketOf(pid_t pid, std::uint16_t port, Visit visit) {
  // By number: not in every C library.
  const OwnedFile process{static_cast<int>(syscall(SYS_pidfd_open, pid, 0))};
  if (process.fd < 0) throw SystemError(fmt::format("pidfd_open: {}", std::strerror(errno)));
  bool found = false;
  for (int file = 0; file < kMostFiles; ++file) {
    const OwnedFile ours{static_cast<int>(syscall(SYS_pidfd_getfd, process.fd, file, 0))};
    if (ours.fd < 0) {
      if (errno == EBADF) continue;
      if (errno == ESRCH) return false;
      throw SystemError(fmt::format("pidfd_getfd: {}", std::strerror(errno)));
    }
    if (!IsOnPort(ours.fd, port)) continue;
    visit(ours.fd);
    found = true;
  }
  return found;
}

}  // namespace

bool GuardSocketsOf(pid_t pid, std::uint16_t port) {
  return ForEachSocketOf(pid, port, [](int socket) {
    const std::optional<std::string> problem = GuardSocket(socket, GuardedChannels::kAny);
    if (problem) throw SystemError(*problem);
  });
}

void RejoinSocketsOf(pid_t pid, std::uint16_t port, const std::string& address) {
  ForEachSocketOf(pid, port, [&](int socket) { JoinAgain(socket, address); });
}

}  // namespace muster::tools
