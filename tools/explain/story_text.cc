#include <fmt/format.h>

#include <cmath>
#include <map>

#include "tools/explain/story.h"
#include "tools/explain/words.h"

namespace muster::tools {
namespace {

using scheduler::AgentAnswer;
using scheduler::AgentCondition;
using scheduler::Forcing;
using scheduler::Obstacle;
using scheduler::Option;
using scheduler::PairLook;
using scheduler::PlaceLook;
using scheduler::RangeNeed;
using scheduler::TaskAnswer;
using scheduler::TaskVerdict;

std::string Km(double metres) { return fmt::format("{:.2f} km", metres / 1000); }

std::string Until(TimeUs t) { return t == kNever ? "an unknown time" : ClockWords(t); }

std::string PartnerOf(const PairLook& pair, bool charging) {
  return AgentName(charging ? AgentKind::kVehicle : AgentKind::kWorker, pair.partner);
}

std::string PairWords(const PairLook& pair, bool charging) {
  return fmt::format("{} and {}", AgentName(AgentKind::kUav, pair.uav.value),
                     PartnerOf(pair, charging));
}

std::string Weighed(const Action& action) {
  return fmt::format("{} ({:.3f})", Words(action), action.weight);
}

std::string RangeWords(const RangeNeed& need, bool charging) {
  const std::string uav = AgentName(AgentKind::kUav, need.uav.value);
  if (charging) {
    return fmt::format("{} has {} of range and is {} away", uav, Km(need.range_m), Km(need.way_m));
  }
  return fmt::format("{} has {} of range and needs {}: {} to the task, {} to sense, {} to charge",
                     uav, Km(need.range_m), Km(need.needs_m()), Km(need.way_m), Km(need.cost_m),
                     Km(need.to_charge_m));
}

std::string LateWords(const PairLook& pair, bool charging) {
  if (pair.end_us == kNever) return PairWords(pair, charging) + " would never be done";
  const std::string done =
      fmt::format("{} would be done at {}", PairWords(pair, charging), ClockWords(pair.end_us));
  if (!pair.window_of) {
    return fmt::format("{}, the mission ends at {}", done, ClockWords(pair.latest_us));
  }
  return fmt::format("{}, but {} goes offline at {}", done,
                     *pair.window_of == AgentKind::kUav ? AgentName(AgentKind::kUav, pair.uav.value)
                                                        : PartnerOf(pair, charging),
                     ClockWords(pair.latest_us));
}

/// Why no pair is possible at a place, with the one that comes nearest.
std::string ObstacleWords(const PlaceLook& look) {
  const char* partner = look.charging ? "vehicle" : "worker";
  switch (look.obstacle) {
    case Obstacle::kNone:
      return "possible";
    case Obstacle::kNoUav:
      return fmt::format("no UAV is free ({} under way)", look.busy_uavs);
    case Obstacle::kNoPartner:
      return fmt::format("no {} is free ({} under way)", partner, look.busy_partners);
    case Obstacle::kNoPlace:
      return "the charging point is full";
    case Obstacle::kRange:
      return fmt::format("range (constraint {}): {}", look.charging ? 5 : 6,
                         look.nearest_range ? RangeWords(*look.nearest_range, look.charging) : "");
    case Obstacle::kWindow:
    case Obstacle::kLimit:
      return fmt::format("{}: {}",
                         look.obstacle == Obstacle::kWindow ? "online window" : "time limit",
                         look.nearest_time ? LateWords(*look.nearest_time, look.charging) : "");
  }
  return "";
}

std::string Plural(int n, const char* what) {
  return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
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

/// Collects a chapter's lines; the first has decision and time in front.
class Lines {
 public:
  explicit Lines(std::string* text) : text_(text) {}
  void Begin(std::int32_t decision, TimeUs at_us) {
    lead_ = fmt::format("decision {:>3}  {}  ", decision, ClockWords(at_us));
  }
  void Add(const std::string& line) {
    *text_ += lead_ + line + "\n";
    lead_ = std::string(23, ' ');
  }

 private:
  std::string* text_;
  std::string lead_;
};

template <class Answer>
void AddEvents(const Chapter<Answer>& chapter, Lines* lines) {
  for (const event_t& event : chapter.events) {
    std::string who;
    const auto add = [&who](const char* name, std::int32_t id) {
      if (id >= 0) who += fmt::format(" {}:{}", name, id);
    };
    add("uav", event.uav_id);
    add("worker", event.worker_id);
    add("vehicle", event.vehicle_id);
    add("task", event.task_id);
    add("charge", event.charge_id);
    lines->Add(fmt::format("* {} {}{}", ClockWords(event.at_us),
                           Spaced(ToString<EventKind>(event.kind)), who));
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

/// Why nobody was commanded at all.
template <class Answer>
void AddForce(const Chapter<Answer>& chapter, Lines* lines) {
  if (!chapter.in_force) {
    lines->Add("no decision was in force: the scheduler was lost");
  } else if (!chapter.scheduled) {
    lines->Add("the log holds no decision");
  }
}

template <class Answer>
void AddNotes(const std::vector<Chapter<Answer>>& chapters, std::string* text) {
  bool own = false;
  std::string policy;
  for (const auto& chapter : chapters) {
    if (!chapter.missing.empty() || !chapter.scheduled || !chapter.in_force ||
        !chapter.quality.own_weights)
      continue;
    own = true;
    policy = chapter.policy;
  }
  if (own) {
    *text += fmt::format(
        "Policy {} decides by weights of its own: those of what was commanded are as logged, all "
        "others are the paper's.\n",
        policy);
  }
}

void AddAnswer(const TaskAnswer& answer, double best, Lines* lines) {
  for (const Action& action : answer.commanded) {
    if (!IsPair(action.kind)) lines->Add("on its way ahead: " + Weighed(action));
  }
  switch (answer.verdict) {
    case TaskVerdict::kDone:
      break;
    case TaskVerdict::kUnderWay:
      if (!answer.activity) {
        lines->Add("under way");
      } else if (answer.activity->start_us == kNever) {
        lines->Add(fmt::format("under way: uav:{} and worker:{} are going there",
                               answer.activity->uav.value, answer.activity->partner));
      } else {
        lines->Add(fmt::format("under way: uav:{} and worker:{} sense it from {} to {}",
                               answer.activity->uav.value, answer.activity->partner,
                               ClockWords(answer.activity->start_us),
                               Until(answer.activity->end_us)));
      }
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
    const AgentState& state = *answer.state;
    Action action;
    action.kind = state.action;
    action.to = state.to;
    const auto set = [&](AgentKind of, std::int32_t id) {
      if (of == AgentKind::kUav) action.uav = UavId(id);
      if (of == AgentKind::kWorker) action.worker = WorkerId(id);
      if (of == AgentKind::kVehicle) action.vehicle = VehicleId(id);
    };
    set(kind, state.id);
    if (IsPair(state.action)) {
      const bool charging = state.action == ActionKind::kCharge;
      set(kind != AgentKind::kUav ? AgentKind::kUav
          : charging              ? AgentKind::kVehicle
                                  : AgentKind::kWorker,
          state.partner);
      (charging ? action.charge.value : action.task.value) = state.target;
    } else if (state.target >= 0) {
      const bool charging =
          state.action == ActionKind::kUavToCharge || state.action == ActionKind::kVehicleToCharge;
      (charging ? action.charge.value : action.task.value) = state.target;
    }
    lines->Add(fmt::format("busy until {}: {} (since decision {})", Until(state.busy_until_us),
                           Words(action), state.decision));
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
    const bool numbers = group.obstacle == Obstacle::kRange ||
                         group.obstacle == Obstacle::kWindow || group.obstacle == Obstacle::kLimit;
    lines->Add(fmt::format(
        "not {}: {}{}", Plural(group.places, group.charging ? "charging point" : "task"),
        numbers ? fmt::format("at {}:{}, which comes nearest, ", group.charging ? "charge" : "task",
                              group.nearest.site)
                : "",
        ObstacleWords(group.nearest)));
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
  AddNotes(story.chapters, &text);
  text += "\n";
  Lines lines(&text);
  for (const auto& chapter : story.chapters) {
    if (chapter.missing.empty() && chapter.answer.verdict == TaskVerdict::kDone) {
      if (story.chapters.size() > 1) continue;
    }
    lines.Begin(chapter.decision, chapter.at_us);
    if (!chapter.missing.empty()) {
      lines.Add("cannot be told, the log lacks " + chapter.missing);
    } else if (chapter.answer.verdict == TaskVerdict::kDone) {
      lines.Add("done");
    } else {
      AddForce(chapter, &lines);
      AddAnswer(chapter.answer, chapter.quality.best.weight, &lines);
      if (chapter.answer.verdict == TaskVerdict::kLost) AddQuality(chapter, &lines);
    }
    AddEvents(chapter, &lines);
  }
  if (story.chapters.size() > 1) text += "\n" + Summary(story);
  return text;
}

std::string ToText(const AgentStory& story) {
  std::string text =
      fmt::format("{} is online from {} to {}\n", AgentName(story.kind, story.id),
                  ClockWords(story.spec.online_from_us), ClockWords(story.spec.online_until_us));
  AddNotes(story.chapters, &text);
  text += "\n";
  Lines lines(&text);
  for (const auto& chapter : story.chapters) {
    lines.Begin(chapter.decision, chapter.at_us);
    if (!chapter.missing.empty()) {
      lines.Add("cannot be told, the log lacks " + chapter.missing);
    } else {
      AddForce(chapter, &lines);
      AddAnswer(chapter.answer, story.kind, chapter.quality.best.weight, &lines);
      if (!chapter.answer.options.empty()) AddQuality(chapter, &lines);
    }
    AddEvents(chapter, &lines);
  }
  return text;
}

}  // namespace muster::tools
