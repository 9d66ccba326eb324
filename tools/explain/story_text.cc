#include <fmt/format.h>

#include <cmath>
#include <map>

#include "tools/explain/horizon_text.h"
#include "tools/explain/phrases.h"
#include "tools/explain/story.h"
#include "tools/explain/words.h"

namespace muster::tools {
namespace {

using scheduler::AgentAnswer;
using scheduler::AgentCondition;
using scheduler::Forcing;
using scheduler::Obstacle;
using scheduler::Option;
using scheduler::TaskAnswer;
using scheduler::TaskVerdict;

std::string Weighed(const Action& action) {
  return fmt::format("{} ({:.3f})", Words(action), action.weight);
}

std::string ForcingWords(const std::optional<Forcing>& forcing, double best) {
  if (!forcing) return "no decision that holds it was found";
  std::string text;
  if (!forcing->exact) {
    text = fmt::format("costs {:.3f} to {:.3f} of {:.3f} (not proven)", forcing->cost_low,
                       forcing->cost_high, best);
  } else if (forcing->cost == 0) {
    text = "costs nothing: another decision of the highest weight holds it";
  } else {
    text = fmt::format("costs {:.3f} of {:.3f}", forcing->cost, best);
  }
  if (forcing->pair) text += fmt::format("; {}", Words(*forcing->pair));
  if (!forcing->displaced.empty()) {
    std::vector<std::string> tasks;
    for (const TaskId task : forcing->displaced) {
      tasks.push_back(fmt::format("task:{}", task.value));
    }
    text +=
        fmt::format(", and {} {} not", fmt::join(tasks, ", "), tasks.size() == 1 ? "is" : "are");
  }
  return text;
}

/// What the members of a pair did instead.
std::string InsteadWords(const Option& option) {
  std::string text = Weighed(option.uav_did);
  if (option.partner_did != option.uav_did) text += ", " + Weighed(option.partner_did);
  if (option.site_holder && *option.site_holder != option.uav_did &&
      *option.site_holder != option.partner_did) {
    text += ", " + Weighed(*option.site_holder);
  }
  return text;
}

/// Why nobody was commanded at all.
void AddForce(bool scheduled, bool in_force, Lines* lines) {
  if (!in_force) {
    lines->Add("no decision was in force: the scheduler was lost");
  } else if (!scheduled) {
    lines->Add("the log holds no decision");
  }
}

/// How good the decision itself was, where that matters to the answer.
template <class Answer>
void AddQuality(const Chapter<Answer>& chapter, Lines* lines) {
  const auto& quality = chapter.quality;
  const double loss = quality.best.weight - quality.weight;
  if (chapter.scheduled && chapter.in_force && loss > 1e-3) {
    lines->Add(fmt::format("the decision itself weighs {:.3f}, the best one {:.3f}", quality.weight,
                           quality.best.weight));
  }
}

/// Whose terms the reasons are in.
template <class Story>
std::string TermsWords(const Story& story) {
  if (story.terms == Terms::kHorizon) {
    return fmt::format(
        "In {}'s own terms: what a pair is worth to its matching, in tasks (1: done before the "
        "next decision).\n",
        story.policy);
  }
  for (const auto& chapter : story.chapters) {
    if (chapter.missing.empty() && chapter.scheduled && chapter.in_force &&
        chapter.quality.own_weights) {
      return fmt::format(
          "In the paper's weights, though policy {} decides by weights of its own: those of what "
          "was commanded are as logged.\n",
          chapter.policy);
    }
  }
  return story.policy.empty()
             ? "In the paper's weights.\n"
             : fmt::format("In the paper's weights, by which {} decides.\n", story.policy);
}

void AddAnswer(const TaskAnswer& answer, double best, Lines* lines) {
  for (const Action& action : answer.commanded) {
    if (!IsPair(action.kind)) lines->Add("on its way ahead: " + Weighed(action));
  }
  switch (answer.verdict) {
    case TaskVerdict::kDone:
      break;
    case TaskVerdict::kUnreported:
    case TaskVerdict::kExpired:
      lines->Add(std::string(ToString(answer.verdict)));
      break;
    case TaskVerdict::kUnderWay:
      lines->Add(UnderWayWords(answer.activity));
      break;
    case TaskVerdict::kChosen:
      for (const Action& action : answer.commanded) {
        if (IsPair(action.kind)) lines->Add("chosen: " + Weighed(action));
      }
      break;
    case TaskVerdict::kInfeasible:
      lines->Add("infeasible, " + ObstacleWords(answer.look));
      break;
    case TaskVerdict::kLost: {
      const Option& option = answer.options.front();
      lines->Add(fmt::format("lost: {} could sense it by {} ({:.3f}), the best of {}",
                             PairWords(option.pair, false), ClockWords(option.pair.end_us),
                             option.pair.weight, Plural(answer.look.pairs_feasible, "pair")));
      lines->Add("to:   " + InsteadWords(option));
      lines->Add("forcing it " + ForcingWords(answer.forcing, best));
      break;
    }
  }
}

/// "of 18 decisions: infeasible in 10 (range 6, time limit 4), lost in 5, ..."
std::string Summary(const TaskStory& story) {
  std::map<TaskVerdict, int> verdicts;
  std::map<Obstacle, int> obstacles;
  const Chapter<TaskAnswer>* cheapest = nullptr;
  for (const auto& chapter : story.chapters) {
    if (!chapter.missing.empty()) continue;
    const TaskAnswer& answer = chapter.answer;
    ++verdicts[answer.verdict];
    if (answer.verdict == TaskVerdict::kInfeasible) ++obstacles[answer.look.obstacle];
    if (answer.verdict != TaskVerdict::kLost || !answer.forcing) continue;
    if (cheapest == nullptr || answer.forcing->cost < cheapest->answer.forcing->cost) {
      cheapest = &chapter;
    }
  }
  std::vector<std::string> parts;
  for (const auto& [verdict, n] : verdicts) {
    std::string part = fmt::format("{} in {}", ToString(verdict), n);
    if (verdict == TaskVerdict::kInfeasible) {
      std::vector<std::string> why;
      for (const auto& [obstacle, times] : obstacles) {
        why.push_back(fmt::format(
            "{} {}", obstacle == Obstacle::kNoPartner ? "no idle worker" : ToString(obstacle),
            times));
      }
      part += fmt::format(" ({})", fmt::join(why, ", "));
    }
    parts.push_back(part);
  }
  std::string text =
      fmt::format("Of {} decisions: {}.\n", story.chapters.size(), fmt::join(parts, ", "));
  if (cheapest != nullptr) {
    const double cost = cheapest->answer.forcing->cost;
    text += fmt::format(
        "Forcing it would have been cheapest at decision {}: {}.\n", cheapest->decision,
        cost == 0 ? std::string("it costs nothing")
                  : fmt::format("it costs {:.3f} of {:.3f}", cost, cheapest->quality.best.weight));
  }
  return text;
}

void AddAnswer(const AgentAnswer& answer, AgentKind kind, double best, Lines* lines) {
  if (answer.condition == AgentCondition::kBusy) {
    lines->Add(BusyWords(kind, *answer.state));
    return;
  }
  if (answer.condition != AgentCondition::kIdle) {
    lines->Add(std::string(ToString(answer.condition)));
    return;
  }
  lines->Add("idle: " + Weighed(*answer.did));
  for (std::size_t i = 0; i < answer.options.size(); ++i) {
    const Option& option = answer.options[i];
    lines->Add(fmt::format(
        "could also, by {}, {} {}:{} with {} ({:.3f}); instead {}", ClockWords(option.pair.end_us),
        option.charging ? "charge at" : "sense", option.charging ? "charge" : "task", option.site,
        kind == AgentKind::kUav ? PartnerOf(option.pair, option.charging)
                                : AgentName(AgentKind::kUav, option.pair.uav.value),
        option.pair.weight, InsteadWords(option)));
    lines->Add("  forcing that " + ForcingWords(answer.forcings[i], best));
  }
  const int more = answer.places_feasible - static_cast<int>(answer.options.size()) -
                   (IsPair(answer.did->kind) ? 1 : 0);
  if (more > 0) lines->Add(fmt::format("and {} with less weight", Plural(more, "other place")));
  for (const AgentAnswer::Blocked& group : answer.blocked) {
    lines->Add(BlockedWords(group.places, group.nearest));
  }
}

}  // namespace

std::string ToText(const TaskStory& story) {
  std::string text = fmt::format(
      "task:{} at ({:.2f}, {:.2f}) km takes {} of range to sense, {} from there to charge: {}\n",
      story.task.value, story.spec.at.x_m / 1000, story.spec.at.y_m / 1000, Km(story.spec.cost_m),
      std::isfinite(story.to_charge_m) ? Km(story.to_charge_m) : "no way",
      story.done ? fmt::format("done at {} by uav:{} and worker:{}", ClockWords(story.done->at_us),
                               story.done->uav_id, story.done->worker_id)
                 : std::string("not done"));
  text += TermsWords(story);
  text += "\n";
  Lines lines(&text);
  for (const auto& chapter : story.chapters) {
    const bool done = chapter.horizon
                          ? chapter.horizon->answer.verdict == scheduler::HorizonVerdict::kDone
                          : chapter.answer.verdict == TaskVerdict::kDone;
    if (chapter.missing.empty() && done && story.chapters.size() > 1) continue;
    lines.Begin(chapter.decision, chapter.at_us);
    if (!chapter.missing.empty()) {
      lines.Add("cannot be told, the log lacks " + chapter.missing);
    } else if (done) {
      lines.Add("done");
    } else if (chapter.horizon) {
      AddForce(chapter.scheduled, chapter.in_force, &lines);
      AddHorizon(chapter, &lines);
    } else {
      AddForce(chapter.scheduled, chapter.in_force, &lines);
      AddAnswer(chapter.answer, chapter.quality.best.weight, &lines);
      if (chapter.answer.verdict == TaskVerdict::kLost) AddQuality(chapter, &lines);
    }
    lines.AddEvents(chapter.events);
  }
  if (story.chapters.size() > 1) {
    text += "\n" + (story.terms == Terms::kHorizon ? HorizonSummary(story) : Summary(story));
  }
  return text;
}

std::string ToText(const AgentStory& story) {
  std::string text =
      fmt::format("{} is online from {} to {}\n", AgentName(story.kind, story.id),
                  ClockWords(story.spec.online_from_us), ClockWords(story.spec.online_until_us));
  text += TermsWords(story);
  text += "\n";
  Lines lines(&text);
  for (const auto& chapter : story.chapters) {
    lines.Begin(chapter.decision, chapter.at_us);
    if (!chapter.missing.empty()) {
      lines.Add("cannot be told, the log lacks " + chapter.missing);
    } else if (chapter.horizon) {
      AddForce(chapter.scheduled, chapter.in_force, &lines);
      AddHorizon(chapter, story.kind, &lines);
    } else {
      AddForce(chapter.scheduled, chapter.in_force, &lines);
      AddAnswer(chapter.answer, story.kind, chapter.quality.best.weight, &lines);
      if (!chapter.answer.options.empty()) AddQuality(chapter, &lines);
    }
    lines.AddEvents(chapter.events);
  }
  return text;
}

}  // namespace muster::tools
