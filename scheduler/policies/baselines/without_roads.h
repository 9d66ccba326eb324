#pragma once

#include <memory>
#include <utility>

#include "scheduler/policy.h"

namespace muster::scheduler {

/// Decides as another policy that believes everybody to travel in straight lines. Of its actions
/// those are left out that break a rule by the true ways, as when the pair would come too late. To
/// show what knowing the roads brings.
class WithoutRoadsPolicy : public Policy {
 public:
  explicit WithoutRoadsPolicy(std::unique_ptr<Policy> policy) : policy_(std::move(policy)) {}
  Decision Decide(const Situation& situation) override;

 private:
  std::unique_ptr<Policy> policy_;
};

}  // namespace muster::scheduler
