// How `rollout` decided. Deciding again would tell, but it takes as long as the decision did, and a
// decision with a deadline would come out differently. So only a search for whole plans is made
// again. Else the commanded pairs carry what they were
// worth, and each variant and draw weighs differently: those that decided are found by that.
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/index.h"
#include "scheduler/policies/horizon/pairs.h"
#include "scheduler/policies/rollout/rollout.h"

namespace muster::scheduler {
namespace {

constexpr double kRounding = 1e-9;  ///< of a pair's worth that is put together in another order
constexpr std::size_t kMostPairs = 4;
/// A longer search is not made again: it may have been meant for a deadline, and never have ended.
constexpr std::int64_t kMostEffortAgain = 20;

/// What the pair is worth to a matching with these settings; NaN: the matching cannot make it.
double WorthOf(const Situation& situation, const HorizonSettings& settings, const Action& pair) {
  Participants few = ParticipantsOf(situation, settings);
  // A worth depends on its pair, on the open tasks, and on the speed of the fastest UAV.
  const auto fastest = std::max_element(
      few.uavs.begin(), few.uavs.end(),
      [](const auto& a, const auto& b) { return a.agent->speed_m_s < b.agent->speed_m_s; });
  const std::int32_t fastest_id = fastest == few.uavs.end() ? -1 : fastest->agent->id;
  std::erase_if(few.uavs, [&](const Participant& p) {
    return p.agent->id != pair.uav.value && p.agent->id != fastest_id;
  });
  std::erase_if(few.workers,
                [&](const Participant& p) { return p.agent->id != pair.worker.value; });
  few.vehicles.clear();
  const PossiblePairs pairs = FindPairs(situation, few, OpenSitesOf(situation), settings);
  const Instance& instance = pairs.instance;
  for (std::int32_t site = 0; site < pairs.n_tasks; ++site) {
    if (pairs.site_ids[At(site)] != pair.task.value) continue;
    const std::int32_t w = instance.partner_begin[At(site)];
    if (w == instance.partner_begin[At(site) + 1]) break;
    for (auto u = instance.uav_begin[At(site)]; u < instance.uav_begin[At(site) + 1]; ++u) {
      const Instance::UavArc& arc = instance.uav_arcs[At(u)];
      if (few.uavs[At(arc.uav)].agent->id != pair.uav.value) continue;
      return Instance::PairWeight(arc, instance.partner_arcs[At(w)]);
    }
  }
  return std::nan("");
}

/// Tells at small cost which settings cannot have led to the commanded actions. It looks at a few
/// pairs, as one of them may be of the second matching, which weighs another situation.
class Sieve {
 public:
  Sieve(const Situation& situation, const std::vector<Action>& commanded,
        const std::vector<HorizonSettings>& variants)
      : situation_(situation) {
    for (const Action& action : commanded) {
      if (action.kind == ActionKind::kSense && pairs_.size() < kMostPairs) pairs_.push_back(action);
    }
    for (const HorizonSettings& variant : variants) {
      auto& of_pairs = worth_.emplace_back();
      for (const Action& pair : pairs_) of_pairs.push_back(WorthOf(situation, variant, pair));
    }
  }

  /// Whether one pair has the worth that the variant, varied by the settings' draws, gives it.
  bool Passes(std::size_t variant, const HorizonSettings& settings) const {
    if (pairs_.empty()) return true;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const auto chance = [&](AgentKind kind, std::int32_t id) {
        return JitterOf(situation_, settings, kind, id, pairs_[k].task.value);
      };
      const double worth = worth_[variant][k] + chance(AgentKind::kUav, pairs_[k].uav.value) +
                           chance(AgentKind::kWorker, pairs_[k].worker.value);
      if (std::abs(worth - pairs_[k].weight) < kRounding) return true;
    }
    return false;
  }

 private:
  const Situation& situation_;
  std::vector<Action> pairs_;
  std::vector<std::vector<double>> worth_;  ///< [variant][pair], without chance
};

/// The draws that a decision may rest on: one, or one and another of a later round around it.
std::vector<std::vector<std::uint32_t>> DrawsOf(const RolloutSettings& rollout) {
  const auto a_round = static_cast<std::uint32_t>(rollout.draws / rollout.rounds);
  const auto n = a_round * static_cast<std::uint32_t>(rollout.rounds);
  std::vector<std::vector<std::uint32_t>> ways;
  for (std::uint32_t draw = 0; draw < n; ++draw) ways.push_back({draw});
  for (std::uint32_t draw = 0; draw < n; ++draw) {
    for (std::uint32_t later = (draw / a_round + 1) * a_round; later < n; ++later) {
      ways.push_back({draw, later});
    }
  }
  return ways;
}

}  // namespace

Deciding RolloutPolicy::Explain(const Situation& situation,
                                const std::vector<Action>& commanded) const {
  if (settings_.effort > 1 && settings_.effort <= kMostEffortAgain) {
    RolloutSettings unhurried = settings_;
    unhurried.deadline.reset();
    const RolloutPlan plan = RolloutPolicy(unhurried).Plan(situation, FuturesOf(situation));
    if (plan.settings.task_draws) {
      Deciding deciding = HorizonPolicy(plan.settings).Explain(situation, commanded);
      const std::vector<std::uint32_t>& drawn = plan.settings.task_draws->of;
      deciding.how.follow = plan.follow;
      deciding.how.variant = plan.variant;
      deciding.how.variants = static_cast<std::int32_t>(settings_.variants.size());
      deciding.how.tasks_drawn =
          drawn.size() - static_cast<std::size_t>(std::count(drawn.begin(), drawn.end(), 0u));
      if (deciding.how.again) return deciding;
    }
  }
  const Sieve sieve(situation, commanded, settings_.variants);
  const auto with = [&](std::size_t variant, const std::vector<std::uint32_t>& draws, bool sieved) {
    HorizonSettings settings = settings_.variants[variant];
    for (const std::uint32_t draw : draws) AddDraw(draw, &settings);
    if (sieved && !sieve.Passes(variant, settings)) return Deciding();
    Deciding deciding = HorizonPolicy(settings).Explain(situation, commanded);
    deciding.how.follow = settings_.variants[variant];
    deciding.how.variant = static_cast<std::int32_t>(variant);
    deciding.how.variants = static_cast<std::int32_t>(settings_.variants.size());
    deciding.how.draws = draws;
    return deciding;
  };
  for (const auto& ways : {std::vector<std::vector<std::uint32_t>>(1), DrawsOf(settings_)}) {
    for (std::size_t i = 0; i < settings_.variants.size(); ++i) {
      for (const std::vector<std::uint32_t>& draws : ways) {
        Deciding deciding = with(i, draws, true);
        if (deciding.how.again) return deciding;
      }
    }
  }
  return with(0, {}, false);
}

}  // namespace muster::scheduler
