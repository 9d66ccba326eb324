#include "scheduler/explain/horizon_facts.h"

#include <algorithm>
#include <utility>

#include "base/index.h"
#include "scheduler/explain/forced.h"

namespace muster::scheduler {
namespace {

constexpr double kSameWorth = 1e-6;  ///< tasks; matchings closer than this are worth the same

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

bool IsAt(const PairPlan& pair, bool charging, std::int32_t site) {
  return pair.charging == charging && pair.site == site;
}

bool SamePair(const Match& a, const Match& b) {
  return a.charging == b.charging && a.site == b.site && a.uav == b.uav && a.partner == b.partner;
}
bool Share(const Match& a, const Match& b) {
  return a.uav == b.uav ||
         (a.charging == b.charging && (a.site == b.site || a.partner == b.partner));
}
bool Holds(const std::vector<Match>& matches, const Match& pair) {
  return std::any_of(matches.begin(), matches.end(),
                     [&](const Match& other) { return SamePair(pair, other); });
}
double WorthOf(const std::vector<Match>& matches) {
  double worth = 0;
  for (const Match& match : matches) worth += match.weight;
  return worth;
}

/// `best` with `pair` of `forced`, and with what that takes in turn: pairs of `forced` that share
/// an agent or a place with a pair that has to go, and so on. What else differs between two
/// matchings of the highest worth is chance, and worth nothing.
std::vector<Match> OnlyWhatFollows(const std::vector<Match>& best, const std::vector<Match>& forced,
                                   const Match& pair) {
  std::vector<Match> leaving, coming;  // may still change
  for (const Match& match : best) {
    if (!Holds(forced, match)) leaving.push_back(match);
  }
  for (const Match& match : forced) {
    if (!Holds(best, match)) coming.push_back(match);
  }
  std::vector<Match> gone, come, next = {pair};
  const auto take = [&next](std::vector<Match>* from, std::vector<Match>* to, const Match& by) {
    for (auto it = from->begin(); it != from->end();) {
      if (!Share(*it, by)) {
        ++it;
        continue;
      }
      to->push_back(*it);
      next.push_back(*it);
      it = from->erase(it);
    }
  };
  while (!next.empty()) {
    const Match by = next.back();
    next.pop_back();
    take(&leaving, &gone, by);
    take(&coming, &come, by);
  }
  std::vector<Match> result = come;
  for (const Match& match : best) {
    if (!Holds(gone, match)) result.push_back(match);
  }
  std::sort(result.begin(), result.end(),
            [](const Match& a, const Match& b) { return a.uav < b.uav; });
  return result;
}

}  // namespace

std::string_view ToString(HorizonVerdict verdict) {
  constexpr std::string_view kNames[] = {"done",       "under way",  "chosen",
                                         "planned",    "outbid",     "worthless",
                                         "impossible", "unreported", "expired"};
  return kNames[static_cast<int>(verdict)];
}

HorizonDecision::HorizonDecision(Situation of, std::vector<Action> actions, const Policy& policy)
    : situation(std::move(of)),
      commanded(std::move(actions)),
      deciding(HowDecided(situation, commanded, policy)) {}

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

HorizonExplainer::HorizonExplainer(const HorizonDecision& decision)
    : decision_(decision),
      look_(decision.situation, decision.deciding.settings),
      plans_(PairsOf(decision.situation, decision.deciding.plan)) {}

const SolverResult& HorizonExplainer::Best() const {
  if (!best_) best_ = Solve(look_.pairs().instance);
  return *best_;
}

std::size_t HorizonExplainer::Forecast(const std::vector<Action>& actions) const {
  const auto& status = situation().task_status;
  return static_cast<std::size_t>(std::count(status.begin(), status.end(), TaskStatus::kDone)) +
         ForecastDone(situation(), actions, *decision_.deciding.follow);
}

HorizonQuality HorizonExplainer::Quality() const {
  const double worth = Best().assignment.weight;
  if (decision_.deciding.follow && !forecast_done_) forecast_done_ = Forecast(decision_.commanded);
  return {worth, std::max(Best().bound, worth), forecast_done_};
}

HorizonOption HorizonExplainer::MakeOption(const PlaceLook& look, const PairLook& pair) const {
  HorizonOption option{pair, look.charging, look.site, {}};
  for (const PairPlan& other : plans_) {
    if (other.second) continue;
    const bool same_place = !look.charging && IsAt(other, false, look.site);
    const bool holds =
        other.uav == pair.uav ||
        other.has(look.charging ? AgentKind::kVehicle : AgentKind::kWorker, pair.partner);
    if (same_place || holds) option.rivals.push_back(other);
  }
  return option;
}

std::optional<HorizonForcing> HorizonExplainer::Force(bool charging, std::int32_t site,
                                                      std::optional<AgentKind> kind,
                                                      std::int32_t agent) const {
  const PossiblePairs& pairs = look_.pairs();
  PairDemand demand;
  demand.site = look_.SiteOf(charging, site);
  if (kind) {
    const std::int32_t index = look_.IndexOf(*kind, agent);
    if (*kind == AgentKind::kUav) {
      demand.uav = index;
    } else {
      demand.partner = index + (*kind == AgentKind::kVehicle ? pairs.n_workers : 0);
    }
  }
  const auto forced = SolveWith(pairs.instance, demand);
  if (!forced) return {};
  const double best = Best().assignment.weight, bound = std::max(Best().bound, best);
  HorizonForcing forcing;
  forcing.cost = std::max(0.0, best - forced->weight);
  forcing.cost_low = std::max(0.0, best - forced->bound);
  forcing.cost_high = std::max(0.0, bound - forced->weight);
  forcing.exact = bound - best <= kSameWorth && forced->bound - forced->weight <= kSameWorth;
  if (forcing.exact && forcing.cost < kSameWorth) forcing.cost = 0;
  std::vector<Match> matches = MatchesOf(pairs, look_.participants(), forced->assignment);
  for (const Match& match : matches) {
    const PairPlan pair = PlanOf(situation(), look_.participants(), match, false);
    if (!IsAt(pair, charging, site) || (kind && !pair.has(*kind, agent))) continue;
    forcing.pair = pair;
    std::vector<Match> closer = OnlyWhatFollows(decision_.deciding.plan.first, matches, match);
    if (WorthOf(closer) >= forced->weight - kSameWorth) matches = std::move(closer);
    break;
  }
  for (const PairPlan& pair : plans_) {
    if (pair.second || pair.charging) continue;
    const bool kept = std::any_of(matches.begin(), matches.end(), [&](const Match& match) {
      return !match.charging && match.site == pair.site;
    });
    if (!kept) forcing.displaced.push_back(TaskId(pair.site));
  }
  std::sort(forcing.displaced.begin(), forcing.displaced.end());
  if (decision_.deciding.follow) {
    forcing.forecast_done =
        Forecast(PlanHorizon(situation(), decision_.deciding.settings, &matches).decision.actions);
  }
  return forcing;
}

HorizonTaskAnswer HorizonExplainer::AboutTask(TaskId task) const {
  HorizonTaskAnswer answer;
  const TaskStatus status = situation().task_status[task.index()];
  if (!IsToDo(status) && status != TaskStatus::kDone) {
    answer.verdict =
        status == TaskStatus::kExpired ? HorizonVerdict::kExpired : HorizonVerdict::kUnreported;
    return answer;
  }
  if (status != TaskStatus::kOpen) {
    const bool done = status == TaskStatus::kDone;
    answer.verdict = done ? HorizonVerdict::kDone : HorizonVerdict::kUnderWay;
    if (!done) answer.activity = UnderWayAt(situation(), task);
    return answer;
  }
  answer.look = look_.AtTask(task);
  for (const Action& action : decision_.commanded) {
    if (action.task == task) answer.commanded.push_back(action);
  }
  if (std::any_of(answer.commanded.begin(), answer.commanded.end(),
                  [](const Action& action) { return IsPair(action.kind); })) {
    answer.verdict = HorizonVerdict::kChosen;
    return answer;
  }
  const auto plan = std::find_if(plans_.begin(), plans_.end(), [task](const PairPlan& pair) {
    return IsAt(pair, false, task.value);
  });
  if (plan != plans_.end()) {
    answer.verdict = HorizonVerdict::kPlanned;
    answer.plan = *plan;
    answer.commanded.clear();
    for (const Action& action : decision_.commanded) {
      if (action.uav == plan->uav || MemberOf(action, AgentKind::kWorker) == plan->partner) {
        answer.commanded.push_back(action);
      }
    }
    if (!plan->second) return answer;
  }
  if (answer.look.obstacle != Obstacle::kNone) return answer;
  if (!answer.plan) {
    answer.verdict =
        answer.look.best.front().weight > 0 ? HorizonVerdict::kOutbid : HorizonVerdict::kWorthless;
  }
  for (const PairLook& pair : answer.look.best) {
    answer.options.push_back(MakeOption(answer.look, pair));
  }
  answer.forcing = Force(false, task.value, {}, -1);
  answer.quality = Quality();
  return answer;
}

HorizonAgentAnswer HorizonExplainer::AboutAgent(AgentKind kind, std::int32_t id,
                                                const AgentSpec& spec) const {
  HorizonAgentAnswer answer;
  answer.condition = ConditionOf(situation(), kind, id, spec, &answer.state);
  const std::int32_t index = look_.IndexOf(kind, id);
  if (answer.condition == AgentCondition::kIdle) {
    answer.did = CommandTo(situation(), decision_.commanded, kind, id);
  } else if (index >= 0) {
    answer.free_us = look_.participants()[kind][At(index)].ready_us;
  }
  if (index < 0) return answer;
  for (const PairPlan& pair : plans_) {
    if (pair.has(kind, id)) answer.plans.push_back(pair);
  }
  const std::vector<PlaceLook> places = PlacesOf(look_, situation(), kind, id);
  std::vector<const PlaceLook*> others;
  for (const PlaceLook& place : places) {
    if (place.obstacle != Obstacle::kNone) continue;
    ++answer.places_feasible;
    const bool matched =
        std::any_of(answer.plans.begin(), answer.plans.end(), [&](const PairPlan& pair) {
          return !pair.second && IsAt(pair, place.charging, place.site);
        });
    if (!matched) others.push_back(&place);
  }
  answer.blocked = BlockedOf(places);
  std::stable_sort(others.begin(), others.end(), [](const PlaceLook* a, const PlaceLook* b) {
    return a->best.front().weight > b->best.front().weight;
  });
  if (others.size() > AgentAnswer::kOptions) others.resize(AgentAnswer::kOptions);
  for (const PlaceLook* place : others) {
    answer.options.push_back(MakeOption(*place, place->best.front()));
    answer.forcings.push_back(Force(place->charging, place->site, kind, id));
  }
  if (!answer.options.empty()) answer.quality = Quality();
  return answer;
}

}  // namespace muster::scheduler
