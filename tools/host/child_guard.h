#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace muster::tools {

/// Guards (lcmtypes/bus/datagram_guard.h) the sockets of another process that are bound to `port`,
/// letting all channels through: for stock LCM programs, which do not guard themselves. False: the
/// process has no such socket, or has ended. Throws SystemError where the kernel does not let us:
/// pid must be a child of ours that has not been waited for, Linux 5.6 or later.
bool GuardSocketsOf(pid_t pid, std::uint16_t port);

/// Has those sockets join the multicast group again (JoinAgain). Throws as above.
void RejoinSocketsOf(pid_t pid, std::uint16_t port, const std::string& address);

}  // namespace muster::tools
