#include "scheduler/solver/build.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <utility>

#include "base/check.h"
#include "base/index.h"
#include "model/place_index.h"
#include "scheduler/solver/expected_costs.h"
#include "scheduler/solver/levels.h"
#include "scheduler/solver/parallel.h"
#include "scheduler/weights.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;
using Clock = std::chrono::steady_clock;

double Seconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

/// Where that many agents and tasks are, neighbours get neighbouring numbers, as memory far apart
/// is slow to reach.
constexpr std::size_t kNeighboursFirst = 4096;

/// Partners of a site that are listed, where not all are; and level from which none is sought.
constexpr std::size_t kNearest = 24;
constexpr std::int32_t kFarthest = 1 << 12;

/// Number of a cell along the Z-order curve.
std::uint32_t ZOrder(double x, double y) {
  const auto spread = [](double v) {
    auto z = static_cast<std::uint32_t>(std::clamp(v, 0.0, 65535.0));
    z = (z | z << 8) & 0x00FF00FFu;
    z = (z | z << 4) & 0x0F0F0F0Fu;
    z = (z | z << 2) & 0x33333333u;
    return (z | z << 1) & 0x55555555u;
  };
  return spread(x) | spread(y) << 1;
}

/// Levels depend on speed alone; agents of one speed share their expected costs.
struct SpeedClasses {
  std::vector<double> speeds;   ///< ascending
  std::vector<Index> of_agent;  ///< [n_agents]
  std::vector<LevelOf> levels;  ///< by class

  SpeedClasses(const std::vector<const AgentState*>& agents, const Rules& rules) {
    for (const AgentState* agent : agents) speeds.push_back(agent->speed_m_s);
    std::sort(speeds.begin(), speeds.end());
    speeds.erase(std::unique(speeds.begin(), speeds.end()), speeds.end());
    for (const AgentState* agent : agents) {
      of_agent.push_back(static_cast<Index>(
          std::lower_bound(speeds.begin(), speeds.end(), agent->speed_m_s) - speeds.begin()));
    }
    for (const double speed : speeds) levels.emplace_back(speed, rules);
  }
  std::size_t size() const { return speeds.size(); }
};

/// A way that an agent might take.
struct Way {
  Index agent;
  Index place;
  double metres;
  std::int32_t level;
};

