// A child for child_test: exits with 0 when no SIGCONT was sent to it between SIGTERM and SIGUSR1.
#include <signal.h>
#include <unistd.h>

#include <initializer_list>
#include <string_view>

namespace {

sigset_t SetOf(std::initializer_list<int> signals) {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : signals) sigaddset(&set, signal);
  return set;
}

bool IsPending(int signal) {
  sigset_t pending;
  sigpending(&pending);
  return sigismember(&pending, signal) == 1;
}

bool Say(std::string_view line) {
  return write(STDOUT_FILENO, line.data(), line.size()) == static_cast<ssize_t>(line.size());
}

}  // namespace

int main() {
  const sigset_t all = SetOf({SIGCONT, SIGTERM, SIGUSR1});
  const sigset_t continues = SetOf({SIGCONT});
  const sigset_t others = SetOf({SIGCONT, SIGUSR1});
  sigprocmask(SIG_SETMASK, &all, nullptr);
  if (!Say("ready\n")) return 2;
  int signal = 0;
  while (signal != SIGTERM) sigwait(&all, &signal);
  if (IsPending(SIGCONT)) sigwait(&continues, &signal);  // it was sent before
  if (!Say("told to end\n")) return 2;
  sigwait(&others, &signal);
  return signal == SIGCONT || IsPending(SIGCONT) ? 1 : 0;
}
