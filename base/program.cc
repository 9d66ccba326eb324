#include "base/program.h"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>

#include "base/check.h"
#include "base/text.h"

namespace muster {
namespace {

void PrintUsage(std::FILE* to, std::string_view program, std::string_view purpose,
                const std::vector<Command>& commands) {
  fmt::print(to, "Usage: {} COMMAND [OPTION...]\n\n{}\n\nCommands:\n", program, purpose);
  for (const Command& command : commands) {
    fmt::print(to, "  {:<14}  {}\n", command.name, command.summary);
  }
  fmt::print(to,
             "\nOptions:\n  -h, --help     Print this help and exit\n"
             "  -v, --version  Print the version and exit\n\n"
             "'{} help COMMAND' tells more of one command.\n",
             program);
}

}  // namespace

int GuardedMain(const char* program, const std::function<int()>& body) {
  try {
    return body();
  } catch (const InputError& error) {
    fmt::print(stderr, "{}: {}\n", program, error.what());
    return kExitUsage;
  } catch (const SystemError& error) {
    fmt::print(stderr, "{}: {}\n", program, error.what());
    return kExitSystem;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: internal error: {}\n", program, error.what());
    return kExitInternal;
  }
}

int RunCommandOf(std::string_view program, std::string_view purpose,
                 const std::vector<Command>& commands, int argc, const char* const* argv) {
  if (argc < 2) {
    PrintUsage(stderr, program, purpose, commands);
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
    PrintUsage(stdout, program, purpose, commands);
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
