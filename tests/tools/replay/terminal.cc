#include "tests/tools/replay/terminal.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace muster::tools {

Terminal::Terminal(const std::vector<std::string>& argv) {
  std::vector<char*> arguments;
  for (const std::string& argument : argv) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  setenv("TERM", "xterm", 1);
  winsize size = {};
  size.ws_row = 24;
  size.ws_col = 200;
  pid_ = forkpty(&fd_, nullptr, nullptr, &size);
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    execv(arguments[0], arguments.data());
    std::perror(arguments[0]);
    _exit(98);
  }
  if (pid_ < 0) ADD_FAILURE() << "forkpty";
}

Terminal::~Terminal() {
  if (pid_ > 0 && !ended()) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (fd_ >= 0) close(fd_);
}

void Terminal::Press(const std::string& bytes) {
  if (write(fd_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
    ADD_FAILURE() << "the terminal takes no keys";
  }
}

void Terminal::Look() {
  pollfd input = {fd_, POLLIN, 0};
  char bytes[4096];
  int wait_ms = 10;
  while (poll(&input, 1, wait_ms) > 0) {
    const ssize_t n = read(fd_, bytes, sizeof bytes);
    if (n <= 0) return;
    shown_.append(bytes, static_cast<std::size_t>(n));
    wait_ms = 0;
  }
}

std::string Terminal::status() const {
  const std::string mark = "next message in ";
  const std::size_t at = shown_.rfind(mark);
  if (at == std::string::npos) return "";
  // "... next message in 12.5 s"
  const std::size_t end = shown_.find(" s", at + mark.size());
  if (end == std::string::npos) {
    const std::size_t before = shown_.rfind(mark, at - 1);
    if (at == 0 || before == std::string::npos) return "";
    const std::size_t begin = shown_.rfind('\r', before);
    return shown_.substr(begin + 1, shown_.find(" s", before + mark.size()) + 1 - begin);
  }
  const std::size_t begin = shown_.rfind('\r', at);
  return shown_.substr(begin + 1, end + 1 - begin);
}

bool Terminal::raw() const {
  termios state = {};
  if (tcgetattr(fd_, &state) != 0) return false;
  return (state.c_lflag & (ICANON | ECHO)) == 0;
}

std::optional<int> Terminal::ended() {
  int status = 0;
  if (!ended_ && waitpid(pid_, &status, WNOHANG) == pid_) {
    ended_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  return ended_;
}

}  // namespace muster::tools
