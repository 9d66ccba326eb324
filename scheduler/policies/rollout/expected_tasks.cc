#include "scheduler/policies/rollout/expected_tasks.h"

#include <memory>
#include <vector>

#include "base/random.h"

namespace muster::scheduler {

Future ExpectTasks(const Situation& situation, double per_hour, std::uint32_t number) {
  Future future{situation};
  std::vector<std::size_t> known;
  for (std::size_t x = 0; x < situation.task_status.size(); ++x) {
    if (situation.task_status[x] != TaskStatus::kUnreported) known.push_back(x);
  }
  const TimeUs left_us = situation.site->rules.limit_us - situation.now_us;
  if (known.empty() || left_us <= 0 || per_hour <= 0) return future;
  Random random(situation.site->seed, Stream::kExpectedTasks, number,
                static_cast<std::uint32_t>(situation.decision));
  const double mean = per_hour * ToSeconds(left_us) / 3600;
  future.expected = static_cast<std::size_t>(mean + random.Uniform());
  auto site = std::make_shared<Site>(*situation.site);
  for (std::size_t i = 0; i < future.expected; ++i) {
    const std::size_t like = known[random.Below(static_cast<std::uint32_t>(known.size()))];
    const Task& model = situation.site->tasks[like];
    const auto since_report = [&](TimeUs t, TimeUs reported_us) {
      return t == kNever ? kNever : t - model.reported_us + reported_us;
    };
    Task task;
    task.at = model.at;
    task.cost_m = model.cost_m;
    task.priority = model.priority;
    task.reported_us =
        situation.now_us + 1 + static_cast<TimeUs>(random.Uniform() * static_cast<double>(left_us));
    task.due_us = since_report(model.due_us, task.reported_us);
    task.expires_us = since_report(model.expires_us, task.reported_us);
    site->tasks.push_back(task);
    site->task_to_charge_m.push_back(situation.site->task_to_charge_m[like]);
    future.situation.task_status.push_back(TaskStatus::kUnreported);
  }
  future.situation.site = std::move(site);
  return future;
}

}  // namespace muster::scheduler
