#include "scheduler/policies/horizon/pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "base/index.h"
#include "base/random.h"
#include "model/feasibility.h"
#include "model/place_index.h"
#include "scheduler/neighbourhood.h"
#include "scheduler/policies/horizon/worths.h"
#include "scheduler/solver/parallel.h"

namespace muster::scheduler {
namespace {

/// Sites and agents from which on two threads are worth while.
constexpr std::size_t kManySites = 512, kManyAgents = 1024;
constexpr std::size_t kManyOfBentWays = 256;  // agents, each of which takes long
/// Ways that memory is taken for at once.
constexpr std::size_t kFewWays = 4096;

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

std::vector<Mover> MoversOf(const std::vector<Participant>& participants,
                            const HorizonSettings& settings) {
  std::vector<Mover> movers;
  movers.reserve(participants.size());
  for (const Participant& p : participants) {
    const AgentState& agent = *p.agent;
    movers.push_back({p.at, agent.speed_m_s, p.ready_us, p.latest_us, p.range_m, agent.range_full_m,
                      p.reach_m(), p.idle ? 0 : settings.tentative - 1, agent.id});
  }
  return movers;
}

/// An agent's way to a site, which of it may turn out to be impossible.
struct Way {
  std::int32_t agent, site;
  double metres;
};

/// The ways of one class of agents to one kind of sites, by site, ascending by agent.
class SiteWays {
 public:
  /// Those that reach allows, and reaches(mover, site, metres).
  template <class Reaches>
  SiteWays(const std::vector<Mover>& movers, const PlaceIndex& sites, std::size_t n_sites,
           int threads, const Reaches& reaches) {
    std::array<std::vector<Way>, 2> halves;
    const std::size_t many = sites.straight() ? kManyAgents : kManyOfBentWays;
    ParallelFor(movers.size(), threads, many, [&](std::size_t begin, std::size_t end) {
      std::vector<Way>* found = &halves[begin == 0 ? 0 : 1];
      found->reserve(std::min((end - begin) * n_sites, kFewWays));
      for (std::size_t i = begin; i < end; ++i) {
        const auto may = [&](std::int32_t s, double metres) {
          return reaches(movers[i], At(s), metres);
        };
        sites.WithinFrom(movers[i].at, movers[i].reach_m, may, [&](std::int32_t s, double metres) {
          found->push_back({static_cast<std::int32_t>(i), s, metres});
        });
      }
    });
    begin_.assign(n_sites + 1, 0);
    for (const auto& half : halves) {
      for (const Way& way : half) ++begin_[At(way.site) + 1];
    }
    for (std::size_t s = 0; s < n_sites; ++s) begin_[s + 1] += begin_[s];
    ways_.resize(At(begin_.back()));
    std::vector<std::int32_t> next(begin_.begin(), begin_.end() - 1);
    for (const auto& half : halves) {
      for (const Way& way : half) ways_[At(next[At(way.site)]++)] = way;
    }
  }

  std::span<const Way> to(std::size_t site) const {
    return {ways_.data() + begin_[site], ways_.data() + begin_[site + 1]};
  }
  /// To the sites [begin, end).
  std::size_t count(std::size_t begin, std::size_t end) const {
    return At(begin_[end] - begin_[begin]);
  }

 private:
  std::vector<std::int32_t> begin_;  ///< [n_sites + 1]
  std::vector<Way> ways_;
};

/// The arcs of a run of sites, and what is at hand while they are made.
struct Arcs {
  std::vector<Instance::UavArc> uavs;
  std::vector<Instance::PartnerArc> partners;
  std::vector<std::int32_t> uav_end, partner_end;  ///< [sites of the run]