std::vector<Point> Places(const std::vector<const AgentState*>& agents, TimeUs now) {
  std::vector<Point> places;
  for (const AgentState* agent : agents) places.push_back(PositionAt(*agent, now));
  return places;
}

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
        neighbours_first_(situation.uavs.size() + situation.workers.size() +
                              situation.vehicles.size() + site_.tasks.size() >
                          kNeighboursFirst),
        cell_m_(std::max(std::max(site_.width_m, site_.height_m) / 65535, 1e-3)),
        uavs_(Idle(situation.uavs)),
        workers_(Idle(situation.workers)),
        vehicles_(Idle(situation.vehicles)),
        uav_at_(Places(uavs_, situation.now_us)),
        worker_at_(Places(workers_, situation.now_us)),
        vehicle_at_(Places(vehicles_, situation.now_us)),
        uav_speeds_(uavs_, rules_),
        worker_speeds_(workers_, rules_),
        vehicle_speeds_(vehicles_, rules_) {
    for (const AgentState* uav : uavs_) range_m_.push_back(situation.range_m(*uav));
    for (std::size_t x = 0; x < site_.tasks.size(); ++x) {
      if (situation.task_status[x] == TaskStatus::kOpen) tasks_.push_back(TaskId(x));
    }
    site_of_charge_.assign(site_.charging_points.size(), -1);
    for (std::size_t y = 0; y < site_.charging_points.size(); ++y) {
      charge_at_.push_back(site_.charging_points[y].at);
      if (situation.free_places(ChargeId(y)) > 0) charges_.push_back(ChargeId(y));
    }
    if (neighbours_first_) {
      SortByNeighbourhood(&tasks_, [&](TaskId x) { return site_.tasks[x.index()].at; });
      SortByNeighbourhood(&charges_,
                          [&](ChargeId y) { return site_.charging_points[y.index()].at; });
    }
    for (const TaskId x : tasks_) task_at_.push_back(site_.tasks[x.index()].at);
    for (std::size_t k = 0; k < charges_.size(); ++k) {
      site_of_charge_[charges_[k].index()] = static_cast<Index>(tasks_.size() + k);
    }
  }

  BuiltInstance Build() {
    const auto start = Clock::now();
    FindUavWays();
    FindPartnerWays();
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
  std::uint32_t Neighbourhood(Point p) const { return ZOrder(p.x_m / cell_m_, p.y_m / cell_m_); }

  template <class Element, class At>
  void SortByNeighbourhood(std::vector<Element>* elements, const At& at) const {
    std::vector<std::pair<std::uint32_t, Element>> keyed;
    for (const Element& element : *elements)
      keyed.emplace_back(Neighbourhood(at(element)), element);
    std::stable_sort(keyed.begin(), keyed.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < keyed.size(); ++i) (*elements)[i] = keyed[i].second;
  }

  std::vector<const AgentState*> Idle(const std::vector<AgentState>& agents) const {
    std::vector<const AgentState*> idle;
    for (const AgentState& agent : agents) {
      if (agent.idle(situation_.now_us)) idle.push_back(&agent);
    }
    if (neighbours_first_) {
      SortByNeighbourhood(&idle,
                          [&](const AgentState* a) { return PositionAt(*a, situation_.now_us); });
    }
    return idle;
  }

  WaysOf Of(AgentKind kind) const { return {site_.ways.get(), kind}; }
  WaysOf PartnersOf(bool charging) const {
    return Of(charging ? AgentKind::kVehicle : AgentKind::kWorker);
  }

  double Share(std::size_t u) const {
    return uavs_[u]->range_full_m > 0 ? range_m_[u] / uavs_[u]->range_full_m : 0;
  }

  template <class Find>
  std::vector<Way> FindWays(std::size_t n_agents, const Find& find) const {
    std::vector<Way> ways, second;
    ParallelFor(n_agents, threads_, 512, [&](std::size_t begin, std::size_t end) {
      std::vector<Way>* out = begin == 0 ? &ways : &second;
      for (std::size_t i = begin; i < end; ++i) find(i, out);
    });
    Append(&ways, second);
    return ways;
  }

  /// Constraints (5) and (6), without regard to time: the expected costs need them so.
  void FindUavWays() {
    const PlaceIndex tasks(task_at_, Of(AgentKind::kUav)), charges(charge_at_, Of(AgentKind::kUav));
    uav_to_task_ = FindWays(uavs_.size(), [&](std::size_t u, std::vector<Way>* ways) {
      const LevelOf& level = uav_speeds_.levels[At(uav_speeds_.of_agent[u])];
      tasks.WithinFrom(uav_at_[u], range_m_[u], [&](Index x, double metres) {
        const TaskId task = tasks_[At(x)];
        if (!CanSense(range_m_[u], metres, site_.tasks[task.index()].cost_m,
                      site_.task_to_charge_m[task.index()])) {
          return;
        }
        ways->push_back({static_cast<Index>(u), x, metres, level(metres)});
      });
    });
    uav_to_charge_ = FindWays(uavs_.size(), [&](std::size_t u, std::vector<Way>* ways) {
      const LevelOf& level = uav_speeds_.levels[At(uav_speeds_.of_agent[u])];
      charges.WithinFrom(uav_at_[u], range_m_[u], [&](Index y, double metres) {
        ways->push_back({static_cast<Index>(u), y, metres, level(metres)});
      });
    });
  }

  /// What can be reached before the agent must be done. Charging points only with a free place.
  void FindPartnerWays() {
    const auto find = [&](const std::vector<const AgentState*>& agents,
                          const std::vector<Point>& at, const SpeedClasses& speeds, bool charging) {
      const std::size_t n_places = charging ? charge_at_.size() : task_at_.size();
      if (rules_.availability == Availability::kOverrun &&
          agents.size() * n_places > all_pairs_up_to_) {
        return NearWays(at, speeds, charging);
      }
      const PlaceIndex index(charging ? charge_at_ : task_at_, PartnersOf(charging));
      return FindWays(agents.size(), [&](std::size_t i, std::vector<Way>* ways) {
        const LevelOf& level = speeds.levels[At(speeds.of_agent[i])];
        const TimeUs left = TimeLeft(*agents[i]);
        const double radius = ToSeconds(left) * agents[i]->speed_m_s * (1 + 1e-9) + 1;
        index.WithinFrom(at[i], radius, [&](Index place, double metres) {
          if (charging && site_of_charge_[At(place)] < 0) return;
          const TimeUs travel = TravelUs(metres, agents[i]->speed_m_s);
          if (travel == kNever || travel > left) return;
          ways->push_back({static_cast<Index>(i), place, metres, level(metres)});
        });
      });
    };
    worker_to_task_ = find(workers_, worker_at_, worker_speeds_, false);
    vehicle_to_charge_ = find(vehicles_, vehicle_at_, vehicle_speeds_, true);
  }

  /// The nearest partners of each place, by whole levels, where time limits nothing.
  std::vector<Way> NearWays(const std::vector<Point>& at, const SpeedClasses& speeds,
                            bool charging) {
    const std::vector<Point>& places = charging ? charge_at_ : task_at_;
    const PlaceIndex index(at, PartnersOf(charging));
    double reach_m = 0;
    for (const LevelOf& level : speeds.levels) reach_m = std::max(reach_m, level.reach_m());
    if (rest_level_.empty()) rest_level_.assign(tasks_.size() + charges_.size(), 0);
    return FindWays(places.size(), [&](std::size_t k, std::vector<Way>* ways) {
      const Index site = charging ? site_of_charge_[k] : static_cast<Index>(k);
      if (site < 0) return;
      const std::size_t before = ways->size();
      for (std::int32_t most = 2;; most *= 2) {
        ways->resize(before);
        index.WithinTo(places[k], reach_m * most * (1 + 1e-9) + 1, [&](Index i, double metres) {
          const std::int32_t level = speeds.levels[At(speeds.of_agent[At(i)])](metres);
          if (level > most) return;
          ways->push_back({i, static_cast<Index>(k), metres, level});
        });
        const bool all = ways->size() - before == at.size();
        rest_level_[At(site)] = all ? 0 : most + 1;
        if (all || ways->size() - before >= kNearest || most >= kFarthest) return;
      }
    });
  }

  /// Whether one who takes that long is at the open task before it expires.
  bool IsInTime(Index task, TimeUs travel_us) const {
    return CanBegin(site_.tasks[tasks_[At(task)].index()], situation_.now_us, travel_us);
  }
  TimeUs TimeLeft(const AgentState& agent) const {
    return LatestEnd(agent, rules_) - situation_.now_us;
  }

  /// Eq. 4-5 to 4-8.
  void ExpectedCosts() {
    const double none =
        static_cast<double>(rules_.limit_us) /
        static_cast<double>(rules_.ceil_to_minutes ? kMinuteUs : rules_.interval_us);
    const auto by_uav = [&](const std::vector<Way>& ways, std::size_t n_places, bool charging) {
      std::vector<double> cost(n_places, 0);
      std::vector<std::int32_t> feasible(n_places, 0);
      std::vector<double> per_level(uavs_.size());
      for (std::size_t u = 0; u < uavs_.size(); ++u) {
        per_level[u] = charging ? ChargeLikelihood(Share(u)) : TaskLikelihood(Share(u));
      }
      for (const Way& way : ways) {
        cost[At(way.place)] += way.level / per_level[At(way.agent)];
        ++feasible[At(way.place)];
      }
      for (std::size_t i = 0; i < n_places; ++i) {
        if (uavs_.empty()) continue;
        if (rules_.mean_over_all) {
          cost[i] /= static_cast<double>(uavs_.size());
        } else {
          cost[i] = feasible[i] == 0 ? none : cost[i] / feasible[i];
        }
      }
      return cost;
    };
    task_by_uav_ = by_uav(uav_to_task_, task_at_.size(), false);
    charge_by_uav_ = by_uav(uav_to_charge_, charge_at_.size(), true);

    const auto by_partner = [&](const std::vector<Point>& agents, const SpeedClasses& speeds,
                                const std::vector<Point>& places, bool charging) {
      std::vector<double> cost(places.size(), 0);
      if (agents.empty()) return cost;
      Queries to(places);
      for (std::size_t c = 0; c < speeds.size(); ++c) {
        std::vector<Point> of_class;
        for (std::size_t i = 0; i < agents.size(); ++i) {
          if (At(speeds.of_agent[i]) == c) of_class.push_back(agents[i]);
        }
        const std::vector<double> sums =
            LevelSums(of_class, speeds.levels[c], PartnersOf(charging), exact_up_to_)
                .Sums(&to, threads_);
        for (std::size_t i = 0; i < cost.size(); ++i) cost[i] += sums[i];
      }
      for (double& value : cost) value /= static_cast<double>(agents.size());
      return cost;
    };
    task_by_worker_ = by_partner(worker_at_, worker_speeds_, task_at_, false);
    charge_by_vehicle_ = by_partner(vehicle_at_, vehicle_speeds_, charge_at_, true);
  }

  /// One softmax mean for each (place, speed) that some way needs.
  struct MeanAt {
    std::vector<double> agent;              ///< [n_agents] where the agent stands
    std::vector<std::vector<double>> task;  ///< [n_classes][n_tasks]
    std::vector<std::vector<double>> charge;
  };

  /// The places that agents of one speed class need sums for: where they stand, where they may go.
  struct Needs {
    std::vector<std::size_t> agents, tasks, charges;
    Queries at{{}};
  };

  std::vector<Needs> NeedsOf(const std::vector<Point>& agents, const SpeedClasses& speeds,
                             const std::vector<Way>* to_task,
                             const std::vector<Way>* to_charge) const {
    std::vector<Needs> needs(speeds.size());
    for (std::size_t i = 0; i < agents.size(); ++i) {
      needs[At(speeds.of_agent[i])].agents.push_back(i);
    }
    std::vector<std::vector<Point>> at(speeds.size());
    for (std::size_t c = 0; c < speeds.size(); ++c) {
      for (const std::size_t i : needs[c].agents) at[c].push_back(agents[i]);
    }
    const auto add = [&](const std::vector<Way>* ways, const std::vector<Point>& places,
                         std::vector<std::size_t> Needs::*list) {
      if (ways == nullptr) return;
      std::vector<std::vector<bool>> needed(speeds.size(), std::vector<bool>(places.size()));
      for (const Way& way : *ways) {
        needed[At(speeds.of_agent[At(way.agent)])][At(way.place)] = true;
      }
      for (std::size_t c = 0; c < speeds.size(); ++c) {
        for (std::size_t i = 0; i < places.size(); ++i) {
          if (!needed[c][i]) continue;
          (needs[c].*list).push_back(i);
          at[c].push_back(places[i]);
        }
      }
    };
    add(to_task, task_at_, &Needs::tasks);
    add(to_charge, charge_at_, &Needs::charges);
    for (std::size_t c = 0; c < speeds.size(); ++c) needs[c].at = Queries(std::move(at[c]));
    return needs;
  }

  MeanAt Means(const PlaceSums& sums, const SpeedClasses& speeds, std::vector<Needs>* needs) const {
    MeanAt mean;
    mean.agent.resize(speeds.of_agent.size());
    mean.task.assign(speeds.size(), std::vector<double>(task_at_.size(), 0));
    mean.charge.assign(speeds.size(), std::vector<double>(charge_at_.size(), 0));
    for (std::size_t c = 0; c < speeds.size(); ++c) {
      Needs& need = (*needs)[c];
      const std::vector<double> means = sums.SoftmaxMeans(&need.at, speeds.levels[c], threads_);
      auto next = means.begin();
      for (const std::size_t i : need.agents) mean.agent[i] = *next++;
      for (const std::size_t i : need.tasks) mean.task[c][i] = *next++;
      for (const std::size_t i : need.charges) mean.charge[c][i] = *next++;
    }
    return mean;
  }

  void MeanCosts() {
    auto needs = NeedsOf(uav_at_, uav_speeds_, &uav_to_task_, &uav_to_charge_);
    uav_tasks_ = Means(PlaceSums(task_at_, task_by_worker_, Of(AgentKind::kUav), exact_up_to_),
                       uav_speeds_, &needs);
    uav_charges_ =
        Means(PlaceSums(charge_at_, charge_by_vehicle_, Of(AgentKind::kUav), exact_up_to_),
              uav_speeds_, &needs);
    needs = NeedsOf(worker_at_, worker_speeds_, &worker_to_task_, nullptr);
    worker_tasks_ = Means(PlaceSums(task_at_, task_by_uav_, PartnersOf(false), exact_up_to_),
                          worker_speeds_, &needs);
    needs = NeedsOf(vehicle_at_, vehicle_speeds_, nullptr, &vehicle_to_charge_);
    vehicle_charges_ = Means(PlaceSums(charge_at_, charge_by_uav_, PartnersOf(true), exact_up_to_),
                             vehicle_speeds_, &needs);
  }

  void Assemble(BuiltInstance* built) {
    Instance& instance = built->instance;
    const double stay = Softplus(0);
    for (std::size_t u = 0; u < uavs_.size(); ++u) {
      instance.uavs.push_back({stay, LatestEnd(*uavs_[u], rules_), Neighbourhood(uav_at_[u])});
    }
    for (const AgentState* worker : workers_) {
      instance.partners.push_back({stay, LatestEnd(*worker, rules_), 0});
    }
    for (const AgentState* vehicle : vehicles_) {
      instance.partners.push_back({stay, LatestEnd(*vehicle, rules_), vehicle->charge_rate_m_s});
    }
    instance.capacity.assign(tasks_.size(), 1);
    for (const ChargeId charge : charges_) {
      instance.capacity.push_back(situation_.free_places(charge));
    }
    instance.rest_level = rest_level_;
    AddUavArcs(&instance);
    AddPartnerArcs(&instance);

    built->uavs = uavs_;
    built->partners = workers_;
    Append(&built->partners, vehicles_);
    built->tasks = tasks_;
    built->charges = charges_;
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
      const AgentState& uav = *uavs_[u];
      const auto c = At(uav_speeds_.of_agent[u]);
      Instance::UavArc& arc = arcs[at];
      site[at] = -1;
      const TimeUs travel = TravelUs(way.metres, uav.speed_m_s);
      if (travel == kNever || travel > TimeLeft(uav)) return;
      if (charging ? site_of_charge_[At(way.place)] < 0 : !IsInTime(way.place, travel)) return;
      const auto& tasks_after = charging ? uav_tasks_.charge[c] : uav_tasks_.task[c];
      const auto& charges_after = charging ? uav_charges_.charge[c] : uav_charges_.task[c];
      const double to_tasks =
          MoveBenefit(uav_tasks_.agent[u], tasks_after[At(way.place)], way.level);
      const double to_charges =
          MoveBenefit(uav_charges_.agent[u], charges_after[At(way.place)], way.level);
      const double arrival_m = range_m_[u] - way.metres;
      const auto gain = [&](double range_m) {
        return UavBenefit(range_m, uav.range_full_m, to_tasks, to_charges);
      };
      arc.uav = way.agent;
      arc.level = way.level;
      arc.arrive_us = situation_.now_us + travel;
      arc.solo = gain(arrival_m);
      if (charging) {
        site[at] = site_of_charge_[At(way.place)];
        arc.base = ChargeFoundation(Foundation::kHierarchical, Share(u));
        arc.pair_gain = gain(uav.range_full_m);
        arc.missing_m = uav.range_full_m - arrival_m;
      } else {
        site[at] = way.place;
        const double cost = site_.tasks[tasks_[At(way.place)].index()].cost_m;
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
        const SpeedClasses& speeds = charging ? vehicle_speeds_ : worker_speeds_;
        const auto c = At(speeds.of_agent[At(way.agent)]);
        const auto& after = charging ? mean.charge[c] : mean.task[c];
        const double speed = speeds.speeds[c];
        arcs[i].partner = charging ? n_workers + way.agent : way.agent;
        arcs[i].level = way.level;
        arcs[i].gain = MoveBenefit(mean.agent[At(way.agent)], after[At(way.place)], way.level);
        const TimeUs travel = TravelUs(way.metres, speed);
        arcs[i].arrive_us = situation_.now_us + travel;
        site[i] = charging                      ? site_of_charge_[At(way.place)]
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
  bool neighbours_first_;  ///< elements are numbered by neighbourhood, else by id
  double cell_m_;
  std::vector<const AgentState*> uavs_, workers_, vehicles_;
  std::vector<Point> uav_at_, worker_at_, vehicle_at_;
  SpeedClasses uav_speeds_, worker_speeds_, vehicle_speeds_;
  std::vector<double> range_m_;
  std::vector<TaskId> tasks_;
  std::vector<ChargeId> charges_;
  std::vector<Point> task_at_, charge_at_;  ///< open tasks; all charging points
  std::vector<Index> site_of_charge_;       ///< -1: no free place

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
