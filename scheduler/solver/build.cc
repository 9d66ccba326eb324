#include "scheduler/solver/build.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "base/index.h"
#include "model/place_index.h"
#include "scheduler/solver/expected_costs.h"
#include "scheduler/solver/parallel.h"
#include "scheduler/solver/roster.h"
#include "scheduler/weights.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;
using Clock = std::chrono::steady_clock;

double Seconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

/// How many partners a site lists where not all are listed: at least kFewest, and up to kMost as
/// long as all sites together list at most half of `all_pairs_up_to`. No partner is sought from
/// level kFarthest on.
constexpr std::size_t kFewest = 24, kMost = 96;
constexpr std::int32_t kFarthest = 1 << 12;

/// A way that an agent might take.
struct Way {
  Index agent;
  Index place;
  double metres;
  std::int32_t level;
};

/// Concatenates what the two halves of a parallel loop found.
template <class T>
void Append(std::vector<T>* to, const std::vector<T>& from) {
  to->insert(to->end(), from.begin(), from.end());
}

class Builder {
 public:
  Builder(const Situation& situation, int threads, std::size_t exact_up_to,
          std::size_t all_pairs_up_to)
      : situation_(situation),
        site_(*situation.site),
        rules_(situation.site->rules),
        threads_(threads),
        exact_up_to_(exact_up_to),
        all_pairs_up_to_(all_pairs_up_to),
        roster_(situation) {}

  BuiltInstance Build() {
    const auto start = Clock::now();
    FindUavWays();
    worker_to_task_ = FindPartnerWays(workers_, false);
    vehicle_to_charge_ = FindPartnerWays(vehicles_, true);
    const auto found = Clock::now();
    ExpectedCosts();
    MeanCosts();
    const auto weighed = Clock::now();
    BuiltInstance built;
    Assemble(&built);
    const auto end = Clock::now();
    built.weights_s = Seconds(found, weighed);
    built.candidates_s = Seconds(start, found) + Seconds(weighed, end);
    return built;
  }

 private:
  double Share(std::size_t u) const {
    const double full_m = uavs_.agents[u]->range_full_m;
    return full_m > 0 ? roster_.range_m[u] / full_m : 0;
  }
  const Task& TaskAt(Index task) const { return site_.tasks[roster_.tasks[At(task)].index()]; }
  const std::vector<Point>& PlacesAt(bool charging) const {
    return charging ? roster_.charge_at : roster_.task_at;
  }
  /// Whether one who takes that long is at the open task before it expires.
  bool IsInTime(Index task, TimeUs travel_us) const {
    return CanBegin(TaskAt(task), situation_.now_us, travel_us);
  }
  bool IsForbidden(const AgentState& agent, Index task) const {
    return !site_.forbidden.empty() && site_.Forbids(agent, roster_.tasks[At(task)].value);
  }
  TimeUs TimeLeft(const AgentState& agent) const {
    return LatestEnd(agent, rules_) - situation_.now_us;
  }

  template <class Find>
  std::vector<Way> FindWays(std::size_t n, const WaysOf& by, const Find& find) const {
    std::vector<Way> ways, second;
    ParallelFor(n, threads_, by.straight() ? 512 : 16, [&](std::size_t begin, std::size_t end) {
      std::vector<Way>* out = begin == 0 ? &ways : &second;
      for (std::size_t i = begin; i < end; ++i) find(i, out);
    });
    Append(&ways, second);
    return ways;
  }

  /// Constraints (5) and (6), without regard to time and to what is forbidden: the expected costs
  /// need them so.
  void FindUavWays() {
    const std::vector<double>& range_m = roster_.range_m;
    const PlaceIndex tasks(roster_.task_at, uavs_.ways), charges(roster_.charge_at, uavs_.ways);
    uav_to_task_ = FindWays(uavs_.size(), uavs_.ways, [&](std::size_t u, std::vector<Way>* ways) {
      const LevelOf& level = uavs_.level_of(u);
      const auto may = [&](Index x, double metres) {
        const double to_charge_m = site_.task_to_charge_m[roster_.tasks[At(x)].index()];
        return CanSense(range_m[u], metres, TaskAt(x).cost_m, to_charge_m);
      };
      tasks.WithinFrom(uavs_.at[u], range_m[u], may, [&](Index x, double metres) {
        ways->push_back({static_cast<Index>(u), x, metres, level(metres)});
      });
    });
    uav_to_charge_ = FindWays(uavs_.size(), uavs_.ways, [&](std::size_t u, std::vector<Way>* ways) {
      const LevelOf& level = uavs_.level_of(u);
      charges.WithinFrom(uavs_.at[u], range_m[u], [&](Index y, double metres) {
        ways->push_back({static_cast<Index>(u), y, metres, level(metres)});
      });
    });
  }

