// The altitudes of a decision: whether UAVs are kept apart, as far as is planned.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/audit/checks.h"

namespace muster::tools::audit {
namespace {

constexpr double kClimb_m_s = 2.5, kDescent_m_s = 1.5;
constexpr std::int64_t kLongestHoldUs = 120'000'000;
constexpr std::int64_t kSecond_us = 1'000'000;
/// A plan may come closer by this share of a minimum, by rounding.
constexpr double kShareSlack = 1e-3;

/// A UAV's plan: its model with the leg that it is sent on, and its altitudes.
struct Plan {
  AgentModel uav;
  clearance_t altitudes{};
  bool is_new = false;  ///< this decision sends it, or changes its altitude
  /// Where it is when; between two of these it moves evenly, and after the last it stays.
  struct Turn {
    std::int64_t at_us;
    Place at;
    double up_m;
  };
  std::vector<Turn> turns;
  Place low, high;

  /// It is there at t, and so high.
  std::pair<Place, double> At(std::int64_t t) const {
    if (t >= turns.back().at_us) return {turns.back().at, turns.back().up_m};
    const auto next = std::upper_bound(turns.begin(), turns.end(), t,
                                       [](std::int64_t us, const Turn& x) { return us < x.at_us; });
    const Turn &b = *next, &a = *std::prev(next);
    const double part = static_cast<double>(t - a.at_us) / static_cast<double>(b.at_us - a.at_us);
    return {{a.at.x_m + part * (b.at.x_m - a.at.x_m), a.at.y_m + part * (b.at.y_m - a.at.y_m)},
            a.up_m + part * (b.up_m - a.up_m)};
  }
};

std::int64_t RampEnd(const clearance_t& c) {
  const double rate = c.to_m > c.from_m ? kClimb_m_s : kDescent_m_s;
  return c.begin_us + DurationUs(std::abs(c.to_m - c.from_m), rate) + 1;
}

double Ramp(const clearance_t& c, std::int64_t t) {
  const double seconds = std::max(0.0, ToSeconds(t - c.begin_us));
  if (c.to_m > c.from_m) return std::min(c.to_m, c.from_m + seconds * kClimb_m_s);
  return std::max(c.to_m, c.from_m - seconds * kDescent_m_s);
}

bool StandsToCharge(const View& view, const AgentModel& uav) {
  return std::any_of(
      view.scenario.charges.begin(), view.scenario.charges.end(),
      [&](const Scenario::Charge& charge) { return Apart(charge.at, uav.to) < kTolerance_m; });
}

bool IsToCharge(const AgentModel& uav) {
  return uav.action == ActionKind::kCharge || uav.action == ActionKind::kUavToCharge;
}

double AltitudeOf(const View& view, const AgentModel& uav, const clearance_t& c, std::int64_t t) {
  if (t >= uav.arrive_us && IsToCharge(uav)) {
    return std::max(0.0, Ramp(c, uav.arrive_us) - kDescent_m_s * ToSeconds(t - uav.arrive_us));
  }
  if (t >= uav.arrive_us && uav.action == ActionKind::kNone && StandsToCharge(view, uav)) return 0;
  return Ramp(c, t);
}

void FindTurns(const View& view, Plan* plan) {
  const AgentModel& uav = plan->uav;
  const std::int64_t now_us = view.now_us, begin_us = uav.depart_us + uav.hold_us;
  std::vector<std::int64_t> times{now_us, plan->altitudes.begin_us, RampEnd(plan->altitudes),
                                  uav.arrive_us, begin_us};
  if (IsToCharge(uav)) {
    times.push_back(uav.arrive_us + DurationUs(Ramp(plan->altitudes, uav.arrive_us), kDescent_m_s) +
                    1);
  }
  if (now_us < uav.arrive_us) {
    for (const double part : uav.leg_ways->TurnsOf(uav.kind, uav.from, uav.to)) {
      times.push_back(begin_us +
                      std::llround(part * static_cast<double>(uav.arrive_us - begin_us)));
    }
  }
  std::erase_if(times, [&](std::int64_t t) { return t < now_us; });
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  plan->low = plan->high = uav.At(now_us);
  for (const std::int64_t t : times) {
    const Place at = uav.At(t);
    plan->turns.push_back({t, at, AltitudeOf(view, uav, plan->altitudes, t)});
    plan->low = {std::min(plan->low.x_m, at.x_m), std::min(plan->low.y_m, at.y_m)};
    plan->high = {std::max(plan->high.x_m, at.x_m), std::max(plan->high.y_m, at.y_m)};
  }
}

/// The leg on which a command sends the UAV.
void SendOff(const View& view, const action_t& action, Plan* plan) {
  AgentModel& uav = plan->uav;
  const Place wanted{action.x_m, action.y_m};
  const Place goal =
      action.kind == ActionKind::kGoTo ? uav.ways->StopNear(kUav, wanted).first : wanted;
  const double way_m = uav.WayM(uav.to, goal);
  if (std::isinf(way_m)) return;
  uav.from = uav.to;
  uav.to = goal;
  uav.leg_ways = uav.ways;
  uav.depart_us = view.now_us;
  uav.hold_us = plan->altitudes.begin_us - view.now_us;
  uav.arrive_us = view.now_us + uav.hold_us + DurationUs(way_m, uav.spec->speed_m_s);
  uav.action = static_cast<ActionKind>(action.kind);
  uav.activity.reset();
}

/// Whether the place is inside, or nearer to an edge than that.
bool IsInOrNear(const Rings& rings, Place at, double near_m) {
  bool inside = false;
  for (const std::vector<Place>& ring : rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Place a = ring[i], b = ring[(i + 1) % ring.size()];
      if ((a.y_m > at.y_m) != (b.y_m > at.y_m) &&
          at.x_m < a.x_m + (b.x_m - a.x_m) * (at.y_m - a.y_m) / (b.y_m - a.y_m)) {
        inside = !inside;
      }
      const double length_m = Apart(a, b);
      const double along =
          ((at.x_m - a.x_m) * (b.x_m - a.x_m) + (at.y_m - a.y_m) * (b.y_m - a.y_m)) /
          (length_m * length_m);
      const double part = std::clamp(along, 0.0, 1.0);
      const Place foot{a.x_m + part * (b.x_m - a.x_m), a.y_m + part * (b.y_m - a.y_m)};
      if (Apart(at, foot) < near_m) return true;
    }
  }
  return inside;
}

class SeparationCheck {
 public:
  explicit SeparationCheck(View& view) : view_(view), minima_(*view.scenario.separation) {}

