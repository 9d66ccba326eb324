#include "scheduler/policies/registry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "scheduler/policies/baselines/greedy.h"
#include "scheduler/policies/baselines/kwta.h"
#include "scheduler/policies/baselines/without_roads.h"
#include "scheduler/policies/baselines/without_times.h"
#include "scheduler/policies/certified/certified_policy.h"
#include "scheduler/policies/external/external_policy.h"
#include "scheduler/policies/horizon/horizon.h"
#include "scheduler/policies/horizon/learned_weights.h"
#include "scheduler/policies/learned/learned_policy.h"
#include "scheduler/policies/paper/paper_policies.h"
#include "scheduler/policies/rollout/rollout.h"

namespace muster::scheduler {
namespace {

constexpr int kMostDeadlineMs = 3'600'000;

constexpr std::string_view kShifts = "shifts";
constexpr std::string_view kForecasts = "a policy that forecasts: rollout or rollout-steps";
constexpr std::string_view kNoCentre = "a policy without a centre: neighbours";
constexpr std::int64_t kMostEffort = 1'000'000;

/// What may stand behind a policy's name, and the option that says the same.
struct Setting {
  std::string_view key, option;
  NumberRange bounds;
  std::string_view expected;    ///< "RATE, tasks an hour from 0 to 100000"
  std::string_view policies;    ///< that have it
  std::string_view help;        ///< of the option, without the policies and the default
  std::optional<double> as_is;  ///< the value that is the same as none
  bool whole = false;           ///< whole numbers only
};
constexpr Setting kSettings[] = {
    {"expect",
     "expect-arrivals",
     {0, 100'000},
     "RATE, tasks an hour from 0 to 100000",
     kForecasts,
     "how many more tasks an hour to expect (docs/reference/scheduling.md; default: 0)",
     0},
    {kShifts,
     "know-shifts",
     {0, 1},
     "0 or 1",
     kForecasts,
     "the shift plan is known: forecasts have the agents that come online later",
     0,
     true},
    {"effort",
     "effort",
     {1, kMostEffort},
     "N, a whole number from 1 to 1000000",
     kForecasts,
     "N times the search for each decision, for those who have seconds (default: 1)",
     1,
     true},
    {"reach",
     "reach",
     {0, 1000},
     "KM, kilometres from 0 to 1000",
     kNoCentre,
     "how far agents hear each other, in kilometres (default: 5)",
     {}},
    {"loss",
     "radio-loss",
     {0, 1},
     "SHARE, from 0 to 1",
     kNoCentre,
     "the share of messages between agents that is lost (default: 0)",
     {}},
};

/// One row a policy: its name, what users read about it, how to make it.
struct Row {
  PolicyInfo info;
  std::unique_ptr<Policy> (*make)();
};

template <int kWinners>
std::unique_ptr<Policy> Kwta() {
  return std::make_unique<KwtaPolicy>(kWinners);
}
template <GreedyPolicy::Aim kAim>
std::unique_ptr<Policy> Greedy() {
  return std::make_unique<GreedyPolicy>(kAim);
}
template <Foundation kFoundation>
std::unique_ptr<Policy> Mpq() {
  return std::make_unique<MpqPolicy>(kFoundation);
}
std::unique_ptr<Policy> Certified() { return std::make_unique<CertifiedPolicy>(); }
std::unique_ptr<Policy> Horizon() { return std::make_unique<HorizonPolicy>(HorizonSettings(), 2); }
template <bool HorizonSettings::*kIngredient, bool kOn = false>
std::unique_ptr<Policy> HorizonVariant() {
  HorizonSettings settings;
  settings.*kIngredient = kOn;
  return std::make_unique<HorizonPolicy>(settings);
}
std::unique_ptr<Policy> Neighbours() {
  HorizonSettings settings;
  settings.steps = true;
  settings.radio.emplace();
  return std::make_unique<HorizonPolicy>(settings);
}
template <bool kSteps>
std::unique_ptr<Policy> Rollout() {
  RolloutSettings settings;
  if (kSteps) settings.rounds = 3;
  for (HorizonSettings& variant : settings.variants) variant.steps = kSteps;
  return std::make_unique<RolloutPolicy>(std::move(settings));
}
std::unique_ptr<Policy> RolloutWithoutDraws() {
  RolloutSettings settings;
  settings.draws = 0;
  return std::make_unique<RolloutPolicy>(std::move(settings));
}
std::unique_ptr<Policy> RolloutWithoutChains() {
  RolloutSettings settings;
  for (HorizonSettings& variant : settings.variants) variant.chains = false;
  return std::make_unique<RolloutPolicy>(std::move(settings));
}
template <std::unique_ptr<Policy> (*kMake)()>
std::unique_ptr<Policy> WithoutTimes() {
  return std::make_unique<WithoutTimesPolicy>(kMake());
}
template <std::unique_ptr<Policy> (*kMake)()>
std::unique_ptr<Policy> WithoutRoads() {
  return std::make_unique<WithoutRoadsPolicy>(kMake());
}
std::unique_ptr<Policy> LearnedHorizon() { return std::make_unique<LearnedHorizonPolicy>(); }
std::unique_ptr<Policy> LearnedRollout() { return std::make_unique<LearnedRolloutPolicy>(); }
std::unique_ptr<Policy> Ils() { return std::make_unique<IlsPolicy>(); }

constexpr PolicyGroup kOurs = PolicyGroup::kOurs, kPaper = PolicyGroup::kPaper,
                      kAblation = PolicyGroup::kAblation;

const Row kPolicies[] = {
    {{kOurs, "rollout-steps",
      "most tasks done: that variant of horizon-steps which gets most done when simulated forward"},
     &Rollout<true>},
    {{kOurs, "rollout", "the same without free moves: the paper's nine kinds of action only"},
     &Rollout<false>},
    {{kOurs, "horizon-steps",
      "nearly as many in about a hundredth of the time: value per true duration, soon-idle agents, "
      "the others sent ahead, far places approached by free moves"},
     &HorizonVariant<&HorizonSettings::steps, true>},
    {{kOurs, "horizon", "the same without free moves"}, &Horizon},
    {{kOurs, "certified",
      "the paper's weights: the heaviest decision, or one within a proven gap of it"},
     &Certified},
    {{kOurs, kNeighbours,
      "no centre: agents agree on pairs with those within --reach of their radio "
      "(docs/guide/without-a-centre.md)"},
     &Neighbours},
    {{kPaper, "mpq", "HoCs-MPQ: iterated local search on a growing subgraph (Alg. 5)"},
     &Mpq<Foundation::kHierarchical>},
    {{kPaper, "mpq-uniform", "HoCs-MPQ with uniform foundational weights (section 5.3.3)"},
     &Mpq<Foundation::kUniform>},
    {{kPaper, "ils", "HoCs-ILS: iterated local search on the whole graph (Alg. 2)"}, &Ils},
    {{kPaper, "kwta", "HoCs-KWTA: K-winners-take-all with K = 3 (appendix B)"}, &Kwta<3>},
    {{kPaper, "greedy-sum", "HoCs-GREEDY as the text says: least sum of distances (appendix B)"},
     &Greedy<GreedyPolicy::Aim::kSum>},
    {{kPaper, "greedy-nearest",
      "HoCs-GREEDY towards the nearest task, as the paper's figures suggest"},
     &Greedy<GreedyPolicy::Aim::kNearest>},
    {{kAblation, "kwta-1", "kwta with K = 1"}, &Kwta<1>},
    {{kAblation, "kwta-5", "kwta with K = 5"}, &Kwta<5>},
    {{kAblation, "kwta-10", "kwta with K = 10"}, &Kwta<10>},
    {{kAblation, "horizon-learned",
      "horizon-steps whose weightings were learned (docs/guide/learned.md)"},
     &LearnedHorizon},
    {{kAblation, "rollout-learned", "rollout-steps over the learned weightings alone"},
     &LearnedRollout},
    {{kAblation, "rollout-without-draws", "rollout over the variants alone"}, &RolloutWithoutDraws},
    {{kAblation, "rollout-without-chains", "rollout that values no next task"},
     &RolloutWithoutChains},
    {{kAblation, "rollout-steps-without-times",
      "rollout-steps that is told neither priorities nor due times"},
     &WithoutTimes<Rollout<true>>},
    {{kAblation, "horizon-without-times", "horizon that is told neither"}, &WithoutTimes<Horizon>},
    {{kAblation, "rollout-steps-without-roads",
      "rollout-steps that believes all ways to be straight (docs/results/roads.md)"},
     &WithoutRoads<Rollout<true>>},
    {{kAblation, "horizon-without-roads", "horizon that believes so"}, &WithoutRoads<Horizon>},
    {{kAblation, "certified-without-roads", "certified that believes so"},
     &WithoutRoads<Certified>},
    {{kAblation, "horizon-without-true-duration", "horizon that counts ways only"},
     &HorizonVariant<&HorizonSettings::true_duration>},
    {{kAblation, "horizon-without-soon-idle", "horizon with idle agents only"},
     &HorizonVariant<&HorizonSettings::soon_idle>},
    {{kAblation, "horizon-without-meet-ahead",
      "horizon whose idle agents wait for a partner to be free"},
     &HorizonVariant<&HorizonSettings::meet_ahead>},
    {{kAblation, "horizon-without-send-ahead", "horizon whose unmatched agents stay"},
     &HorizonVariant<&HorizonSettings::send_ahead>},
    {{kAblation, "horizon-without-charge-by-use", "horizon with a fixed worth of charging"},
     &HorizonVariant<&HorizonSettings::charge_by_use>},
    {{kAblation, "horizon-without-chains", "horizon that values no next task"},
     &HorizonVariant<&HorizonSettings::chains>},
    {{kAblation, "horizon-without-ties", "horizon that sees whole decisions only"},
     &HorizonVariant<&HorizonSettings::ties>},
};

/// Whether ":KEY=..." behind it would be no part of a command or a folder.
bool TakesSettings(std::string_view name) {
  return !IsExternal(name) && !name.starts_with(kLearnedPrefix);
}

[[noreturn]] void FailToSet(const Setting& setting, std::string_view policy) {
  throw InputError("options", fmt::format("--{}", setting.option),
                   fmt::format("policy {}", Printable(policy)), std::string(setting.policies));
}

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const Row& row : kPolicies) names.emplace_back(row.info.name);
  return names;
}

}  // namespace

