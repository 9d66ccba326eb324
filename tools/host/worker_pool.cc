#include "tools/host/worker_pool.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <string_view>
#include <vector>

#include "base/check.h"

namespace muster::tools {
namespace {

struct Worker {
  pid_t pid = -1;
  int pipe = -1;  ///< what it says
  std::size_t task = 0;
  std::string said;
};

void WriteAll(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = write(file, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) _exit(3);
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

Worker Start(std::size_t task, const std::function<std::string(std::size_t)>& work) {
  int ends[2];
  if (pipe(ends) != 0) throw SystemError(fmt::format("pipe: {}", std::strerror(errno)));
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) throw SystemError(fmt::format("fork: {}", std::strerror(errno)));
  if (pid == 0) {
    // No child is left behind when this program is killed.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);
    close(ends[0]);
    try {
      WriteAll(ends[1], work(task));
      _exit(0);
    } catch (const std::exception& error) {
      WriteAll(ends[1], error.what());
      _exit(1);
    }
  }
  close(ends[1]);
  return {pid, ends[0], task, ""};
}

/// Waits for the worker, whose pipe is at its end; "" when it went well.
std::string EndOf(const Worker& worker) {
  close(worker.pipe);
  int status = 0;
  while (waitpid(worker.pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return fmt::format("ended by signal {}", WTERMSIG(status));
  if (WEXITSTATUS(status) == 0) return "";
  return worker.said.empty() ? fmt::format("exit code {}", WEXITSTATUS(status)) : worker.said;
}

}  // namespace

void RunInProcesses(std::size_t n, int jobs, const std::function<std::string(std::size_t)>& work,
                    const std::function<void(std::size_t, const std::string&)>& done,
                    const std::function<void(std::size_t, const std::string&)>& failed,
                    const std::function<bool()>& stop) {
  std::vector<Worker> workers;
  std::size_t next = 0;
  while ((next < n && !stop()) || !workers.empty()) {
    while (next < n && !stop() && workers.size() < static_cast<std::size_t>(jobs)) {
      workers.push_back(Start(next, work));
      ++next;
    }
    std::vector<pollfd> files;
    for (const Worker& worker : workers) files.push_back({worker.pipe, POLLIN, 0});
    if (poll(files.data(), files.size(), -1) < 0 && errno != EINTR) {
      throw SystemError(fmt::format("poll: {}", std::strerror(errno)));
    }
    for (std::size_t i = workers.size(); i-- > 0;) {
      if (files[i].revents == 0) continue;
      char buffer[4096];
      const ssize_t got = read(workers[i].pipe, buffer, sizeof buffer);
      if (got > 0) workers[i].said.append(buffer, static_cast<std::size_t>(got));
      if (got != 0) continue;
      const Worker worker = std::move(workers[i]);
      workers.erase(workers.begin() + static_cast<std::ptrdiff_t>(i));
      const std::string why = EndOf(worker);
      if (why.empty()) {
        done(worker.task, worker.said);
      } else {
        failed(worker.task, why);
      }
    }
  }
}

}  // namespace muster::tools
