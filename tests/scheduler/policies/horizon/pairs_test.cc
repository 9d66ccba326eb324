#include "scheduler/policies/horizon/pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "base/random.h"
#include "tests/model/manhattan_ways.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;

std::size_t At(std::int64_t i) { return static_cast<std::size_t>(i); }

/// Every agent at every site, one after the other, by the definitions of
/// docs/reference/scheduling.md.
class Trial {
 public:
  Trial(const Situation& situation, const Participants& participants,
        const HorizonSettings& settings)
      : situation_(situation),
        site_(*situation.site),
        participants_(participants),
        settings_(settings) {}

  double Worth(std::int64_t decisions) const {
    return std::pow(static_cast<double>(decisions), -settings_.patience);
  }
  std::int64_t Decisions(TimeUs took) const { return Intervals(took, site_.rules.interval_us); }

  std::int32_t Level(TimeUs arrive, TimeUs duration) const {
    const TimeUs interval = site_.rules.interval_us;
    const TimeUs took = arrive - situation_.now_us + (settings_.true_duration ? duration : 0);
    double worth = Worth(Decisions(took));
    if (settings_.ties) {
      const double into = static_cast<double>(took - (Decisions(took) - 1) * interval) /
                          static_cast<double>(interval);
      const double next = Worth(Decisions(took) + 1);
      worth -= settings_.finish_weight * std::max(0.0, into) * (worth - next);
    }
    return std::max(1, static_cast<std::int32_t>(std::lround(256 / worth)));
  }

  double ChanceOf(AgentKind kind, std::int32_t id, std::int32_t task) const {
    double sum = 0;
    for (const auto& [most, draw] : settings_.jitters) {
      if (most == 0) continue;
      const auto entity = static_cast<std::uint64_t>(kind) << 60 |
                          static_cast<std::uint64_t>(draw) << 50 |
                          static_cast<std::uint64_t>(id) << 25 | static_cast<std::uint64_t>(task);
      sum += Random(site_.seed, Stream::kPolicy, entity,
                    static_cast<std::uint32_t>(situation_.decision))
                 .Uniform(-most, most);
    }
    return sum;
  }

  double IdleGain(const Participant& p) const { return p.idle ? 0 : settings_.tentative - 1; }

  double UavGain(const Participant& uav, double way) const {
    return IdleGain(uav) - (settings_.ties ? settings_.uav_way * way / uav.agent->range_full_m : 0);
  }

  double ChainGain(const Participant& uav, double range, TimeUs end, std::int32_t task) const {
    if (!settings_.chains) return 0;
    const TimeUs interval = site_.rules.interval_us;
    const auto open =
        std::count(situation_.task_status.begin(), situation_.task_status.end(), TaskStatus::kOpen);
    const double radius = std::sqrt(site_.width_m * site_.height_m / static_cast<double>(open));
    double best = 0;
    for (std::size_t y = 0; y < site_.tasks.size(); ++y) {
      const double way =
          site_.ways->Length(AgentKind::kUav, site_.tasks[At(task)].at, site_.tasks[y].at);
      if (y == At(task) || situation_.task_status[y] != TaskStatus::kOpen || way > radius) continue;
      if (!CanSense(range, way, site_.tasks[y].cost_m, site_.task_to_charge_m[y])) continue;
      const TimeUs next = (end + interval - 1) / interval * interval +
                          TravelUs(way, uav.agent->speed_m_s) +
                          SensingUs(site_.tasks[y].cost_m, uav.agent->speed_m_s);
      if (next <= uav.latest_us) best = std::max(best, Worth(Decisions(next - situation_.now_us)));
    }
    return settings_.chain_worth * best;
  }

  /// (arrival, level, gain) of the UAV's way to the task; nothing: not possible.
  std::vector<std::tuple<std::int32_t, std::int32_t, TimeUs, double>> UavsTo(std::int32_t x) const {
    std::vector<std::tuple<std::int32_t, std::int32_t, TimeUs, double>> ways;
    const Task& task = site_.tasks[At(x)];
    for (std::size_t u = 0; u < participants_.uavs.size(); ++u) {
      const Participant& uav = participants_.uavs[u];
      const double way = uav.agent->WayM(uav.at, task.at);
      if (!CanSense(uav.range_m, way, task.cost_m, site_.task_to_charge_m[At(x)])) continue;
      const TimeUs arrive = uav.ready_us + TravelUs(way, uav.agent->speed_m_s);
      const TimeUs duration = SensingUs(task.cost_m, uav.agent->speed_m_s);
      if (arrive + duration > uav.latest_us) continue;
      const double gain = UavGain(uav, way) + ChanceOf(AgentKind::kUav, uav.agent->id, x) +
                          ChainGain(uav, uav.range_m - way - task.cost_m, arrive + duration, x);
      ways.emplace_back(u, Level(arrive, duration), arrive, gain);
    }
    return ways;
  }

