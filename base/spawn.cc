#include "base/spawn.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/close_range.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "base/check.h"
#include "base/text.h"

namespace muster {
namespace {

/// Lets fdatasync(2) return 0 at once, in this process and in what it becomes; nothing where the
/// kernel does not let. The program's calls are numbered as ours: it is of the same architecture.
void SkipDiskWaits() {
  std::array<sock_filter, 4> program = {{
      {BPF_LD | BPF_W | BPF_ABS, 0, 0, offsetof(seccomp_data, nr)},
      {BPF_JMP | BPF_JEQ | BPF_K, 0, 1, SYS_fdatasync},
      {BPF_RET | BPF_K, 0, 0, SECCOMP_RET_ERRNO},
      {BPF_RET | BPF_K, 0, 0, SECCOMP_RET_ALLOW},
  }};
  const sock_fprog filter = {program.size(), program.data()};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0) {
    prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter);
  }
}

/// Between fork and exec: async-signal-safe calls only, since the parent may have threads.
[[noreturn]] void BecomeChild(char* const* argv, int input, int output, int error, int failure,
                              pid_t parent, DiskWaits disk_waits) {
  const auto fail = [failure] {
    const int why = errno;
    [[maybe_unused]] const ssize_t written = write(failure, &why, sizeof why);
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
      dup2(error, STDERR_FILENO) < 0) {
    fail();
  }
  if (disk_waits == DiskWaits::kSkipped) SkipDiskWaits();
  if (close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC) != 0) fail();
  execv(argv[0], argv);
  fail();
  _exit(127);
}

bool IsProgram(const std::string& path) {
  struct stat status = {};
  return stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode) &&
         access(path.c_str(), X_OK) == 0;
}

}  // namespace

Descriptor::Descriptor(int fd) : fd_(fd) {
  if (fd < 0 || fd > STDERR_FILENO) return;
  fd_ = fcntl(fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  close(fd);
}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  Close();
  fd_ = other.Release();
  return *this;
}

void Descriptor::Close() {
  if (fd_ >= 0) close(fd_);
  fd_ = -1;
}

int Descriptor::Release() { return std::exchange(fd_, -1); }

std::optional<Pipe> MakePipe() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return std::nullopt;
  return Pipe{Descriptor(ends[0]), Descriptor(ends[1])};
}

pid_t Spawn(std::vector<std::string> argv, int input, int output, int error, DiskWaits disk_waits) {
  MUSTER_CHECK(!argv.empty());
  const auto refuse = [&argv](int why) {
    throw SystemError(fmt::format("cannot start {}: {}", argv.front(), std::strerror(why)));
  };
  std::vector<char*> arguments;
  for (std::string& argument : argv) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  std::optional<Pipe> failure = MakePipe();
  if (!failure) refuse(errno);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) refuse(errno);
  if (pid == 0) {
    BecomeChild(arguments.data(), input, output, error, failure->write_end.get(), parent,
                disk_waits);
  }
  failure->write_end.Close();

  // The pipe closes without a byte when exec succeeds.
  int why = 0;
  ssize_t got = 0;
  do {
    got = read(failure->read_end.get(), &why, sizeof why);
  } while (got < 0 && errno == EINTR);
  if (got != 0) {
    waitpid(pid, nullptr, 0);
    refuse(got > 0 ? why : EIO);
  }
  return pid;
}

std::optional<std::string> FindProgram(const std::string& name) {
  if (name.find('/') != std::string::npos) {
    return IsProgram(name) ? std::optional(name) : std::nullopt;
  }
  const char* path = std::getenv("PATH");
  for (const std::string& folder : Split(path == nullptr ? "" : path, ':')) {
    const std::string file = (folder.empty() ? "." : folder) + "/" + name;
    if (!name.empty() && IsProgram(file)) return file;
  }
  return std::nullopt;
}

}  // namespace muster
