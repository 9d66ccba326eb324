#include "agents/core/agent_main.h"

#include <fmt/format.h>

#include <charconv>

#include "agents/core/agent_process.h"
#include "base/check.h"
#include "base/program.h"
#include "protocol/run_process.h"

namespace muster::agents {
namespace {

IdRange ReadIds(const std::string& text) {
  std::int32_t first = 0;
  std::int32_t last = 0;
  const char* end = text.data() + text.size();
  std::from_chars_result read = std::from_chars(text.data(), end, first);
  last = first;
  if (read.ec == std::errc() && read.ptr != end && *read.ptr == '-') {
    read = std::from_chars(read.ptr + 1, end, last);
  }
  if (read.ec != std::errc() || read.ptr != end || first < 0 || last < first) {
    throw InputError("command line", "--ids", text, "an id or a range, 0-9");
  }
  return std::pair(first, last);
}

int Run(AgentKind kind, int argc, char** argv) {
  const std::string name(ToString(kind));
  cxxopts::Options options("muster-" + name,
                           fmt::format("The {}s of a mission, or some of them", name));
  options.add_options()("ids", "Ids of the agents that this process moves, 0-9; default: all",
                        cxxopts::value<std::string>());
  AddProcessOptions(&options, name);
  const auto result = ParseOptions(&options, argc, argv);
  if (!result) return kExitOk;
  const ProcessFlags flags = ReadProcessFlags(*result);
  IdRange ids;
  if (result->count("ids") > 0) ids = ReadIds((*result)["ids"].as<std::string>());
  AgentProcess process(flags.identity, flags.window, kind, ids);
  const auto bus = OpenBus(flags);
  return RunProcess(&process, bus.get(), flags.quiet);
}

}  // namespace

int AgentMain(AgentKind kind, int argc, char** argv) {
  const std::string program = "muster-" + std::string(ToString(kind));
  return GuardedMain(program.c_str(), [&] { return Run(kind, argc, argv); });
}

}  // namespace muster::agents
