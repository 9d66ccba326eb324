#include "scheduler/process/scheduler_main.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "protocol/run_process.h"
#include "scheduler/process/scheduler_process.h"

namespace muster::scheduler {
namespace {

std::unique_ptr<Policy> Make(const std::string& name, std::optional<double> deadline_ms,
                             const std::vector<OwnPolicy>& own) {
  const auto found = std::find_if(own.begin(), own.end(), [&](const OwnPolicy& policy) {
    return policy.name == BaseName(name);
  });
  if (found == own.end()) return MakePolicy(name, deadline_ms);
  std::unique_ptr<Policy> policy = found->make();
  ApplySettings(policy.get(), name);
  SetDeadline(policy.get(), name, deadline_ms);
  return policy;
}

int Run(const std::string& program, int argc, char** argv, const std::vector<OwnPolicy>& own) {
  Options options(program, "The scheduler of a mission");
  std::string help = "How to decide:";
  for (const OwnPolicy& policy : own) help += " " + policy.name;
  Option& option = AddPolicyOption(&options, help);
  if (!own.empty()) option.Default(own.front().name);
  AddDeadlineOption(&options);
  AddProcessOptions(&options, process_name::kScheduler);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const ProcessFlags flags = ReadProcessFlags(*arguments);
  if (!process_name::IsScheduler(flags.identity.name)) {
    throw InputError("command line", "--name", fmt::format("'{}'", flags.identity.name),
                     "scheduler, or scheduler-1, scheduler-2, ... where there are several");
  }
  std::optional<double> deadline_ms;
  arguments->Read("deadline", &deadline_ms);
  const std::string policy = PolicyFrom(*arguments);
  SchedulerProcess process(flags.identity, flags.window, policy, Make(policy, deadline_ms, own),
                           MonotonicUs);
  const auto bus = OpenBus(flags, GuardedChannels::kOfScheduler);
  return RunProcess(&process, bus.get(), flags.quiet);
}

}  // namespace

int SchedulerMain(int argc, char** argv, const std::vector<OwnPolicy>& own) {
  const std::string program = std::filesystem::path(argv[0]).filename().string();
  return GuardedMain(program.c_str(), [&] { return Run(program, argc, argv, own); });
}

}  // namespace muster::scheduler
