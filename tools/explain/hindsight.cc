#include "tools/explain/hindsight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "base/check.h"
#include "base/index.h"
#include "protocol/convert.h"
#include "scheduler/policies/rollout/rollout.h"
#include "tools/explain/words.h"
#include "tools/host/progress.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;
using scheduler::Future;
using scheduler::Situation;

constexpr std::size_t kCostliest = 3, kMostActions = 6;  ///< that are told in words
constexpr std::size_t kIdsPerLine = 9;
constexpr double kWorthRounding = 1e-6;

/// Sensing of the mission or of a forecast that was done.
struct Sensed {
  std::int32_t task = -1;
  TimeUs start_us = 0, end_us = 0;
};

/// An outcome with what a forecast counts: early tasks a little more.
struct Value {
  Outcome outcome;
  double forecast = 0;
};

Value ValueOf(const std::vector<Sensed>& sensed, const Scenario& scenario) {
  const double early = scheduler::RolloutSettings().early;
  Value value;
  for (const Sensed& one : sensed) {
    const double worth = WorthOf(scenario.tasks[At(one.task)], one.start_us, scenario.rules);
    const double how_early =
        1 - static_cast<double>(one.end_us) / static_cast<double>(scenario.rules.limit_us);
    ++value.outcome.done;
    value.outcome.worth += worth;
    value.forecast += worth * (1 + early * how_early);
  }
  return value;
}

std::vector<Sensed> SensedIn(const DecisionLog& log) {
  std::vector<Sensed> sensed;
  std::map<std::int32_t, TimeUs> started;
  for (const event_t& event : log.events) {
    if (event.task_id < 0 || At(event.task_id) >= log.scenario.tasks.size()) continue;
    if (event.kind == EventKind::kSensingStarted) started[event.task_id] = event.at_us;
    if (event.kind != EventKind::kSensingDone) continue;
    const auto start = started.find(event.task_id);
    const TimeUs start_us = start == started.end() ? event.at_us : start->second;
    sensed.push_back({event.task_id, start_us, event.at_us});
  }
  return sensed;
}

/// When each agent failed for the first time.
std::map<std::pair<AgentKind, std::int32_t>, TimeUs> FailuresIn(const DecisionLog& log) {
  std::map<std::pair<AgentKind, std::int32_t>, TimeUs> failures;
  for (const event_t& event : log.events) {
    if (event.kind != EventKind::kAgentFailed) continue;
    for (const AgentKind kind : kAgentKinds) {
      const std::int32_t id = ByKind(kind, event.uav_id, event.worker_id, event.vehicle_id);
      if (id >= 0) failures.emplace(std::pair(kind, id), event.at_us);
    }
  }
  return failures;
}

/// What is known afterwards of all that was still to come at a decision.
class Afterwards {
 public:
  explicit Afterwards(const DecisionLog& log)
      : log_(log), whole_(log.scenario), failures_(FailuresIn(log)) {}

  Future Of(const Situation& situation) const {
    Future future{situation, log_.scenario.tasks.size()};
    future.situation.site = SiteOf(*situation.site);
    future.situation.task_status.resize(log_.scenario.tasks.size(), TaskStatus::kUnreported);
    for (std::size_t x = 0; x < log_.scenario.tasks.size(); ++x) {
      if (IsCancelled(x) && future.MayBeDone(x)) {
        future.situation.task_status[x] = TaskStatus::kCancelled;
      }
    }
    auto coming =
        std::make_shared<std::vector<AgentState>>(*scheduler::ComingAgents(future.situation));
    for (const AgentKind kind : kAgentKinds) {
      auto& agents =
          ByKind(kind, future.situation.uavs, future.situation.workers, future.situation.vehicles);
      for (AgentState& agent : agents) {
        agent.online_until_us = log_.scenario.agents(kind)[At(agent.id)].online_until_us;
        EndAtFailure(&agent);
      }
    }
    for (AgentState& agent : *coming) EndAtFailure(&agent);
    future.coming = std::move(coming);
    return future;
  }

