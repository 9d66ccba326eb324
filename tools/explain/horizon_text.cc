#include "tools/explain/horizon_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <vector>

#include "tools/explain/words.h"

namespace muster::tools {
namespace {

using scheduler::AgentCondition;
using scheduler::Fate;
using scheduler::FateKind;
using scheduler::HorizonForcing;
using scheduler::HorizonOption;
using scheduler::HorizonQuality;
using scheduler::HorizonVerdict;
using scheduler::Obstacle;
using scheduler::PairPlan;

/// "uav:3 (free at 0:50:00) and worker:7 for task:4 by 1:02:00 (0.331)"
std::string PlanWords(const PairPlan& pair) {
  return fmt::format("uav:{}{} and {}{} for {}:{} by {} ({:.3f})", pair.uav.value,
                     FreeWords(pair.uav_free_us), AgentName(pair.partner_kind(), pair.partner),
                     FreeWords(pair.partner_free_us), pair.charging ? "charge" : "task", pair.site,
                     ClockWords(pair.end_us), pair.worth);
}

std::string PlansWords(const std::vector<PairPlan>& pairs) {
  std::vector<std::string> words;
  for (const PairPlan& pair : pairs) words.push_back(PlanWords(pair));
  return fmt::format("{}", fmt::join(words, "; "));
}

std::string CostWords(const HorizonForcing& forcing, double of) {
  if (!forcing.exact) {
    return fmt::format("costs {:.3f} to {:.3f} of {:.3f} tasks (not proven)", forcing.cost_low,
                       forcing.cost_high, of);
  }
  if (forcing.cost == 0) return "costs nothing: another matching of the highest worth holds it";
  return fmt::format("costs {:.3f} of {:.3f} tasks", forcing.cost, of);
}

std::string ForceWords(const std::optional<HorizonForcing>& forcing,
                       const HorizonQuality& quality) {
  if (!forcing) return "no matching that holds it was found";
  std::string text = CostWords(*forcing, quality.worth) + "; " + PlanWords(forcing->pair);
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

/// Which way to weigh decided, where there is more than one.
template <class Answer>
void AddVariant(const HorizonChapter<Answer>& chapter, bool scheduled, Lines* lines) {
  if (scheduled && !chapter.again) {
    lines->Add(
        "not the decision that comes out when made again (a deadline, another build): reasons are "
        "those of the " +
        std::string(chapter.forecast ? "first variant" : "one that comes out"));
    return;
  }
  if (!chapter.forecast || !scheduled) return;
  lines->Add(fmt::format(
      "decided by variant {} of {}{}{}", chapter.variant + 1, chapter.variants,
      chapter.settings.empty() ? std::string() : fmt::format(" ({})", chapter.settings),
      chapter.draws.empty()
          ? std::string()
          : fmt::format(", worth varied by chance, draw{} {}", chapter.draws.size() == 1 ? "" : "s",
                        fmt::join(chapter.draws, " and "))));
}

std::string FateWords(const Fate& fate) {
  const std::string when =
      fate.decision < 0 ? std::string("no decision followed")
                        : fmt::format("at decision {}, {}", fate.decision, ClockWords(fate.at_us));
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
void AddFates(const HorizonChapter<Answer>& chapter, Lines* lines) {
  for (const auto& [pair, fate] : chapter.fates) {
    lines->Add(fmt::format("the plan for {}:{} {}", pair.charging ? "charge" : "task", pair.site,
                           FateWords(fate)));
  }
}

void AddOutbid(const scheduler::HorizonTaskAnswer& answer, Lines* lines) {
  const HorizonOption& option = answer.options.front();
  const char* verdict = answer.verdict == HorizonVerdict::kPlanned  ? "now outbid"
                        : answer.verdict == HorizonVerdict::kOutbid ? "outbid"
                                                                    : "worthless";
  lines->Add(fmt::format("{}: {} could sense it by {} ({:.3f}), the best of {}", verdict,
                         PairWords(option.pair, false), ClockWords(option.pair.end_us),
                         option.pair.weight, Plural(answer.look.pairs_feasible, "pair")));
  if (!option.rivals.empty()) lines->Add("by:   " + PlansWords(option.rivals));
  lines->Add("forcing it " + ForceWords(answer.forcing, answer.quality));
}

}  // namespace

void AddHorizon(const Chapter<scheduler::TaskAnswer>& chapter, Lines* lines) {
  const auto& answer = chapter.horizon->answer;
  const bool scheduled = chapter.scheduled && chapter.in_force;
  switch (answer.verdict) {
    case HorizonVerdict::kDone:
      lines->Add("done");
      return;
    case HorizonVerdict::kUnreported:
    case HorizonVerdict::kExpired:
      lines->Add(std::string(ToString(answer.verdict)));
      return;
    case HorizonVerdict::kUnderWay:
      lines->Add(UnderWayWords(answer.activity));
      return;
    case HorizonVerdict::kChosen:
      for (const Action& action : answer.commanded) {
        if (IsPair(action.kind)) {
          lines->Add(fmt::format("chosen: {} ({:.3f})", Words(action), action.weight));
        }
      }
      break;
    case HorizonVerdict::kPlanned:
      lines->Add(fmt::format("planned{}: {}", answer.plan->second ? " for after that" : "",
                             PlanWords(*answer.plan)));
      for (const Action& action : answer.commanded) lines->Add("now:  " + Words(action));
      AddFates(*chapter.horizon, lines);
      if (!answer.options.empty()) AddOutbid(answer, lines);
      break;
    case HorizonVerdict::kOutbid:
    case HorizonVerdict::kWorthless:
      AddOutbid(answer, lines);
      break;
    case HorizonVerdict::kImpossible:
      lines->Add("impossible, " + ObstacleWords(answer.look));
      return;
  }
  AddVariant(*chapter.horizon, scheduled, lines);
}

void AddHorizon(const Chapter<scheduler::AgentAnswer>& chapter, AgentKind kind, Lines* lines) {
  const auto& answer = chapter.horizon->answer;
  if (answer.condition == AgentCondition::kBusy) {
    lines->Add(BusyWords(kind, *answer.state) +
               (answer.free_us ? ", takes part as free at " + ClockWords(*answer.free_us) : ""));
  } else if (answer.condition == AgentCondition::kIdle) {
    lines->Add("idle: " + Words(*answer.did) +
               (IsPair(answer.did->kind) ? fmt::format(" ({:.3f})", answer.did->weight) : ""));
  } else {
    lines->Add(std::string(ToString(answer.condition)));
    return;
  }
  if (answer.condition == AgentCondition::kBusy && !answer.free_us) return;
  for (const PairPlan& pair : answer.plans) {
    lines->Add((pair.second ? "then planned: " : "matched: ") + PlanWords(pair));
  }
  AddFates(*chapter.horizon, lines);
  for (std::size_t i = 0; i < answer.options.size(); ++i) {
    const HorizonOption& option = answer.options[i];
    const scheduler::PairLook& other = option.pair;
    lines->Add(fmt::format(
        "could also, by {}, {} {}:{} with {} ({:.3f}){}", ClockWords(other.end_us),
        option.charging ? "charge at" : "sense", option.charging ? "charge" : "task", option.site,
        kind == AgentKind::kUav
            ? PartnerOf(other, option.charging) + FreeWords(other.partner_free_us)
            : AgentName(AgentKind::kUav, other.uav.value) + FreeWords(other.uav_free_us),
        other.weight,
        option.rivals.empty() ? std::string() : "; instead " + PlansWords(option.rivals)));
    lines->Add("  forcing that " + ForceWords(answer.forcings[i], answer.quality));
  }
  bool matched = false;
  for (const PairPlan& pair : answer.plans) matched = matched || !pair.second;
  const int more = answer.places_feasible - static_cast<int>(answer.options.size()) - matched;
  if (more > 0) lines->Add(fmt::format("and {} of less worth", Plural(more, "other place")));
  for (const auto& group : answer.blocked) {
    lines->Add(BlockedWords(group.places, group.nearest));
  }
  AddVariant(*chapter.horizon, chapter.scheduled && chapter.in_force, lines);
}

std::string HorizonSummary(const TaskStory& story) {
  std::map<HorizonVerdict, int> verdicts;
  std::map<Obstacle, int> obstacles;
  const Chapter<scheduler::TaskAnswer>* cheapest = nullptr;
  for (const auto& chapter : story.chapters) {
    if (!chapter.horizon) continue;
    const auto& answer = chapter.horizon->answer;
    ++verdicts[answer.verdict];
    if (answer.verdict == HorizonVerdict::kImpossible) ++obstacles[answer.look.obstacle];
    if (!answer.forcing) continue;
    if (cheapest == nullptr || answer.forcing->cost < cheapest->horizon->answer.forcing->cost) {
      cheapest = &chapter;
    }
  }
  std::vector<std::string> parts;
  for (const auto& [verdict, n] : verdicts) {
    std::string part = fmt::format("{} in {}", ToString(verdict), n);
    if (verdict == HorizonVerdict::kImpossible) {
      std::vector<std::string> why;
      for (const auto& [obstacle, times] : obstacles) {
        why.push_back(fmt::format("{} {}",
                                  obstacle == Obstacle::kNoUav       ? "no uav soon"
                                  : obstacle == Obstacle::kNoPartner ? "no worker soon"
                                                                     : ToString(obstacle),
                                  times));
      }
      part += fmt::format(" ({})", fmt::join(why, ", "));
    }
    parts.push_back(part);
  }
  std::string text =
      fmt::format("Of {} decisions: {}.\n", story.chapters.size(), fmt::join(parts, ", "));
  if (cheapest != nullptr) {
    const auto& answer = cheapest->horizon->answer;
    text += fmt::format("Forcing it would have been cheapest at decision {}: it {}.\n",
                        cheapest->decision, CostWords(*answer.forcing, answer.quality.worth));
  }
  return text;
}

}  // namespace muster::tools
