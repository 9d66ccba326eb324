#pragma once

#include <functional>
#include <thread>

namespace muster::tools {

/// Starts a thread that takes no signals: they are the main thread's.
std::thread StartQuietThread(std::function<void()> body);

}  // namespace muster::tools