  std::size_t FailedBetween(TimeUs from_us, TimeUs to_us) const {
    return static_cast<std::size_t>(std::count_if(
        failures_.begin(), failures_.end(),
        [&](const auto& failure) { return from_us <= failure.second && failure.second < to_us; }));
  }

 private:
  /// All tasks and shifts that there were, on the ways of then.
  std::shared_ptr<const scheduler::Site> SiteOf(const scheduler::Site& then) const {
    auto site = std::make_shared<scheduler::Site>(then);
    site->tasks = whole_.tasks;
    site->shifts = whole_.shifts;
    site->task_to_charge_m.resize(whole_.tasks.size());
    for (std::size_t x = 0; x < whole_.tasks.size(); ++x) {
      if (x >= then.tasks.size() || then.tasks[x].at != whole_.tasks[x].at) {
        site->task_to_charge_m[x] = whole_.task_to_charge_m[x];
      }
    }
    return site;
  }
  bool IsCancelled(std::size_t x) const {
    return log_.last_world && x < log_.last_world->task_status.size() &&
           log_.last_world->task_status[x] == static_cast<std::int8_t>(TaskStatus::kCancelled);
  }
  void EndAtFailure(AgentState* agent) const {
    const auto failure = failures_.find({agent->kind, agent->id});
    if (failure == failures_.end()) return;
    agent->online_until_us = std::min(agent->online_until_us, failure->second);
  }

  const DecisionLog& log_;
  scheduler::Site whole_;  ///< with all that came by orders
  std::map<std::pair<AgentKind, std::int32_t>, TimeUs> failures_;
};

std::vector<Sensed> SensedBy(const scheduler::RolloutPlan& plan, const Future& future) {
  scheduler::ForwardModel model(future);
  const scheduler::HorizonPolicy policy(plan.follow);
  model.Step(plan.decision.actions);
  while (!model.over() && model.anybody()) model.Step(policy.ActionsOf(model.situation()));
  std::vector<Sensed> sensed;
  for (const Activity& one : model.done()) {
    sensed.push_back({one.site, one.start_us, one.end_us});
  }
  return sensed;
}

/// The best plan that was found at a decision.
struct Found {
  Value value;
  std::vector<Sensed> sensed;
  std::vector<Action> actions;
};

/// The search at one decision after the other.
class Searcher {
 public:
  Searcher(const DecisionLog& log, std::int64_t effort)
      : log_(log), afterwards_(log), was_(SensedIn(log)), policy_(SettingsOf(log, effort)) {}

  const Afterwards& afterwards() const { return afterwards_; }
  const std::vector<Sensed>& was() const { return was_; }

  Found Find(const Situation& situation) {
    const Future future = afterwards_.Of(situation);
    scheduler::RolloutPlan plan = policy_.Plan(future.situation, {future});
    Found found = FoundOf(plan, future);
    if (!kept_) {
      kept_ = plan;
      return found;
    }
    // The last decision's plan may still be the best.
    scheduler::RolloutPlan again = *kept_;
    again.decision = scheduler::HorizonPolicy(again.follow).Decide(future.situation);
    Found of_kept = FoundOf(again, future);
    if (of_kept.value.forecast <= found.value.forecast) {
      kept_ = plan;
      return found;
    }
    return of_kept;
  }

 private:
  static scheduler::RolloutSettings SettingsOf(const DecisionLog& log, std::int64_t effort) {
    scheduler::RolloutSettings settings;
    settings.rounds = 3;
    settings.effort = effort;
    // Every plan is followed to the end.
    settings.work = std::max(settings.work, settings.draws * log.scenario.decisions());
    for (scheduler::HorizonSettings& variant : settings.variants) variant.steps = true;
    return settings;
  }

  Found FoundOf(const scheduler::RolloutPlan& plan, const Future& future) const {
    Found found{{}, SensedBy(plan, future), plan.decision.actions};
    for (const Sensed& one : was_) {
      if (one.end_us <= future.situation.now_us) found.sensed.push_back(one);
    }
    found.value = ValueOf(found.sensed, log_.scenario);
    return found;
  }

