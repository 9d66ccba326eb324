#include "tools/host/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/close_range.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <utility>

#include "base/check.h"
#include "base/program.h"

namespace muster::tools {
namespace {

/// Between fork and exec: async-signal-safe calls only, since the parent may have threads.
[[noreturn]] void BecomeChild(char* const* argv, int output, int input, int failure, pid_t parent) {
  const auto fail = [failure] {
    const int error = errno;
    [[maybe_unused]] const ssize_t written = write(failure, &error, sizeof error);
    _exit(127);
  };
  if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) fail();
  if (getppid() != parent) _exit(127);  // it died before prctl
  if (setpgid(0, 0) != 0) fail();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ}) {
    if (std::signal(signal, SIG_DFL) == SIG_ERR) fail();
  }
  sigset_t none;
  sigemptyset(&none);
  if (sigprocmask(SIG_SETMASK, &none, nullptr) != 0) fail();
  if (dup2(input, STDIN_FILENO) < 0 || dup2(output, STDOUT_FILENO) < 0 ||
      dup2(output, STDERR_FILENO) < 0) {
    fail();
  }
  if (close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC) != 0) fail();
  execv(argv[0], argv);
  fail();
  _exit(127);
}

/// An open file, never one of stdin, stdout and stderr (even where our caller closed those), that
/// closes itself.
class Descriptor {
 public:
  /// Takes fd over; a negative one stays so.
  explicit Descriptor(int fd) : fd_(fd) {
    if (fd < 0 || fd > STDERR_FILENO) return;
    fd_ = fcntl(fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    close(fd);
  }
  ~Descriptor() { Close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  void Close() {
    if (fd_ >= 0) close(fd_);
    fd_ = -1;
  }

 private:
  int fd_;
};

}  // namespace

bool ChildEnd::clean() const { return WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == 0; }

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
  int held[2] = {-1, -1};
  const bool has_pipe = spec_.hold_stdin || !spec_.input.empty();
  if (has_pipe && pipe2(held, O_CLOEXEC) != 0) {
    throw SystemError(fmt::format("cannot start {}: {}", spec_.name, std::strerror(errno)));
  }
  const Descriptor input(has_pipe ? held[0] : open("/dev/null", O_RDONLY | O_CLOEXEC));
  // A line fits into a pipe.
  if (!spec_.input.empty() && write(held[1], spec_.input.data(), spec_.input.size()) !=
                                  static_cast<ssize_t>(spec_.input.size())) {
    close(held[1]);
    throw SystemError(fmt::format("cannot start {}: {}", spec_.name, std::strerror(errno)));
  }
  if (has_pipe && !spec_.hold_stdin) {
    close(held[1]);
  } else {
    stdin_fd_ = held[1];
  }
  int ends[2];
  if (input.get() < 0 || pipe2(ends, O_CLOEXEC) != 0) {
    throw SystemError(fmt::format("cannot start {}: {}", spec_.name, std::strerror(errno)));
  }
  const Descriptor read_end(ends[0]);
  Descriptor write_end(ends[1]);

  std::vector<char*> argv;
  for (std::string& argument : spec_.argv) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) {
    throw SystemError(fmt::format("cannot start {}: {}", spec_.name, std::strerror(errno)));
  }
  if (pid_ == 0) {
    BecomeChild(argv.data(), output.get(), input.get(), write_end.get(), parent);
  }
  write_end.Close();

  // The pipe closes without a byte when exec succeeds.
  int error = 0;
  ssize_t got = 0;
  do {
    got = read(read_end.get(), &error, sizeof error);
  } while (got < 0 && errno == EINTR);
  if (got == 0) return;
  waitpid(pid_, nullptr, 0);
  throw SystemError(
      fmt::format("cannot start {}: {}", spec_.argv.front(), std::strerror(got > 0 ? error : EIO)));
}

Child::Child(Child&& other) noexcept
    : spec_(std::move(other.spec_)),
      pid_(std::exchange(other.pid_, -1)),
      stdin_fd_(std::exchange(other.stdin_fd_, -1)),
      end_(std::move(other.end_)) {}

Child::~Child() {
  if (stdin_fd_ >= 0) close(stdin_fd_);
  if (pid_ < 0 || Poll()) return;
  kill(pid_, SIGKILL);
  while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

const std::optional<ChildEnd>& Child::Poll() {
  int status = 0;
  if (!end_ && waitpid(pid_, &status, WNOHANG) == pid_) end_ = ChildEnd{status};
  return end_;
}

void Child::Signal(int signal) {
  if (!Poll()) kill(pid_, signal);
}

void Child::AskToEnd() {
  if (Poll()) return;
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
