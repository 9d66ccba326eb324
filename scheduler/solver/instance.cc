#include "scheduler/solver/instance.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "scheduler/solver/parallel.h"

namespace muster::scheduler {
namespace {

using Index = std::int32_t;

template <class Arc>
ArcsByAgent Sort(Index n_agents, const std::vector<Index>& arc_begin, const std::vector<Arc>& arcs,
                 Index Arc::*agent_of) {
  ArcsByAgent by_agent{std::vector<Index>(At(n_agents) + 1, 0), {}};
  std::vector<Index>& begin = by_agent.begin;
  by_agent.site_arc.resize(arcs.size());
  for (const Arc& arc : arcs) ++begin[At(arc.*agent_of) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Index> next(begin.begin(), begin.end() - 1);
  for (std::size_t s = 0; s + 1 < arc_begin.size(); ++s) {
    for (Index i = arc_begin[s]; i < arc_begin[s + 1]; ++i) {
      by_agent.site_arc[At(next[At(arcs[At(i)].*agent_of)]++)] = {static_cast<Index>(s), i};
    }
  }
  return by_agent;
}

}  // namespace

ArcsByAgent UavArcsOf(const Instance& instance) {
  return Sort(instance.n_uavs(), instance.uav_begin, instance.uav_arcs, &Instance::UavArc::uav);
}

ArcsByAgent PartnerArcsOf(const Instance& instance) {
  return Sort(instance.n_partners(), instance.partner_begin, instance.partner_arcs,
              &Instance::PartnerArc::partner);
}

Index ArcsByAgent::Find(Index agent, Index site) const {
  const auto last = site_arc.begin() + begin[At(agent) + 1];
  const auto found =
      std::lower_bound(site_arc.begin() + begin[At(agent)], last, std::pair(site, Index{0}));
  return found != last && found->first == site ? found->second : -1;
}

bool IsValid(const Instance& instance, const Assignment& assignment) {
  std::vector<std::int32_t> site_use(instance.capacity.size(), 0);
  std::vector<std::int32_t> partner_use(instance.partners.size(), 0);
  if (assignment.uavs.size() != instance.uavs.size()) return false;
  if (assignment.partner_solo.size() != instance.partners.size()) return false;
  for (std::size_t u = 0; u < assignment.uavs.size(); ++u) {
    const Assignment::Choice& choice = assignment.uavs[u];
    if (choice.site < 0) continue;
    const auto& arc = instance.uav_arcs[static_cast<std::size_t>(choice.uav_arc)];
    if (arc.uav != static_cast<std::int32_t>(u)) return false;
    ++site_use[static_cast<std::size_t>(choice.site)];
    if (choice.partner_arc < 0) {
      if (arc.solo == Instance::kNone) return false;
      continue;
    }
    const auto& partner = instance.partner_arcs[static_cast<std::size_t>(choice.partner_arc)];
    if (arc.pair_gain == Instance::kNone || !instance.Compatible(arc, partner)) return false;
    ++partner_use[static_cast<std::size_t>(partner.partner)];
  }
  for (std::size_t p = 0; p < assignment.partner_solo.size(); ++p) {
    const std::int32_t arc = assignment.partner_solo[p];
    if (arc < 0) continue;
    const auto begin = instance.partner_begin.begin();
    const auto site = std::upper_bound(begin, instance.partner_begin.end(), arc) - begin - 1;
    if (!instance.partner_arcs[static_cast<std::size_t>(arc)].solo) return false;
    ++site_use[static_cast<std::size_t>(site)];
    ++partner_use[p];
  }
  for (std::size_t s = 0; s < site_use.size(); ++s) {
    if (site_use[s] > instance.capacity[s]) return false;
  }
  return std::all_of(partner_use.begin(), partner_use.end(), [](int n) { return n <= 1; });
}

double WeightOf(const Instance& instance, const Assignment& assignment) {
  double weight = 0;
  std::vector<bool> busy(instance.partners.size(), false);
  for (std::size_t u = 0; u < assignment.uavs.size(); ++u) {
    const Assignment::Choice& choice = assignment.uavs[u];
    if (choice.site < 0) {
      weight += instance.uavs[u].stay;
      continue;
    }
    const auto& arc = instance.uav_arcs[static_cast<std::size_t>(choice.uav_arc)];
    if (choice.partner_arc < 0) {
      weight += arc.solo;
      continue;
    }
    const auto& partner = instance.partner_arcs[static_cast<std::size_t>(choice.partner_arc)];
    weight += Instance::PairWeight(arc, partner);
    busy[static_cast<std::size_t>(partner.partner)] = true;
  }
  for (std::size_t p = 0; p < assignment.partner_solo.size(); ++p) {
    if (busy[p]) continue;
    const std::int32_t arc = assignment.partner_solo[p];
    weight += arc < 0 ? instance.partners[p].stay
                      : instance.partner_arcs[static_cast<std::size_t>(arc)].gain;
  }
  return weight;
}

std::int64_t CountNodes(const Instance& instance, int threads) {
  std::int64_t nodes = instance.n_uavs() + instance.n_partners();
  for (const auto& arc : instance.partner_arcs) nodes += arc.solo ? 1 : 0;
  for (const auto& arc : instance.uav_arcs) nodes += arc.solo != Instance::kNone ? 1 : 0;
  std::int64_t pairs[2] = {0, 0};
  ParallelFor(instance.capacity.size(), threads, 4096, [&](std::size_t begin, std::size_t end) {
    std::int64_t found = 0;
    for (std::size_t s = begin; s < end; ++s) {
      const auto first = static_cast<std::size_t>(instance.partner_begin[s]);
      const auto last = static_cast<std::size_t>(instance.partner_begin[s + 1]);
      // A partner that arrives later and has less time than any here: a UAV that suits it suits
      // all.
      TimeUs arrive = 0, latest = kNever;
      double rate = std::numeric_limits<double>::infinity();
      for (std::size_t j = first; j < last; ++j) {
        const auto& arc = instance.partner_arcs[j];
        const auto& partner = instance.partners[static_cast<std::size_t>(arc.partner)];
        arrive = std::max(arrive, arc.arrive_us);
        latest = std::min(latest, partner.latest_us);
        rate = std::min(rate, partner.charge_rate_m_s);
      }
      for (auto i = static_cast<std::size_t>(instance.uav_begin[s]);
           i < static_cast<std::size_t>(instance.uav_begin[s + 1]); ++i) {
        const auto& uav = instance.uav_arcs[i];
        if (uav.pair_gain == Instance::kNone) continue;
        const TimeUs duration =
            uav.missing_m < 0 ? uav.duration_us : ChargingUs(uav.missing_m, rate);
        const TimeUs uav_latest = instance.uavs[static_cast<std::size_t>(uav.uav)].latest_us;
        if (duration != kNever &&
            duration <= std::min(latest, uav_latest) - std::max(arrive, uav.arrive_us)) {
          found += static_cast<std::int64_t>(last - first);
          continue;
        }
        for (std::size_t j = first; j < last; ++j) {
          found += instance.Compatible(uav, instance.partner_arcs[j]) ? 1 : 0;
        }
      }
    }
    pairs[begin == 0 ? 0 : 1] = found;
  });
  return nodes + pairs[0] + pairs[1];
}

}  // namespace muster::scheduler
