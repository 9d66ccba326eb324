#include "scheduler/policies/horizon/pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "base/grid_index.h"
#include "base/index.h"
#include "base/random.h"
#include "model/feasibility.h"
#include "scheduler/policies/horizon/worths.h"
#include "scheduler/solver/parallel.h"

namespace muster::scheduler {
namespace {

/// So few agents are looked through one by one.
constexpr std::size_t kFew = 64;
/// Sites from which on two threads are worth while.
constexpr std::size_t kManySites = 512;

/// What a way depends on, close together in memory.
struct Mover {
  Point at;
  double speed_m_s;
  TimeUs ready_us, latest_us;
  double range_m, range_full_m;  ///< UAVs
  double reach_m;                ///< that time and range allow, and a little more
  double idle_gain;              ///< less than 0 where it is not idle yet
  std::int32_t id;
};

/// The agents of one kind, to be found by place.
class Movers {
 public:
  Movers(const std::vector<Participant>& participants, const HorizonSettings& settings) {
    for (const Participant& p : participants) {
      const AgentState& agent = *p.agent;
      double reach_m = ToSeconds(p.latest_us - p.ready_us) * agent.speed_m_s * (1 + 1e-9) + 1;
      if (agent.kind == AgentKind::kUav) reach_m = std::min(reach_m, p.range_m);
      all_.push_back({p.at, agent.speed_m_s, p.ready_us, p.latest_us, p.range_m, agent.range_full_m,
                      reach_m, p.idle ? 0 : settings.tentative - 1, agent.id});
      reach_m_ = std::max(reach_m_, reach_m);
    }
    if (all_.size() <= kFew) return;
    std::vector<Point> places;
    for (const Mover& mover : all_) places.push_back(mover.at);
    index_.emplace(places);
  }

  /// Calls visit(index, distance) for everybody within reach of the place. Ascends by index if
  /// `ordered`.
  template <class Visit>
  void Near(Point place, const Visit& visit) const {
    const auto look = [&](std::int32_t i, double way_m) {
      if (way_m <= all_[At(i)].reach_m) visit(i, way_m);
    };
    if (index_) return index_->Within(place, reach_m_, look);
    for (std::size_t i = 0; i < all_.size(); ++i) {
      look(static_cast<std::int32_t>(i), Distance(all_[i].at, place));
    }
  }
  bool ordered() const { return !index_; }
  const std::vector<Mover>& all() const { return all_; }
  const Mover& operator[](std::int32_t i) const { return all_[At(i)]; }

 private:
  std::vector<Mover> all_;
  std::optional<GridIndex> index_;
  double reach_m_ = -1;
};

/// The ways to a run of sites, and what is at hand while they are looked for.
struct SiteWays {
  std::vector<Instance::UavArc> uavs;
  std::vector<Instance::PartnerArc> partners;
  std::vector<std::int32_t> uav_end, partner_end;  ///< [sites of the run]

  std::vector<std::pair<std::int32_t, double>> near;  ///< UAVs and their distances
  std::vector<std::pair<double, TimeUs>> next;        ///< tasks close by: range needed, duration
  std::vector<Instance::PartnerArc> found;            ///< of a site, in any order
  std::vector<std::pair<std::uint64_t, std::size_t>> order;  ///< by (level, partner)
};

class PairFinder {
 public:
  PairFinder(const Situation& situation, const Participants& participants, const OpenSites& open,
             const HorizonSettings& settings, int threads)
      : situation_(situation),
        site_(*situation.site),
        participants_(participants),
        open_(open),
        settings_(settings),
        threads_(threads),
        worths_(situation, settings),
        uavs_(participants.uavs, settings),
        workers_(participants.workers, settings),
        vehicles_(participants.vehicles, settings) {}

  PossiblePairs Find() {
    Instance& instance = pairs_.instance;
    for (const Mover& uav : uavs_.all()) {
      instance.uavs.push_back({0, uav.latest_us});
      fastest_uav_m_s_ = std::max(fastest_uav_m_s_, uav.speed_m_s);
    }
    for (const Mover& worker : workers_.all()) {
      instance.partners.push_back({0, worker.latest_us, 0});
    }
    pairs_.n_workers = static_cast<std::int32_t>(workers_.all().size());
    for (const Participant& vehicle : participants_.vehicles) {
      const double rate_m_s = vehicle.agent->charge_rate_m_s;
      instance.partners.push_back({0, vehicle.latest_us, rate_m_s});
      fastest_charge_m_s_ = std::max(fastest_charge_m_s_, rate_m_s);
    }
    OpenAll();
    ChargeWorths();
    if (settings_.chains) NextTasks();

    std::array<SiteWays, 2> halves;
    ParallelFor(instance.capacity.size(), threads_, kManySites,
                [&](std::size_t begin, std::size_t end) {
                  SiteWays* ways = &halves[begin == 0 ? 0 : 1];
                  for (std::size_t s = begin; s < end; ++s) AddSite(s, ways);
                });
    Join(&halves[0], &halves[1]);
    return std::move(pairs_);
  }

