#include "scheduler/explain/deciding.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "base/index.h"
#include "scheduler/policies/rollout/forward_model.h"

namespace muster::scheduler {

PairPlan PlanOf(const Situation& situation, const Participants& participants, const Match& match,
                bool second) {
  const Participant& uav = participants.uavs[At(match.uav)];
  const Participant& partner =
      (match.charging ? participants.vehicles : participants.workers)[At(match.partner)];
  PairPlan plan;
  plan.charging = match.charging;
  plan.site = match.site;
  plan.uav = UavId(uav.agent->id);
  plan.partner = partner.agent->id;
  if (uav.ready_us > situation.now_us) plan.uav_free_us = uav.ready_us;
  if (partner.ready_us > situation.now_us) plan.partner_free_us = partner.ready_us;
  plan.worth = match.weight;
  plan.end_us = match.end_us;
  plan.second = second;
  return plan;
}

std::vector<PairPlan> PairsOf(const Situation& situation, const HorizonPlan& plan) {
  std::vector<PairPlan> pairs;
  for (const Match& match : plan.first) {
    pairs.push_back(PlanOf(situation, plan.now, match, false));
  }
  for (const Match& match : plan.second) {
    pairs.push_back(PlanOf(situation, plan.then, match, true));
  }
  return pairs;
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
  if (settings.radio) {
    parts.push_back(
        fmt::format("agreed among neighbours within {} km", settings.radio->reach_m / 1e3));
  }
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
