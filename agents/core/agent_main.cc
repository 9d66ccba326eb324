#include "agents/core/agent_main.h"

#include <fmt/format.h>

#include <limits>
#include <string>
#include <vector>

#include "agents/core/agent_process.h"
#include "agents/driver/driver_programs.h"
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

/// [ID=]COMMAND.
DriverPrograms::Command ReadDriver(const std::string& text) {
  const std::size_t sign = text.find('=');
  if (sign != std::string::npos) {
    const auto id = ToInteger(text.substr(0, sign), 0, std::numeric_limits<std::int32_t>::max());
    if (id) return {static_cast<std::int32_t>(*id), DriverCommand(text.substr(sign + 1))};
  }
  return {{}, DriverCommand(text)};
}

std::unique_ptr<DriverPort> DriversOf(const Arguments& arguments) {
  std::vector<DriverPrograms::Command> commands;
  for (const std::string& text : arguments.All("driver")) commands.push_back(ReadDriver(text));
  if (commands.empty()) return nullptr;
  DriverSession::Rules rules;
  if (arguments.Get("rate") != "max") rules.rate = arguments.Get<double>("rate");
  rules.lost_after_us = ToUs(arguments.Get<double>("lost-after"));
  return std::make_unique<DriverPrograms>(std::move(commands), rules);
}

int Run(AgentKind kind, int argc, char** argv) {
  const std::string name(ToString(kind));
  Options options("muster-" + name, fmt::format("The {}s of a mission, or some of them", name));
  options.Add("ids", "N-M", "Ids of the agents that this process moves, 0-9; default: all");
  options
      .Add("driver", "[ID=]COMMAND",
           "A program that takes the part of that agent, or of all of this process, which the "
           "scenario has as measured (docs/guide/drivers.md)")
      .Repeated();
  AddRateOption(&options);
  options.Add("lost-after", "SECONDS", "A driver that takes longer to answer has failed")
      .Number(Above0(3600))
      .Default(5);
  AddProcessOptions(&options, name);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const ProcessFlags flags = ReadProcessFlags(*arguments);
  IdRange ids;
  if (arguments->Has("ids")) ids = ReadIds(arguments->Get("ids"));
  AgentProcess process(flags.identity, flags.window, kind, ids, AgentProcess::kMostWhole,
                       DriversOf(*arguments));
  const auto bus = OpenBus(flags, GuardedChannels::kOfAgents);
  return RunProcess(&process, bus.get(), flags.quiet);
}

}  // namespace

int AgentMain(AgentKind kind, int argc, char** argv) {
  const std::string program = "muster-" + std::string(ToString(kind));
  return GuardedMain(program.c_str(), [&] { return Run(kind, argc, argv); });
}

}  // namespace muster::agents
