#include "scheduler/policies/baselines/kwta.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "base/index.h"
#include "scheduler/candidates.h"
#include "scheduler/weights.h"

namespace muster::scheduler {
namespace {

constexpr double kChargeBelowShare = 0.5;  // where E_tL = E_chL

/// Sites in the order of an agent's score: its likelihood is the same for all, so by the way.
std::vector<int> Ranking(const Legs& legs, int row, std::vector<int> sites) {
  std::sort(sites.begin(), sites.end(), [&](int a, int b) {
    return std::tuple(legs.intervals(row, a), legs.way_m(row, a), a) <
           std::tuple(legs.intervals(row, b), legs.way_m(row, b), b);
  });
  return sites;
}

/// A UAV that looks for a site, and where it may go, best first.
struct Seeker {
  int uav = 0;
  double best_score = 0;
  double best_way_m = 0;
  std::vector<int> sites;
};

struct Taken {
  int uav, site, partner;
};

/// One round of winners-take-all. `places` [n_sites] is how many pairs each site takes,
/// `allowed(uav, site, partner)` whether the pair may be formed.
template <class Allowed>
std::vector<Taken> TakeAll(std::vector<Seeker> seekers, const Legs& partner_legs, int winners,
                           std::vector<std::int32_t> places, const Allowed& allowed) {
  const int n_partners = static_cast<int>(partner_legs.intervals.rows());
  const int n_sites = static_cast<int>(partner_legs.intervals.cols());
  std::vector<int> all(At(n_sites));
  std::iota(all.begin(), all.end(), 0);
  Table<int> rank(n_partners, n_sites);
  for (int partner = 0; partner < n_partners; ++partner) {
    const std::vector<int> ranking = Ranking(partner_legs, partner, all);
    for (int r = 0; r < n_sites; ++r) rank(partner, ranking[At(r)]) = r;
  }
  std::sort(seekers.begin(), seekers.end(), [](const Seeker& a, const Seeker& b) {
    return std::tuple(-a.best_score, a.best_way_m, a.uav) <
           std::tuple(-b.best_score, b.best_way_m, b.uav);
  });
  std::vector<char> taken(At(n_partners), 0);
  std::vector<Taken> matches;
  for (const Seeker& seeker : seekers) {
    for (int r = 0; r < static_cast<int>(seeker.sites.size()); ++r) {
      const int site = seeker.sites[At(r)];
      if (places[At(site)] == 0) continue;
      const int width = std::max(winners, r + 1);
      int best = -1;
      for (int partner = 0; partner < n_partners; ++partner) {
        if (taken[At(partner)] || rank(partner, site) >= width ||
            !allowed(seeker.uav, site, partner)) {
          continue;
        }
        const auto key = [&](int p) {
          return std::tuple(partner_legs.intervals(p, site), partner_legs.way_m(p, site));
        };
        if (best < 0 || key(partner) < key(best)) best = partner;
      }
      if (best < 0) continue;
      matches.push_back({seeker.uav, site, best});
      taken[At(best)] = 1;
      --places[At(site)];
      break;
    }
  }
  return matches;
}

}  // namespace

Decision KwtaPolicy::Decide(const Situation& situation) {
  const Weights weights = ComputeWeights(situation);
  const Feasibility feasible(situation, weights);
  const int n_tasks = weights.n_tasks();
  const int n_charges = weights.n_charging_points();

  std::vector<Seeker> for_tasks, for_charging;
  std::int64_t candidates = 0;
  for (int u = 0; u < weights.n_uavs(); ++u) {
    const AgentState& uav = situation.uavs[At(weights.uavs[At(u)])];
    const double share = weights.range_m(u) / uav.range_full_m;
    std::vector<int> tasks, charges;
    for (int x = 0; x < n_tasks; ++x) {
      if (weights.senseable(u, x)) tasks.push_back(x);
    }
    for (int y = 0; y < n_charges; ++y) {
      if (weights.chargeable(u, y)) charges.push_back(y);
    }
    const bool charging = share < kChargeBelowShare || tasks.empty();
    const Legs& legs = charging ? weights.uav_charge : weights.uav_task;
    Seeker seeker;
    seeker.uav = u;
    seeker.sites = Ranking(legs, u, charging ? charges : tasks);
    if (seeker.sites.empty()) continue;
    const int best = seeker.sites.front();
    seeker.best_score =
        (charging ? ChargeLikelihood(share) : TaskLikelihood(share)) / legs.intervals(u, best);
    seeker.best_way_m = legs.way_m(u, best);
    candidates += static_cast<std::int64_t>(seeker.sites.size()) *
                  (charging ? weights.n_vehicles() : weights.n_workers());
    (charging ? for_charging : for_tasks).push_back(std::move(seeker));
  }

  std::vector<std::int32_t> places;
  for (int y = 0; y < n_charges; ++y) places.push_back(feasible.free_places(y));
  const std::vector<Taken> sensing =
      TakeAll(std::move(for_tasks), weights.worker_task, winners_,
              std::vector<std::int32_t>(At(n_tasks), 1),
              [&](int u, int x, int w) { return feasible.Sense(u, x, w); });
  const std::vector<Taken> charging =
      TakeAll(std::move(for_charging), weights.vehicle_charge, winners_, std::move(places),
              [&](int u, int y, int v) { return feasible.Charge(u, y, v); });

  std::vector<Action> actions;
  const auto add = [&](const Node& node) { actions.push_back(ToAction(situation, weights, node)); };
  std::vector<char> uav_acts(At(weights.n_uavs()), 0), worker_acts(At(weights.n_workers()), 0),
      vehicle_acts(At(weights.n_vehicles()), 0);
  for (const auto& [u, x, w] : sensing) {
    add({weights.Sense(u, x, w), u, w, x, ActionKind::kSense});
    uav_acts[At(u)] = worker_acts[At(w)] = 1;
  }
  for (const auto& [u, y, v] : charging) {
    add({weights.Charge(u, y, v), u, v, y, ActionKind::kCharge});
    uav_acts[At(u)] = vehicle_acts[At(v)] = 1;
  }
  for (int u = 0; u < weights.n_uavs(); ++u) {
    if (!uav_acts[At(u)]) add({weights.stay, u, -1, -1, ActionKind::kUavStays});
  }
  for (int w = 0; w < weights.n_workers(); ++w) {
    if (!worker_acts[At(w)]) add({weights.stay, -1, w, -1, ActionKind::kWorkerStays});
  }
  for (int v = 0; v < weights.n_vehicles(); ++v) {
    if (!vehicle_acts[At(v)]) add({weights.stay, -1, v, -1, ActionKind::kVehicleStays});
  }
  return MakeDecision(std::move(actions), candidates);
}

}  // namespace muster::scheduler