  void Check() {
    for (const clearance_t& c : view_.clearances->clearances) {
      if (c.uav_id >= static_cast<int>(view_.agents[kUav].size())) {
        return view_.Violate("separation", "an altitude of uav:{}, which the scenario has not",
                             c.uav_id);
      }
    }
    std::map<int, clearance_t> said;
    for (const clearance_t& c : view_.clearances->clearances) said[c.uav_id] = c;
    for (const AgentModel& uav : view_.agents[kUav]) AddPlan(uav, said);
    view_.cleared = said;
    for (const Plan& plan : plans_) CheckHighZones(plan);
    for (std::size_t i = 0; i < plans_.size(); ++i) {
      for (std::size_t j = i + 1; j < plans_.size(); ++j) Compare(plans_[i], plans_[j]);
    }
  }

 private:
  void AddPlan(const AgentModel& uav, const std::map<int, clearance_t>& said) {
    const auto before = view_.cleared.find(uav.id);
    const auto now = said.find(uav.id);
    const auto command = view_.commands.find({kUav, uav.id});
    const bool sent = command != view_.commands.end() && command->second.at_us == view_.now_us;
    clearance_t old{};
    old.uav_id = uav.id;
    old.decision = -1;
    if (before != view_.cleared.end()) old = before->second;
    Plan plan;
    plan.uav = uav;
    plan.altitudes = now == said.end() ? old : now->second;
    plan.is_new = plan.altitudes.decision == view_.due;
    if (!plan.is_new) {
      const clearance_t& c = plan.altitudes;
      if (c.decision != old.decision || c.from_m != old.from_m || c.to_m != old.to_m ||
          c.begin_us != old.begin_us) {
        view_.Violate("separation", "{} has another altitude than decision {} gave it", uav.name(),
                      old.decision);
      }
      if (sent) view_.Violate("separation", "{} is sent off without an altitude", uav.name());
    } else {
      CheckNew(plan, AltitudeOf(view_, uav, old, view_.now_us), sent);
    }
    const std::int64_t t = view_.now_us;
    if (uav.failed || t < uav.spec->online_from_us || t >= uav.spec->online_until_us) return;
    // Otherwise a violation has been reported already. Flights are checked second by second, so one
    // that begins in the far future would never end.
    if (!CanBeFlown(plan.altitudes)) return;
    if (sent) SendOff(view_, command->second.action, &plan);
    FindTurns(view_, &plan);
    plans_.push_back(std::move(plan));
  }

  /// Soon, and within the mission's altitudes.
  bool CanBeFlown(const clearance_t& c) const {
    return c.begin_us <= view_.now_us + kLongestHoldUs &&
           std::max(c.from_m, c.to_m) <= minima_.ceiling_m + kTolerance_m;
  }