  std::vector<std::pair<double, TimeUs>> next;  ///< tasks close by: range needed, duration
  std::vector<Instance::PartnerArc> found;      ///< of a site, in any order
  std::vector<std::uint64_t> order;             ///< of these: level, then number in `found`
};

class PairFinder {
 public:
  PairFinder(const Situation& situation, const Participants& participants, const OpenSites& open,
             const HorizonSettings& settings, int threads)
      : situation_(situation),
        site_(*situation.site),
        participants_(participants),
        settings_(settings),
        threads_(threads),
        worths_(situation, settings),
        outlook_(OutlookOf(situation, open)),
        uavs_(MoversOf(participants.uavs, settings)),
        workers_(MoversOf(participants.workers, settings)),
        vehicles_(MoversOf(participants.vehicles, settings)),
        pairs_(OpenAll(open)),
        task_at_(TaskPlaces()),
        charge_at_(ChargePlaces()),
        tasks_(task_at_, Of(AgentKind::kUav)),
        uavs_to_task_(uavs_, tasks_, n_tasks(), threads,
                      [&](const Mover& uav, std::size_t s, double way_m) {
                        return CanSense(uav.range_m, way_m, TaskAt(s).cost_m, ToChargeFrom(s)) &&
                               MayDo(AgentKind::kUav, uav, s);
                      }),
        uavs_to_charge_(uavs_, PlaceIndex(charge_at_, Of(AgentKind::kUav)), n_charges(), threads,
                        kAnybody),
        workers_to_task_(workers_, PlaceIndex(task_at_, Of(AgentKind::kWorker)), n_tasks(), threads,
                         [&](const Mover& worker, std::size_t s, double) {
                           return MayDo(AgentKind::kWorker, worker, s);
                         }),
        vehicles_to_charge_(vehicles_, PlaceIndex(charge_at_, Of(AgentKind::kVehicle)), n_charges(),
                            threads, kAnybody) {}

  PossiblePairs Find() {
    Instance& instance = pairs_.instance;
    const Neighbourhoods neighbourhoods(site_);
    const bool by_place = ByNeighbourhood(situation_);
    for (const Mover& uav : uavs_) {
      instance.uavs.push_back(
          {0, uav.latest_us, by_place ? neighbourhoods.Of(uav.at) : std::uint32_t{0}});
      fastest_uav_m_s_ = std::max(fastest_uav_m_s_, uav.speed_m_s);
    }
    for (const Mover& worker : workers_) instance.partners.push_back({0, worker.latest_us, 0});
    pairs_.n_workers = static_cast<std::int32_t>(workers_.size());
    for (const Participant& vehicle : participants_.vehicles) {
      const double rate_m_s = vehicle.agent->charge_rate_m_s;
      instance.partners.push_back({0, vehicle.latest_us, rate_m_s});
      fastest_charge_m_s_ = std::max(fastest_charge_m_s_, rate_m_s);
    }
    ChargeWorths();
    std::array<Arcs, 2> halves;
    ParallelFor(
        instance.capacity.size(), threads_, kManySites, [&](std::size_t begin, std::size_t end) {
          Arcs* arcs = &halves[begin == 0 ? 0 : 1];
          arcs->uavs.reserve(CountWays(uavs_to_task_, uavs_to_charge_, begin, end));
          arcs->partners.reserve(CountWays(workers_to_task_, vehicles_to_charge_, begin, end));
          for (std::size_t s = begin; s < end; ++s) AddSite(s, arcs);
        });
    Join(&halves[0], &halves[1]);
    return std::move(pairs_);
  }

 private:
  bool MayDo(AgentKind kind, const Mover& mover, std::size_t s) const {
    return !site_.Forbids({kind, mover.id, pairs_.site_ids[s]});
  }
  static constexpr auto kAnybody = [](const Mover&, std::size_t, double) { return true; };