  const DecisionLog& log_;
  Afterwards afterwards_;
  std::vector<Sensed> was_;
  scheduler::RolloutPolicy policy_;
  std::optional<scheduler::RolloutPlan> kept_;
};

Outcome LessThan(const Outcome& more, const Outcome& less) {
  return {more.done - std::min(more.done, less.done), std::max(0.0, more.worth - less.worth)};
}

}  // namespace

Hindsight LookBack(const DecisionLog& log, const std::string& run, std::int64_t effort,
                   const DecisionProgress& progress) {
  const Rules& rules = log.scenario.rules;
  const std::int64_t last = log.last_world ? log.last_world->tick : 0;
  if (last < rules.limit_us / rules.tick_us) {
    throw InputError(run, "mission", fmt::format("known until {}", ClockText(last * rules.tick_us)),
                     fmt::format("one that has ended, at {}", ClockText(rules.limit_us)));
  }
  Searcher searcher(log, effort);
  Hindsight hindsight;
  hindsight.policy = LoggedPolicy(log).name;
  for (const Task& task : log.scenario.tasks) {
    if (task.reported_us < log.scenario.rules.limit_us) ++hindsight.tasks;
  }
  std::vector<Found> found;
  for (const auto& [d, logged] : log.decisions) {
    HindsightDecision decision;
    decision.decision = d;
    decision.at_us = logged.at_us;
    decision.missing = WhatIsMissing(logged, log);
    const auto situation = decision.missing.empty() ? SituationOf(logged, log) : std::nullopt;
    found.push_back(situation ? searcher.Find(*situation) : Found{});
    if (situation) {
      const std::vector<Action> commanded = CommandsOf(logged, log.scenario);
      decision.better = OnlyIn(found.back().actions, commanded);
      decision.commanded = OnlyIn(commanded, found.back().actions);
      decision.failed = searcher.afterwards().FailedBetween(
          logged.at_us, log.scenario.rules.TimeOfDecision(logged.decision + 1));
    }
    hindsight.decisions.push_back(std::move(decision));
    if (progress) progress(found.size(), log.decisions.size());
  }

  Value next = ValueOf(searcher.was(), log.scenario);
  hindsight.was = next.outcome;
  std::vector<Sensed> best = searcher.was();
  for (std::size_t i = found.size(); i-- > 0;) {
    HindsightDecision& decision = hindsight.decisions[i];
    const bool better = found[i].value.forecast > next.forecast + kWorthRounding;
    if (better) {
      decision.lost = LessThan(found[i].value.outcome, next.outcome);
      next = found[i].value;
      best = std::move(found[i].sensed);
    } else {
      decision.better.clear();
      decision.commanded.clear();
    }
    decision.best = next.outcome;
  }
  hindsight.best = next.outcome;
  std::set<std::int32_t> missed;
  for (const Sensed& one : best) missed.insert(one.task);
  for (const Sensed& one : searcher.was()) missed.erase(one.task);
  hindsight.missed.assign(missed.begin(), missed.end());
  return hindsight;
}

namespace {

/// What the tasks are worth, where that is another number than how many there are.
std::string WorthWords(const Outcome& outcome) {
  if (std::abs(outcome.worth - static_cast<double>(outcome.done)) < kWorthRounding) return "";
  return fmt::format(" (worth {:.1f})", outcome.worth);
}

/// "3 tasks"; "worth 0.5" where the same number of tasks is worth less.
std::string OutcomeWords(const Outcome& outcome) {
  if (outcome.done == 0 && outcome.worth > 0) return fmt::format("worth {:.1f}", outcome.worth);
  return Plural(static_cast<int>(outcome.done), "task") + WorthWords(outcome);
}

/// The pairs first.
void AddActions(std::string_view what, std::vector<Action> actions, std::string* text) {
  std::stable_partition(actions.begin(), actions.end(),
                        [](const Action& action) { return IsPair(action.kind); });
  for (std::size_t i = 0; i < std::min(actions.size(), kMostActions); ++i) {
    *text += fmt::format("  {:<9}  {}\n", i == 0 ? what : "", Words(actions[i]));
  }
  if (actions.size() > kMostActions) {
    *text +=
        fmt::format("  {:<9}  and {} more (--json has all)\n", "", actions.size() - kMostActions);
  }
}

}  // namespace

