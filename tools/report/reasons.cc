#include "tools/report/reasons.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tools/log/log_source.h"

namespace muster::tools {
namespace {

std::vector<std::int32_t> Undone(const Timeline& timeline) {
  std::vector<std::int32_t> tasks;
  for (std::size_t i = 0; i < timeline.tasks().size(); ++i) {
    const auto& changes = timeline.tasks()[i].rows;
    const bool done =
        !changes.empty() && changes.back().status == static_cast<int>(TaskStatus::kDone);
    if (!done) tasks.push_back(static_cast<std::int32_t>(i));
  }
  return tasks;
}

}  // namespace

nlohmann::ordered_json Reasons(const std::string& run, const Timeline& timeline, std::size_t most,
                               const DecisionProgress& progress) {
  std::vector<std::int32_t> tasks = Undone(timeline);
  nlohmann::ordered_json reasons = {{"undone", tasks.size()},
                                    {"tasks", nlohmann::ordered_json::array()}};
  tasks.resize(std::min(tasks.size(), most));
  if (tasks.empty()) return reasons;
  LogSource source(run);
  const DecisionLog log = ReadDecisionLog(&source);
  for (const TaskStory& story : TellTasks(log, run, tasks, {}, progress)) {
    reasons["tasks"].push_back({story.task.value, ToText(story)});
  }
  return reasons;
}

}  // namespace muster::tools
