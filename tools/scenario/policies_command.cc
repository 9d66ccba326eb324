#include "tools/scenario/policies_command.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string_view>

#include "base/options.h"
#include "base/program.h"
#include "scheduler/policies/registry.h"
#include "tools/scenario/policies_check.h"

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

constexpr std::string_view kOutside =
    "a program of yours, in any language (docs/guide/external-schedulers.md)";
constexpr std::string_view kLearned =
    "a model that muster train made, in its folder (docs/guide/learned.md)";

void PrintText() {
  for (const PolicyGroup group : scheduler::kPolicyGroups) {
    fmt::print("{}\n", Heading(group));
    for (const scheduler::PolicyInfo& info : scheduler::Policies()) {
      if (info.group != group) continue;
      fmt::print("  {:<30} {}{}\n", info.name, info.summary,
                 info.name == scheduler::kDefaultPolicy ? " (default)" : "");
    }
  }
  fmt::print("your own:\n  {:<30} {}\n", "external:COMMAND", kOutside);
  fmt::print("  {:<30} {}\n", "learned:MODEL", kLearned);
}

void PrintJson() {
  Json policies = Json::array();
  for (const scheduler::PolicyInfo& info : scheduler::Policies()) {
    policies.push_back(
        {{"name", info.name}, {"group", NameOf(info.group)}, {"summary", info.summary}});
  }
  const Json list = {{"version", 1},
                     {"default", scheduler::kDefaultPolicy},
                     {"policies", std::move(policies)},
                     {"outside", {{"prefix", "external:"}, {"summary", kOutside}}},
                     {"learned", {{"prefix", "learned:"}, {"summary", kLearned}}}};
  fmt::print("{}\n", list.dump(2));
}

}  // namespace

int PoliciesCommand(int argc, const char* const* argv) {
  if (argc > 1 && std::string_view(argv[1]) == "check") return PoliciesCheck(argc - 1, argv + 1);
  Options options("muster policies",
                  "Says which policy to take for what. muster policies check COMMAND: tries a "
                  "scheduler of yours.");
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