const std::vector<PolicyInfo>& Policies() {
  static const std::vector<PolicyInfo> policies = [] {
    std::vector<PolicyInfo> list;
    for (const Row& row : kPolicies) list.push_back(row.info);
    return list;
  }();
  return policies;
}

Option& AddPolicyOption(Options* options, std::string_view help) {
  std::vector<std::string_view> names;
  for (const Row& row : kPolicies) {
    if (row.info.group != PolicyGroup::kAblation) names.push_back(row.info.name);
  }
  Option& policy =
      options
          ->Add("policy", "NAME",
                fmt::format("{} {} external:COMMAND learned:MODEL (see muster policies)", help,
                            fmt::join(names, " ")))
          .Default(kDefaultPolicy);
  for (const Setting& setting : kSettings) {
    const std::string text = fmt::format(
        "{}: {}", setting.policies == kForecasts ? "rollout, rollout-steps" : kNeighbours,
        setting.help);
    if (setting.key == kShifts) {
      options->Flag(setting.option, text);
      continue;
    }
    const std::string_view value =
        setting.expected.substr(0, setting.expected.find(','));  // "RATE"
    Option& option = options->Add(setting.option, value, text);
    setting.whole ? option.Integer(static_cast<std::int64_t>(setting.bounds.low),
                                   static_cast<std::int64_t>(setting.bounds.high))
                  : option.Number(setting.bounds);
  }
  return policy;
}

