#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace muster::tools {

/// Runs work(0) to work(n - 1), each in a process of its own, up to `jobs` at a time, so that a
/// crash of one does not touch the others. In this process, in the order in which they end,
/// `done(i, text)` takes what work(i) returned, or `failed(i, why)` is told how it ended instead.
/// While `stop` holds, no further process is started. This process must be single-threaded. Throws
/// SystemError when no process can be started.
void RunInProcesses(
    std::size_t n, int jobs, const std::function<std::string(std::size_t)>& work,
    const std::function<void(std::size_t, const std::string&)>& done,
    const std::function<void(std::size_t, const std::string&)>& failed,
    const std::function<bool()>& stop = [] { return false; });

}  // namespace muster::tools
