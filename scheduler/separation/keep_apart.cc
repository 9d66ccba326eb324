#include "scheduler/separation/keep_apart.h"

#include <algorithm>
#include <map>
#include <optional>

#include "model/air_ways.h"
#include "model/directive.h"
#include "model/feasibility.h"
#include "model/high_zones.h"
#include "model/separation.h"

namespace muster::scheduler {
namespace {

class ClearancePlanner {
 public:
  explicit ClearancePlanner(const Situation& situation)
      : s_(situation),
        minima_(*situation.site->separation),
        landing_(situation.site->charging_points) {
    for (const HighZone& zone : situation.site->high_zones) {
      if (zone.until_us > s_.now_us) high_zones_.push_back(&zone);
    }
    for (const Clearance& clearance : situation.clearances) cleared_[clearance.uav] = clearance;
    for (const AgentState& uav : s_.uavs) {
      paths_.push_back(TrajectoryOf(uav, Cleared(uav), s_.now_us, landing_));
    }
  }

  Decision Plan(Decision decision) {
    std::vector<Action> kept;
    std::vector<bool> sent(s_.uavs.size(), false), withheld(s_.uavs.size(), false);
    for (const Action& action : decision.actions) {
      const bool flies = action.uav.valid() && !IsStay(action.kind);
      if (flies && !Send(action, &sent)) {
        decision.withheld.push_back(action);
        withheld[IndexOf(action.uav)] = true;
        continue;
      }
      kept.push_back(action);
    }
    for (std::size_t i = 0; i < s_.uavs.size(); ++i) {
      if (sent[i] || !s_.uavs[i].idle(s_.now_us)) continue;
      const auto out = withheld[i] ? std::optional<Action>() : WayOutOfZone(i);
      if (out && Send(*out, &sent)) {
        std::erase_if(kept, [&](const Action& stays) { return stays.uav == out->uav; });
        kept.push_back(*out);
      } else {
        MakeWay(i, withheld[i]);
      }
    }
    if (kept != decision.actions) {
      SortActions(&kept);
      decision.weight = 0;
      for (const Action& action : kept) decision.weight += action.weight;
      decision.actions = std::move(kept);
    }
    for (const auto& [uav, clearance] : cleared_) decision.clearances.push_back(clearance);
    return decision;
  }

 private:
  Clearance Cleared(const AgentState& uav) const {
    const auto found = cleared_.find(uav.id);
    return found == cleared_.end() ? Clearance{.uav = uav.id} : found->second;
  }
  std::size_t IndexOf(UavId uav) const {
    const auto found =
        std::lower_bound(s_.uavs.begin(), s_.uavs.end(), uav.value,
                         [](const AgentState& agent, std::int32_t id) { return agent.id < id; });
    return static_cast<std::size_t>(found - s_.uavs.begin());
  }
  /// `to_m`: the altitude that is flown in the end.
  bool IsFree(const Trajectory& path, double to_m, std::size_t own) const {
    for (const HighZone* zone : high_zones_) {
      if (IsTooHigh(path, to_m, *zone)) return false;
    }
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      if (i != own && AreInConflict(path, paths_[i], minima_)) return false;
    }
    return true;
  }

  /// Finds the altitude and the time for one action; false: there are none.
  bool Send(const Action& action, std::vector<bool>* sent) {
    const std::size_t i = IndexOf(action.uav);
    const AgentState& uav = s_.uavs[i];
    Clearance clearance = Cleared(uav);
    clearance.from_m = AltitudeAt(uav, clearance, s_.now_us, landing_);
    clearance.decision = s_.decision;
    const bool to_east = action.to.x_m >= uav.to.x_m;
    for (TimeUs hold_us = 0; hold_us <= MostHoldUs(); hold_us += kHoldStepUs) {
      if (hold_us > 0 && !IsInTime(action, hold_us)) return false;
      // As computed: when it sets out itself, a measured agent says later.
      AgentState sent_off = uav;
      sent_off.measured.reset();
      Begin(&sent_off, action, s_.decision, s_.now_us, Disturbances{}, 0, hold_us);
      clearance.begin_us = s_.now_us + hold_us;
      for (const int parity : {to_east ? 0 : 1, to_east ? 1 : 0}) {
        for (int layer = parity; layer < minima_.layers(); layer += 2) {
          clearance.to_m = minima_.AltitudeOf(layer);
          Trajectory path = TrajectoryOf(sent_off, clearance, s_.now_us, landing_);
          if (!IsFree(path, clearance.to_m, i)) continue;
          paths_[i] = std::move(path);
          cleared_[uav.id] = clearance;
          (*sent)[i] = true;
          return true;
        }
      }
    }
    return false;
  }

