#pragma once

#include <functional>
#include <string>
#include <vector>

namespace muster::tools {

/// How a forked child ended and what it wrote to stdout and stderr.
struct ChildResult {
  int exit_code = -1;  ///< -1 when a signal ended it
  std::string output;
};

/// Runs `body` in a forked child, which exits with its result.
ChildResult RunInChild(const std::function<int()>& body);

/// Replaces the process by `program`, which must be a path; never returns.
[[noreturn]] void Exec(const std::string& program, const std::vector<std::string>& arguments);

#ifdef MUSTER_PROGRAM
/// Runs `muster` with these arguments.
inline ChildResult RunMuster(const std::vector<std::string>& arguments) {
  return RunInChild([&]() -> int { Exec(MUSTER_PROGRAM, arguments); });
}
#endif

inline bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A network that refuses private ones for real: a user namespace whose limit on network namespaces
/// is 0, where this process is root. With `route`, multicast is routed over lo as on a host set up
/// for it; without, there is no network at all. False where the kernel forbids making it. Only in a
/// child: there is no way back.
bool EnterRefusingNetwork(bool route);
/// Exit code of a child for which that returned false.
inline constexpr int kRefused = 77;

}  // namespace muster::tools
