#include "scheduler/explain/deciding.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/index.h"
#include "scheduler/policies/horizon/pairs.h"
#include "scheduler/policies/rollout/forward_model.h"
#include "scheduler/policies/rollout/rollout.h"

namespace muster::scheduler {
namespace {

constexpr double kRounding = 1e-9;  ///< of a pair's worth that is put together in another order

/// Commanded pairs whose weights tell the ways to weigh from each other: a few, as one may stem
/// from the second matching, which weighs in another situation.
std::vector<Action> Fingerprints(const std::vector<Action>& commanded) {
  constexpr std::size_t kMost = 4;
  std::vector<Action> pairs;
  for (const Action& action : commanded) {
    if (action.kind == ActionKind::kSense && pairs.size() < kMost) pairs.push_back(action);
  }
  return pairs;
}

/// What the pair is worth to a matching with these settings; NaN: it is none of its pairs.
double WorthOf(const Situation& situation, const HorizonSettings& settings, const Action& pair) {
  Participants few = ParticipantsOf(situation, settings);
  // A worth rests on its pair, on the tasks that are open, and on the speed of the fastest UAV.
  const auto fastest = std::max_element(
      few.uavs.begin(), few.uavs.end(),
      [](const auto& a, const auto& b) { return a.agent->speed_m_s < b.agent->speed_m_s; });
  const std::int32_t fastest_id = fastest == few.uavs.end() ? -1 : fastest->agent->id;
  std::erase_if(few.uavs, [&](const Participant& p) {
    return p.agent->id != pair.uav.value && p.agent->id != fastest_id;
  });
  std::erase_if(few.workers,
                [&](const Participant& p) { return p.agent->id != pair.worker.value; });
  few.vehicles.clear();
  const PossiblePairs pairs = FindPairs(situation, few, OpenSitesOf(situation), settings);
  const Instance& instance = pairs.instance;
  for (std::int32_t site = 0; site < pairs.n_tasks; ++site) {
    if (pairs.site_ids[At(site)] != pair.task.value) continue;
    const std::int32_t w = instance.partner_begin[At(site)];
    if (w == instance.partner_begin[At(site) + 1]) break;
    for (auto u = instance.uav_begin[At(site)]; u < instance.uav_begin[At(site) + 1]; ++u) {
      const Instance::UavArc& arc = instance.uav_arcs[At(u)];
      if (few.uavs[At(arc.uav)].agent->id != pair.uav.value) continue;
      return Instance::PairWeight(arc, instance.partner_arcs[At(w)]);
    }
  }
  return std::nan("");
}

Deciding OfHorizon(const Situation& situation, const std::vector<Action>& commanded,
                   const HorizonSettings& settings) {
  Deciding deciding;
  deciding.settings = settings;
  deciding.plan = PlanHorizon(situation, settings);
  deciding.again = deciding.plan.decision.actions == commanded;
  return deciding;
}

/// The draws that a decision of `rollout` may rest on, [way][draw]: one alone, or one and another
/// of a later round around it.
std::vector<std::vector<std::uint32_t>> DrawsOf(const RolloutSettings& rollout) {
  const auto a_round = static_cast<std::uint32_t>(rollout.draws / rollout.rounds);
  const auto n = a_round * static_cast<std::uint32_t>(rollout.rounds);
  std::vector<std::vector<std::uint32_t>> ways;
  for (std::uint32_t draw = 0; draw < n; ++draw) ways.push_back({draw});
  for (std::uint32_t draw = 0; draw < n; ++draw) {
    for (std::uint32_t later = (draw / a_round + 1) * a_round; later < n; ++later) {
      ways.push_back({draw, later});
    }
  }
  return ways;
}

Deciding OfRollout(const Situation& situation, const std::vector<Action>& commanded,
                   const RolloutSettings& rollout) {
  const auto with = [&](std::size_t variant, const HorizonSettings& settings) {
    Deciding deciding = OfHorizon(situation, commanded, settings);
    deciding.follow = rollout.variants[variant];
    deciding.variant = static_cast<std::int32_t>(variant);
    deciding.variants = static_cast<std::int32_t>(rollout.variants.size());
    return deciding;
  };
  const std::vector<Action> pairs = Fingerprints(commanded);
  std::vector<std::vector<double>> worth;  // [variant][pair], without chance
  for (const HorizonSettings& variant : rollout.variants) {
    auto& of_pairs = worth.emplace_back();
    for (const Action& pair : pairs) of_pairs.push_back(WorthOf(situation, variant, pair));
  }
  const auto may_be = [&](std::size_t variant, const HorizonSettings& settings) {
    if (pairs.empty()) return true;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto chance = [&](AgentKind kind, std::int32_t id) {
        return JitterOf(situation, settings, kind, id, pairs[k].task.value);
      };
      const double pair_worth = worth[variant][k] + chance(AgentKind::kUav, pairs[k].uav.value) +
                                chance(AgentKind::kWorker, pairs[k].worker.value);
      if (std::abs(pair_worth - pairs[k].weight) < kRounding) return true;
    }
    return false;
  };
  for (std::size_t i = 0; i < worth.size(); ++i) {
    if (!may_be(i, rollout.variants[i])) continue;
    Deciding deciding = with(i, rollout.variants[i]);
    if (deciding.again) return deciding;
  }
  const std::vector<std::vector<std::uint32_t>> all_draws = DrawsOf(rollout);
  for (std::size_t i = 0; i < worth.size(); ++i) {
    for (const std::vector<std::uint32_t>& draws : all_draws) {
      HorizonSettings settings = rollout.variants[i];
      for (std::size_t k = 0; k < draws.size(); ++k) {
        settings.jitters[k] = {k == 0 ? rollout.jitter : rollout.later_jitter, draws[k]};
      }
      if (!may_be(i, settings)) continue;
      Deciding deciding = with(i, settings);
      if (!deciding.again) continue;
      deciding.draws = draws;
      return deciding;
    }
  }
  return with(0, rollout.variants.front());
}

}  // namespace

