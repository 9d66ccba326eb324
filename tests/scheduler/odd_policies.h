#ifndef MUSTER_TESTS_SCHEDULER_ODD_POLICIES_H_
#define MUSTER_TESTS_SCHEDULER_ODD_POLICIES_H_

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "scheduler/policies/registry.h"
#include "scheduler/policy.h"

namespace muster::scheduler::testing {

/// What a broken host, or another build, may make of a policy's decisions.
enum class Lie {
  kOneLess,  ///< leaves its last action out: possible, and worth less
  kTwice,    ///< gives its first action twice: impossible, and worth more
};

/// A policy of ours whose decisions are changed.
class LyingPolicy : public Policy {
 public:
  LyingPolicy(const std::string& name, Lie lie) : policy_(MakePolicy(name)), lie_(lie) {}
  Decision Decide(const Situation& situation) override {
    Decision decision = policy_->Decide(situation);
    if (decision.actions.empty()) return decision;
    if (lie_ == Lie::kOneLess) {
      decision.weight -= decision.actions.back().weight;
      decision.actions.pop_back();
    } else {
      decision.weight += decision.actions.front().weight;
      decision.actions.insert(decision.actions.begin(), decision.actions.front());
    }
    return decision;
  }

 private:
  std::unique_ptr<Policy> policy_;
  Lie lie_;
};

/// One whose decisions take it so long.
class SlowPolicy : public Policy {
 public:
  SlowPolicy(const std::string& name, std::chrono::milliseconds takes)
      : policy_(MakePolicy(name)), takes_(takes) {}
  Decision Decide(const Situation& situation) override {
    std::this_thread::sleep_for(takes_);
    return policy_->Decide(situation);
  }

 private:
  std::unique_ptr<Policy> policy_;
  std::chrono::milliseconds takes_;
};

}  // namespace muster::scheduler::testing

#endif  // MUSTER_TESTS_SCHEDULER_ODD_POLICIES_H_