 private:
  void OpenAll() {
    std::vector<std::int32_t>& ids = pairs_.site_ids;
    for (std::size_t x = 0; x < site_.tasks.size(); ++x) {
      if (open_.task[x]) ids.push_back(static_cast<std::int32_t>(x));
    }
    pairs_.n_tasks = static_cast<std::int32_t>(ids.size());
    pairs_.instance.capacity.assign(ids.size(), 1);
    for (std::size_t y = 0; y < site_.charging_points.size(); ++y) {
      if (open_.place[y] <= 0) continue;
      ids.push_back(static_cast<std::int32_t>(y));
      pairs_.instance.capacity.push_back(open_.place[y]);
    }
  }

  /// For each open task the others within the way that is expected to a next one.
  void NextTasks() {
    const auto n_tasks = At(pairs_.n_tasks);
    std::vector<Point> places;
    for (std::size_t s = 0; s < n_tasks; ++s) places.push_back(TaskAt(s).at);
    next_index_.emplace(places);
    next_radius_m_ =
        std::sqrt(site_.width_m * site_.height_m / std::max(1.0, static_cast<double>(n_tasks)));
  }

  /// Tasks that each UAV can still do, without and with charging first.
  void ChargeWorths() {
    const double open_tasks = std::max(1.0, static_cast<double>(pairs_.n_tasks));
    double cost = 0;
    for (std::size_t s = 0; s < At(pairs_.n_tasks); ++s) cost += TaskAt(s).cost_m;
    cost /= open_tasks;
    const double way =
        settings_.expected_way * std::sqrt(site_.width_m * site_.height_m / open_tasks);
    for (const Participant& uav : participants_.uavs) {
      const double full = uav.agent->range_full_m;
      if (!settings_.charge_by_use) {
        charge_worth_.push_back(0.1 * (1 + (full > 0 ? 1 - uav.range_m / full : 0)));
        continue;
      }
      const double interval = static_cast<double>(site_.rules.interval_us);
      const double each =
          interval *
          static_cast<double>(worths_.Decisions(TravelUs(way + cost, uav.agent->speed_m_s)));
      const double time = static_cast<double>(uav.until_us - uav.ready_us);
      const double to_charge = way / 2;
      const auto tasks = [&](double range_m, double time_us) {
        return std::max(
            0.0, std::min((range_m - to_charge) / (way + cost), std::floor(time_us / each + 0.25)));
      };
      const double enabled = std::min(tasks(full, time - interval), open_tasks) -
                             std::min(tasks(uav.range_m, time), open_tasks);
      charge_worth_.push_back(settings_.charge_worth * std::max(0.0, enabled));
    }
  }

  const Task& TaskAt(std::size_t s) const { return site_.tasks[At(pairs_.site_ids[s])]; }

  void AddSite(std::size_t s, SiteWays* ways) const {
    if (s < At(pairs_.n_tasks)) {
      AddTask(s, ways);
    } else {
      AddCharge(At(pairs_.site_ids[s]), ways);
    }
    ways->uav_end.push_back(static_cast<std::int32_t>(ways->uavs.size()));
    ways->partner_end.push_back(static_cast<std::int32_t>(ways->partners.size()));
  }

  std::int32_t Level(TimeUs arrive, TimeUs duration) const {
    return worths_.Level(arrive - situation_.now_us +
                         (settings_.true_duration ? duration : TimeUs{0}));
  }

  double Jitter(AgentKind kind, std::int32_t id, std::int32_t task) const {
    return JitterOf(situation_, settings_, kind, id, task);
  }

  double PartnerGain(const Mover& partner, TimeUs travel) const {
    if (!settings_.ties) return partner.idle_gain;
    return partner.idle_gain - settings_.partner_way * static_cast<double>(travel) /
                                   static_cast<double>(site_.rules.interval_us);
  }
  double UavGain(const Mover& uav, double way_m) const {
    return uav.idle_gain - (settings_.ties ? settings_.uav_way * way_m / uav.range_full_m : 0);
  }

  /// The UAVs near a place for which reaches(UAV, metres) holds, ascending.
  template <class Reaches>
  void FindUavs(Point place, SiteWays* ways, const Reaches& reaches) const {
    ways->near.clear();
    uavs_.Near(place, [&](std::int32_t u, double way_m) {
      if (reaches(uavs_[u], way_m)) ways->near.emplace_back(u, way_m);
    });
    if (!uavs_.ordered()) std::sort(ways->near.begin(), ways->near.end());
  }

