#include <algorithm>
#include <utility>

#include "scheduler/explain/explain.h"
#include "scheduler/explain/forced.h"
#include "scheduler/solver/solver.h"

namespace muster::scheduler {
namespace {

constexpr double kSameWorth = 1e-6;  ///< tasks; matchings closer than this are worth the same

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

/// Worth in tasks, and horizon's first matching. Pairs, worth and matchings are the policy's.
class ByHorizon : public Score {
 public:
  explicit ByHorizon(const HorizonDecision& decision)
      : decision_(decision),
        look_(decision.situation, decision.deciding.how.settings),
        plans_(PairsOf(decision.situation, decision.deciding.plan)) {}

  Terms terms() const override { return Terms::kHorizon; }
  const Look& look() const override { return look_; }
  const std::vector<Action>& commanded() const override { return decision_.commanded; }
  std::vector<PairPlan> plans() const override { return plans_; }

  void Oppose(Option* option) const override {
    const AgentKind kind = option->charging ? AgentKind::kVehicle : AgentKind::kWorker;
    for (const PairPlan& other : plans_) {
      if (other.second) continue;
      const bool same_place = !option->charging && other.at(false, option->site);
      const bool holds = other.uav == option->pair.uav || other.has(kind, option->pair.partner);
      if (same_place || holds) option->rivals.push_back(other);
    }
  }

  std::optional<Forcing> Force(const Demand& demand) const override {
    const auto forced = SolveWith(look_.pairs().instance, InInstance(demand));
    if (!forced) return {};
    Forcing forcing = ForcingOf(Best(), {forced->weight, forced->bound, {}});
    std::vector<Match> matches = MatchesOf(look_.pairs(), look_.participants(), forced->assignment);
    const bool charging = demand.charge.valid();
    const std::int32_t site = charging ? demand.charge.value : demand.task.value;
    for (const Match& match : matches) {
      const PairPlan pair = PlanOf(situation(), look_.participants(), match, false);
      if (!pair.at(charging, site)) continue;
      if (demand.agent_kind && !pair.has(*demand.agent_kind, demand.agent)) continue;
      forcing.plan = pair;
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
    if (how().follow) {
      forcing.forecast_done =
          Forecast(PlanHorizon(situation(), how().settings, &matches).decision.actions);
    }
    return forcing;
  }

  DecisionQuality Quality() const override {
    DecisionQuality quality;
    quality.best = Best();
    if (how().follow && !forecast_done_) forecast_done_ = Forecast(decision_.commanded);
    quality.forecast_done = forecast_done_;
    return quality;
  }

 private:
  const Situation& situation() const { return decision_.situation; }
  const HowDecided& how() const { return decision_.deciding.how; }

  const Optimum& Best() const {
    if (!best_) {
      const SolverResult solved = Solve(look_.pairs().instance);
      const double worth = solved.assignment.weight;
      best_ = {worth, std::max(solved.bound, worth), {}};
    }
    return *best_;
  }

  PairDemand InInstance(const Demand& demand) const {
    const bool charging = demand.charge.valid();
    PairDemand pair;
    pair.site = look_.SiteOf(charging, charging ? demand.charge.value : demand.task.value);
    if (!demand.agent_kind) return pair;
    const std::int32_t index = look_.IndexOf(*demand.agent_kind, demand.agent);
    if (*demand.agent_kind == AgentKind::kUav) {
      pair.uav = index;
    } else {
      pair.partner =
          index + (*demand.agent_kind == AgentKind::kVehicle ? look_.pairs().n_workers : 0);
    }
    return pair;
  }

  std::size_t Forecast(const std::vector<Action>& actions) const {
    const auto& status = situation().task_status;
    return static_cast<std::size_t>(std::count(status.begin(), status.end(), TaskStatus::kDone)) +
           ForecastDone(situation(), actions, *how().follow);
  }

  const HorizonDecision& decision_;
  HorizonLook look_;
  std::vector<PairPlan> plans_;
  mutable std::optional<Optimum> best_;
  mutable std::optional<std::size_t> forecast_done_;
};

}  // namespace

std::unique_ptr<Score> HorizonScore(const HorizonDecision& decision) {
  return std::make_unique<ByHorizon>(decision);
}

}  // namespace muster::scheduler
