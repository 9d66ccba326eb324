#pragma once

#include <string>
#include <string_view>

#include "scheduler/policies/learned/model.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

/// A policy of that name is a trained model: the rest of the name is its folder.
inline constexpr std::string_view kLearnedPrefix = "learned:";

/// Decides with a model of `muster train`: each agent takes the option that its own network values
/// most, without a word between them. Source: the paper's appendix B (decentralised execution);
/// options and the pairs that come of them: ours, docs/reference/learned.md.
class LearnedPolicy : public Policy {
 public:
  /// `name` with the prefix. Throws InputError when there is no model.
  explicit LearnedPolicy(std::string_view name);

  /// Throws InputError when the model is for another shape of scenario.
  void CheckScenario(const Scenario& scenario) const override;
  Decision Decide(const Situation& situation) override;

 private:
  std::string folder_;
  learned::Shape shape_;
  learned::Network network_;

  LearnedPolicy(std::string folder, learned::Model model);
};

}  // namespace muster::scheduler