std::string PolicyFrom(const Arguments& arguments) {
  std::string name = arguments.Get("policy");
  const bool has_settings = BaseName(name) != name;
  for (const Setting& setting : kSettings) {
    const std::string option(setting.option);
    if (!arguments.Has(option)) continue;
    const double value = setting.key == kShifts ? 1 : arguments.Get<double>(option);
    if (has_settings) {
      throw InputError("command line", "--" + option,
                       setting.key == kShifts ? "the option" : fmt::to_string(value),
                       fmt::format("nothing beside --policy {}", arguments.Get("policy")));
    }
    if (!TakesSettings(name)) FailToSet(setting, name);
    if (setting.as_is == value) continue;
    name += fmt::format(":{}={}", setting.key, value);
  }
  return name;
}

void AddDeadlineOption(Options* options) {
  options
      ->Add("deadline", "MS",
            "Milliseconds after which a policy takes the best decision that it has found (default: "
            "none, so that decisions can be repeated)")
      .Number(Above0(kMostDeadlineMs));
}

bool IsExternal(std::string_view name) { return name.starts_with(kExternalPrefix); }

std::string_view BaseName(std::string_view name) {
  return TakesSettings(name) ? name.substr(0, name.find(':')) : name;
}

void ApplySettings(Policy* policy, std::string_view name) {
  const std::string_view base = BaseName(name);
  if (base == name) return;
  const auto refuse = [&](const std::string& expected) {
    throw InputError("options", "--policy", Printable(name), expected);
  };
  std::set<std::string> given;
  for (const std::string& text : Split(std::string(name.substr(base.size() + 1)), ':')) {
    const std::size_t equals = std::min(text.find('='), text.size());
    const std::string key = text.substr(0, equals);
    const auto setting = std::find_if(std::begin(kSettings), std::end(kSettings),
                                      [&](const Setting& known) { return known.key == key; });
    if (setting == std::end(kSettings) || !given.insert(key).second) {
      std::vector<std::string_view> keys;
      for (const Setting& known : kSettings) keys.push_back(known.key);
      refuse(fmt::format("{}:KEY=VALUE, each KEY once: {}", base, fmt::join(keys, ", ")));
    }
    const auto value = ToNumber(text.substr(std::min(equals + 1, text.size())));
    if (!value || !(*value >= setting->bounds.low && *value <= setting->bounds.high) ||
        (setting->whole && *value != std::floor(*value))) {
      refuse(fmt::format("{}:{}={}", base, key, setting->expected));
    }
    if (!policy->Set(key, *value)) FailToSet(*setting, base);
  }
}

