#include "scheduler/policies/baselines/without_times.h"

namespace muster::scheduler {

Decision WithoutTimesPolicy::Decide(const Situation& situation) {
  auto site = std::make_shared<Site>(*situation.site);
  for (Task& task : site->tasks) {
    task.priority = Priority::kNormal;
    task.due_us = kNever;
  }
  Situation plain = situation;
  plain.site = std::move(site);
  return policy_->Decide(plain);
}

}  // namespace muster::scheduler
