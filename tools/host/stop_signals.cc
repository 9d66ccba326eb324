#include "tools/host/stop_signals.h"

#include <atomic>

namespace muster::tools {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP, SIGCHLD};

std::atomic<int> stops = 0;
static_assert(std::atomic<int>::is_always_lock_free);

void OnSignal(int signal) {
  if (signal != SIGCHLD) ++stops;
}

}  // namespace

StopSignals::StopSignals() {
  stops = 0;
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  for (std::size_t i = 0; i < std::size(kSignals); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    const bool ignored = kSignals[i] != SIGCHLD && before_[i].sa_handler == SIG_IGN;
    if (!ignored) sigaction(kSignals[i], &action, nullptr);
  }
}

StopSignals::~StopSignals() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i)
    sigaction(kSignals[i], &before_[i], nullptr);
}

int StopSignals::count() const { return stops; }

}  // namespace muster::tools
