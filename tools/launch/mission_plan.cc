// What follows from a mission's plan and its result.
#include "base/program.h"
#include "base/say.h"
#include "lcmtypes/words.h"
#include "tools/launch/supervisor.h"

namespace muster::tools {

std::string_view NameOf(Logger logger) {
  return logger == Logger::kLcm ? process_name::kLogger : process_name::kRecorder;
}
std::string_view LauncherNameWith(Logger logger) {
  return logger == Logger::kLcm ? process_name::kRecorder : process_name::kLauncher;
}

Identity LauncherOf(const MissionPlan& plan) {
  const std::string name(LauncherNameWith(plan.logger));
  return {plan.run_id, name, plan.StartsOf(name)};
}

std::int64_t MissionPlan::StartsOf(const std::string& sender) const {
  const auto found = starts.find(sender);
  return found == starts.end() ? 0 : found->second;
}

int ExitCodeOf(const MissionResult& result) {
  switch (result.end) {
    case MissionEnd::kInterrupted:
      return kExitInterrupted;
    case MissionEnd::kFailed:
      return kExitSystem;
    case MissionEnd::kComplete:
      break;
  }
  return result.without_effect.empty() && result.record.CheckComplete().complete ? kExitOk
                                                                                 : kExitCheckFailed;
}

void PrintProblems(const MissionResult& result) {
  for (const std::string& problem : result.problems) Say("muster: {}\n", problem);
  for (const std::string& line : result.without_effect) Say("muster: {}\n", line);
  if (result.end == MissionEnd::kInterrupted) Say("muster: interrupted\n");
}

}  // namespace muster::tools
