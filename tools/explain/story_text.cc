#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>

#include "tools/explain/story.h"
#include "tools/explain/words.h"
#include "tools/host/progress.h"

namespace muster::tools {
namespace {

using scheduler::AgentAnswer;
using scheduler::AgentCondition;
using scheduler::DecisionQuality;
using scheduler::Fate;
using scheduler::FateKind;
using scheduler::Forcing;
using scheduler::Obstacle;
using scheduler::Option;
using scheduler::PairPlan;
using scheduler::TaskAnswer;
using scheduler::TaskVerdict;

/// Collects a chapter's lines. The first one begins with decision and time.
class Lines {
 public:
  explicit Lines(std::string* text) : text_(text) {}
  void Begin(std::int32_t decision, TimeUs at_us) {
    lead_ = fmt::format("decision {:>3}  {}  ", decision, ClockText(at_us));
  }
  void Add(const std::string& line) {
    *text_ += lead_ + line + "\n";
    lead_ = std::string(23, ' ');
  }
  void AddEvents(const std::vector<event_t>& events) {
    for (const event_t& event : events) {
      std::string who;
      const auto add = [&who](const char* name, std::int32_t id) {
        if (id >= 0) who += fmt::format(" {}:{}", name, id);
      };
      add("uav", event.uav_id);
      add("worker", event.worker_id);
      add("vehicle", event.vehicle_id);
      add("task", event.task_id);
      add("charge", event.charge_id);
      if (IsOfDriver(static_cast<EventKind>(event.kind))) who += ": " + event.detail;
      Add(fmt::format("* {} {}{}", ClockText(event.at_us), Spaced(ToString<EventKind>(event.kind)),
                      who));
    }
  }

