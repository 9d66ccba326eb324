// All that the explainer says of small random situations, as it was when this was written: number
// of tasks by verdict, of options, and a hash of the answers. Where a change is meant to move them,
// the new lines (printed by a failure) and the reason belong in its commit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "scheduler/explain/explain.h"
#include "scheduler/policies/registry.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

std::string Told(const std::vector<Action>& actions) {
  std::string text;
  for (const Action& action : actions) text += ToString(action) + ";";
  return text;
}

std::string Told(const PairLook& pair) {
  return fmt::format("[{} {} {} {:.9g} {} {} {}]", pair.uav.value, pair.partner,
                     ToString(pair.obstacle), pair.weight, pair.end_us, pair.latest_us,
                     pair.window_of ? ToString(*pair.window_of) : "nobody");
}

std::string Told(const PlaceLook& look) {
  std::string text = fmt::format(
      "({} {} {}: {} {} {} {} {} {} {} {} {}", look.charging, look.site, ToString(look.obstacle),
      look.idle_uavs, look.idle_partners, look.busy_uavs, look.busy_partners, look.uavs_in_range,
      look.pairs, look.pairs_feasible, look.pairs_after_window, look.pairs_after_limit);
  for (const PairLook& pair : look.best) text += Told(pair);
  if (const auto& need = look.nearest_range) {
    text += fmt::format("range {} {:.9g} {:.9g} {:.9g} {:.9g}", need->uav.value, need->range_m,
                        need->way_m, need->cost_m, need->to_charge_m);
  }
  if (look.nearest_time) text += "time " + Told(*look.nearest_time);
  return text + ")";
}

std::string Told(const std::optional<Forcing>& forcing) {
  if (!forcing) return "not forced";
  std::string text =
      fmt::format("forced {:.9g} {:.9g} {} {:.9g} {:.9g}", forcing->with.weight, forcing->cost,
                  forcing->exact, forcing->cost_low, forcing->cost_high);
  if (forcing->pair) text += ToString(*forcing->pair);
  for (const TaskId task : forcing->displaced) text += fmt::format(" task:{}", task.value);
  return text;
}

std::string Told(const Option& option) {
  return fmt::format("option {} {} {} {} {} {}", Told(option.pair), option.charging, option.site,
                     ToString(option.uav_did), ToString(option.partner_did),
                     option.site_holder ? ToString(*option.site_holder) : "free");
}

std::string Told(const TaskAnswer& answer) {
  std::string text =
      fmt::format("{} {} {}", ToString(answer.verdict), Told(answer.commanded), Told(answer.look));
  if (answer.activity) {
    text += fmt::format("{} {} {}", answer.activity->uav.value, answer.activity->partner,
                        answer.activity->start_us);
  }
  for (const Option& option : answer.options) text += Told(option);
  return text + Told(answer.rivals) + Told(answer.forcing) + "\n";
}

std::string Told(const AgentAnswer& answer) {
  std::string text = fmt::format("{} {} {}", ToString(answer.condition), answer.places_feasible,
                                 answer.did ? ToString(*answer.did) : "nothing");
  for (const Option& option : answer.options) text += Told(option);
  for (const Option& option : answer.options) text += Told(option.forcing);
  for (const AgentAnswer::Blocked& blocked : answer.blocked) {
    text += fmt::format("{} {} {} {}", ToString(blocked.obstacle), blocked.charging, blocked.places,
                        Told(blocked.nearest));
  }
  return text + "\n";
}

