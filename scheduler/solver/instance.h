#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "base/index.h"
#include "base/units.h"
#include "model/feasibility.h"

namespace muster::scheduler {

/// One decision's conflict graph, never written out. A node is a UAV or a partner (worker, vehicle)
/// that stays, either of them going to a site (task, charging point), or both meeting there. Nodes
/// conflict when they share a UAV, a partner, or a site's last free place, so the graph is the
/// occupancy of its elements. The weight of a pair is
///     base / max(level of the UAV's way, level of the partner's way) + UAV's gain + partner's
///     gain,
/// which leaves one arc for each (UAV, site) and each (partner, site) in place of a node for each
/// triple. Source: the paper's Eq. 4-18, 4-19; the decomposition is ours.
struct Instance {
  static constexpr double kNone = -std::numeric_limits<double>::infinity();

  /// A UAV's way to a site.
  struct UavArc {
    std::int32_t uav = 0;
    std::int32_t level = 1;    ///< decision intervals of the way, at least 1
    double solo = kNone;       ///< weight of going alone; kNone when not offered
    double base = 0;           ///< of a pair, shared by levels
    double pair_gain = kNone;  ///< UAV's share of a pair's weight; kNone: no pair
    TimeUs arrive_us = 0;
    TimeUs duration_us = 0;  ///< of sensing
    double missing_m = -1;   ///< charging: range to charge, duration_us is not used; -1: sensing
  };

  /// A worker's way to a task or a vehicle's to a charging point.
  struct PartnerArc {
    std::int32_t partner = 0;
    std::int32_t level = 1;
    double gain = 0;  ///< weight of going alone, and the partner's share of a pair's weight
    TimeUs arrive_us = 0;
    bool solo = true;  ///< going alone is offered
  };

  struct Uav {
    double stay = 0;
    TimeUs latest_us = kNever;  ///< an action must end by then
    /// UAVs of close numbers are close to each other: an order of work, of no other meaning.
    std::uint32_t place = 0;
  };
  struct Partner {
    double stay = 0;
    TimeUs latest_us = kNever;
    double charge_rate_m_s = 0;  ///< vehicles
  };

  std::vector<Uav> uavs;
  std::vector<Partner> partners;
  std::vector<std::int32_t> capacity;  ///< [n_sites] free places, at least 1

  /// Arcs by site: those of site s are [begin[s], begin[s + 1]); a site's UAV arcs ascend by UAV,
  /// its partner arcs by (level, partner).
  std::vector<std::int32_t> uav_begin, partner_begin;
  std::vector<UavArc> uav_arcs;
  std::vector<PartnerArc> partner_arcs;

  /// [n_sites] where partners beyond some level are not listed: the lowest level that one of them
  /// may have; 0: all are listed. Empty: all are everywhere. Bounds take them into account.
  std::vector<std::int32_t> rest_level;
  /// No partner's gain is above this / level.
  static constexpr double kMostGain = 1.3132616875182228;  // softplus(1)

  std::int32_t n_uavs() const { return static_cast<std::int32_t>(uavs.size()); }
  std::int32_t n_partners() const { return static_cast<std::int32_t>(partners.size()); }
  std::int32_t n_sites() const { return static_cast<std::int32_t>(capacity.size()); }

  /// Whether the two, at the same site, may act as a pair: both offered, and the end of sensing or
  /// charging, which begins at the later arrival, is not after either's latest end.
  bool Compatible(const UavArc& u, const PartnerArc& p) const {
    const Partner& partner = partners[static_cast<std::size_t>(p.partner)];
    const TimeUs start = u.arrive_us > p.arrive_us ? u.arrive_us : p.arrive_us;
    const TimeUs latest_uav = uavs[static_cast<std::size_t>(u.uav)].latest_us;
    const TimeUs latest = latest_uav < partner.latest_us ? latest_uav : partner.latest_us;
    const TimeUs duration =
        u.missing_m < 0 ? u.duration_us : ChargingUs(u.missing_m, partner.charge_rate_m_s);
    return duration != kNever && duration <= latest - start;
  }
  static double PairWeight(const UavArc& u, const PartnerArc& p) {
    return u.base / (u.level > p.level ? u.level : p.level) + p.gain + u.pair_gain;
  }
};

/// Arcs of one side by agent, each agent's ascending by site.
struct ArcsByAgent {
  std::vector<std::int32_t> begin;                              ///< [n_agents + 1] of site_arc
  std::vector<std::pair<std::int32_t, std::int32_t>> site_arc;  ///< site, index of the arc

  std::span<const std::pair<std::int32_t, std::int32_t>> of(std::int32_t agent) const {
    const auto first = site_arc.begin();
    return {first + begin[At(agent)], first + begin[At(agent) + 1]};
  }
  /// The agent's arc to the site; -1: none.
  std::int32_t Find(std::int32_t agent, std::int32_t site) const;
};
ArcsByAgent UavArcsOf(const Instance& instance);
ArcsByAgent PartnerArcsOf(const Instance& instance);

/// A solution: what each agent does. A UAV's choice names the arcs; -1: none.
struct Assignment {
  struct Choice {
    std::int32_t site = -1;  ///< -1: the UAV stays
    std::int32_t uav_arc = -1;
    std::int32_t partner_arc = -1;  ///< -1: the UAV goes alone
  };
  std::vector<Choice> uavs;                ///< [n_uavs]
  std::vector<std::int32_t> partner_solo;  ///< [n_partners] arc of a partner that goes alone, or -1
  double weight = 0;                       ///< of all nodes, staying agents included
};

/// Whether no element is used beyond its capacity and every pair is compatible.
bool IsValid(const Instance& instance, const Assignment& assignment);

/// Sum of the node weights of an assignment.
double WeightOf(const Instance& instance, const Assignment& assignment);

/// Number of nodes of the conflict graph. Cost: one look at each (UAV arc, partner arc) of a site.
std::int64_t CountNodes(const Instance& instance, int threads = 1);

}  // namespace muster::scheduler