  /// What the partners can reach before they must be done. Charging points only with a free place.
  std::vector<Way> FindPartnerWays(const Crew& crew, bool charging) {
    const std::vector<Point>& places = PlacesAt(charging);
    if (rules_.availability == Availability::kOverrun &&
        crew.size() * places.size() > all_pairs_up_to_) {
      return NearWays(crew, charging);
    }
    const PlaceIndex index(places, crew.ways);
    return FindWays(crew.size(), crew.ways, [&](std::size_t i, std::vector<Way>* ways) {
      const LevelOf& level = crew.level_of(i);
      const double speed_m_s = crew.agents[i]->speed_m_s;
      const TimeUs left = TimeLeft(*crew.agents[i]);
      const double radius = ToSeconds(left) * speed_m_s * (1 + 1e-9) + 1;
      index.WithinFrom(crew.at[i], radius, [&](Index place, double metres) {
        if (charging && roster_.site_of_charge[At(place)] < 0) return;
        const TimeUs travel = TravelUs(metres, speed_m_s);
        if (travel == kNever || travel > left) return;
        if (!charging && IsForbidden(*crew.agents[i], place)) return;
        ways->push_back({static_cast<Index>(i), place, metres, level(metres)});
      });
    });
  }

  /// The nearest partners of each place, by whole levels, where time limits nothing.
  std::vector<Way> NearWays(const Crew& crew, bool charging) {
    const std::vector<Point>& places = PlacesAt(charging);
    const std::size_t nearest = std::clamp(all_pairs_up_to_ / (2 * places.size()), kFewest, kMost);
    const PlaceIndex index(crew.at, crew.ways);
    double reach_m = 0;
    for (const LevelOf& level : crew.levels) reach_m = std::max(reach_m, level.reach_m());
    if (rest_level_.empty()) rest_level_.assign(roster_.tasks.size() + roster_.charges.size(), 0);
    return FindWays(places.size(), crew.ways, [&](std::size_t k, std::vector<Way>* ways) {
      const Index site = charging ? roster_.site_of_charge[k] : static_cast<Index>(k);
      if (site < 0) return;
      const std::size_t before = ways->size();
      for (std::int32_t most = 2;; most *= 2) {
        ways->resize(before);
        index.WithinTo(places[k], reach_m * most * (1 + 1e-9) + 1, [&](Index i, double metres) {
          const std::int32_t level = crew.level_of(At(i))(metres);
          if (level > most) return;
          if (!charging && IsForbidden(*crew.agents[At(i)], static_cast<Index>(k))) return;
          ways->push_back({i, static_cast<Index>(k), metres, level});
        });
        const bool all = ways->size() - before == crew.size();
        rest_level_[At(site)] = all ? 0 : most + 1;
        if (all || ways->size() - before >= nearest || most >= kFarthest) return;
      }
    });
  }

  /// Eq. 4-5 to 4-8.
  void ExpectedCosts() {
    task_by_uav_ = CostByUav(uav_to_task_, false);
    charge_by_uav_ = CostByUav(uav_to_charge_, true);
    task_by_worker_ = CostByPartner(workers_, false);
    charge_by_vehicle_ = CostByPartner(vehicles_, true);
  }

  std::vector<double> CostByUav(const std::vector<Way>& ways, bool charging) const {
    const double none =
        static_cast<double>(rules_.limit_us) /
        static_cast<double>(rules_.ceil_to_minutes ? kMinuteUs : rules_.interval_us);
    std::vector<double> cost(PlacesAt(charging).size(), 0);
    if (uavs_.size() == 0) return cost;
    std::vector<std::int32_t> feasible(cost.size(), 0);
    std::vector<double> likelihood(uavs_.size());
    for (std::size_t u = 0; u < uavs_.size(); ++u) {
      likelihood[u] = charging ? ChargeLikelihood(Share(u)) : TaskLikelihood(Share(u));
    }
    for (const Way& way : ways) {
      cost[At(way.place)] += way.level / likelihood[At(way.agent)];
      ++feasible[At(way.place)];
    }
    for (std::size_t i = 0; i < cost.size(); ++i) {
      if (rules_.mean_over_all) {
        cost[i] /= static_cast<double>(uavs_.size());
      } else {
        cost[i] = feasible[i] == 0 ? none : cost[i] / feasible[i];
      }
    }
    return cost;
  }

