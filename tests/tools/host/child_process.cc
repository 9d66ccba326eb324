#include "tests/tools/host/child_process.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <fstream>

#include "tools/host/network_namespace.h"

namespace muster::tools {
namespace {

bool Store(const char* path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  return !file.fail();
}

}  // namespace

ChildResult RunInChild(const std::function<int()>& body) {
  std::array<int, 2> ends;
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return {};
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    int code = 99;
    try {
      code = body();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
    }
    std::fflush(nullptr);
    _exit(code);
  }
  close(ends[1]);
  ChildResult result;
  std::array<char, 4096> buffer;
  for (ssize_t got; (got = read(ends[0], buffer.data(), buffer.size())) > 0;) {
    result.output.append(buffer.data(), static_cast<std::size_t>(got));
  }
  close(ends[0]);
  int status = 0;
  if (child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status)) {
    result.exit_code = WEXITSTATUS(status);
  }
  return result;
}

void Exec(const std::string& program, const std::vector<std::string>& arguments) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  std::perror(program.c_str());
  _exit(98);
}

bool EnterRefusingNetwork(bool route) {
  const std::string user = std::to_string(geteuid());
  const std::string group = std::to_string(getegid());
  // A user namespace first: its limits are its own, the host's stay as they are.
  if (unshare(CLONE_NEWUSER) != 0) return false;
  if (!Store("/proc/self/setgroups", "deny") || !Store("/proc/self/uid_map", "0 " + user + " 1") ||
      !Store("/proc/self/gid_map", "0 " + group + " 1")) {
    return false;
  }
  if (route) {
    if (EnterPrivateNetwork().kind != Network::Kind::kPrivate) return false;
  } else if (unshare(CLONE_NEWNET) != 0) {
    return false;
  }
  return Store("/proc/sys/user/max_net_namespaces", "0");
}

}  // namespace muster::tools