  void AddPartners(const Movers& partners, std::int32_t first, Point at, TimeUs duration,
                   std::int32_t task, SiteWays* ways) const {
    ways->found.clear();
    ways->order.clear();
    partners.Near(at, [&](std::int32_t p, double way_m) {
      const Mover& partner = partners[p];
      const TimeUs travel = TravelUs(way_m, partner.speed_m_s);
      if (travel > partner.latest_us - partner.ready_us - duration) return;
      Instance::PartnerArc arc;
      arc.partner = first + p;
      arc.arrive_us = partner.ready_us + travel;
      arc.level = Level(arc.arrive_us, duration);
      arc.gain = PartnerGain(partner, travel);
      if (task >= 0) arc.gain += Jitter(AgentKind::kWorker, partner.id, task);
      arc.solo = false;
      ways->order.push_back(
          {static_cast<std::uint64_t>(arc.level) << 32 | static_cast<std::uint64_t>(arc.partner),
           ways->found.size()});
      ways->found.push_back(arc);
    });
    std::sort(ways->order.begin(), ways->order.end());
    for (const auto& [key, i] : ways->order) ways->partners.push_back(ways->found[i]);
  }

  /// The tasks that may follow this one, for a UAV of that speed.
  void FindNext(std::size_t s, double speed_m_s, SiteWays* ways) const {
    ways->next.clear();
    next_index_->Within(TaskAt(s).at, next_radius_m_, [&](std::int32_t i, double way_m) {
      if (At(i) == s) return;
      const Task& next = TaskAt(At(i));
      ways->next.emplace_back(
          way_m + next.cost_m + site_.task_to_charge_m[At(pairs_.site_ids[At(i)])],
          TravelUs(way_m, speed_m_s) + SensingUs(next.cost_m, speed_m_s));
    });
  }

  /// What it is worth to be at a task at `end` with that range: the best task that the UAV can do
  /// next, if any.
  double ChainGain(const Mover& uav, double range_m, TimeUs end, const SiteWays& ways) const {
    const TimeUs interval = site_.rules.interval_us;
    const TimeUs ready = DecisionAfter(end, interval);
    TimeUs first_end = kNever;
    for (const auto& [need_m, takes] : ways.next) {
      if (need_m <= range_m && ready + takes <= uav.latest_us) {
        first_end = std::min(first_end, ready + takes);
      }
    }
    if (first_end == kNever) return 0;
    return settings_.chain_worth * worths_.Of(worths_.Decisions(first_end - situation_.now_us));
  }

  void AddTask(std::size_t s, SiteWays* ways) const {
    const Task& task = TaskAt(s);
    const std::int32_t x = pairs_.site_ids[s];
    const double to_charge_m = site_.task_to_charge_m[At(x)];
    double speed_m_s = -1;  // that duration and next tasks are of
    TimeUs duration = 0;
    FindUavs(task.at, ways, [&](const Mover& uav, double way) {
      return CanSense(uav.range_m, way, task.cost_m, to_charge_m);
    });
    for (const auto& [u, way] : ways->near) {
      const Mover& uav = uavs_[u];
      if (uav.speed_m_s != speed_m_s) {
        speed_m_s = uav.speed_m_s;
        duration = SensingUs(task.cost_m, speed_m_s);
        if (settings_.chains) FindNext(s, speed_m_s, ways);
      }
      Instance::UavArc arc;
      arc.uav = u;
      arc.arrive_us = uav.ready_us + TravelUs(way, speed_m_s);
      arc.duration_us = duration;
      if (arc.arrive_us + duration > uav.latest_us) continue;
      arc.level = Level(arc.arrive_us, duration);
      arc.base = Worths::kParts;
      arc.pair_gain = UavGain(uav, way) + Jitter(AgentKind::kUav, uav.id, x);
      if (settings_.chains) {
        arc.pair_gain +=
            ChainGain(uav, uav.range_m - way - task.cost_m, arc.arrive_us + duration, *ways);
      }
      ways->uavs.push_back(arc);
    }
    AddPartners(workers_, 0, task.at,
                fastest_uav_m_s_ > 0 ? SensingUs(task.cost_m, fastest_uav_m_s_) : 0, x, ways);
  }