  std::vector<double> CostByPartner(const Crew& crew, bool charging) const {
    std::vector<double> cost(PlacesAt(charging).size(), 0);
    if (crew.size() == 0) return cost;
    Queries to(PlacesAt(charging));
    for (std::size_t c = 0; c < crew.speeds.size(); ++c) {
      std::vector<Point> of_speed;
      for (std::size_t i = 0; i < crew.size(); ++i) {
        if (At(crew.speed_of[i]) == c) of_speed.push_back(crew.at[i]);
      }
      const std::vector<double> sums =
          LevelSums(of_speed, crew.levels[c], crew.ways, exact_up_to_).Sums(&to, threads_);
      for (std::size_t i = 0; i < cost.size(); ++i) cost[i] += sums[i];
    }
    for (double& value : cost) value /= static_cast<double>(crew.size());
    return cost;
  }

  /// One softmax mean for each (place, speed) that some way needs.
  struct MeanAt {
    std::vector<double> agent;              ///< [n_agents] where the agent stands
    std::vector<std::vector<double>> task;  ///< [n_speeds][n_tasks]
    std::vector<std::vector<double>> charge;
  };

  /// The places that agents of one speed need sums for: where they stand, where they may go.
  struct Needs {
    std::vector<std::size_t> agents, tasks, charges;
    Queries at{{}};
  };

  /// [n_speeds]
  std::vector<Needs> NeedsOf(const Crew& crew, const std::vector<Way>* to_task,
                             const std::vector<Way>* to_charge) const {
    const std::size_t n_speeds = crew.speeds.size();
    std::vector<Needs> needs(n_speeds);
    std::vector<std::vector<Point>> at(n_speeds);
    for (std::size_t i = 0; i < crew.size(); ++i) {
      needs[At(crew.speed_of[i])].agents.push_back(i);
      at[At(crew.speed_of[i])].push_back(crew.at[i]);
    }
    const auto add = [&](const std::vector<Way>* ways, const std::vector<Point>& places,
                         std::vector<std::size_t> Needs::*list) {
      if (ways == nullptr) return;
      std::vector<std::vector<bool>> needed(n_speeds, std::vector<bool>(places.size()));
      for (const Way& way : *ways) needed[At(crew.speed_of[At(way.agent)])][At(way.place)] = true;
      for (std::size_t c = 0; c < n_speeds; ++c) {
        for (std::size_t i = 0; i < places.size(); ++i) {
          if (!needed[c][i]) continue;
          (needs[c].*list).push_back(i);
          at[c].push_back(places[i]);
        }
      }
    };
    add(to_task, roster_.task_at, &Needs::tasks);
    add(to_charge, roster_.charge_at, &Needs::charges);
    for (std::size_t c = 0; c < n_speeds; ++c) needs[c].at = Queries(std::move(at[c]));
    return needs;
  }

  /// Means of the places' costs, which are those of tasks or of charging points.
  MeanAt Means(const std::vector<double>& cost, bool charging, const Crew& crew,
               std::vector<Needs>* needs) const {
    const PlaceSums sums(PlacesAt(charging), cost, crew.ways, exact_up_to_);
    const std::size_t n_speeds = crew.speeds.size();
    MeanAt mean;
    mean.agent.resize(crew.size());
    mean.task.assign(n_speeds, std::vector<double>(roster_.task_at.size(), 0));
    mean.charge.assign(n_speeds, std::vector<double>(roster_.charge_at.size(), 0));
    for (std::size_t c = 0; c < n_speeds; ++c) {
      Needs& need = (*needs)[c];
      const std::vector<double> means = sums.SoftmaxMeans(&need.at, crew.levels[c], threads_);
      auto next = means.begin();
      for (const std::size_t i : need.agents) mean.agent[i] = *next++;
      for (const std::size_t i : need.tasks) mean.task[c][i] = *next++;
      for (const std::size_t i : need.charges) mean.charge[c][i] = *next++;
    }
    return mean;
  }

