#pragma once

#include <string>

namespace muster::tools {

/// How this process and its children come to multicast.
struct Network {
  enum class Kind {
    kPrivate,  ///< a network namespace of our own: no other mission can be heard
    kHost,  ///< the host's network, kept on this host by ttl 0; others on the same port are heard
    kNone,  ///< no multicast at all
  };
  Kind kind = Kind::kNone;
  /// One line. kPrivate: empty. kHost: why no namespace could be made. kNone: that, and what to do.
  std::string detail;
};

/// Moves the calling process into a network namespace of its own, with `lo` up and multicast routed
/// to it; without root by way of a user namespace, which keeps user and group. Children inherit it,
/// sockets that are already open stay in the host's network. Where the kernel forbids it the
/// process stays where it is and the host's multicast is tried. Call it before any thread starts:
/// the kernel refuses otherwise. Takes a few milliseconds. Throws SystemError only when the process
/// cannot fork.
Network EnterPrivateNetwork();

/// What EnterPrivateNetwork would find if no namespace could be made, because of `reason`.
Network HostNetwork(const std::string& reason);

/// Whether EnterPrivateNetwork would make a namespace: empty, or why not. Tries it in a child.
std::string NamespaceProblem();

}  // namespace muster::tools