  void CheckNew(const Plan& plan, double altitude_m, bool sent) {
    const clearance_t& c = plan.altitudes;
    const auto wrong = [&]<class... T>(fmt::format_string<T...> text, T&&... values) {
      view_.Violate("separation", "{}: {}", plan.uav.name(),
                    fmt::format(text, std::forward<T>(values)...));
    };
    if (std::abs(c.from_m - altitude_m) > kTolerance_m) {
      wrong("is said to be {:.3f} m above the ground, expected {:.3f} m", c.from_m, altitude_m);
    }
    const double layer = (c.to_m - minima_.lowest_m) / minima_.above_m;
    if (c.to_m > minima_.ceiling_m + kTolerance_m || layer < -kTolerance_m ||
        std::abs(layer - std::round(layer)) > kTolerance_m) {
      wrong("is sent to {:.3f} m above the ground, which is no altitude of this mission", c.to_m);
    }
    const std::int64_t hold_us = c.begin_us - view_.now_us;
    if (hold_us < 0 || hold_us > kLongestHoldUs || (!sent && hold_us > 0)) {
      wrong("waits {} us for its altitude", hold_us);
    }
  }

  /// Each second of the flight, and its end.
  void CheckHighZones(const Plan& plan) {
    if (!plan.is_new) return;
    for (const Scenario::HighZone& zone : view_.scenario.high_zones) {
      const bool is_ever_higher =
          std::any_of(plan.turns.begin(), plan.turns.end(),
                      [&](const Plan::Turn& turn) { return turn.up_m > zone.highest_m; });
      if (!is_ever_higher || zone.until_us <= view_.now_us) continue;
      for (std::int64_t t = view_.now_us;; t += kSecond_us) {
        const auto [at, up_m] = plan.At(t);
        if (up_m > zone.highest_m + kTolerance_m &&
            IsInOrNear(zone.rings, at, *view_.scenario.margin_m - kTolerance_m)) {
          view_.Violate("separation",
                        "{} flies {:.1f} m high at {} us, in a zone that begins at "
                        "{:.1f} m",
                        plan.uav.name(), up_m, t, zone.highest_m + minima_.above_m);
          break;
        }
        if (t >= plan.turns.back().at_us) break;
      }
    }
  }

  void Compare(const Plan& a, const Plan& b) {
    const double reach_m = minima_.across_m;
    if (a.high.x_m + reach_m < b.low.x_m || b.high.x_m + reach_m < a.low.x_m ||
        a.high.y_m + reach_m < b.low.y_m || b.high.y_m + reach_m < a.low.y_m) {
      return;
    }
    std::vector<std::int64_t> turns;
    for (const Plan::Turn& turn : a.turns) turns.push_back(turn.at_us);
    for (const Plan::Turn& turn : b.turns) turns.push_back(turn.at_us);
    std::sort(turns.begin(), turns.end());
    double share = std::numeric_limits<double>::infinity();
    std::int64_t at_us = -1;
    for (std::size_t i = 0; i < turns.size(); ++i) {
      const std::int64_t next = i + 1 < turns.size() ? turns[i + 1] : turns[i];
      const auto [least, when] = Least(a, b, turns[i], next);
      if (least < share) share = least, at_us = when;
    }
    if (at_us < 0) return;
    const auto [there_a, up_a] = a.At(at_us);
    const auto [there_b, up_b] = b.At(at_us);
    const double across_m = Apart(there_a, there_b), above_m = std::abs(up_a - up_b);
    if (share < 1 - kShareSlack && (a.is_new || b.is_new)) {
      view_.Violate("separation", "{} and {} come within {:.1f} m across and {:.1f} m up at {} us",
                    a.uav.name(), b.uav.name(), across_m, above_m, at_us);
    } else if (share < 1 - kShareSlack) {
      ++view_.closest.leftover;
    } else if (share < view_.closest.share) {
      view_.closest.share = share;
      view_.closest.across_m = across_m;
      view_.closest.above_m = above_m;
    }
  }

  /// Infinity while one of them is on the ground.
  double ShareAt(const Plan& a, const Plan& b, std::int64_t t) const {
    const auto [there_a, up_a] = a.At(t);
    const auto [there_b, up_b] = b.At(t);
    if (up_a <= 0 || up_b <= 0) return std::numeric_limits<double>::infinity();
    return std::max(Apart(there_a, there_b) / minima_.across_m,
                    std::abs(up_a - up_b) / minima_.above_m);
  }
  /// The least share between two turns, where it is convex, and when: by halves.
  std::pair<double, std::int64_t> Least(const Plan& a, const Plan& b, std::int64_t low,
                                        std::int64_t high) const {
    while (high - low > 2) {
      const std::int64_t third = (high - low) / 3;
      if (ShareAt(a, b, low + third) <= ShareAt(a, b, high - third)) {
        high -= third;
      } else {
        low += third;
      }
    }
    std::pair best(ShareAt(a, b, low), low);
    for (std::int64_t t = low + 1; t <= high; ++t) {
      const double share = ShareAt(a, b, t);
      if (share < best.first) best = {share, t};
    }
    return best;
  }

  View& view_;
  const Scenario::Separation minima_;
  std::vector<Plan> plans_;
};

}  // namespace

void CheckSeparation(View& view) { SeparationCheck(view).Check(); }

}  // namespace muster::tools::audit
