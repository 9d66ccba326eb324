#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/options.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

/// Whose a policy is, which is also what it is for.
enum class PolicyGroup {
  kOurs,      ///< for missions
  kPaper,     ///< to compare with: the paper's, and its baselines
  kAblation,  ///< for studies: another one with an ingredient more or less, or another K
};
inline constexpr PolicyGroup kPolicyGroups[] = {PolicyGroup::kOurs, PolicyGroup::kPaper,
                                                PolicyGroup::kAblation};

struct PolicyInfo {
  PolicyGroup group;
  std::string_view name;
  std::string_view summary;
};

/// The policy of a mission that names none: of all, it gets most done on Random_1 within 50 ms a
/// decision (docs/results/ablation.md).
inline constexpr std::string_view kDefaultPolicy = "rollout-steps";

/// The policy of missions without a centre (policies/neighbours/game.h).
inline constexpr std::string_view kNeighbours = "neighbours";

/// All policies, in the order in which they are listed to users.
const std::vector<PolicyInfo>& Policies();

/// Declares --policy, whose name MakePolicy checks, with the options of its settings
/// (--expect-arrivals, --reach, --radio-loss), and --deadline, milliseconds. Ablations are known,
/// but not listed.
Option& AddPolicyOption(Options* options, std::string_view help = "How to decide:");
/// What --policy and the options of its settings say together: the name that decisions are logged
/// under and made again by. Throws InputError when the policy has no such setting, or both say one.
std::string PolicyFrom(const Arguments& arguments);
void AddDeadlineOption(Options* options);

/// Whether a policy of that name is a program of the user's (docs/guide/external-schedulers.md). A
/// log may name any program, so such a policy is made only if the user names it.
bool IsExternal(std::string_view name);

/// "rollout" of "rollout:expect=12"; the whole name where nothing stands behind it.
std::string_view BaseName(std::string_view name);

/// Gives the policy what stands behind its name: "rollout:expect=12" (RolloutSettings),
/// "neighbours:reach=5:loss=0.1" (Radio; kilometres). Throws InputError when a key or a value is
/// impossible, or the policy has no such setting.
void ApplySettings(Policy* policy, std::string_view name);

/// Throws InputError naming the known policies when `name` is none of them, nor "external:" and a
/// program that is there. What may stand behind a name: see ApplySettings.
std::unique_ptr<Policy> MakePolicy(std::string_view name);

/// Gives the policy of that name a deadline for each decision, in milliseconds; throws InputError
/// (`--deadline`) when it is not above 0 or the policy has none. No value: without.
void SetDeadline(Policy* policy, std::string_view name, std::optional<double> deadline_ms);

/// Both.
std::unique_ptr<Policy> MakePolicy(std::string_view name, std::optional<double> deadline_ms);

}  // namespace muster::scheduler
