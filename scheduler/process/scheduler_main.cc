#include "scheduler/process/scheduler_main.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "base/program.h"
#include "protocol/run_process.h"
#include "scheduler/process/scheduler_process.h"

namespace muster::scheduler {
namespace {

std::string PolicyHelp(const std::vector<OwnPolicy>& own) {
  std::string help = "How to decide:";
  for (const OwnPolicy& policy : own) help += fmt::format(" {}", policy.name);
  for (const PolicyInfo& policy : Policies()) help += fmt::format(" {}", policy.name);
  return help;
}

std::unique_ptr<Policy> Make(const std::string& name, std::optional<double> deadline_ms,
                             const std::vector<OwnPolicy>& own) {
  const auto found = std::find_if(own.begin(), own.end(),
                                  [&](const OwnPolicy& policy) { return policy.name == name; });
  if (found == own.end()) return MakePolicy(name, deadline_ms);
  std::unique_ptr<Policy> policy = found->make();
  SetDeadline(policy.get(), name, deadline_ms);
  return policy;
}

int Run(const std::string& program, int argc, char** argv, const std::vector<OwnPolicy>& own) {
  cxxopts::Options options(program, "The scheduler of a mission");
  options.add_options()("policy", PolicyHelp(own),
                        cxxopts::value<std::string>()->default_value(
                            own.empty() ? std::string(kDefaultPolicy) : own.front().name));
  options.add_options()("deadline",
                        "Milliseconds that a decision may take, the best found until then is taken "
                        "(default: none, so that decisions can be repeated)",
                        cxxopts::value<double>(), "MS");
  AddProcessOptions(&options, "scheduler");
  const auto result = ParseOptions(&options, argc, argv);
  if (!result) return kExitOk;
  const ProcessFlags flags = ReadProcessFlags(*result, "scheduler");
  std::optional<double> deadline_ms;
  if (result->count("deadline") > 0) deadline_ms = (*result)["deadline"].as<double>();
  const std::string policy = (*result)["policy"].as<std::string>();
  SchedulerProcess process(flags.identity, flags.window, policy, Make(policy, deadline_ms, own),
                           MonotonicUs);
  const auto bus = OpenBus(flags);
  return RunProcess(&process, bus.get(), flags.quiet);
}

}  // namespace

int SchedulerMain(int argc, char** argv, const std::vector<OwnPolicy>& own) {
  const std::string program = std::filesystem::path(argv[0]).filename().string();
  return GuardedMain(program.c_str(), [&] { return Run(program, argc, argv, own); });
}

}  // namespace muster::scheduler
