#include "tools/bound/bound_command.h"

#include <fmt/format.h>

#include "base/options.h"
#include "base/program.h"
#include "tools/bound/upper_bound.h"
#include "tools/scenario/mission_options.h"

namespace muster::tools {

int BoundCommand(int argc, const char* const* argv) {
  Options options("muster bound",
                  "Tells how many of a scenario's tasks any policy could do at most, even one that "
                  "knows everything beforehand.");
  AddRuleOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const Scenario scenario = ResolveScenario(ReadRuleOptions(*arguments));
  const std::int64_t bound = UpperBound(scenario);
  const std::size_t tasks = scenario.n_tasks();
  fmt::print("at most {} of {} tasks ({:.1f} %)\n", bound, tasks,
             tasks == 0 ? 0.0 : 100.0 * static_cast<double>(bound) / static_cast<double>(tasks));
  return kExitOk;
}

}  // namespace muster::tools