  /// The same of partners, that then take at least `duration`, by level; (level, partner, ...).
  std::vector<std::tuple<std::int32_t, std::int32_t, TimeUs, double>> PartnersTo(
      AgentKind kind, std::int32_t first, Point at, TimeUs duration, std::int32_t task) const {
    std::vector<std::tuple<std::int32_t, std::int32_t, TimeUs, double>> ways;
    for (std::size_t p = 0; p < participants_[kind].size(); ++p) {
      const Participant& partner = participants_[kind][p];
      const TimeUs travel = TravelUs(partner.agent->WayM(partner.at, at), partner.agent->speed_m_s);
      const TimeUs arrive = partner.ready_us + travel;
      if (arrive + duration > partner.latest_us) continue;
      double gain = IdleGain(partner);
      if (settings_.ties) {
        gain -= settings_.partner_way * static_cast<double>(travel) /
                static_cast<double>(site_.rules.interval_us);
      }
      if (task >= 0) gain += ChanceOf(kind, partner.agent->id, task);
      ways.emplace_back(Level(arrive, duration), first + static_cast<std::int32_t>(p), arrive,
                        gain);
    }
    std::sort(ways.begin(), ways.end());
    return ways;
  }

 private:
  const Situation& situation_;
  const Site& site_;
  const Participants& participants_;
  const HorizonSettings& settings_;
};

HorizonSettings SettingsOf(std::uint64_t seed) {
  HorizonSettings settings;
  settings.patience = seed % 3 == 1 ? 0.6 : 1;
  settings.true_duration = seed % 5 != 1;
  settings.chains = seed % 5 != 2;
  settings.ties = seed % 5 != 3;
  settings.soon_idle = seed % 5 != 4;
  if (seed % 4 == 1) settings.jitters[0] = {0.1, static_cast<std::uint32_t>(seed)};
  if (seed % 8 == 1) settings.jitters[1] = {0.07, static_cast<std::uint32_t>(seed + 1)};
  return settings;
}

/// As RandomSituation, with so many agents that they are found through an index, and those of half
/// of the seeds able to reach a part of the area only.
Situation Crowded(std::uint64_t seed) {
  Situation situation = RandomSituation(seed, {150, 180, 90, 60, 12, seed % 2 == 0 ? 20.0 : 120.0});
  for (AgentState& uav : situation.uavs) {
    if (uav.id % 3 == 0) uav.range_at_departure_m *= 0.2;
  }
  return situation;
}

TEST(FindPairs, FindsWhatATrialOfAllPairsFinds) {
  std::size_t uav_ways = 0, partner_ways = 0, all = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::optional<muster::testing::InManhattan> bent;
    if (seed % 4 >= 2) bent.emplace();
    const Situation situation =
        seed % 2 == 0 ? Crowded(seed / 2) : RandomSituation(seed, {6, 9, 5, 12, 3, 15});
    const Site& site = *situation.site;
    const HorizonSettings settings = SettingsOf(seed);
    const Participants participants = ParticipantsOf(situation, settings);
    const OpenSites open = OpenSitesOf(situation);
    const PossiblePairs pairs = FindPairs(situation, participants, open, settings);
    const Instance& instance = pairs.instance;
    const Trial trial(situation, participants, settings);
    double fastest = 0;
    for (const Participant& uav : participants.uavs) {
      fastest = std::max(fastest, uav.agent->speed_m_s);
    }
    std::size_t s = 0;
    for (std::int32_t x = 0; At(x) < site.tasks.size(); ++x) {
      if (!open.task[At(x)]) continue;
      ASSERT_EQ(pairs.site_ids[s], x);
      std::vector<std::tuple<std::int32_t, std::int32_t, TimeUs, double>> uavs, partners;
      for (std::int32_t i = instance.uav_begin[s]; i < instance.uav_begin[s + 1]; ++i) {
        const Instance::UavArc& arc = instance.uav_arcs[At(i)];
        uavs.emplace_back(arc.uav, arc.level, arc.arrive_us, arc.pair_gain);
      }
      for (std::int32_t j = instance.partner_begin[s]; j < instance.partner_begin[s + 1]; ++j) {
        const Instance::PartnerArc& arc = instance.partner_arcs[At(j)];
        partners.emplace_back(arc.level, arc.partner, arc.arrive_us, arc.gain);
      }
      EXPECT_EQ(uavs, trial.UavsTo(x)) << "task " << x;
      const TimeUs duration = fastest > 0 ? SensingUs(site.tasks[At(x)].cost_m, fastest) : 0;
      EXPECT_EQ(partners,
                trial.PartnersTo(AgentKind::kWorker, 0, site.tasks[At(x)].at, duration, x))
          << "task " << x;
      uav_ways += uavs.size();
      partner_ways += partners.size();
      all += participants.uavs.size();
      ++s;
    }
    EXPECT_EQ(pairs.n_tasks, static_cast<std::int32_t>(s));
  }
  EXPECT_GT(uav_ways, 1000u);
  EXPECT_LT(uav_ways, all);  // some are out of reach
  EXPECT_GT(partner_ways, 1000u);
}

