#include "base/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>
#include <system_error>

#include "base/check.h"
#include "base/say.h"
#include "base/text.h"

namespace muster {
namespace {

std::string Usage(std::string_view program, std::string_view purpose,
                  const std::vector<Command>& commands) {
  std::string text =
      fmt::format("Usage: {} COMMAND [OPTION...]\n\n{}\n\nCommands:\n", program, purpose);
  for (const Command& command : commands) {
    text += fmt::format("  {:<14}  {}\n", command.name, command.summary);
  }
  text += fmt::format(
      "\nOptions:\n  -h, --help     Print this help and exit\n"
      "  -v, --version  Print the version and exit\n\n"
      "'{} help COMMAND' tells more of one command.\n",
      program);
  return text;
}

/// A closed stdin, stdout or stderr is taken by something that fails, or no file of ours would be
/// safe: the next one to be opened would get its number.
void HoldStandardFiles() {
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(fd, F_GETFD) >= 0 || errno != EBADF) continue;
    const int taken = open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    if (taken >= 0 && taken != fd) close(taken);
  }
}

/// A decision takes and frees megabytes. By default malloc hands them back, and the kernel has to
/// give every page anew for the next one.
void KeepFreedMemory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
}

int FailToPrint(const char* program, int error) {
  Say("{}: cannot write to stdout{}{}\n", program, error == 0 ? "" : ": ",
      error == 0 ? "" : std::strerror(error));
  return kExitSystem;
}

}  // namespace

int GuardedMain(const char* program, const std::function<int()>& body) {
  HoldStandardFiles();
  KeepFreedMemory();
  // A write that fails is an error to report, not a death.
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
  try {
    const int code = body();
    const bool written = std::fflush(stdout) == 0;
    const int error = written ? 0 : errno;
    if (written && std::ferror(stdout) == 0) return code;
    const int failure = FailToPrint(program, error);
    return code == kExitOk || code == kExitCheckFailed ? failure : code;
  } catch (const InputError& error) {
    Say("{}: {}\n", program, error.what());
    return kExitUsage;
  } catch (const SystemError& error) {
    Say("{}: {}\n", program, error.what());
    return kExitSystem;
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) != 0) return FailToPrint(program, error.code().value());
    Say("{}: internal error: {}\n", program, error.what());
    return kExitInternal;
  } catch (const std::exception& error) {
    Say("{}: internal error: {}\n", program, error.what());
    return kExitInternal;
  }
}

int RunCommandOf(std::string_view program, std::string_view purpose,
                 const std::vector<Command>& commands, int argc, const char* const* argv) {
  if (argc < 2) {
    SayTo(stderr, Usage(program, purpose, commands));
    return kExitUsage;
  }
  std::string name = argv[1];
  std::vector<std::string> rest(argv + 2, argv + argc);
  if (name == "help" && !rest.empty()) {
    name = rest.front();
    rest.erase(rest.begin());
    rest.emplace_back("--help");
  }
  if (name == "--help" || name == "-h" || name == "help") {
    fmt::print("{}", Usage(program, purpose, commands));
    return kExitOk;
  }
  if (name == "--version" || name == "-v") {
    fmt::print("{} {}\n", program, MUSTER_VERSION);
    return kExitOk;
  }
  std::vector<std::string> names;
  for (const Command& command : commands) {
    names.emplace_back(command.name);
    if (command.name != name) continue;
    rest.insert(rest.begin(), fmt::format("{} {}", program, name));
    std::vector<const char*> arguments;
    for (const std::string& text : rest) arguments.push_back(text.c_str());
    return command.body(static_cast<int>(arguments.size()), arguments.data());
  }
  std::string hint = DidYouMean(name, names);
  if (hint.empty()) hint = fmt::format(" (see {} --help)", program);
  throw InputError(fmt::format("no command '{} {}'{}", program, name, hint));
}

}  // namespace muster
