#include <fmt/format.h>

#include <optional>

#include "base/program.h"
#include "protocol/run_process.h"
#include "scheduler/process/scheduler_process.h"

namespace muster::scheduler {
namespace {

std::string PolicyHelp() {
  std::string help = "How to decide:";
  for (const PolicyInfo& policy : Policies()) help += fmt::format(" {}", policy.name);
  return help;
}

int Main(int argc, char** argv) {
  cxxopts::Options options("muster-scheduler", "The scheduler of a mission");
  options.add_options()("policy", PolicyHelp(),
                        cxxopts::value<std::string>()->default_value(std::string(kDefaultPolicy)));
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
  SchedulerProcess process(flags.identity, flags.window, (*result)["policy"].as<std::string>(),
                           MonotonicUs, deadline_ms);
  const auto bus = OpenBus(flags);
  return RunProcess(&process, bus.get(), flags.quiet);
}

}  // namespace
}  // namespace muster::scheduler

int main(int argc, char** argv) {
  return muster::GuardedMain("muster-scheduler",
                             [&] { return muster::scheduler::Main(argc, argv); });
}