std::string ToText(const Hindsight& hindsight) {
  std::string text = fmt::format(
      "{} did {} of {}{}. The best plan found in hindsight does {}{}.\n"
      "It knows who comes, leaves or fails and what is reported, but nothing that goes wrong by\n"
      "chance. The search is not exact: more may be possible, and one task may be chance.\n\n"
      "decision     time  could still be done  lost\n",
      hindsight.policy.empty() ? "The mission" : hindsight.policy, hindsight.was.done,
      Plural(static_cast<int>(hindsight.tasks), "task"), WorthWords(hindsight.was),
      hindsight.best.done, WorthWords(hindsight.best));
  std::vector<const HindsightDecision*> costly;
  for (const HindsightDecision& decision : hindsight.decisions) {
    text += fmt::format("{:>8}  {:>7}  ", decision.decision, ClockText(decision.at_us));
    if (!decision.missing.empty()) {
      text += fmt::format("not known: the log lacks {}\n", decision.missing);
      continue;
    }
    std::string lost;
    if (decision.lost.worth > kWorthRounding) {
      lost = OutcomeWords(decision.lost);
      costly.push_back(&decision);
    }
    if (decision.failed > 0) {
      lost += fmt::format("{}{} failed", lost.empty() ? "" : ", ",
                          Plural(static_cast<int>(decision.failed), "agent"));
    }
    text +=
        fmt::format("{:>19}{}{}\n", OutcomeWords(decision.best), lost.empty() ? "" : "  ", lost);
  }
  std::stable_sort(costly.begin(), costly.end(),
                   [](const auto* a, const auto* b) { return a->lost.worth > b->lost.worth; });
  if (costly.size() > kCostliest) costly.resize(kCostliest);
  for (const HindsightDecision* decision : costly) {
    text += fmt::format("\nDecision {} at {} lost {}:\n", decision->decision,
                        ClockText(decision->at_us), OutcomeWords(decision->lost));
    AddActions("commanded", decision->commanded, &text);
    AddActions("better", decision->better, &text);
  }
  if (!hindsight.missed.empty()) {
    text += "\nThe best plan does these tasks, and the mission did not:\n";
    for (std::size_t i = 0; i < hindsight.missed.size(); ++i) {
      const bool last = (i + 1) % kIdsPerLine == 0 || i + 1 == hindsight.missed.size();
      text += fmt::format("  task:{}{}", hindsight.missed[i], last ? "\n" : "");
    }
  }
  return text;
}

Json ToJson(const Hindsight& hindsight) {
  const auto outcome = [](const Outcome& o) { return Json{{"done", o.done}, {"worth", o.worth}}; };
  const auto actions = [](const std::vector<Action>& list) {
    Json json = Json::array();
    for (const Action& action : list) json.push_back(ActionJson(ToWire(action)));
    return json;
  };
  Json json;
  json["policy"] = hindsight.policy;
  json["tasks_total"] = hindsight.tasks;
  json["was"] = outcome(hindsight.was);
  json["best"] = outcome(hindsight.best);
  json["decisions"] = Json::array();
  for (const HindsightDecision& decision : hindsight.decisions) {
    Json one = {{"decision", decision.decision}, {"at_s", ToSeconds(decision.at_us)}};
    if (!decision.missing.empty()) {
      one["missing"] = decision.missing;
    } else {
      one["best"] = outcome(decision.best);
      one["lost"] = outcome(decision.lost);
      one["agents_failed"] = decision.failed;
      one["commanded"] = actions(decision.commanded);
      one["better"] = actions(decision.better);
    }
    json["decisions"].push_back(std::move(one));
  }
  json["missed"] = hindsight.missed;
  return json;
}

}  // namespace muster::tools
