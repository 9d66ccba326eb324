#include "scheduler/policies/baselines/kwta.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "base/index.h"
#include "model/feasibility.h"
#include "scheduler/solver/candidates.h"
#include "scheduler/weights.h"

namespace muster::scheduler {
namespace {

constexpr double kChargeBelowShare = 0.5;  // where E_tL = E_chL

/// An open task or a charging point.
struct Place {
  TaskId task;
  ChargeId charge;
  Point at;
  std::int32_t free;  ///< how many pairs it takes
};

/// A way to a place. An agent's likelihood is the same for all places, so the way decides its
/// score: places are ranked by `<`.
struct Leg {
  std::int64_t intervals = 0;
  double way_m = 0;
  int place = 0;  ///< index
  auto operator<=>(const Leg&) const = default;
};

/// A UAV that looks for a place, and where it may go, best first.
struct Seeker {
  const AgentState* uav = nullptr;
  double best_score = 0;
  std::vector<Leg> legs;
};

class WinnersTakeAll {
 public:
  WinnersTakeAll(const Situation& situation, int winners)
      : situation_(situation), winners_(winners), weights_(situation) {
    const Site& site = *situation.site;
    for (std::size_t x = 0; x < site.tasks.size(); ++x) {
      if (situation.task_status[x] != TaskStatus::kOpen) continue;
      tasks_.push_back({TaskId(x), {}, site.tasks[x].at, 1});
    }
    for (std::size_t y = 0; y < site.charging_points.size(); ++y) {
      const ChargeId charge(y);
      charges_.push_back({{}, charge, site.charging_points[y].at, situation.free_places(charge)});
    }
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentState& agent : situation.agents(kind)) {
        if (agent.idle(situation.now_us)) idle_[kind].push_back(&agent);
      }
    }
  }

  Decision Decide() {
    std::vector<Seeker> for_tasks, for_charging;
    std::int64_t candidates = 0;
    for (const AgentState* uav : idle_.uavs) {
      const double share = situation_.range_m(*uav) / uav->range_full_m;
      Seeker seeker{uav, 0, LegsTo(tasks_, *uav, false)};
      const bool charging = share < kChargeBelowShare || seeker.legs.empty();
      if (charging) seeker.legs = LegsTo(charges_, *uav, true);
      if (seeker.legs.empty()) continue;
      seeker.best_score = (charging ? ChargeLikelihood(share) : TaskLikelihood(share)) /
                          static_cast<double>(seeker.legs.front().intervals);
      candidates += static_cast<std::int64_t>(seeker.legs.size() *
                                              (charging ? idle_.vehicles : idle_.workers).size());
      (charging ? for_charging : for_tasks).push_back(std::move(seeker));
    }
    TakeAll(std::move(for_tasks), false);
    TakeAll(std::move(for_charging), true);
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentState* agent : idle_[kind]) Add(MakeStay(*situation_.site, *agent));
    }
    return MakeDecision(std::move(actions_), candidates);
  }

 private:
  std::vector<Leg> LegsTo(const std::vector<Place>& places, const AgentState& agent) const {
    const Rules& rules = situation_.site->rules;
    const TimeUs unit_us = rules.ceil_to_minutes ? kMinuteUs : rules.interval_us;
    std::vector<Leg> legs;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const TaskId task = places[i].task;
      if (task.valid() && situation_.site->Forbids(agent, task.value)) continue;
      const double way_m = agent.WayM(agent.to, places[i].at);
      legs.push_back(
          {Intervals(TravelUs(way_m, agent.speed_m_s), unit_us), way_m, static_cast<int>(i)});
    }
    return legs;
  }

  /// Those that the UAV's range allows, best first.
  std::vector<Leg> LegsTo(const std::vector<Place>& places, const AgentState& uav,
                          bool charging) const {
    const double range_m = situation_.range_m(uav);
    std::vector<Leg> legs = LegsTo(places, uav);
    std::erase_if(legs, [&](const Leg& leg) {
      if (charging) return !CanReachCharge(range_m, leg.way_m);
      const std::size_t task = places[At(leg.place)].task.index();
      return !CanSense(range_m, leg.way_m, situation_.site->tasks[task].cost_m,
                       situation_.site->task_to_charge_m[task]);
    });
    std::sort(legs.begin(), legs.end());
    return legs;
  }

  /// One round: the UAV with the best score chooses first.
  void TakeAll(std::vector<Seeker> seekers, bool charging) {
    std::vector<Place>& places = charging ? charges_ : tasks_;
    auto partners = charging ? idle_.vehicles : idle_.workers;
    const std::vector<std::vector<Ranked>> ranked = RankingsOf(partners, places);
    std::sort(seekers.begin(), seekers.end(), [](const Seeker& a, const Seeker& b) {
      return std::tuple(-a.best_score, a.legs.front().way_m, a.uav->id) <
             std::tuple(-b.best_score, b.legs.front().way_m, b.uav->id);
    });
    for (const Seeker& seeker : seekers) {
      for (int r = 0; r < static_cast<int>(seeker.legs.size()); ++r) {
        const auto at = At(seeker.legs[At(r)].place);
        if (places[at].free == 0) continue;
        const int width = std::max(winners_, r + 1);
        std::optional<Action> best;
        std::size_t with = 0;
        for (std::size_t p = 0; p < partners.size(); ++p) {
          if (partners[p] == nullptr || ranked[p][at].rank >= width) continue;
          if (best && !(ranked[p][at].leg < ranked[with][at].leg)) continue;
          const Action pair = PairOf(*seeker.uav, *partners[p], places[at]);
          if (!weights_.Of(pair)) continue;
          best = pair;
          with = p;
        }
        if (!best) continue;
        Add(*best);
        std::erase(idle_.uavs, seeker.uav);
        std::erase(charging ? idle_.vehicles : idle_.workers, partners[with]);
        partners[with] = nullptr;
        --places[at].free;
        break;
      }
    }
  }

  /// A place as a partner sees it.
  struct Ranked {
    Leg leg;
    int rank = 0;
  };
  /// [n_partners][n_places]
  std::vector<std::vector<Ranked>> RankingsOf(const std::vector<const AgentState*>& partners,
                                              const std::vector<Place>& places) const {
    std::vector<std::vector<Ranked>> ranked;
    for (const AgentState* partner : partners) {
      std::vector<Leg> legs = LegsTo(places, *partner);
      std::sort(legs.begin(), legs.end());
      auto& of_partner = ranked.emplace_back(places.size());
      for (std::size_t r = 0; r < legs.size(); ++r) {
        of_partner[At(legs[r].place)] = {legs[r], static_cast<int>(r)};
      }
    }
    return ranked;
  }

  Action PairOf(const AgentState& uav, const AgentState& partner, const Place& place) const {
    return MakeAction(*situation_.site, &uav, &partner, place.task, place.charge);
  }

  void Add(Action action) {
    action.weight = weights_.Of(action).value_or(0);
    actions_.push_back(action);
  }

  const Situation& situation_;
  int winners_;
  ActionWeights weights_;
  std::vector<Place> tasks_, charges_;
  PerKind<std::vector<const AgentState*>> idle_;  ///< in no pair so far
  std::vector<Action> actions_;
};

}  // namespace

Decision KwtaPolicy::Decide(const Situation& situation) {
  return WinnersTakeAll(situation, winners_).Decide();
}

}  // namespace muster::scheduler