 private:
  std::string* text_;
  std::string lead_;
};

std::string Weighed(const Action& action) {
  return fmt::format("{} ({:.3f})", Words(action), action.weight);
}

/// "uav:3 (free at 0:50:00) and worker:7 for task:4 by 1:02:00 (0.331)"
std::string PlanWords(const PairPlan& pair) {
  return fmt::format("uav:{}{} and {}{} for {}:{} by {} ({:.3f})", pair.uav.value,
                     FreeWords(pair.uav_free_us), AgentName(pair.partner_kind(), pair.partner),
                     FreeWords(pair.partner_free_us), pair.charging ? "charge" : "task", pair.site,
                     ClockText(pair.end_us), pair.worth);
}

std::string PlansWords(const std::vector<PairPlan>& pairs) {
  std::vector<std::string> words;
  for (const PairPlan& pair : pairs) words.push_back(PlanWords(pair));
  return fmt::format("{}", fmt::join(words, "; "));
}

std::string CostWords(const Forcing& forcing, Terms terms, double of) {
  const bool paper = terms == Terms::kPaper;
  const char* unit = paper ? "" : " tasks";
  if (!forcing.exact) {
    return fmt::format("costs {:.3f} to {:.3f} of {:.3f}{} (not proven)", forcing.cost_low,
                       forcing.cost_high, of, unit);
  }
  if (forcing.cost == 0) {
    return fmt::format("costs nothing: another {} holds it",
                       paper ? "decision of the highest weight" : "matching of the highest worth");
  }
  return fmt::format("costs {:.3f} of {:.3f}{}", forcing.cost, of, unit);
}

std::string ForcingWords(const std::optional<Forcing>& forcing, Terms terms,
                         const DecisionQuality& quality) {
  if (!forcing) {
    return fmt::format("no {} that holds it was found",
                       terms == Terms::kPaper ? "decision" : "matching");
  }
  std::string text = CostWords(*forcing, terms, quality.best.weight);
  if (forcing->pair) text += "; " + Words(*forcing->pair);
  if (forcing->plan) text += "; " + PlanWords(*forcing->plan);
  if (!forcing->displaced.empty()) {
    std::vector<std::string> tasks;
    for (const TaskId task : forcing->displaced) {
      tasks.push_back(fmt::format("task:{}", task.value));
    }
    text +=
        fmt::format(", and {} {} not", fmt::join(tasks, ", "), tasks.size() == 1 ? "is" : "are");
  }
  if (forcing->forecast_done && quality.forecast_done) {
    text += fmt::format("; the forecast ends with {} tasks done, {} as decided",
                        *forcing->forecast_done, *quality.forecast_done);
  }
  return text;
}

/// What the members of an option's pair did instead; empty: nothing.
std::string InsteadWords(const Option& option, Terms terms) {
  if (terms == Terms::kHorizon) return PlansWords(option.rivals);
  std::string text = Weighed(option.uav_did);
  if (option.partner_did != option.uav_did) text += ", " + Weighed(option.partner_did);
  if (option.site_holder && *option.site_holder != option.uav_did &&
      *option.site_holder != option.partner_did) {
    text += ", " + Weighed(*option.site_holder);
  }
  return text;
}

std::string FateWords(const Fate& fate) {
  const std::string when =
      fate.decision < 0 ? std::string("no decision followed")
                        : fmt::format("at decision {}, {}", fate.decision, ClockText(fate.at_us));
  const std::string lost = fmt::format("did not come about {}: ", when);
  switch (fate.kind) {
    case FateKind::kCameAbout:
      return fmt::format("came about {}", when);
    case FateKind::kFailed:
      return fmt::format("{}{} had failed", lost, AgentName(*fate.member_kind, fate.member));
    case FateKind::kOffline:
      return fmt::format("{}{} was offline", lost, AgentName(*fate.member_kind, fate.member));
    case FateKind::kImpossible:
      return lost + "impossible, " + ObstacleWords(*fate.look);
    case FateKind::kOthers:
      if (!fate.taken_by) return lost + "instead " + PlansWords(fate.rivals);
      return lost + "instead " + Words(*fate.taken_by) +
             (fate.rivals.empty() ? "" : "; " + PlansWords(fate.rivals));
    case FateKind::kOutbid:
      return lost + (fate.rivals.empty() ? "the pair was not worth it any more"
                                         : "instead " + PlansWords(fate.rivals));
    case FateKind::kOpen:
      break;
  }
  return fate.decision < 0 ? std::string("had no decision after it")
                           : fmt::format("still stood {}, the last", when);
}

template <class Answer>
void AddFates(const Chapter<Answer>& chapter, Lines* lines) {
  for (const auto& [pair, fate] : chapter.fates) {
    lines->Add(fmt::format("the plan for {}:{} {}", pair.charging ? "charge" : "task", pair.site,
                           FateWords(fate)));
  }
}

/// Why nobody was commanded at all.
void AddForce(bool scheduled, bool in_force, Lines* lines) {
  if (!in_force) {
    lines->Add("no decision was in force: the scheduler was lost");
  } else if (!scheduled) {
    lines->Add("the log holds no decision");
  }
}

/// What the policy decided and nobody began, as UAVs are kept apart.
void AddWithheld(const std::vector<event_t>& withheld, Lines* lines) {
  for (const event_t& event : withheld) {
    std::string who = AgentName(AgentKind::kUav, event.uav_id);
    if (event.worker_id >= 0) who += " and " + AgentName(AgentKind::kWorker, event.worker_id);
    if (event.vehicle_id >= 0) who += " and " + AgentName(AgentKind::kVehicle, event.vehicle_id);
    const std::string where = event.task_id >= 0     ? fmt::format(" to task:{}", event.task_id)
                              : event.charge_id >= 0 ? fmt::format(" to charge:{}", event.charge_id)
                                                     : " off";
    lines->Add(fmt::format("decided, but left out: {} sent{} ({})", who, where, event.detail));
  }
}

std::string_view StateWords(const Directed& directed) {
  using State = scheduler::DirectiveOutcome::State;
  if (directed.state == State::kWaits) return "waits";
  if (directed.state == State::kUnkept) return "cannot be kept";
  return directed.sent.empty() ? "kept: it stays there" : "kept";
}

/// What the commander had decided, and what that changed.
template <class Answer>
void AddDirectives(const Chapter<Answer>& chapter, Lines* lines) {
  for (const Directed& directed : chapter.directives) {
    const Directive& one = directed.directive;
    std::string text = fmt::format("directed by order {}{} ({}): {}", one.order,
                                   one.issuer.empty() ? "" : fmt::format(" of {}", one.issuer),
                                   ToString(one), StateWords(directed));
    if (!directed.why.empty()) text += ", " + directed.why;
    for (const Action& action : directed.sent) text += "; " + Weighed(action);
    lines->Add(text);
  }
  if (!chapter.with_and_without) return;
  const auto [with, without] = *chapter.with_and_without;
  lines->Add(
      fmt::format("the decision weighs {:.3f} with that, and {:.3f} without", with, without));
}

/// In the paper's terms: how good the decision itself was. In horizon's: which way to weigh
/// decided, where there is more than one.
template <class Answer>
void AddHow(const Chapter<Answer>& chapter, Lines* lines) {
  if (!chapter.scheduled || !chapter.in_force) return;
  if (!chapter.how) {
    const DecisionQuality& quality = chapter.quality;
    if (quality.best.weight - quality.weight > 1e-3) {
      lines->Add(fmt::format("the decision itself weighs {:.3f}, the best one {:.3f}",
                             quality.weight, quality.best.weight));
    }
    return;
  }
  const scheduler::HowDecided& how = *chapter.how;
  if (!how.again) {
    lines->Add(
        "made again, the decision comes out differently (a deadline, another build): the reasons "
        "are "
        "those of the " +
        std::string(how.follow ? "first variant" : "one that comes out"));
  } else if (how.follow) {
    lines->Add(fmt::format(
        "decided by variant {} of {}{}{}", how.variant + 1, how.variants,
        chapter.settings.empty() ? std::string() : fmt::format(" ({})", chapter.settings),
        how.tasks_drawn > 0
            ? fmt::format(", worth varied by chance at {} in the plan that a search found",
                          Plural(static_cast<int>(how.tasks_drawn), "task"))
        : how.draws.empty()
            ? std::string()
            : fmt::format(", worth varied by chance, draw{} {}", how.draws.size() == 1 ? "" : "s",
                          fmt::join(how.draws, " and "))));
  }
}

/// In whose terms the answer gives reasons.
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

/// That pairs were possible, and what the task lost to.
void AddLost(const Chapter<TaskAnswer>& chapter, Terms terms, Lines* lines) {
  const TaskAnswer& answer = chapter.answer;
  const Option& option = answer.options.front();
  lines->Add(
      fmt::format("{}: {} could sense it by {} ({:.3f}), the best of {}",
                  answer.verdict == TaskVerdict::kPlanned ? "now outbid" : ToString(answer.verdict),
                  PairWords(option.pair, false), ClockText(option.pair.end_us), option.pair.weight,
                  Plural(answer.look.pairs_feasible, "pair")));
  const std::string instead = InsteadWords(option, terms);
  if (!instead.empty()) lines->Add((terms == Terms::kPaper ? "to:   " : "by:   ") + instead);
  lines->Add("forcing it " + ForcingWords(answer.forcing, terms, chapter.quality));
}

void AddAnswer(const Chapter<TaskAnswer>& chapter, Terms terms, Lines* lines) {
  const TaskAnswer& answer = chapter.answer;
  if (terms == Terms::kPaper) {
    for (const Action& action : answer.commanded) {
      if (!IsPair(action.kind)) lines->Add("on its way ahead: " + Weighed(action));
    }
  }
  switch (answer.verdict) {
    case TaskVerdict::kDone:
    case TaskVerdict::kUnreported:
    case TaskVerdict::kExpired:
      lines->Add(std::string(ToString(answer.verdict)));
      return;
    case TaskVerdict::kUnderWay:
      lines->Add(UnderWayWords(answer.activity));
      return;
    case TaskVerdict::kInfeasible:
    case TaskVerdict::kImpossible:
      lines->Add(fmt::format("{}, {}", ToString(answer.verdict), ObstacleWords(answer.look)));
      return;
    case TaskVerdict::kChosen:
      for (const Action& action : answer.commanded) {
        if (IsPair(action.kind)) lines->Add("chosen: " + Weighed(action));
      }
      if (terms == Terms::kPaper) return;
      break;
    case TaskVerdict::kPlanned:
      lines->Add(fmt::format("planned{}: {}", answer.plan->second ? " for after that" : "",
                             PlanWords(*answer.plan)));
      for (const Action& action : answer.commanded) lines->Add("now:  " + Words(action));
      AddFates(chapter, lines);
      if (!answer.options.empty()) AddLost(chapter, terms, lines);
      break;
    case TaskVerdict::kLost:
    case TaskVerdict::kOutbid:
    case TaskVerdict::kWorthless:
      AddLost(chapter, terms, lines);
      break;
  }
  AddHow(chapter, lines);
}

/// "could also, by 0:15:00, sense task:4 with worker:7 (0.331); instead ..."
std::string OptionWords(const Option& option, AgentKind kind, Terms terms) {
  const scheduler::PairLook& pair = option.pair;
  const std::string instead = InsteadWords(option, terms);
  return fmt::format("could also, by {}, {} {}:{} with {} ({:.3f}){}", ClockText(pair.end_us),
                     option.charging ? "charge at" : "sense", option.charging ? "charge" : "task",
                     option.site,
                     kind == AgentKind::kUav
                         ? PartnerOf(pair, option.charging) + FreeWords(pair.partner_free_us)
                         : AgentName(AgentKind::kUav, pair.uav.value) + FreeWords(pair.uav_free_us),
                     pair.weight, instead.empty() ? instead : "; instead " + instead);
}

/// What the agent does.
void AddDoing(const AgentAnswer& answer, AgentKind kind, Terms terms, Lines* lines) {
  if (answer.condition == AgentCondition::kBusy) {
    lines->Add(BusyWords(kind, *answer.state) +
               (answer.free_us ? ", takes part as free at " + ClockText(*answer.free_us) : ""));
  } else if (answer.condition == AgentCondition::kIdle) {
    // What a move weighs is the paper's.
    const bool weighed = terms == Terms::kPaper || IsPair(answer.did->kind);
    lines->Add("idle: " + (weighed ? Weighed(*answer.did) : Words(*answer.did)));
  } else {
    lines->Add(std::string(ToString(answer.condition)));
  }
}

void AddAnswer(const Chapter<AgentAnswer>& chapter, AgentKind kind, Terms terms, Lines* lines) {
  const AgentAnswer& answer = chapter.answer;
  AddDoing(answer, kind, terms, lines);
  if (answer.condition != AgentCondition::kIdle && !answer.free_us) return;
  bool sent = terms == Terms::kPaper && IsPair(answer.did->kind);
  for (const PairPlan& pair : answer.plans) {
    lines->Add((pair.second ? "then planned: " : "matched: ") + PlanWords(pair));
    sent = sent || !pair.second;
  }
  AddFates(chapter, lines);
  for (const Option& option : answer.options) {
    lines->Add(OptionWords(option, kind, terms));
    lines->Add("  forcing that " + ForcingWords(option.forcing, terms, chapter.quality));
  }
  const int more = answer.places_feasible - static_cast<int>(answer.options.size()) - sent;
  if (more > 0) {
    lines->Add(fmt::format("and {} {}", Plural(more, "other place"),
                           terms == Terms::kPaper ? "with less weight" : "of less worth"));
  }
  for (const AgentAnswer::Blocked& group : answer.blocked) {
    lines->Add(BlockedWords(group.places, group.nearest));
  }
  if (terms == Terms::kHorizon || !answer.options.empty()) AddHow(chapter, lines);
}

/// An obstacle in the words of a summary: a missing agent is missing now, or will be soon.
std::string_view ShortWords(Obstacle obstacle, Terms terms) {
  const bool paper = terms == Terms::kPaper;
  if (obstacle == Obstacle::kNoPartner) return paper ? "no idle worker" : "no worker soon";
  if (obstacle == Obstacle::kNoUav && !paper) return "no uav soon";
  return ToString(obstacle);
}

/// "Of 18 decisions: infeasible in 10 (range 6, time limit 4), lost in 5, ...", and where forcing
/// it would have been cheapest.
std::string Summary(const TaskStory& story) {
  int directed = 0;
  std::map<TaskVerdict, int> verdicts;
  std::map<Obstacle, int> obstacles;
  const Chapter<TaskAnswer>* cheapest = nullptr;
  const auto impossible = [](TaskVerdict verdict) {
    return verdict == TaskVerdict::kInfeasible || verdict == TaskVerdict::kImpossible;
  };
  for (const auto& chapter : story.chapters) {
    if (!chapter.missing.empty()) continue;
    if (chapter.directed) {
      ++directed;
      continue;
    }
    const TaskAnswer& answer = chapter.answer;
    ++verdicts[answer.verdict];
    if (impossible(answer.verdict)) ++obstacles[answer.look.obstacle];
    if (!answer.forcing) continue;
    if (cheapest == nullptr || answer.forcing->cost < cheapest->answer.forcing->cost) {
      cheapest = &chapter;
    }
  }
  std::vector<std::string> parts;
  if (directed > 0) parts.push_back(fmt::format("directed in {}", directed));
  for (const auto& [verdict, n] : verdicts) {
    std::string part = fmt::format("{} in {}", ToString(verdict), n);
    if (impossible(verdict)) {
      std::vector<std::string> why;
      for (const auto& [obstacle, times] : obstacles) {
        why.push_back(fmt::format("{} {}", ShortWords(obstacle, story.terms), times));
      }
      part += fmt::format(" ({})", fmt::join(why, ", "));
    }
    parts.push_back(part);
  }
  std::string text =
      fmt::format("Of {} decisions: {}.\n", story.chapters.size(), fmt::join(parts, ", "));
  if (cheapest != nullptr) {
    text += fmt::format(
        "Forcing it would have been cheapest at decision {}: it {}.\n", cheapest->decision,
        CostWords(*cheapest->answer.forcing, story.terms, cheapest->quality.best.weight));
  }
  return text;
}

}  // namespace

std::string ToText(const TaskStory& story) {
  std::string text = fmt::format(
      "task:{} at ({:.2f}, {:.2f}) km takes {} of range to sense, {} from there to charge: {}\n",
      story.task.value, story.spec.at.x_m / 1000, story.spec.at.y_m / 1000, Km(story.spec.cost_m),
      std::isfinite(story.to_charge_m) ? Km(story.to_charge_m) : "no way",
      story.done ? fmt::format("done at {} by uav:{} and worker:{}", ClockText(story.done->at_us),
                               story.done->uav_id, story.done->worker_id)
                 : std::string("not done"));
  text += TermsWords(story);
  text += "\n";
  Lines lines(&text);
  for (const auto& chapter : story.chapters) {
    const bool done = chapter.answer.verdict == TaskVerdict::kDone;
    if (chapter.missing.empty() && done && story.chapters.size() > 1) continue;
    lines.Begin(chapter.decision, chapter.at_us);
    if (!chapter.missing.empty()) {
      lines.Add("cannot be told, the log lacks " + chapter.missing);
    } else {
      if (!done) AddForce(chapter.scheduled, chapter.in_force, &lines);
      AddWithheld(chapter.withheld, &lines);
      AddDirectives(chapter, &lines);
      if (!chapter.directed) AddAnswer(chapter, story.terms, &lines);
    }
    lines.AddEvents(chapter.events);
  }
  if (story.chapters.size() > 1) text += "\n" + Summary(story);
  return text;
}

std::string ToText(const AgentStory& story) {
  std::string text =
      fmt::format("{} is online from {} to {}\n", AgentName(story.kind, story.id),
                  ClockText(story.spec.online_from_us), ClockText(story.spec.online_until_us));
  text += TermsWords(story);
  text += "\n";
  Lines lines(&text);
  for (const auto& chapter : story.chapters) {
    lines.Begin(chapter.decision, chapter.at_us);
    if (!chapter.missing.empty()) {
      lines.Add("cannot be told, the log lacks " + chapter.missing);
    } else {
      AddForce(chapter.scheduled, chapter.in_force, &lines);
      AddWithheld(chapter.withheld, &lines);
      AddDirectives(chapter, &lines);
      if (!chapter.directed) AddAnswer(chapter, story.kind, story.terms, &lines);
    }
    lines.AddEvents(chapter.events);
  }
  return text;
}

}  // namespace muster::tools