  /// The open sites, tasks first.
  PossiblePairs OpenAll(const OpenSites& open) const {
    std::vector<std::int32_t> tasks, charges;
    for (std::size_t x = 0; x < site_.tasks.size(); ++x) {
      if (open.task[x]) tasks.push_back(static_cast<std::int32_t>(x));
    }
    for (std::size_t y = 0; y < site_.charging_points.size(); ++y) {
      if (open.place[y] > 0) charges.push_back(static_cast<std::int32_t>(y));
    }
    if (ByNeighbourhood(situation_)) {
      const Neighbourhoods neighbourhoods(site_);
      neighbourhoods.Sort(&tasks, [&](std::int32_t x) { return site_.tasks[At(x)].at; });
      neighbourhoods.Sort(&charges,
                          [&](std::int32_t y) { return site_.charging_points[At(y)].at; });
    }
    PossiblePairs pairs;
    pairs.n_tasks = static_cast<std::int32_t>(tasks.size());
    pairs.instance.capacity.assign(tasks.size(), 1);
    for (const std::int32_t y : charges) pairs.instance.capacity.push_back(open.place[At(y)]);
    pairs.site_ids = std::move(tasks);
    pairs.site_ids.insert(pairs.site_ids.end(), charges.begin(), charges.end());
    return pairs;
  }
  std::size_t n_tasks() const { return At(pairs_.n_tasks); }
  std::size_t n_charges() const { return pairs_.site_ids.size() - n_tasks(); }
  const Task& TaskAt(std::size_t s) const { return site_.tasks[At(pairs_.site_ids[s])]; }
  double ToChargeFrom(std::size_t s) const {
    return site_.task_to_charge_m[At(pairs_.site_ids[s])];
  }
  Point ChargeAt(std::size_t k) const {
    return site_.charging_points[At(pairs_.site_ids[n_tasks() + k])].at;
  }
  std::vector<Point> TaskPlaces() const {
    std::vector<Point> places;
    for (std::size_t s = 0; s < n_tasks(); ++s) places.push_back(TaskAt(s).at);
    return places;
  }
  std::vector<Point> ChargePlaces() const {
    std::vector<Point> places;
    for (std::size_t k = 0; k < n_charges(); ++k) places.push_back(ChargeAt(k));
    return places;
  }
  WaysOf Of(AgentKind kind) const { return {site_.ways.get(), kind}; }
  /// Tasks that each UAV can still do, without and with charging first.
  void ChargeWorths() {
    const double open_tasks = outlook_.open_tasks, cost = outlook_.cost_m;
    const double way = settings_.expected_way * outlook_.way_m;
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

  /// Ways to the sites [begin, end).
  std::size_t CountWays(const SiteWays& to_task, const SiteWays& to_charge, std::size_t begin,
                        std::size_t end) const {
    const auto charge = [&](std::size_t s) { return s < n_tasks() ? 0 : s - n_tasks(); };
    return to_task.count(std::min(begin, n_tasks()), std::min(end, n_tasks())) +
           to_charge.count(charge(begin), charge(end));
  }

  void AddSite(std::size_t s, Arcs* arcs) const {
    if (s < n_tasks()) {
      AddTask(s, arcs);
    } else {
      AddCharge(s - n_tasks(), arcs);
    }
    arcs->uav_end.push_back(static_cast<std::int32_t>(arcs->uavs.size()));
    arcs->partner_end.push_back(static_cast<std::int32_t>(arcs->partners.size()));
  }

  std::int32_t Level(TimeUs arrive, TimeUs duration) const {
    return worths_.Level(arrive - situation_.now_us +
                         (settings_.true_duration ? duration : TimeUs{0}));
  }

  double ChanceOf(AgentKind kind, std::int32_t id, std::int32_t task) const {
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

  /// `task`: its id, -1 for charging. `late_loss`: what a partner costs that is there after the
  /// task is due, in tasks.
  void AddPartners(std::span<const Way> ways, const std::vector<Mover>& partners,
                   std::int32_t first, TimeUs duration, std::int32_t task, double late_loss,
                   Arcs* arcs) const {
    arcs->found.clear();
    arcs->order.clear();
    for (const Way& way : ways) {
      const Mover& partner = partners[At(way.agent)];
      const TimeUs travel = TravelUs(way.metres, partner.speed_m_s);
      if (travel > partner.latest_us - partner.ready_us - duration) continue;
      Instance::PartnerArc arc;
      arc.partner = first + way.agent;
      arc.arrive_us = partner.ready_us + travel;
      arc.level = Level(arc.arrive_us, duration);
      arc.gain = PartnerGain(partner, travel);
      if (task >= 0) {
        if (!site_.tasks[At(task)].AllowsStart(arc.arrive_us)) continue;
        arc.gain += ChanceOf(AgentKind::kWorker, partner.id, task);
        if (arc.arrive_us > site_.tasks[At(task)].due_us) arc.gain -= late_loss;
      }
      arc.solo = false;
      arcs->order.push_back(static_cast<std::uint64_t>(arc.level) << 32 | arcs->found.size());
      arcs->found.push_back(arc);
    }
    // By level, then by partner, as `found` is by partner.
    std::sort(arcs->order.begin(), arcs->order.end());
    for (const std::uint64_t key : arcs->order) {
      arcs->partners.push_back(arcs->found[key & 0xFFFFFFFFu]);
    }
  }

  /// The open tasks within the way that is expected to a next one, for a UAV of that speed.
  void FindNext(std::size_t s, double speed_m_s, Arcs* arcs) const {
    arcs->next.clear();
    tasks_.WithinFrom(TaskAt(s).at, outlook_.way_m, [&](std::int32_t i, double way_m) {
      if (At(i) == s) return;
      const double cost_m = TaskAt(At(i)).cost_m;
      arcs->next.emplace_back(way_m + cost_m + ToChargeFrom(At(i)),
                              TravelUs(way_m, speed_m_s) + SensingUs(cost_m, speed_m_s));
    });
  }

  /// What it is worth to be at a task at `end` with that range: the best task that the UAV can do
  /// next, if any.
  double ChainGain(const Mover& uav, double range_m, TimeUs end, const Arcs& arcs) const {
    const TimeUs ready = DecisionAfter(end, site_.rules.interval_us);
    TimeUs first_end = kNever;
    for (const auto& [need_m, takes] : arcs.next) {
      if (need_m <= range_m && ready + takes <= uav.latest_us) {
        first_end = std::min(first_end, ready + takes);
      }
    }
    if (first_end == kNever) return 0;
    return settings_.chain_worth * worths_.Of(worths_.Decisions(first_end - situation_.now_us));
  }

  void AddTask(std::size_t s, Arcs* arcs) const {
    const Task& task = TaskAt(s);
    const std::int32_t x = pairs_.site_ids[s];
    bool in_time = false;   // some UAV is there before it is due
    double speed_m_s = -1;  // that duration and next tasks are of
    TimeUs duration = 0;
    for (const Way& way : uavs_to_task_.to(s)) {
      const Mover& uav = uavs_[At(way.agent)];
      if (uav.speed_m_s != speed_m_s) {
        speed_m_s = uav.speed_m_s;
        duration = SensingUs(task.cost_m, speed_m_s);
        if (settings_.chains) FindNext(s, speed_m_s, arcs);
      }
      Instance::UavArc arc;
      arc.uav = way.agent;
      arc.arrive_us = uav.ready_us + TravelUs(way.metres, speed_m_s);
      arc.duration_us = duration;
      if (arc.arrive_us + duration > uav.latest_us || !task.AllowsStart(arc.arrive_us)) continue;
      arc.level = Level(arc.arrive_us, duration);
      in_time |= arc.arrive_us <= task.due_us;
      arc.base = Worths::kParts * WorthOf(task, arc.arrive_us, site_.rules);
      arc.pair_gain = UavGain(uav, way.metres) + ChanceOf(AgentKind::kUav, uav.id, x);
      if (settings_.chains) {
        arc.pair_gain +=
            ChainGain(uav, uav.range_m - way.metres - task.cost_m, arc.arrive_us + duration, *arcs);
      }
      arcs->uavs.push_back(arc);
    }
    const double late_loss =
        in_time ? WorthOf(task, 0, site_.rules) - WorthOf(task, kNever, site_.rules) : 0;
    AddPartners(workers_to_task_.to(s), workers_, 0,
                fastest_uav_m_s_ > 0 ? SensingUs(task.cost_m, fastest_uav_m_s_) : 0, x, late_loss,
                arcs);
  }

  void AddCharge(std::size_t k, Arcs* arcs) const {
    TimeUs shortest = kNever;
    for (const Way& way : uavs_to_charge_.to(k)) {
      const Mover& uav = uavs_[At(way.agent)];
      const double worth = charge_worth_[At(way.agent)];
      if (!CanReachCharge(uav.range_m, way.metres) || worth <= 0) continue;
      Instance::UavArc arc;
      arc.uav = way.agent;
      arc.arrive_us = uav.ready_us + TravelUs(way.metres, uav.speed_m_s);
      arc.missing_m = uav.range_full_m - (uav.range_m - way.metres);
      const TimeUs duration =
          fastest_charge_m_s_ > 0 ? ChargingUs(arc.missing_m, fastest_charge_m_s_) : kNever;
      if (duration == kNever || arc.arrive_us + duration > uav.latest_us) continue;
      shortest = std::min(shortest, duration);
      arc.level = Level(arc.arrive_us, duration);
      arc.base = Worths::kParts * worth;
      arc.pair_gain = UavGain(uav, way.metres);
      arcs->uavs.push_back(arc);
    }
    if (shortest == kNever) return;
    AddPartners(vehicles_to_charge_.to(k), vehicles_, static_cast<std::int32_t>(workers_.size()),
                shortest, -1, 0, arcs);
  }

  /// The arcs of all sites, those of the second run after those of the first.
  void Join(Arcs* first, Arcs* second) {
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
    for (Arcs* run : {first, second}) {
      join(&instance.uav_begin, &instance.uav_arcs, &run->uavs, run->uav_end);
      join(&instance.partner_begin, &instance.partner_arcs, &run->partners, run->partner_end);
    }
  }

  const Situation& situation_;
  const Site& site_;
  const Participants& participants_;
  const HorizonSettings& settings_;
  int threads_;
  Worths worths_;
  Outlook outlook_;
  std::vector<Mover> uavs_, workers_, vehicles_;
  PossiblePairs pairs_;
  std::vector<Point> task_at_, charge_at_;  ///< of the open ones, in the order of the sites
  PlaceIndex tasks_;                        ///< as UAVs reach them
  SiteWays uavs_to_task_, uavs_to_charge_, workers_to_task_, vehicles_to_charge_;
  std::vector<double> charge_worth_;  ///< [n_uavs]
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
      match.charging ? ChargingUs(uav.missing_m,
                                  participants.vehicles[At(match.partner)].agent->charge_rate_m_s)
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
  const std::uint64_t seed = situation.site->seed;
  const auto agent_and_task = static_cast<std::uint64_t>(kind) << 60 |
                              static_cast<std::uint64_t>(id) << 25 |
                              static_cast<std::uint64_t>(task);
  double sum = 0;
  for (const Jitter& jitter : settings.jitters) {
    if (jitter.most == 0) continue;
    sum += Random(seed, Stream::kPolicy,
                  agent_and_task | static_cast<std::uint64_t>(jitter.draw) << 50,
                  static_cast<std::uint32_t>(situation.decision))
               .Uniform(-jitter.most, jitter.most);
  }
  if (settings.task_draws && At(task) < settings.task_draws->of.size()) {
    const TaskDraws& draws = *settings.task_draws;
    if (const std::uint32_t draw = draws.of[At(task)]; draw != 0) {
      sum +=
          Random(seed, Stream::kPlanSearch, agent_and_task, draw).Uniform(-draws.most, draws.most);
    }
  }
  return sum;
}

}  // namespace muster::scheduler
