#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "base/options.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

struct PolicyInfo {
  std::string_view name;
  std::string_view summary;
};

/// The policy of a mission that names none.
inline constexpr std::string_view kDefaultPolicy = "certified";

/// All policies, in the order in which they are listed to users.
const std::vector<PolicyInfo>& Policies();

/// Declares --policy, whose name MakePolicy checks, and --deadline, milliseconds.
Option& AddPolicyOption(Options* options, std::string_view help = "How to decide:");
void AddDeadlineOption(Options* options);

/// Throws InputError naming the known policies when `name` is none of them.
std::unique_ptr<Policy> MakePolicy(std::string_view name);

/// Gives the policy of that name a deadline for each decision, in milliseconds; throws InputError
/// (`--deadline`) when it is not above 0 or the policy has none. No value: without.
void SetDeadline(Policy* policy, std::string_view name, std::optional<double> deadline_ms);

/// Both.
std::unique_ptr<Policy> MakePolicy(std::string_view name, std::optional<double> deadline_ms);

}  // namespace muster::scheduler
