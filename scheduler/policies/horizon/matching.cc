#include "scheduler/policies/horizon/matching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/grid_index.h"
#include "base/index.h"
#include "base/random.h"
#include "model/feasibility.h"
#include "scheduler/solver/solver.h"

namespace muster::scheduler {
namespace {

/// Instance takes a pair's worth as base / level with whole levels. A level is here the reciprocal
/// of the worth per unit of base in these parts, so a worth is off by at most 0.2 %.
constexpr double kParts = 256;

/// Ways that end too late with any partner are left out, which only makes the instance smaller:
/// Instance::Compatible refuses every pair that ends too late.
class Builder {
 public:
  Builder(const Situation& situation, const Participants& participants, const OpenSites& open,
          const HorizonSettings& settings)
      : situation_(situation),
        site_(*situation.site),
        uavs_(participants.uavs),
        workers_(participants.workers),
        vehicles_(participants.vehicles),
        open_(open),
        settings_(settings) {}

  Instance Build() {
    for (const Participant& uav : uavs_) {
      instance_.uavs.push_back({0, uav.latest_us});
      fastest_uav_m_s_ = std::max(fastest_uav_m_s_, uav.agent->speed_m_s);
    }
    for (const Participant& worker : workers_)
      instance_.partners.push_back({0, worker.latest_us, 0});
    for (const Participant& vehicle : vehicles_) {
      instance_.partners.push_back({0, vehicle.latest_us, vehicle.agent->charge_rate_m_s});
      fastest_charge_m_s_ = std::max(fastest_charge_m_s_, vehicle.agent->charge_rate_m_s);
    }
    ChargeWorths();
    if (settings_.chains) NextTasks();
    for (std::size_t x = 0; x < site_.tasks.size(); ++x) {
      if (open_.task[x]) AddTask(static_cast<std::int32_t>(x));
    }
    for (std::size_t y = 0; y < site_.charging_points.size(); ++y) {
      if (open_.place[y] > 0) AddCharge(static_cast<std::int32_t>(y));
    }
    instance_.uav_begin.push_back(static_cast<std::int32_t>(instance_.uav_arcs.size()));
    instance_.partner_begin.push_back(static_cast<std::int32_t>(instance_.partner_arcs.size()));
    return std::move(instance_);
  }
  const std::vector<std::int32_t>& site_ids() const { return site_ids_; }
  std::int32_t n_tasks() const { return n_tasks_; }

 private:
  double Worth(std::int64_t decisions) const {
    return std::pow(static_cast<double>(decisions), -settings_.patience);
  }

  /// Level of a pair whose last member arrives at `arrive` and that then takes `duration`.
  std::int32_t Level(TimeUs arrive, TimeUs duration) const {
    const TimeUs interval = site_.rules.interval_us;
    const TimeUs took =
        arrive - situation_.now_us + (settings_.true_duration ? duration : TimeUs{0});
    const std::int64_t decisions = Intervals(took, interval);
    double worth = Worth(decisions);
    if (settings_.ties) {
      const double into =
          static_cast<double>(took - (decisions - 1) * interval) / static_cast<double>(interval);
      const double next = Worth(decisions + 1);
      worth -= settings_.finish_weight * std::max(0.0, into) * (worth - next);
    }
    return std::max(1, static_cast<std::int32_t>(std::lround(kParts / worth)));
  }

  /// For each open task the others within the way that is expected to a next one.
  void NextTasks() {
    std::vector<Point> places;
    std::vector<std::int32_t> ids;
    for (std::size_t x = 0; x < site_.tasks.size(); ++x) {
      if (!open_.task[x]) continue;
      places.push_back(site_.tasks[x].at);
      ids.push_back(static_cast<std::int32_t>(x));
    }
    const GridIndex index(places);
    const double radius_m =
        std::sqrt(site_.width_m * site_.height_m / std::max(1.0, static_cast<double>(ids.size())));
    next_tasks_.resize(site_.tasks.size());
    for (const std::int32_t x : ids) {
      index.Within(site_.tasks[At(x)].at, radius_m, [&](std::int32_t i, double way_m) {
        if (ids[At(i)] != x) next_tasks_[At(x)].push_back({ids[At(i)], way_m});
      });
    }
  }

  /// What it is worth to be at a task at `end` with that range: the best task that the UAV can do
  /// next, if any.
  double ChainGain(const Participant& uav, double range_m, TimeUs end, std::int32_t task) const {
    const TimeUs interval = site_.rules.interval_us;
    const TimeUs ready = DecisionAfter(end, interval);
    double best = 0;
    for (const auto& [y, way_m] : next_tasks_[At(task)]) {
      const Task& next = site_.tasks[At(y)];
      if (!CanSense(range_m, way_m, next.cost_m, site_.task_to_charge_m[At(y)])) continue;
      const TimeUs next_end = ready + TravelUs(way_m, uav.agent->speed_m_s) +
                              SensingUs(next.cost_m, uav.agent->speed_m_s);
      if (next_end > uav.latest_us) continue;
      best = std::max(best, Worth(Intervals(next_end - situation_.now_us, interval)));
    }
    return settings_.chain_worth * best;
  }