  void AddCharge(std::size_t y, SiteWays* ways) const {
    const Point at = site_.charging_points[y].at;
    TimeUs shortest = kNever;
    FindUavs(at, ways,
             [](const Mover& uav, double way) { return CanReachCharge(uav.range_m, way); });
    for (const auto& [u, way] : ways->near) {
      const Mover& uav = uavs_[u];
      if (charge_worth_[At(u)] <= 0) continue;
      Instance::UavArc arc;
      arc.uav = u;
      arc.arrive_us = uav.ready_us + TravelUs(way, uav.speed_m_s);
      arc.missing_m = uav.range_full_m - (uav.range_m - way);
      const TimeUs duration =
          fastest_charge_m_s_ > 0 ? TravelUs(arc.missing_m, fastest_charge_m_s_) : kNever;
      if (duration == kNever || arc.arrive_us + duration > uav.latest_us) continue;
      shortest = std::min(shortest, duration);
      arc.level = Level(arc.arrive_us, duration);
      arc.base = Worths::kParts * charge_worth_[At(u)];
      arc.pair_gain = UavGain(uav, way);
      ways->uavs.push_back(arc);
    }
    if (shortest == kNever) return;
    AddPartners(vehicles_, static_cast<std::int32_t>(workers_.all().size()), at, shortest, -1,
                ways);
  }

  /// The ways to all sites, those of the second run after those of the first.
  void Join(SiteWays* first, SiteWays* second) {
    Instance& instance = pairs_.instance;
    const auto join = [](auto* begins, auto* arcs, auto* run, const auto& ends) {
      const auto before = static_cast<std::int32_t>(arcs->size());
      if (arcs->empty()) {
        *arcs = std::move(*run);
      } else {
        arcs->insert(arcs->end(), run->begin(), run->end());
      }
      for (const std::int32_t end : ends) begins->push_back(before + end);
    };
    instance.uav_begin.push_back(0);
    instance.partner_begin.push_back(0);
    for (SiteWays* ways : {first, second}) {
      join(&instance.uav_begin, &instance.uav_arcs, &ways->uavs, ways->uav_end);
      join(&instance.partner_begin, &instance.partner_arcs, &ways->partners, ways->partner_end);
    }
  }

  const Situation& situation_;
  const Site& site_;
  const Participants& participants_;
  const OpenSites& open_;
  const HorizonSettings& settings_;
  int threads_;
  Worths worths_;
  Movers uavs_, workers_, vehicles_;
  PossiblePairs pairs_;
  std::vector<double> charge_worth_;  ///< [n_uavs]
  std::optional<GridIndex> next_index_;
  double next_radius_m_ = 0;
  double fastest_uav_m_s_ = 0, fastest_charge_m_s_ = 0;
};

}  // namespace

PossiblePairs FindPairs(const Situation& situation, const Participants& participants,
                        const OpenSites& open, const HorizonSettings& settings, int threads) {
  return PairFinder(situation, participants, open, settings, threads).Find();
}

Match MatchOf(const PossiblePairs& pairs, const Participants& participants, std::int32_t site,
              const Instance::UavArc& uav, const Instance::PartnerArc& partner) {
  Match match;
  match.charging = site >= pairs.n_tasks;
  match.uav = uav.uav;
  match.partner = match.charging ? partner.partner - pairs.n_workers : partner.partner;
  match.site = pairs.site_ids[At(site)];
  match.weight = Instance::PairWeight(uav, partner);
  const TimeUs duration =
      match.charging
          ? TravelUs(uav.missing_m, participants.vehicles[At(match.partner)].agent->charge_rate_m_s)
          : uav.duration_us;
  match.end_us = std::max(uav.arrive_us, partner.arrive_us) + duration;
  return match;
}

std::vector<Match> MatchesOf(const PossiblePairs& pairs, const Participants& participants,
                             const Assignment& assignment) {
  std::vector<Match> matches;
  for (const Assignment::Choice& choice : assignment.uavs) {
    if (choice.partner_arc < 0) continue;
    matches.push_back(MatchOf(pairs, participants, choice.site,
                              pairs.instance.uav_arcs[At(choice.uav_arc)],
                              pairs.instance.partner_arcs[At(choice.partner_arc)]));
  }
  return matches;
}

double JitterOf(const Situation& situation, const HorizonSettings& settings, AgentKind kind,
                std::int32_t id, std::int32_t task) {
  if (settings.jitter == 0) return 0;
  const auto entity = static_cast<std::uint64_t>(kind) << 60 |
                      static_cast<std::uint64_t>(settings.draw) << 50 |
                      static_cast<std::uint64_t>(id) << 25 | static_cast<std::uint64_t>(task);
  return Random(situation.site->seed, Stream::kPolicy, entity,
                static_cast<std::uint32_t>(situation.decision))
      .Uniform(-settings.jitter, settings.jitter);
}

}  // namespace muster::scheduler
