#include "scheduler/policies/learned/learned_policy.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "model/generator.h"

namespace muster::scheduler {

namespace {

/// A message holds no longer name of a policy.
constexpr std::size_t kLongestModelName = 256;

std::string ModelFolderOf(std::string_view name) {
  if (name.size() > kLongestModelName || HasControls(name)) {
    throw InputError("policy", "learned", Printable(name.substr(0, kLongestModelName)),
                     fmt::format("learned:MODEL, at most {} bytes, without control characters",
                                 kLongestModelName));
  }
  return std::string(name.substr(kLearnedPrefix.size()));
}

}  // namespace

LearnedPolicy::LearnedPolicy(std::string_view name)
    : LearnedPolicy(ModelFolderOf(name), learned::ReadModel(ModelFolderOf(name))) {}

LearnedPolicy::LearnedPolicy(std::string folder, learned::Model model)
    : folder_(std::move(folder)),
      shape_(model.shape),
      network_(std::move(model.tensors), model.shape, model.method == "mf-qmix",
               folder_ + "/model.bin") {}

void LearnedPolicy::CheckScenario(const Scenario& scenario) const {
  const learned::Shape shape = learned::ShapeOf(scenario);
  if (shape == shape_) return;
  throw InputError("policy", std::string(kLearnedPrefix) + folder_,
                   "a scenario of " + ToString(shape),
                   ToString(shape_) + ": what the model was trained for");
}

Decision LearnedPolicy::Decide(const Situation& situation) {
  // Where nobody has checked the whole scenario, as much as the situation tells.
  const Site& site = *situation.site;
  const auto cells = [](double metres) { return static_cast<int>(std::ceil(metres / kCellM)); };
  const bool fits = cells(site.width_m) == shape_.columns && cells(site.height_m) == shape_.rows &&
                    site.rules.interval_us == shape_.interval_us &&
                    site.rules.limit_us == shape_.limit_us;
  if (!fits) {
    throw InputError("policy", std::string(kLearnedPrefix) + folder_,
                     "a situation of another scenario",
                     ToString(shape_) + ": what the model was trained for");
  }
  const learned::Observation observation = learned::Observe(situation, shape_);
  const learned::Choices choices = learned::BestOf(observation, network_.ValuesOf(observation));
  std::int64_t candidates = 0;
  for (const AgentKind kind : kAgentKinds) {
    for (const learned::AgentView& view : observation.agents[kind]) {
      for (const learned::PlaceOption& option : view.options) {
        candidates += option.kind != learned::PlaceOption::Kind::kNone;
      }
    }
  }
  return MakeDecision(learned::ActionsOf(situation, observation, choices), candidates);
}

}  // namespace muster::scheduler