/// FNV-1a, 32 bits.
std::uint32_t HashOf(const std::string& text) {
  std::uint32_t hash = 2166136261u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

TEST(Answers, AreThoseTheyWere) {
  const char* known[] = {
      "0 done, 0 under way, 0 chosen, 6 lost, 0 infeasible; 42 options, 4 blocked, b2a5c0fb",
      "0 done, 1 under way, 2 chosen, 5 lost, 0 infeasible; 40 options, 9 blocked, 97ea4053",
      "0 done, 1 under way, 0 chosen, 5 lost, 4 infeasible; 44 options, 18 blocked, bcbabe79",
      "0 done, 0 under way, 1 chosen, 5 lost, 0 infeasible; 34 options, 9 blocked, e4dc1cac",
      "0 done, 0 under way, 0 chosen, 4 lost, 4 infeasible; 37 options, 13 blocked, 502631f1",
      "1 done, 2 under way, 2 chosen, 0 lost, 5 infeasible; 17 options, 28 blocked, 4cecb344",
      "0 done, 1 under way, 0 chosen, 5 lost, 0 infeasible; 34 options, 6 blocked, 6653434e",
      "0 done, 2 under way, 3 chosen, 3 lost, 0 infeasible; 37 options, 8 blocked, e0102e81",
      "1 done, 1 under way, 0 chosen, 6 lost, 2 infeasible; 41 options, 17 blocked, 407b9c5a",
      "0 done, 1 under way, 0 chosen, 0 lost, 5 infeasible; 0 options, 11 blocked, 2a85f879",
      "1 done, 1 under way, 0 chosen, 6 lost, 0 infeasible; 40 options, 13 blocked, d7ebfb88",
      "0 done, 1 under way, 5 chosen, 4 lost, 0 infeasible; 59 options, 5 blocked, 6b99f970",
      "0 done, 1 under way, 0 chosen, 0 lost, 5 infeasible; 4 options, 9 blocked, 3dcd7775",
      "2 done, 0 under way, 2 chosen, 4 lost, 0 infeasible; 41 options, 8 blocked, 978f0540",
      "0 done, 1 under way, 0 chosen, 4 lost, 5 infeasible; 27 options, 21 blocked, a63fd97f",
      "0 done, 2 under way, 0 chosen, 0 lost, 4 infeasible; 10 options, 10 blocked, b36b7f3b",
      "1 done, 2 under way, 0 chosen, 5 lost, 0 infeasible; 42 options, 11 blocked, 1e8cd5c4",
      "1 done, 0 under way, 2 chosen, 4 lost, 3 infeasible; 17 options, 29 blocked, 2aad585f",
      "0 done, 1 under way, 0 chosen, 5 lost, 0 infeasible; 24 options, 8 blocked, 54d7cae2",
      "0 done, 1 under way, 2 chosen, 4 lost, 1 infeasible; 39 options, 11 blocked, e20838a2",
      "0 done, 2 under way, 0 chosen, 0 lost, 8 infeasible; 6 options, 32 blocked, c4dcca25",
      "1 done, 1 under way, 0 chosen, 0 lost, 4 infeasible; 2 options, 14 blocked, bd7d65da",
      "1 done, 1 under way, 0 chosen, 2 lost, 4 infeasible; 14 options, 21 blocked, 10b6064f",
      "1 done, 0 under way, 4 chosen, 3 lost, 2 infeasible; 40 options, 25 blocked, a827f615",
  };
  std::uint64_t seed = 0;
  for (const char* line : known) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rules rules;
    if (seed % 4 == 3) rules.availability = Availability::kOverrun;
    const int more = static_cast<int>(seed % 3);
    Situation situation = testing::RandomSituation(
        seed, {4 + more, 4 + 2 * more, 3, 6 + 2 * more, 3, 12.0 + 6 * more}, rules);
    if (seed % 5 == 4 && !situation.uavs.empty()) situation.uavs.front().failed = true;
    const Decision decision =
        MakePolicy(seed % 2 == 0 ? "greedy-nearest" : "mpq")->Decide(situation);
    const Explainer explainer(situation, decision.actions);
    std::map<TaskVerdict, int> verdicts;
    std::size_t options = 0, blocked = 0;
    std::string text;
    for (std::size_t x = 0; x < situation.site->tasks.size(); ++x) {
      const TaskAnswer answer = explainer.AboutTask(TaskId(x));
      ++verdicts[answer.verdict];
      options += answer.options.size();
      text += Told(answer);
    }
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentState& agent : situation.agents(kind)) {
        AgentSpec spec;
        spec.online_from_us = agent.online_from_us;
        spec.online_until_us = agent.online_until_us;
        const AgentAnswer answer = explainer.AboutAgent(kind, agent.id, spec);
        options += answer.options.size();
        blocked += answer.blocked.size();
        text += Told(answer);
      }
    }
    const DecisionQuality quality = explainer.Quality();
    text += fmt::format("{:.9g} {:.9g} {:.9g} {} {}", quality.weight, quality.best.weight,
                        quality.best.bound, quality.own_weights, Told(quality.best.actions));
    EXPECT_EQ(fmt::format("{} done, {} under way, {} chosen, {} lost, {} infeasible; {} options, "
                          "{} blocked, {:08x}",
                          verdicts[TaskVerdict::kDone], verdicts[TaskVerdict::kUnderWay],
                          verdicts[TaskVerdict::kChosen], verdicts[TaskVerdict::kLost],
                          verdicts[TaskVerdict::kInfeasible], options, blocked, HashOf(text)),
              line)
        << text;
    ++seed;
  }
}

}  // namespace
}  // namespace muster::scheduler
