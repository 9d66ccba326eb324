#include "tools/explain/story.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "base/check.h"
#include "model/feasibility.h"
#include "model/own_rule.h"
#include "protocol/convert.h"

namespace muster::tools {
namespace {

using scheduler::Explainer;

bool IsToldOf(const event_t& event) {
  return IsOutcome(static_cast<EventKind>(event.kind)) ||
         event.kind == EventKind::kActionWithheld || IsOfDriver(static_cast<EventKind>(event.kind));
}

/// Whether an event lies between a decision and the next. What happens at a decision's very time
/// was there before it, but for a match that fails, which is its consequence.
bool BelongsTo(const event_t& event, std::int32_t decision, TimeUs at_us, TimeUs next_us) {
  if (event.kind == EventKind::kMatchFailed) return at_us <= event.at_us && event.at_us < next_us;
  return (at_us < event.at_us || decision == 0) && event.at_us <= next_us;
}

/// A logged situation, parted into what directives decided and what was left to the policy.
struct Parted {
  scheduler::Directing directing;
  std::vector<Action> commands;  ///< of the policy, or what agents do by themselves
};

/// None: the decision's messages are not whole.
std::optional<Parted> PartedOf(const LoggedDecision& logged, const DecisionLog& log) {
  auto situation = SituationOf(logged, log);
  if (!situation) return {};
  Parted parted{{}, CommandsOf(logged, log.scenario)};
  for (const AgentState& uav : situation->uavs) {
    if (logged.in_force) break;
    const auto action = OwnAction(uav, logged.at_us, log.scenario);
    if (action) parted.commands.push_back(*action);
  }
  if (situation->site->directives.empty()) {
    parted.directing.rest = std::move(*situation);
    return parted;
  }
  parted.directing = scheduler::Direct(*situation);
  std::erase_if(parted.commands, [&](const Action& command) {
    const auto& actions = parted.directing.actions;
    return std::any_of(actions.begin(), actions.end(), [&](const Action& action) {
      return std::any_of(std::begin(kAgentKinds), std::end(kAgentKinds), [&](AgentKind kind) {
        return MemberOf(command, kind) >= 0 && MemberOf(command, kind) == MemberOf(action, kind);
      });
    });
  });
  return parted;
}

/// A log's decisions by horizon's matchings. The policy is asked once how it made each.
class HorizonDecisions {
 public:
  HorizonDecisions(const DecisionLog& log, const scheduler::MatchingPolicy& policy)
      : log_(log), policy_(policy) {}

  /// Null: its messages are not whole.
  const scheduler::HorizonDecision* at(std::int32_t decision) {
    const auto [entry, is_new] = decisions_.try_emplace(decision);
    const auto logged = log_.decisions.find(decision);
    if (!is_new || logged == log_.decisions.end()) return entry->second.get();
    if (auto parted = PartedOf(logged->second, log_)) {
      entry->second = std::make_unique<scheduler::HorizonDecision>(
          std::move(parted->directing.rest), std::move(parted->commands), policy_);
    }
    return entry->second.get();
  }

 private:
  const DecisionLog& log_;
  const scheduler::MatchingPolicy& policy_;
  std::map<std::int32_t, std::unique_ptr<scheduler::HorizonDecision>> decisions_;
};

/// What a story is about.
template <class Answer>
struct Question {
  std::function<Answer(const Explainer&)> ask;
  std::function<bool(const event_t&)> concerns;  ///< whether an event belongs to the story
  /// Whether a directive, with what its agents are sent to do, belongs to it.
  std::function<bool(const Directed&)> is_about;
};

/// The planned pairs of an answer that were not commanded.
std::vector<scheduler::PairPlan> PlannedIn(const scheduler::TaskAnswer& answer) {
  if (!answer.plan) return {};
  return {*answer.plan};
}
std::vector<scheduler::PairPlan> PlannedIn(const scheduler::AgentAnswer& answer) {
  std::vector<scheduler::PairPlan> planned;
  for (const scheduler::PairPlan& pair : answer.plans) {
    const bool commanded =
        answer.did && IsPair(answer.did->kind) &&
        (pair.charging ? answer.did->charge.value : answer.did->task.value) == pair.site;
    if (!commanded) planned.push_back(pair);
  }
  return planned;
}

/// Tells one or several stories. Each decision is looked at once for all of them.
template <class Answer>
class Teller {
 public:
  Teller(const DecisionLog& log, std::vector<Question<Answer>> questions)
      : log_(log), questions_(std::move(questions)), logged_(LoggedPolicy(log)) {
    const auto* matching = dynamic_cast<const scheduler::MatchingPolicy*>(logged_.policy.get());
    if (matching != nullptr) horizon_.emplace(log, *matching);
  }

  const std::string& policy() const { return logged_.name; }
  Terms terms() const { return horizon_ ? Terms::kHorizon : Terms::kPaper; }

