#include "tools/explain/story.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "base/check.h"
#include "model/feasibility.h"
#include "protocol/convert.h"

namespace muster::tools {
namespace {

using scheduler::Explainer;

std::vector<Action> CommandsOf(const LoggedDecision& decision, const Scenario& scenario) {
  std::vector<Action> actions;
  if (decision.schedules.empty() || !decision.in_force) return actions;
  const WireLimits limits(scenario);
  for (const action_t& wire : decision.schedules.front().actions) {
    if (const auto action = FromWire(wire, limits)) actions.push_back(*action);
  }
  return actions;
}

/// Whether an event lies between a decision and the next. What happens at a decision's very time
/// was there before it, but for a match that fails, which is its consequence.
bool BelongsTo(const event_t& event, std::int32_t decision, TimeUs at_us, TimeUs next_us) {
  if (event.kind == EventKind::kMatchFailed) return at_us <= event.at_us && event.at_us < next_us;
  return (at_us < event.at_us || decision == 0) && event.at_us <= next_us;
}

/// Chapters with what `ask(explainer)` answers and the events that `concerns` picks.
template <class Answer>
std::vector<Chapter<Answer>> Tell(const DecisionLog& log, const std::string& run,
                                  std::optional<std::int32_t> only,
                                  const std::function<Answer(const Explainer&)>& ask,
                                  const std::function<bool(const event_t&)>& concerns) {
  if (only && !log.decisions.contains(*only)) {
    throw InputError(run, "--decision", fmt::to_string(*only),
                     log.decisions.empty() ? std::string("a log with a decision")
                                           : fmt::format("a decision of the log, {} to {}",
                                                         log.decisions.begin()->first,
                                                         log.decisions.rbegin()->first));
  }
  std::vector<Chapter<Answer>> chapters;
  for (const auto& [d, logged] : log.decisions) {
    if (only && d != *only) continue;
    Chapter<Answer> chapter;
    chapter.decision = d;
    chapter.at_us = logged.at_us;
    chapter.scheduled = !logged.schedules.empty();
    chapter.in_force = logged.in_force;
    if (chapter.scheduled) chapter.policy = logged.schedules.front().policy;
    const TimeUs until = logged.at_us + log.scenario.rules.interval_us;
    for (const event_t& event : log.events) {
      if (concerns(event) && BelongsTo(event, d, logged.at_us, until)) {
        chapter.events.push_back(event);
      }
    }
    const auto situation = SituationOf(logged, log.scenario);
    if (situation) {
      const Explainer explainer(*situation, CommandsOf(logged, log.scenario));
      chapter.quality = explainer.Quality();
      chapter.answer = ask(explainer);
    } else {
      chapter.missing = WhatIsMissing(logged, log.scenario);
      if (chapter.missing.empty()) chapter.missing = "a message that can be";
    }
    chapters.push_back(std::move(chapter));
  }
  return chapters;
}

}  // namespace

TaskStory TellTask(const DecisionLog& log, const std::string& run, std::int32_t task,
                   std::optional<std::int32_t> decision) {
  const auto n = static_cast<std::int32_t>(log.scenario.tasks.size());
  if (task < 0 || task >= n) {
    throw InputError(run, "--task", fmt::to_string(task),
                     n == 0 ? std::string("a mission with tasks")
                            : fmt::format("a task of the mission, 0 to {}", n - 1));
  }
  TaskStory story;
  story.task = TaskId(task);
  story.spec = log.scenario.tasks[story.task.index()];
  story.to_charge_m = NearestChargeDistance(story.spec.at, log.scenario.charging_points);
  if (log.last_world && story.task.index() < log.last_world->task_status.size()) {
    story.last_status = static_cast<TaskStatus>(log.last_world->task_status[story.task.index()]);
  }
  const auto concerns = [task](const event_t& event) {
    return event.task_id == task && IsOutcome(static_cast<EventKind>(event.kind));
  };
  for (const event_t& event : log.events) {
    if (concerns(event) && event.kind == EventKind::kSensingDone) story.done = event;
  }
  story.chapters = Tell<scheduler::TaskAnswer>(
      log, run, decision,
      [&](const Explainer& explainer) { return explainer.AboutTask(story.task); }, concerns);
  return story;
}

AgentStory TellAgent(const DecisionLog& log, const std::string& run, AgentKind kind,
                     std::int32_t id, std::optional<std::int32_t> decision) {
  const auto& specs = log.scenario.agents(kind);
  const auto n = static_cast<std::int32_t>(specs.size());
  if (id < 0 || id >= n) {
    throw InputError(run, "--agent", fmt::format("{}:{}", ToString(kind), id),
                     n == 0 ? fmt::format("a mission with {}s", ToString(kind))
                            : fmt::format("{0}:0 to {0}:{1}", ToString(kind), n - 1));
  }
  AgentStory story;
  story.kind = kind;
  story.id = id;
  story.spec = specs[static_cast<std::size_t>(id)];
  story.chapters = Tell<scheduler::AgentAnswer>(
      log, run, decision,
      [&](const Explainer& explainer) { return explainer.AboutAgent(kind, id, story.spec); },
      [kind, id](const event_t& event) {
        return ByKind(kind, event.uav_id, event.worker_id, event.vehicle_id) == id &&
               IsOutcome(static_cast<EventKind>(event.kind));
      });
  return story;
}

}  // namespace muster::tools