  /// Tasks that each UAV can still do, without and with charging first.
  void ChargeWorths() {
    const double open_tasks =
        std::max(1.0, static_cast<double>(std::count(open_.task.begin(), open_.task.end(), 1)));
    double cost = 0;
    for (std::size_t x = 0; x < site_.tasks.size(); ++x) {
      if (open_.task[x]) cost += site_.tasks[x].cost_m;
    }
    cost /= open_tasks;
    const double way =
        settings_.expected_way * std::sqrt(site_.width_m * site_.height_m / open_tasks);
    for (const Participant& uav : uavs_) {
      const double full = uav.agent->range_full_m;
      if (!settings_.charge_by_use) {
        charge_worth_.push_back(0.1 * (1 + (full > 0 ? 1 - uav.range_m / full : 0)));
        continue;
      }
      const double interval = static_cast<double>(site_.rules.interval_us);
      const double each =
          interval * static_cast<double>(Intervals(TravelUs(way + cost, uav.agent->speed_m_s),
                                                   site_.rules.interval_us));
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

  double Jitter(AgentKind kind, std::int32_t id, std::int32_t task) const {
    return JitterOf(situation_, settings_, kind, id, task);
  }

  double PartnerGain(const Participant& partner, TimeUs travel) const {
    if (!settings_.ties) return partner.idle ? 0 : settings_.tentative - 1;
    return (partner.idle ? 0 : settings_.tentative - 1) -
           settings_.partner_way * static_cast<double>(travel) /
               static_cast<double>(site_.rules.interval_us);
  }
  double UavGain(const Participant& uav, double way_m) const {
    return (uav.idle ? 0 : settings_.tentative - 1) -
           (settings_.ties ? settings_.uav_way * way_m / uav.agent->range_full_m : 0);
  }

  void Open(std::int32_t id, std::int32_t capacity) {
    site_ids_.push_back(id);
    instance_.capacity.push_back(capacity);
    instance_.uav_begin.push_back(static_cast<std::int32_t>(instance_.uav_arcs.size()));
    instance_.partner_begin.push_back(static_cast<std::int32_t>(instance_.partner_arcs.size()));
  }
  void AddPartners(const std::vector<Participant>& partners, std::int32_t first, Point at,
                   TimeUs duration, std::int32_t task = -1) {
    for (std::size_t p = 0; p < partners.size(); ++p) {
      const Participant& partner = partners[p];
      const TimeUs travel = TravelUs(Distance(partner.at, at), partner.agent->speed_m_s);
      if (travel == kNever) continue;
      const TimeUs arrive = partner.ready_us + travel;
      if (arrive + duration > partner.latest_us) continue;
      Instance::PartnerArc arc;
      arc.partner = first + static_cast<std::int32_t>(p);
      arc.level = Level(arrive, duration);
      arc.gain = PartnerGain(partner, travel);
      if (task >= 0) arc.gain += Jitter(AgentKind::kWorker, partner.agent->id, task);
      arc.arrive_us = arrive;
      arc.solo = false;
      instance_.partner_arcs.push_back(arc);
    }
    const auto begin = instance_.partner_arcs.begin() + instance_.partner_begin.back();
    std::sort(begin, instance_.partner_arcs.end(), [](const auto& a, const auto& b) {
      return a.level != b.level ? a.level < b.level : a.partner < b.partner;
    });
  }

  void AddTask(std::int32_t x) {
    ++n_tasks_;
    Open(x, 1);
    const Task& task = site_.tasks[At(x)];
    for (std::size_t u = 0; u < uavs_.size(); ++u) {
      const Participant& uav = uavs_[u];
      const double way = Distance(uav.at, task.at);
      if (!CanSense(uav.range_m, way, task.cost_m, site_.task_to_charge_m[At(x)])) continue;
      Instance::UavArc arc;
      arc.uav = static_cast<std::int32_t>(u);
      arc.arrive_us = uav.ready_us + TravelUs(way, uav.agent->speed_m_s);
      arc.duration_us = SensingUs(task.cost_m, uav.agent->speed_m_s);
      if (arc.arrive_us + arc.duration_us > uav.latest_us) continue;
      arc.level = Level(arc.arrive_us, arc.duration_us);
      arc.base = kParts;
      arc.pair_gain = UavGain(uav, way) + Jitter(AgentKind::kUav, uav.agent->id, x);
      if (settings_.chains) {
        arc.pair_gain +=
            ChainGain(uav, uav.range_m - way - task.cost_m, arc.arrive_us + arc.duration_us, x);
      }
      instance_.uav_arcs.push_back(arc);
    }
    AddPartners(workers_, 0, task.at,
                fastest_uav_m_s_ > 0 ? SensingUs(task.cost_m, fastest_uav_m_s_) : 0, x);
  }

  void AddCharge(std::int32_t y) {
    Open(y, open_.place[At(y)]);
    const Point at = site_.charging_points[At(y)].at;
    TimeUs shortest = kNever;
    for (std::size_t u = 0; u < uavs_.size(); ++u) {
      const Participant& uav = uavs_[u];
      const double way = Distance(uav.at, at);
      if (!CanReachCharge(uav.range_m, way) || charge_worth_[u] <= 0) continue;
      Instance::UavArc arc;
      arc.uav = static_cast<std::int32_t>(u);
      arc.arrive_us = uav.ready_us + TravelUs(way, uav.agent->speed_m_s);
      arc.missing_m = uav.agent->range_full_m - (uav.range_m - way);
      const TimeUs duration =
          fastest_charge_m_s_ > 0 ? TravelUs(arc.missing_m, fastest_charge_m_s_) : kNever;
      if (duration == kNever || arc.arrive_us + duration > uav.latest_us) continue;
      shortest = std::min(shortest, duration);
      arc.level = Level(arc.arrive_us, duration);
      arc.base = kParts * charge_worth_[u];
      arc.pair_gain = UavGain(uav, way);
      instance_.uav_arcs.push_back(arc);
    }
    if (shortest == kNever) return;
    AddPartners(vehicles_, static_cast<std::int32_t>(workers_.size()), at, shortest);
  }

  const Situation& situation_;
  const Site& site_;
  const std::vector<Participant>&uavs_, &workers_, &vehicles_;
  const OpenSites& open_;
  const HorizonSettings& settings_;
  Instance instance_;
  std::vector<std::int32_t> site_ids_;
  std::vector<double> charge_worth_;                                      ///< [n_uavs]
  std::vector<std::vector<std::pair<std::int32_t, double>>> next_tasks_;  ///< [n_tasks] id, way_m
  std::int32_t n_tasks_ = 0;
  double fastest_uav_m_s_ = 0, fastest_charge_m_s_ = 0;
};

}  // namespace

TimeUs DecisionAfter(TimeUs t, TimeUs interval_us) {
  return (t + interval_us - 1) / interval_us * interval_us;
}

Participants ParticipantsOf(const Situation& situation, const HorizonSettings& settings) {
  Participants participants;
  const Rules& rules = situation.site->rules;
  for (const AgentKind kind : kAgentKinds) {
    for (const AgentState& agent : situation.agents(kind)) {
      Participant participant;
      participant.agent = &agent;
      participant.idle = agent.idle(situation.now_us);
      participant.until_us = std::min(agent.online_until_us, rules.limit_us);
      // Even where an action may overrun its agents' time, what ends after the limit is lost.
      participant.latest_us = std::min(LatestEnd(agent, rules), rules.limit_us);
      if (participant.idle) {
        participant.at = agent.to;
        participant.ready_us = situation.now_us;
        participant.range_m = situation.range_m(agent);
      } else {
        if (!settings.soon_idle || agent.failed || agent.busy_until_us == kNever) continue;
        participant.at = agent.to;
        participant.ready_us = DecisionAfter(agent.busy_until_us, rules.interval_us);
        if (participant.ready_us - situation.now_us > settings.soon_decisions * rules.interval_us ||
            participant.ready_us >= rules.limit_us || !agent.online(participant.ready_us)) {
          continue;
        }
        participant.range_m = RangeAt(agent, agent.busy_until_us, situation.site->tasks);
      }
      participants[kind].push_back(participant);
    }
  }
  return participants;
}

OpenSites OpenSitesOf(const Situation& situation) {
  OpenSites open;
  for (const TaskStatus status : situation.task_status) {
    open.task.push_back(status == TaskStatus::kOpen ? 1 : 0);
  }
  for (std::size_t y = 0; y < situation.site->charging_points.size(); ++y) {
    open.place.push_back(situation.free_places(ChargeId(y)));
  }
  return open;
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

PairInstance PairsToMatch(const Situation& situation, const Participants& participants,
                          const OpenSites& open, const HorizonSettings& settings) {
  Builder builder(situation, participants, open, settings);
  PairInstance pairs;
  pairs.instance = builder.Build();
  pairs.site_ids = builder.site_ids();
  pairs.n_tasks = builder.n_tasks();
  pairs.n_workers = static_cast<std::int32_t>(participants.workers.size());
  return pairs;
}

Match MatchOf(const PairInstance& pairs, const Participants& participants, std::int32_t site,
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

std::vector<Match> MatchesOf(const PairInstance& pairs, const Participants& participants,
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

std::vector<Match> HeaviestPairs(const Situation& situation, const Participants& participants,
                                 const OpenSites& open, const HorizonSettings& settings,
                                 std::int64_t* candidates) {
  const PairInstance pairs = PairsToMatch(situation, participants, open, settings);
  if (candidates != nullptr) *candidates = CountNodes(pairs.instance);
  return MatchesOf(pairs, participants, Solve(pairs.instance).assignment);
}

}  // namespace muster::scheduler