bool DecidesByHorizon(const Policy& policy) {
  return dynamic_cast<const HorizonPolicy*>(&policy) != nullptr ||
         dynamic_cast<const RolloutPolicy*>(&policy) != nullptr;
}

Deciding HowDecided(const Situation& situation, const std::vector<Action>& commanded,
                    const Policy& policy) {
  if (const auto* rollout = dynamic_cast<const RolloutPolicy*>(&policy)) {
    return OfRollout(situation, commanded, rollout->settings());
  }
  return OfHorizon(situation, commanded, dynamic_cast<const HorizonPolicy&>(policy).settings());
}

std::string Difference(const HorizonSettings& settings) {
  const HorizonSettings own;
  std::vector<std::string> parts;
  const auto number = [&](const char* name, auto HorizonSettings::*field) {
    if (settings.*field != own.*field) parts.push_back(fmt::format("{} {}", name, settings.*field));
  };
  const auto flag = [&](const char* name, bool HorizonSettings::*field) {
    if (settings.*field == own.*field) return;
    parts.push_back(fmt::format("{} {}", settings.*field ? "with" : "without", name));
  };
  number("patience", &HorizonSettings::patience);
  number("finish_weight", &HorizonSettings::finish_weight);
  number("uav_way", &HorizonSettings::uav_way);
  number("partner_way", &HorizonSettings::partner_way);
  number("chain_worth", &HorizonSettings::chain_worth);
  number("tentative", &HorizonSettings::tentative);
  number("soon_decisions", &HorizonSettings::soon_decisions);
  number("charge_worth", &HorizonSettings::charge_worth);
  number("expected_way", &HorizonSettings::expected_way);
  flag("true_duration", &HorizonSettings::true_duration);
  flag("soon_idle", &HorizonSettings::soon_idle);
  flag("send_ahead", &HorizonSettings::send_ahead);
  flag("charge_by_use", &HorizonSettings::charge_by_use);
  flag("ties", &HorizonSettings::ties);
  flag("chains", &HorizonSettings::chains);
  flag("meet_ahead", &HorizonSettings::meet_ahead);
  flag("steps", &HorizonSettings::steps);
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::size_t ForecastDone(const Situation& situation, const std::vector<Action>& actions,
                         const HorizonSettings& follow) {
  ForwardModel model(situation);
  HorizonPolicy policy(follow);
  model.Step(actions);
  while (!model.over() && model.anybody()) model.Step(policy.Decide(model.situation()).actions);
  return model.done().size();
}

}  // namespace muster::scheduler
