#include "agents/core/agent_main.h"

#include <fmt/format.h>

#include <exception>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "agents/core/agent_process.h"
#include "agents/driver/driver_programs.h"
#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/text.h"
#include "protocol/run_process.h"
#include "scheduler/policies/registry.h"
#include "scheduler/process/scheduler_process.h"

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

std::string ReadSchedulerName(const std::string& name) {
  if (process_name::IsScheduler(name) && !HasControls(name)) return name;
  throw InputError("command line", "--decide-as", Printable(name),
                   "scheduler, or scheduler-1, scheduler-2, ... where there are several");
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

/// A scheduler of the mission in this program, on a thread and a bus of its own: it lives and dies
/// with the agents.
class OwnScheduler {
 public:
  /// As a process of that name, with the program's other flags.
  OwnScheduler(ProcessFlags flags, const std::string& name, const std::string& policy)
      : flags_(std::move(flags)), policy_(scheduler::MakePolicy(policy)) {
    flags_.identity.name = name;
    thread_ = std::thread([this, policy] { Run(policy); });
  }
  ~OwnScheduler() { Stop(); }
  OwnScheduler(const OwnScheduler&) = delete;
  OwnScheduler& operator=(const OwnScheduler&) = delete;

  /// Rethrows what ended it.
  void Join() {
    Stop();
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  }

 private:
  void Stop() {
    StopProcesses();
    if (thread_.joinable()) thread_.join();
  }

  void Run(const std::string& policy) {
    try {
      scheduler::SchedulerProcess process(flags_.identity, flags_.window, policy,
                                          std::move(policy_), MonotonicUs);
      const auto bus = OpenBus(flags_, GuardedChannels::kOfScheduler);
      RunProcess(&process, bus.get(), flags_.quiet, [] {
        Usage usage = HostUsage();  // its time and memory are reported with the agents'
        usage.cpu_s = 0;
        usage.rss_bytes = 0;
        return usage;
      });
    } catch (...) {
      error_ = std::current_exception();
      StopProcesses();
    }
  }

  ProcessFlags flags_;
  std::unique_ptr<scheduler::Policy> policy_;
  std::exception_ptr error_;
  std::thread thread_;
};

int Run(AgentKind kind, int argc, char** argv) {
  const std::string name(ToString(kind));
  Options options("muster-" + name, fmt::format("The {}s of a mission, or some of them", name));
  options.Add("ids", "N-M", "Ids of the agents that this process moves, 0-9; default: all");
  options
      .Add("driver", "[ID=]COMMAND",
           "A program that drives agent ID (without ID: all agents of this process). The scenario "
           "must have them as measured (docs/guide/drivers.md)")
      .Repeated();
  AddRateOption(&options);
  options.Add("lost-after", "SECONDS", "A driver that takes longer to answer has failed")
      .Number(Above0(3600))
      .Default(5);
  options.Add("decide-as", "NAME",
              "Also decide, as the scheduler of that name: scheduler-1, scheduler-2, ... "
              "(docs/guide/without-a-centre.md)");
  scheduler::AddPolicyOption(&options, "With --decide-as, how to decide:");
  AddProcessOptions(&options, name);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const ProcessFlags flags = ReadProcessFlags(*arguments);
  IdRange ids;
  if (arguments->Has("ids")) ids = ReadIds(arguments->Get("ids"));
  AgentProcess process(flags.identity, flags.window, kind, ids, AgentProcess::kMostWhole,
                       DriversOf(*arguments));
  const auto bus = OpenBus(flags, GuardedChannels::kOfAgents);
  if (!arguments->Has("decide-as")) return RunProcess(&process, bus.get(), flags.quiet);
  OwnScheduler own(flags, ReadSchedulerName(arguments->Get("decide-as")),
                   scheduler::PolicyFrom(*arguments));
  const int exit_code = RunProcess(&process, bus.get(), flags.quiet);
  own.Join();
  return exit_code;
}

}  // namespace

int AgentMain(AgentKind kind, int argc, char** argv) {
  const std::string program = "muster-" + std::string(ToString(kind));
  return GuardedMain(program.c_str(), [&] { return Run(kind, argc, argv); });
}

}  // namespace muster::agents