  /// The chapters of each question.
  std::vector<std::vector<Chapter<Answer>>> Tell(const std::string& run,
                                                 std::optional<std::int32_t> only,
                                                 const DecisionProgress& progress) {
    if (only && !log_.decisions.contains(*only)) {
      throw InputError(run, "--decision", fmt::to_string(*only),
                       log_.decisions.empty() ? std::string("a log with a decision")
                                              : fmt::format("a decision of the log, {} to {}",
                                                            log_.decisions.begin()->first,
                                                            log_.decisions.rbegin()->first));
    }
    std::vector<std::vector<Chapter<Answer>>> stories(questions_.size());
    const std::size_t of = only ? 1 : log_.decisions.size();
    std::size_t told = 0;
    for (const auto& [d, logged] : log_.decisions) {
      if (only && d != *only) continue;
      if (progress) progress(told++, of);
      TellOne(logged, &stories);
    }
    return stories;
  }

 private:
  void TellOne(const LoggedDecision& logged, std::vector<std::vector<Chapter<Answer>>>* stories) {
    const scheduler::HorizonDecision* matched = horizon_ ? horizon_->at(logged.decision) : nullptr;
    std::optional<Parted> parted;
    std::optional<Explainer> explainer;
    if (!horizon_ || HasDirectives()) parted = PartedOf(logged, log_);
    if (matched != nullptr) {
      explainer.emplace(*matched);
    } else if (!horizon_ && parted) {
      explainer.emplace(parted->directing.rest, parted->commands);
    }
    for (std::size_t i = 0; i < questions_.size(); ++i) {
      const Question<Answer>& question = questions_[i];
      Chapter<Answer>& chapter = (*stories)[i].emplace_back(Opened(logged, question));
      if (!explainer) {
        chapter.missing = WhatIsMissing(logged, log_);
        if (chapter.missing.empty()) chapter.missing = "a message that can be";
        continue;
      }
      if (parted) AddDirectives(logged, parted->directing, question, &chapter);
      if (chapter.directed) continue;
      chapter.answer = question.ask(*explainer);
      if (matched == nullptr || !chapter.answer.options.empty()) {
        chapter.quality = explainer->Quality();
      }
      if (matched != nullptr) AddHow(*matched, &chapter);
    }
  }

  /// Whether the mission has ever had a directive.
  bool HasDirectives() const {
    for (const auto& [tick, orders] : log_.orders->said()) {
      for (const TakenOrder& taken : log_.orders->TakenAt(tick)) {
        if (taken.order.directive) return true;
      }
    }
    return false;
  }

  void AddDirectives(const LoggedDecision& logged, const scheduler::Directing& directing,
                     const Question<Answer>& question, Chapter<Answer>* chapter) {
    using State = scheduler::DirectiveOutcome::State;
    std::set<std::string> about;
    for (const scheduler::DirectiveOutcome& outcome : directing.outcomes) {
      Directed directed{outcome.directive, outcome.state, outcome.why, {}};
      for (const Action& action : directing.actions) {
        if (scheduler::IsSentBy(action, directed.directive)) directed.sent.push_back(action);
      }
      if (outcome.state == State::kOver || !question.is_about(directed)) continue;
      about.insert(directed.directive.order);
      chapter->directed =
          chapter->directed || outcome.state == State::kKept || outcome.state == State::kWaits;
      chapter->directives.push_back(std::move(directed));
    }
    if (!chapter->directed || logged_.policy == nullptr) return;
    const scheduler::Situation with = *SituationOf(logged, log_);
    auto site = std::make_shared<scheduler::Site>(*with.site);
    std::erase_if(site->directives,
                  [&](const Directive& one) { return about.contains(one.order); });
    site->forbidden = ForbiddenPairs(site->directives);
    scheduler::Situation without = with;
    without.site = std::move(site);
    chapter->with_and_without = {
        scheduler::DecideWithDirectives(with, logged_.policy.get()).weight,
        scheduler::DecideWithDirectives(without, logged_.policy.get()).weight};
  }

  /// A chapter with all but the answer.
  Chapter<Answer> Opened(const LoggedDecision& logged, const Question<Answer>& question) const {
    Chapter<Answer> chapter;
    chapter.decision = logged.decision;
    chapter.at_us = logged.at_us;
    chapter.scheduled = !logged.schedules.empty();
    chapter.in_force = logged.in_force;
    if (chapter.scheduled) chapter.policy = logged.schedules.front().policy;
    const TimeUs until = log_.scenario.rules.TimeOfDecision(logged.decision + 1);
    for (const event_t& event : log_.events) {
      if (!question.concerns(event)) continue;
      if (event.kind == EventKind::kActionWithheld) {
        if (event.at_us == logged.at_us) chapter.withheld.push_back(event);
      } else if (BelongsTo(event, logged.decision, logged.at_us, until)) {
        chapter.events.push_back(event);
      }
    }
    return chapter;
  }

