#include "tools/scenario/policies_command.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string_view>

#include "base/options.h"
#include "base/program.h"
#include "scheduler/policies/registry.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;
using scheduler::PolicyGroup;

std::string_view NameOf(PolicyGroup group) {
  switch (group) {
    case PolicyGroup::kOurs:
      return "ours";
    case PolicyGroup::kPaper:
      return "paper";
    case PolicyGroup::kAblation:
      return "ablation";
  }
  return "";
}

std::string_view Heading(PolicyGroup group) {
  switch (group) {
    case PolicyGroup::kOurs:
      return "ours, for missions:";
    case PolicyGroup::kPaper:
      return "the paper's and its baselines, to compare with:";
    case PolicyGroup::kAblation:
      return "ablations, to study one ingredient:";
  }
  return "";
}

void PrintText() {
  for (const PolicyGroup group : scheduler::kPolicyGroups) {
    fmt::print("{}\n", Heading(group));
    for (const scheduler::PolicyInfo& info : scheduler::Policies()) {
      if (info.group != group) continue;
      fmt::print("  {:<30} {}{}\n", info.name, info.summary,
                 info.name == scheduler::kDefaultPolicy ? " (default)" : "");
    }
  }
}

void PrintJson() {
  Json policies = Json::array();
  for (const scheduler::PolicyInfo& info : scheduler::Policies()) {
    policies.push_back(
        {{"name", info.name}, {"group", NameOf(info.group)}, {"summary", info.summary}});
  }
  const Json list = {
      {"version", 1}, {"default", scheduler::kDefaultPolicy}, {"policies", std::move(policies)}};
  fmt::print("{}\n", list.dump(2));
}

}  // namespace

int PoliciesCommand(int argc, const char* const* argv) {
  Options options("muster policies", "Says which policy to take for what.");
  options.Json();
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  if (arguments->Has("json")) {
    PrintJson();
  } else {
    PrintText();
  }
  return kExitOk;
}

}  // namespace muster::tools
