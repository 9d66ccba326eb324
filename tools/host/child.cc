#include "tools/host/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <utility>

#include "base/check.h"
#include "base/program.h"
#include "base/spawn.h"

namespace muster::tools {

bool ChildEnd::clean() const {
  return (WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == 0) ||
         (was_asked && WIFSIGNALED(wait_status) && WTERMSIG(wait_status) == SIGTERM);
}

bool ChildEnd::usage_error() const {
  return WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == kExitUsage;
}

std::string ChildEnd::Text() const {
  if (WIFSIGNALED(wait_status)) {
    const int signal = WTERMSIG(wait_status);
    return fmt::format("was killed by signal {} ({})", signal, strsignal(signal));
  }
  return fmt::format("exited with code {}", WEXITSTATUS(wait_status));
}

Child::Child(ChildSpec spec) : spec_(std::move(spec)) {
  MUSTER_CHECK(!spec_.argv.empty(), "{}", spec_.name);
  const Descriptor output(
      open(spec_.output_file.c_str(),
           O_WRONLY | O_CREAT | (spec_.append ? 0 : O_TRUNC) | O_APPEND | O_CLOEXEC, 0666));
  if (output.get() < 0) {
    throw SystemError(fmt::format("cannot write {}: {}", spec_.output_file, std::strerror(errno)));
  }
  const auto refuse = [this] {
    throw SystemError(fmt::format("cannot start {}: {}", spec_.name, std::strerror(errno)));
  };
  std::optional<Pipe> held;
  if (spec_.hold_stdin || !spec_.input.empty()) {
    held = MakePipe();
    if (!held) refuse();
    // A line fits into a pipe.
    const std::string& line = spec_.input;
    if (!line.empty() && write(held->write_end.get(), line.data(), line.size()) !=
                             static_cast<ssize_t>(line.size())) {
      refuse();
    }
    if (!spec_.hold_stdin) held->write_end.Close();
  }
  const Descriptor nothing(held ? -1 : open("/dev/null", O_RDONLY | O_CLOEXEC));
  const int input = held ? held->read_end.get() : nothing.get();
  if (input < 0) refuse();
  pid_ = Spawn(spec_.argv, input, output.get(), output.get(), spec_.disk_waits);
  if (held) stdin_fd_ = held->write_end.Release();
}

Child::Child(Child&& other) noexcept
    : spec_(std::move(other.spec_)),
      pid_(std::exchange(other.pid_, -1)),
      stdin_fd_(std::exchange(other.stdin_fd_, -1)),
      was_asked_(other.was_asked_),
      end_(other.end_) {}

Child::~Child() {
  if (stdin_fd_ >= 0) close(stdin_fd_);
  if (pid_ < 0 || Poll()) return;
  kill(pid_, SIGKILL);
  while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

const std::optional<ChildEnd>& Child::Poll() {
  int status = 0;
  if (!end_ && waitpid(pid_, &status, WNOHANG) == pid_) end_ = ChildEnd{status, was_asked_};
  return end_;
}

void Child::Signal(int signal) {
  if (!Poll()) kill(pid_, signal);
}

void Child::AskToEnd() {
  if (Poll()) return;
  was_asked_ = true;
  // A SIGCONT takes back every stop that is on its way to the process, that of PTRACE_ATTACH too:
  // after the SIGTERM it could meet LeakSanitizer, which looks at a process that exits, or a
  // debugger, and these would wait for that stop for ever.
  kill(pid_, SIGCONT);
  if (stdin_fd_ >= 0) {
    close(std::exchange(stdin_fd_, -1));
  } else {
    kill(pid_, SIGTERM);
  }
}

bool Child::Stopped() const {
  // "PID (NAME) STATE ...", and a name may hold anything.
  std::ifstream stat(fmt::format("/proc/{}/stat", pid_));
  std::string text;
  std::getline(stat, text);
  const std::size_t close = text.rfind(") ");
  return !end_ && close != std::string::npos && text.size() > close + 2 && text[close + 2] == 'T';
}

std::string LastLines(const std::string& file, int lines) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return "";
  constexpr std::streamoff kMost = 4096;
  in.seekg(0, std::ios::end);
  const std::streamoff size = in.tellg();
  const std::streamoff start = size > kMost ? size - kMost : 0;
  in.seekg(start);
  std::string text(static_cast<std::size_t>(size - start), '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::size_t from = text.size();
  for (int i = 0; i < lines && from != std::string::npos && from > 0; ++i) {
    from = text.rfind('\n', from - 1);
  }
  return from == std::string::npos || text.empty() ? text : text.substr(from > 0 ? from + 1 : 0);
}

}  // namespace muster::tools