std::unique_ptr<Policy> MakePolicy(std::string_view name) {
  if (IsExternal(name)) return std::make_unique<ExternalPolicy>(name);
  if (name.starts_with(kLearnedPrefix)) return std::make_unique<LearnedPolicy>(name);
  const std::string_view base = BaseName(name);
  for (const Row& row : kPolicies) {
    if (row.info.name != base) continue;
    auto policy = row.make();
    ApplySettings(policy.get(), name);
    return policy;
  }
  const std::vector<std::string> names = Names();
  throw InputError(
      fmt::format("policy: found {}, expected one of {}, external:COMMAND, learned:MODEL{}", name,
                  fmt::join(names, ", "), DidYouMean(name, names)));
}

void SetDeadline(Policy* policy, std::string_view name, std::optional<double> deadline_ms) {
  if (!deadline_ms) return;
  if (!(*deadline_ms > 0 && *deadline_ms <= kMostDeadlineMs)) {
    throw InputError("options", "--deadline", fmt::to_string(*deadline_ms),
                     fmt::format("milliseconds above 0, up to {}", kMostDeadlineMs));
  }
  const auto deadline = std::chrono::duration<double, std::milli>(*deadline_ms);
  if (!policy->SetDeadline(
          std::chrono::duration_cast<std::chrono::steady_clock::duration>(deadline))) {
    throw InputError(
        "options", "--deadline", fmt::format("policy {}", name),
        "one that can be cut short: certified, rollout, rollout-steps, external:COMMAND");
  }
}

std::unique_ptr<Policy> MakePolicy(std::string_view name, std::optional<double> deadline_ms) {
  auto policy = MakePolicy(name);
  SetDeadline(policy.get(), name, deadline_ms);
  return policy;
}

}  // namespace muster::scheduler