  TimeUs MostHoldUs() const {
    return std::min(kMostHoldUs,
                    s_.site->rules.NextDecisionUs(s_.now_us) - s_.now_us - kHoldStepUs);
  }

  /// Whether the action still counts if its UAV sets out so much later.
  bool IsInTime(const Action& action, TimeUs hold_us) const {
    AgentState uav = s_.uavs[IndexOf(action.uav)];
    uav.measured.reset();
    Begin(&uav, action, s_.decision, s_.now_us, Disturbances{}, 0, hold_us);
    TimeUs start_us = uav.arrive_us, end_us = uav.arrive_us;
    TimeUs latest_us = LatestEnd(uav, s_.site->rules);
    if (IsPair(action.kind)) {
      const auto& partners = action.kind == ActionKind::kSense ? s_.workers : s_.vehicles;
      const std::int32_t id =
          action.kind == ActionKind::kSense ? action.worker.value : action.vehicle.value;
      AgentState partner = *std::find_if(partners.begin(), partners.end(),
                                         [&](const AgentState& agent) { return agent.id == id; });
      Begin(&partner, action, s_.decision, s_.now_us, Disturbances{}, 0);
      const Activity activity = PlanActivity(uav, partner, s_.site->tasks);
      start_us = activity.start_us;
      end_us = activity.end_us;
      latest_us = std::min(latest_us, LatestEnd(partner, s_.site->rules));
    }
    const bool expires =
        action.task.valid() && !s_.site->tasks[action.task.index()].AllowsStart(start_us);
    return !expires && end_us <= latest_us;
  }

  /// That a UAV in the air which a zone has come upon goes to the nearest free stop. None: it is
  /// outside, on the ground, or cannot.
  std::optional<Action> WayOutOfZone(std::size_t i) const {
    const AgentState& uav = s_.uavs[i];
    const auto* const ways = dynamic_cast<const AirWays*>(uav.ways);
    if (ways == nullptr || ways->air().IsFree(uav.to)) return {};
    if (AltitudeAt(uav, Cleared(uav), s_.now_us, landing_) <= 0) return {};
    const Ways::Stop stop = ways->StopNear(AgentKind::kUav, uav.to);
    if (stop.number < 0 || IsOffLimits(s_.site->directives, AgentKind::kUav, stop.at)) return {};
    Action action = MakeStay(*s_.site, uav);
    action.kind = ActionKind::kGoTo;
    action.to = stop.at;
    const double way_m = uav.WayM(uav.to, stop.at);
    if (!(way_m <= RangeAt(uav, s_.now_us, s_.site->tasks)) || !IsInTime(action, 0)) return {};
    return action;
  }

  /// A UAV that stays in the air changes its altitude if it would be met. One whose action was left
  /// out, as it was perhaps too high for a zone on its way, goes as low as it can.
  void MakeWay(std::size_t i, bool goes_down) {
    const AgentState& uav = s_.uavs[i];
    if (!paths_[i].IsEverAirborne()) return;
    goes_down = goes_down && !high_zones_.empty();
    if (!goes_down && IsFree(paths_[i], Cleared(uav).to_m, i)) return;
    Clearance clearance = Cleared(uav);
    clearance.from_m = AltitudeAt(uav, clearance, s_.now_us, landing_);
    clearance.decision = s_.decision;
    clearance.begin_us = s_.now_us;
    for (int layer = 0; layer < minima_.layers(); ++layer) {
      clearance.to_m = minima_.AltitudeOf(layer);
      Trajectory path = TrajectoryOf(uav, clearance, s_.now_us, landing_);
      if (!IsFree(path, clearance.to_m, i)) continue;
      paths_[i] = std::move(path);
      cleared_[uav.id] = clearance;
      return;
    }
  }

  const Situation& s_;
  const Separation minima_;
  const LandingPlaces landing_;
  std::vector<const HighZone*> high_zones_;    ///< that still hold
  std::map<std::int32_t, Clearance> cleared_;  ///< by UAV
  std::vector<Trajectory> paths_;              ///< of each of s_.uavs
};

}  // namespace

Decision KeepApart(const Situation& situation, Decision decision) {
  if (!situation.site->separation) return decision;
  return ClearancePlanner(situation).Plan(std::move(decision));
}

}  // namespace muster::scheduler
