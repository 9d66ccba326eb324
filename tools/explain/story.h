#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/explain/explain.h"
#include "scheduler/explain/fate.h"
#include "scheduler/policies/directives/directing.h"
#include "tools/explain/decision_log.h"

namespace muster::tools {

using scheduler::Terms;

/// One directive at a decision.
struct Directed {
  Directive directive;
  scheduler::DirectiveOutcome::State state = scheduler::DirectiveOutcome::State::kKept;
  std::string why;           ///< of what waits or cannot be kept
  std::vector<Action> sent;  ///< its agents' actions at this decision
};

/// One decision of a story. `Answer` is scheduler::TaskAnswer or AgentAnswer.
template <class Answer>
struct Chapter {
  std::int32_t decision = -1;
  TimeUs at_us = 0;
  std::string missing;    ///< why nothing can be told; else empty
  bool scheduled = true;  ///< the log holds a schedule for it
  bool in_force = true;   ///< as LoggedDecision; else no agent was commanded
  std::string policy;
  /// What the commander had decided about the task or agent, and what became of it.
  std::vector<Directed> directives;
  /// Weights of the decision with these, and as the policy decides without them; none: no policy of
  /// ours decided.
  std::optional<std::pair<double, double>> with_and_without;
  /// The commander decided, not the policy: there is no answer.
  bool directed = false;
  Answer answer;
  scheduler::DecisionQuality quality;  ///< in horizon's terms only where the answer has options
  // In horizon's terms only.
  std::optional<scheduler::HowDecided> how;
  std::string settings;  ///< what tells those that decided from horizon's own
  /// The answer's planned pairs and what became of them.
  std::vector<std::pair<scheduler::PairPlan, scheduler::Fate>> fates;
  /// What was decided for the task or agent and left out, as no altitude was free.
  std::vector<event_t> withheld;
  std::vector<event_t> events;  ///< of the task or agent, after the decision, up to the next
};

/// A task over the mission.
struct TaskStory {
  TaskId task;
  Task spec;
  double to_charge_m = 0;
  TaskStatus last_status = TaskStatus::kOpen;  ///< as the log shows last
  std::optional<event_t> done;
  std::string policy;  ///< of the log's first schedule; empty: it has none
  Terms terms = Terms::kPaper;
  std::vector<Chapter<scheduler::TaskAnswer>> chapters;
};

/// An agent over the mission.
struct AgentStory {
  AgentKind kind = AgentKind::kUav;
  std::int32_t id = -1;
  AgentSpec spec;
  std::string policy;
  Terms terms = Terms::kPaper;
  std::vector<Chapter<scheduler::AgentAnswer>> chapters;
};

/// All decisions, or one, in the terms of the policy that decided. Throws InputError when the
/// scenario has no such task or agent, or the log no such decision; `run` is named then. Costs a
/// few exact decisions each, or a few matchings and forecasts.
TaskStory TellTask(const DecisionLog& log, const std::string& run, std::int32_t task,
                   std::optional<std::int32_t> decision, const DecisionProgress& progress = {});
/// The same of several tasks, where each decision is made again once for all.
std::vector<TaskStory> TellTasks(const DecisionLog& log, const std::string& run,
                                 const std::vector<std::int32_t>& tasks,
                                 std::optional<std::int32_t> decision,
                                 const DecisionProgress& progress = {});
AgentStory TellAgent(const DecisionLog& log, const std::string& run, AgentKind kind,
                     std::int32_t id, std::optional<std::int32_t> decision,
                     const DecisionProgress& progress = {});

/// For people.
std::string ToText(const TaskStory& story);
std::string ToText(const AgentStory& story);

/// The same facts for tools (docs/guide/explain.md).
nlohmann::ordered_json ToJson(const TaskStory& story);
nlohmann::ordered_json ToJson(const AgentStory& story);

}  // namespace muster::tools
