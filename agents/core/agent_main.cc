#include "agents/core/agent_main.h"

#include <fmt/format.h>

#include <limits>
#include <string>
#include <vector>

#include "agents/core/agent_process.h"
#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/text.h"
#include "protocol/run_process.h"

namespace muster::agents {
namespace {

IdRange ReadIds(const std::string& text) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  const std::vector<std::string> ends = Split(text, '-');
  const auto first = ToInteger(ends.front(), 0, kMost);
  const auto last = ToInteger(ends.back(), first.value_or(0), kMost);
  if (!first || !last || ends.size() > 2) {
    throw InputError("command line", "--ids", text, "an id or a range, 0-9");
  }
  return std::pair(static_cast<std::int32_t>(*first), static_cast<std::int32_t>(*last));
}

int Run(AgentKind kind, int argc, char** argv) {
  const std::string name(ToString(kind));
  Options options("muster-" + name, fmt::format("The {}s of a mission, or some of them", name));
  options.Add("ids", "N-M", "Ids of the agents that this process moves, 0-9; default: all");
  AddProcessOptions(&options, name);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const ProcessFlags flags = ReadProcessFlags(*arguments);
  IdRange ids;
  if (arguments->Has("ids")) ids = ReadIds(arguments->Get("ids"));
  AgentProcess process(flags.identity, flags.window, kind, ids);
  const auto bus = OpenBus(flags, GuardedChannels::kOfAgents);
  return RunProcess(&process, bus.get(), flags.quiet);
}

}  // namespace

int AgentMain(AgentKind kind, int argc, char** argv) {
  const std::string program = "muster-" + std::string(ToString(kind));
  return GuardedMain(program.c_str(), [&] { return Run(kind, argc, argv); });
}

}  // namespace muster::agents