TEST(FindPairs, VehiclesAreThoseThatATrialFinds) {
  std::size_t ways = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = Crowded(seed);
    const Site& site = *situation.site;
    const HorizonSettings settings = SettingsOf(seed);
    const Participants participants = ParticipantsOf(situation, settings);
    const PossiblePairs pairs =
        FindPairs(situation, participants, OpenSitesOf(situation), settings);
    const Instance& instance = pairs.instance;
    const Trial trial(situation, participants, settings);
    double rate = 0;
    for (const Participant& v : participants.vehicles) {
      rate = std::max(rate, v.agent->charge_rate_m_s);
    }
    for (auto s = At(pairs.n_tasks); s < pairs.site_ids.size(); ++s) {
      TimeUs shortest = kNever;
      for (std::int32_t i = instance.uav_begin[s]; i < instance.uav_begin[s + 1]; ++i) {
        shortest = std::min(shortest, TravelUs(instance.uav_arcs[At(i)].missing_m, rate));
      }
      std::vector<std::tuple<std::int32_t, std::int32_t, TimeUs, double>> partners;
      for (std::int32_t j = instance.partner_begin[s]; j < instance.partner_begin[s + 1]; ++j) {
        const Instance::PartnerArc& arc = instance.partner_arcs[At(j)];
        partners.emplace_back(arc.level, arc.partner, arc.arrive_us, arc.gain);
      }
      ways += partners.size();
      if (shortest == kNever) {
        EXPECT_TRUE(partners.empty());
        continue;
      }
      EXPECT_EQ(partners,
                trial.PartnersTo(AgentKind::kVehicle,
                                 static_cast<std::int32_t>(participants.workers.size()),
                                 site.charging_points[At(pairs.site_ids[s])].at, shortest, -1));
    }
  }
  EXPECT_GT(ways, 500u);
}

TEST(FindPairs, DependsNotOnThreads) {
  std::size_t sites = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Situation situation = RandomSituation(seed, {90, 120, 60, 1500, 200, 90});
    const HorizonSettings settings = SettingsOf(seed);
    const Participants participants = ParticipantsOf(situation, settings);
    const OpenSites open = OpenSitesOf(situation);
    const Instance one = FindPairs(situation, participants, open, settings, 1).instance;
    const Instance two = FindPairs(situation, participants, open, settings, 2).instance;
    EXPECT_EQ(one.uav_begin, two.uav_begin);
    EXPECT_EQ(one.partner_begin, two.partner_begin);
    ASSERT_EQ(one.uav_arcs.size(), two.uav_arcs.size());
    ASSERT_EQ(one.partner_arcs.size(), two.partner_arcs.size());
    for (std::size_t i = 0; i < one.uav_arcs.size(); ++i) {
      EXPECT_EQ(one.uav_arcs[i].uav, two.uav_arcs[i].uav);
      EXPECT_EQ(one.uav_arcs[i].pair_gain, two.uav_arcs[i].pair_gain);
    }
    for (std::size_t j = 0; j < one.partner_arcs.size(); ++j) {
      EXPECT_EQ(one.partner_arcs[j].partner, two.partner_arcs[j].partner);
      EXPECT_EQ(one.partner_arcs[j].level, two.partner_arcs[j].level);
    }
    sites += one.capacity.size();
  }
  EXPECT_GT(sites, 2048u);  // enough of them for two threads
}

}  // namespace
}  // namespace muster::scheduler