  void AddHow(const scheduler::HorizonDecision& decision, Chapter<Answer>* chapter) {
    chapter->how = decision.deciding.how;
    chapter->settings = scheduler::Difference(chapter->how->settings);
    for (const scheduler::PairPlan& pair : PlannedIn(chapter->answer)) {
      chapter->fates.emplace_back(
          pair, scheduler::FateOf(pair, decision.situation.decision, log_.scenario,
                                  [this](std::int32_t d) { return horizon_->at(d); }));
    }
  }

  const DecisionLog& log_;
  std::vector<Question<Answer>> questions_;
  PolicyOfLog logged_;
  std::optional<HorizonDecisions> horizon_;
};

}  // namespace

std::vector<TaskStory> TellTasks(const DecisionLog& log, const std::string& run,
                                 const std::vector<std::int32_t>& tasks,
                                 std::optional<std::int32_t> decision,
                                 const DecisionProgress& progress) {
  const auto n = static_cast<std::int32_t>(log.scenario.n_tasks());
  std::vector<TaskStory> stories;
  std::vector<Question<scheduler::TaskAnswer>> questions;
  for (const std::int32_t task : tasks) {
    if (task < 0 || task >= n) {
      throw InputError(run, "--task", fmt::to_string(task),
                       n == 0 ? std::string("a mission with tasks")
                              : fmt::format("a task of the mission, 0 to {}", n - 1));
    }
    TaskStory& story = stories.emplace_back();
    const TaskId id(task);
    story.task = id;
    story.spec = log.scenario.tasks[id.index()];
    story.to_charge_m =
        NearestChargeM(*log.scenario.ways, story.spec.at, log.scenario.charging_points);
    if (log.last_world && id.index() < log.last_world->task_status.size()) {
      story.last_status = static_cast<TaskStatus>(log.last_world->task_status[id.index()]);
    }
    const auto concerns = [task](const event_t& event) {
      return event.task_id == task && IsToldOf(event);
    };
    for (const event_t& event : log.events) {
      if (concerns(event) && event.kind == EventKind::kSensingDone) story.done = event;
    }
    questions.push_back({[id](const Explainer& explainer) { return explainer.AboutTask(id); },
                         concerns,
                         [id](const Directed& directed) {
                           return directed.directive.task == id.value &&
                                  directed.directive.kind == Directive::Kind::kPin;
                         }});
  }
  Teller<scheduler::TaskAnswer> teller(log, std::move(questions));
  auto chapters = teller.Tell(run, decision, progress);
  for (std::size_t i = 0; i < stories.size(); ++i) {
    stories[i].policy = teller.policy();
    stories[i].terms = teller.terms();
    stories[i].chapters = std::move(chapters[i]);
  }
  return stories;
}

TaskStory TellTask(const DecisionLog& log, const std::string& run, std::int32_t task,
                   std::optional<std::int32_t> decision, const DecisionProgress& progress) {
  return std::move(TellTasks(log, run, {task}, decision, progress).front());
}

AgentStory TellAgent(const DecisionLog& log, const std::string& run, AgentKind kind,
                     std::int32_t id, std::optional<std::int32_t> decision,
                     const DecisionProgress& progress) {
  const auto& specs = log.scenario.agents(kind);
  const auto n = static_cast<std::int32_t>(log.scenario.n_agents(kind));
  if (id < 0 || id >= n) {
    throw InputError(run, "--agent", fmt::format("{}:{}", ToString(kind), id),
                     n == 0 ? fmt::format("a mission with {}s", ToString(kind))
                            : fmt::format("{0}:0 to {0}:{1}", ToString(kind), n - 1));
  }
  AgentStory story;
  story.kind = kind;
  story.id = id;
  story.spec = specs[static_cast<std::size_t>(id)];
  const Question<scheduler::AgentAnswer> question = {
      [&](const Explainer& explainer) { return explainer.AboutAgent(kind, id, story.spec); },
      [kind, id](const event_t& event) {
        return ByKind(kind, event.uav_id, event.worker_id, event.vehicle_id) == id &&
               IsToldOf(event);
      },
      [kind, id](const Directed& directed) {
        return directed.directive.kind != Directive::Kind::kForbid &&
               (directed.directive.agents[kind] == id ||
                std::any_of(directed.sent.begin(), directed.sent.end(),
                            [&](const Action& action) { return MemberOf(action, kind) == id; }));
      }};
  Teller<scheduler::AgentAnswer> teller(log, {question});
  story.policy = teller.policy();
  story.terms = teller.terms();
  story.chapters = std::move(teller.Tell(run, decision, progress).front());
  return story;
}

}  // namespace muster::tools
