#include "model/scenario.h"

namespace muster {

bool Task::IsPlain() const {
  return reported_us == 0 && due_us == kNever && expires_us == kNever &&
         priority == Priority::kNormal && name.empty() && external_id.empty() && source.empty();
}

double WorthOf(const Task& task, TimeUs start_us, const Rules& rules) {
  const double worth = rules.priority_worth[static_cast<std::size_t>(task.priority)];
  return start_us <= task.due_us ? worth : worth * rules.late_worth;
}

bool Scenario::IsOpen() const {
  const Rules usual;
  return rules.priority_worth != usual.priority_worth || rules.late_worth != usual.late_worth ||
         !std::all_of(tasks.begin(), tasks.end(), [](const Task& task) { return task.IsPlain(); });
}

}  // namespace muster
