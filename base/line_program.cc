#include "base/line_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>
#include <utility>

#include "base/check.h"

namespace muster {
namespace {

/// For a program whose stdin is closed, to end of itself.
constexpr std::chrono::seconds kGrace(1);
/// Looks at its stdout after the deadline: what a pipe can hold, and no more of what never ends.
constexpr int kMostLateLooks = 16;

/// For poll(2): rounded up, not below 0.
int MillisecondsUntil(LineProgram::Clock::time_point deadline) {
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(deadline - LineProgram::Clock::now()).count();
  return static_cast<int>(std::clamp<std::int64_t>(left, 0, INT_MAX));
}

}  // namespace

LineProgram::LineProgram(std::vector<std::string> argv, std::size_t most_bytes)
    : most_bytes_(most_bytes) {
  // A write to a program that has ended fails instead of ending us. Programs of ours do so anyway.
  struct sigaction now = {};
  if (sigaction(SIGPIPE, nullptr, &now) == 0 && now.sa_handler == SIG_DFL) {
    std::signal(SIGPIPE, SIG_IGN);
  }
  auto to = MakePipe();
  auto from = MakePipe();
  if (!to || !from) {
    throw SystemError(fmt::format("cannot start {}: {}", argv.front(), std::strerror(errno)));
  }
  pid_ = Spawn(std::move(argv), to->read_end.get(), from->write_end.get(), STDERR_FILENO);
  input_ = std::move(to->write_end);
  output_ = std::move(from->read_end);
  for (const int fd : {input_.get(), output_.get()}) fcntl(fd, F_SETFL, O_NONBLOCK);
}

LineProgram::~LineProgram() {
  if (pid_ < 0) return;
  Finish();
  AwaitEnd(finished_by_);
  Kill();
}

void LineProgram::Finish() {
  if (finished_by_ != Clock::time_point{}) return;
  finished_by_ = Clock::now() + kGrace;
  input_.Close();
}

void LineProgram::Write(std::string_view line) {
  to_write_.erase(0, std::exchange(written_, 0));
  to_write_ += line;
  to_write_ += '\n';
}

LineProgram::Outcome LineProgram::Read(Clock::time_point deadline, std::string* line) {
  int late_looks = 0;
  while (true) {
    if (TakeLine(line)) return Outcome::kLine;
    if (read_.size() > most_bytes_) return Outcome::kTooLong;
    if (ended_) return Outcome::kEnded;
    const bool writes = written_ < to_write_.size();
    pollfd files[] = {{output_.get(), POLLIN, 0}, {input_.get(), POLLOUT, 0}};
    const int wait_ms = MillisecondsUntil(deadline);
    const int ready = poll(files, writes ? 2 : 1, wait_ms);
    // What is there counts even if we come late to look, as after a stop of our own.
    if (wait_ms == 0 && (ready == 0 || ++late_looks > kMostLateLooks)) return Outcome::kLate;
    if (ready <= 0) continue;  // a signal, or poll woke early
    if (files[0].revents != 0) ReadSome();
    if (writes && files[1].revents != 0) WriteSome();
  }
}

std::string LineProgram::Kill() {
  if (ended_) AwaitEnd(Clock::now() + kGrace);  // of itself, so that its own end is told
  int status = 0;
  kill(-pid_, SIGKILL);
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  if (!WIFSIGNALED(status)) return fmt::format("exited with code {}", WEXITSTATUS(status));
  const int signal = WTERMSIG(status);
  return fmt::format("was killed by signal {} ({})", signal, strsignal(signal));
}

bool LineProgram::TakeLine(std::string* line) {
  const std::size_t newline = read_.find('\n', searched_);
  searched_ = read_.size();
  if (newline == std::string::npos || newline > most_bytes_) return false;
  *line = read_.substr(0, newline);
  read_.erase(0, newline + 1);
  searched_ = 0;
  return true;
}

void LineProgram::ReadSome() {
  char some[1 << 16];
  const ssize_t got = read(output_.get(), some, sizeof some);
  if (got > 0) read_.append(some, static_cast<std::size_t>(got));
  if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) ended_ = true;
}

void LineProgram::WriteSome() {
  const ssize_t put = write(input_.get(), to_write_.data() + written_, to_write_.size() - written_);
  if (put > 0) written_ += static_cast<std::size_t>(put);
  // It reads no more; what it says, or its silence, tells the rest.
  if (put < 0 && errno != EAGAIN && errno != EINTR) written_ = to_write_.size();
}

void LineProgram::AwaitEnd(Clock::time_point deadline) const {
  // By number: not in every C library.
  const Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, pid_, 0)));
  if (process.get() < 0) return;
  pollfd file = {process.get(), POLLIN, 0};
  int ready = 0;
  do {
    ready = poll(&file, 1, MillisecondsUntil(deadline));
  } while (ready < 0 && errno == EINTR);
}

}  // namespace muster