  void MeanCosts() {
    auto needs = NeedsOf(uavs_, &uav_to_task_, &uav_to_charge_);
    uav_tasks_ = Means(task_by_worker_, false, uavs_, &needs);
    uav_charges_ = Means(charge_by_vehicle_, true, uavs_, &needs);
    needs = NeedsOf(workers_, &worker_to_task_, nullptr);
    worker_tasks_ = Means(task_by_uav_, false, workers_, &needs);
    needs = NeedsOf(vehicles_, nullptr, &vehicle_to_charge_);
    vehicle_charges_ = Means(charge_by_uav_, true, vehicles_, &needs);
  }

  void Assemble(BuiltInstance* built) {
    Instance& instance = built->instance;
    const double stay = Softplus(0);
    for (std::size_t u = 0; u < uavs_.size(); ++u) {
      instance.uavs.push_back(
          {stay, LatestEnd(*uavs_.agents[u], rules_), roster_.neighbourhoods.Of(uavs_.at[u])});
    }
    for (const AgentState* worker : workers_.agents) {
      instance.partners.push_back({stay, LatestEnd(*worker, rules_), 0});
    }
    for (const AgentState* vehicle : vehicles_.agents) {
      instance.partners.push_back({stay, LatestEnd(*vehicle, rules_), vehicle->charge_rate_m_s});
    }
    instance.capacity.assign(roster_.tasks.size(), 1);
    for (const ChargeId charge : roster_.charges) {
      instance.capacity.push_back(situation_.free_places(charge));
    }
    instance.rest_level = rest_level_;
    AddUavArcs(&instance);
    AddPartnerArcs(&instance);

    built->uavs = uavs_.agents;
    built->partners = workers_.agents;
    Append(&built->partners, vehicles_.agents);
    built->tasks = roster_.tasks;
    built->charges = roster_.charges;
    built->site_of_charge = roster_.site_of_charge;
    built->n_workers = static_cast<Index>(workers_.size());
  }

  /// Counting sort of arcs by site; within a site in the order given.
  template <class Arc>
  static std::vector<Index> SortBySite(std::vector<Arc>* arcs, const std::vector<Index>& site,
                                       std::size_t n_sites) {
    std::vector<Index> begin(n_sites + 1, 0);
    for (const Index s : site) ++begin[At(s) + 1];
    for (std::size_t s = 0; s < n_sites; ++s) begin[s + 1] += begin[s];
    std::vector<Index> next(begin.begin(), begin.end() - 1);
    std::vector<Arc> sorted(arcs->size());
    for (std::size_t i = 0; i < arcs->size(); ++i) sorted[At(next[At(site[i])]++)] = (*arcs)[i];
    *arcs = std::move(sorted);
    return begin;
  }

