#include "tools/host/quiet_thread.h"

#include <csignal>
#include <utility>

namespace muster::tools {

std::thread StartQuietThread(std::function<void()> body) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread thread(std::move(body));
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return thread;
}

}  // namespace muster::tools
