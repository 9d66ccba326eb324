#pragma once

#include <memory>
#include <utility>

#include "scheduler/policy.h"

namespace muster::scheduler {

/// Decides as another policy that takes all tasks for equally urgent: of normal priority and never
/// due. What has expired is gone for it, too. To show what knowing them brings.
class WithoutTimesPolicy : public Policy {
 public:
  explicit WithoutTimesPolicy(std::unique_ptr<Policy> policy) : policy_(std::move(policy)) {}
  Decision Decide(const Situation& situation) override;

 private:
  std::unique_ptr<Policy> policy_;
};

}  // namespace muster::scheduler