  template <class Arc>
  static void DropWithoutSite(std::vector<Arc>* arcs, std::vector<Index>* site) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < arcs->size(); ++i) {
      if ((*site)[i] < 0) continue;
      (*arcs)[kept] = (*arcs)[i];
      (*site)[kept++] = (*site)[i];
    }
    arcs->resize(kept);
    site->resize(kept);
  }

  void AddUavArcs(Instance* instance) {
    const double sense_base = SenseFoundation(Foundation::kHierarchical);
    std::vector<Instance::UavArc> arcs(uav_to_task_.size() + uav_to_charge_.size());
    std::vector<Index> site(arcs.size());
    const auto fill = [&](const Way& way, bool charging, std::size_t at) {
      const auto u = At(way.agent);
      const AgentState& uav = *uavs_.agents[u];
      const auto c = At(uavs_.speed_of[u]);
      Instance::UavArc& arc = arcs[at];
      site[at] = -1;
      const TimeUs travel = TravelUs(way.metres, uav.speed_m_s);
      if (travel == kNever || travel > TimeLeft(uav)) return;
      if (charging ? roster_.site_of_charge[At(way.place)] < 0
                   : !IsInTime(way.place, travel) || IsForbidden(uav, way.place)) {
        return;
      }
      const auto& tasks_after = charging ? uav_tasks_.charge[c] : uav_tasks_.task[c];
      const auto& charges_after = charging ? uav_charges_.charge[c] : uav_charges_.task[c];
      const double to_tasks =
          MoveBenefit(uav_tasks_.agent[u], tasks_after[At(way.place)], way.level);
      const double to_charges =
          MoveBenefit(uav_charges_.agent[u], charges_after[At(way.place)], way.level);
      const double arrival_m = roster_.range_m[u] - way.metres;
      const auto gain = [&](double range_m) {
        return UavBenefit(range_m, uav.range_full_m, to_tasks, to_charges);
      };
      arc.uav = way.agent;
      arc.level = way.level;
      arc.arrive_us = situation_.now_us + travel;
      arc.solo = gain(arrival_m);
      if (charging) {
        site[at] = roster_.site_of_charge[At(way.place)];
        arc.base = ChargeFoundation(Foundation::kHierarchical, Share(u));
        arc.pair_gain = gain(uav.range_full_m);
        arc.missing_m = uav.range_full_m - arrival_m;
      } else {
        site[at] = way.place;
        const double cost = TaskAt(way.place).cost_m;
        arc.base = sense_base;
        arc.pair_gain = gain(arrival_m - cost);
        arc.duration_us = SensingUs(cost, uav.speed_m_s);
      }
    };
    ParallelFor(arcs.size(), threads_, 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const bool charging = i >= uav_to_task_.size();
        fill(charging ? uav_to_charge_[i - uav_to_task_.size()] : uav_to_task_[i], charging, i);
      }
    });
    DropWithoutSite(&arcs, &site);
    instance->uav_begin = SortBySite(&arcs, site, instance->capacity.size());
    instance->uav_arcs = std::move(arcs);
  }

  void AddPartnerArcs(Instance* instance) {
    std::vector<Instance::PartnerArc> arcs(worker_to_task_.size() + vehicle_to_charge_.size());
    std::vector<Index> site(arcs.size());
    const auto n_workers = static_cast<Index>(workers_.size());
    ParallelFor(arcs.size(), threads_, 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const bool charging = i >= worker_to_task_.size();
        const Way& way =
            charging ? vehicle_to_charge_[i - worker_to_task_.size()] : worker_to_task_[i];
        const MeanAt& mean = charging ? vehicle_charges_ : worker_tasks_;
        const Crew& crew = charging ? vehicles_ : workers_;
        const auto c = At(crew.speed_of[At(way.agent)]);
        const auto& after = charging ? mean.charge[c] : mean.task[c];
        arcs[i].partner = charging ? n_workers + way.agent : way.agent;
        arcs[i].level = way.level;
        arcs[i].gain = MoveBenefit(mean.agent[At(way.agent)], after[At(way.place)], way.level);
        const TimeUs travel = TravelUs(way.metres, crew.speeds[c]);
        arcs[i].arrive_us = situation_.now_us + travel;
        site[i] = charging                      ? roster_.site_of_charge[At(way.place)]
                  : IsInTime(way.place, travel) ? way.place
                                                : -1;
      }
    });
    DropWithoutSite(&arcs, &site);
    instance->partner_begin = SortBySite(&arcs, site, instance->capacity.size());
    const auto& begins = instance->partner_begin;
    ParallelFor(instance->capacity.size(), threads_, 512, [&](std::size_t begin, std::size_t end) {
      for (std::size_t s = begin; s < end; ++s) {
        std::sort(arcs.begin() + begins[s], arcs.begin() + begins[s + 1],
                  [](const Instance::PartnerArc& a, const Instance::PartnerArc& b) {
                    return a.level != b.level ? a.level < b.level : a.partner < b.partner;
                  });
      }
    });
    instance->partner_arcs = std::move(arcs);
  }

  const Situation& situation_;
  const Site& site_;
  const Rules& rules_;
  int threads_;
  std::size_t exact_up_to_, all_pairs_up_to_;
  const Roster roster_;
  const Crew &uavs_ = roster_.uavs, &workers_ = roster_.workers, &vehicles_ = roster_.vehicles;

  std::vector<std::int32_t> rest_level_;  ///< Instance::rest_level
  std::vector<Way> uav_to_task_, uav_to_charge_, worker_to_task_, vehicle_to_charge_;
  std::vector<double> task_by_uav_, charge_by_uav_, task_by_worker_, charge_by_vehicle_;
  MeanAt uav_tasks_, uav_charges_, worker_tasks_, vehicle_charges_;
};

}  // namespace

BuiltInstance BuildInstance(const Situation& situation, int threads, std::size_t exact_up_to,
                            std::size_t all_pairs_up_to) {
  return Builder(situation, threads, exact_up_to, all_pairs_up_to).Build();
}

}  // namespace muster::scheduler
