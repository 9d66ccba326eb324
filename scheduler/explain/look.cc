#include "scheduler/explain/look.h"

#include <algorithm>

#include "base/index.h"
#include "model/feasibility.h"

namespace muster::scheduler {
namespace {

constexpr int kAny = -2;  ///< no row; -1 is an agent that is not idle

}  // namespace

std::string_view ToString(Obstacle obstacle) {
  switch (obstacle) {
    case Obstacle::kNone:
      return "none";
    case Obstacle::kNoUav:
      return "no idle uav";
    case Obstacle::kNoPartner:
      return "no idle partner";
    case Obstacle::kNoPlace:
      return "no free place";
    case Obstacle::kRange:
      return "range";
    case Obstacle::kWindow:
      return "online window";
    case Obstacle::kLimit:
      return "time limit";
    case Obstacle::kExpiry:
      return "expiry";
    case Obstacle::kNoUse:
      return "no use";
  }
  return "none";
}

void PlaceLook::Offer(const PairLook& pair) {
  const auto at = std::find_if(best.begin(), best.end(),
                               [&](const PairLook& other) { return other.weight < pair.weight; });
  if (at == best.end() && best.size() == kBest) return;
  best.insert(at, pair);
  if (best.size() > kBest) best.pop_back();
}

void PlaceLook::OfferLate(PairLook pair, TimeUs limit_us, const AgentState& uav,
                          const AgentState& partner) {
  if (pair.end_us > limit_us) {
    pair.obstacle = Obstacle::kLimit;
    pair.latest_us = limit_us;
    ++pairs_after_limit;
  } else {
    pair.obstacle = Obstacle::kWindow;
    const bool by_uav = uav.online_until_us <= partner.online_until_us;
    pair.window_of = by_uav ? uav.kind : partner.kind;
    pair.latest_us = by_uav ? uav.online_until_us : partner.online_until_us;
    ++pairs_after_window;
  }
  KeepLeastLate(pair);
}

void PlaceLook::OfferExpired(PairLook pair, TimeUs there_us, TimeUs expires_us) {
  pair.obstacle = Obstacle::kExpiry;
  pair.end_us = there_us;
  pair.latest_us = expires_us;
  ++pairs_after_expiry;
  KeepLeastLate(pair);
}

void PlaceLook::KeepLeastLate(const PairLook& pair) {
  if (!nearest_time ||
      pair.end_us - pair.latest_us < nearest_time->end_us - nearest_time->latest_us) {
    nearest_time = pair;
  }
}

void PlaceLook::OfferShort(const RangeNeed& need) {
  const auto lacks = [](const RangeNeed& n) { return n.needs_m() - n.range_m; };
  if (!nearest_range || lacks(need) < lacks(*nearest_range)) nearest_range = need;
}

Look::Look(const Situation& situation)
    : situation_(situation), weights_(ComputeWeights(situation)), feasible_(situation, weights_) {}

int Look::RowOf(AgentKind kind, std::int32_t id) const {
  const auto& rows = ByKind(kind, weights_.uavs, weights_.workers, weights_.vehicles);
  const auto& agents = situation_.agents(kind);
  const auto found = std::lower_bound(
      rows.begin(), rows.end(), id,
      [&](std::int32_t row, std::int32_t wanted) { return agents[At(row)].id < wanted; });
  if (found == rows.end() || agents[At(*found)].id != id) return -1;
  return static_cast<int>(found - rows.begin());
}

PlaceLook Look::AtTask(TaskId task, UavId uav, WorkerId worker) const {
  const auto found = std::lower_bound(weights_.tasks.begin(), weights_.tasks.end(), task);
  const auto column = static_cast<int>(found - weights_.tasks.begin());
  return AtPlace(false, task.value, column, uav.valid() ? RowOf(AgentKind::kUav, uav.value) : kAny,
                 worker.valid() ? RowOf(AgentKind::kWorker, worker.value) : kAny);
}

PlaceLook Look::AtCharge(ChargeId charge, UavId uav, VehicleId vehicle) const {
  return AtPlace(true, charge.value, charge.value,
                 uav.valid() ? RowOf(AgentKind::kUav, uav.value) : kAny,
                 vehicle.valid() ? RowOf(AgentKind::kVehicle, vehicle.value) : kAny);
}

bool Look::InTime(int uav, int task, int worker) const {
  return weights_.uav_task.travel_us(uav, task) != kNever &&
         weights_.worker_task.travel_us(worker, task) != kNever;
}

PlaceLook Look::AtPlace(bool charging, std::int32_t site, int column, int only_uav,
                        int only_partner) const {
  const Rules& rules = situation_.site->rules;
  const Legs& legs = charging ? weights_.uav_charge : weights_.uav_task;
  const int n_partners = charging ? weights_.n_vehicles() : weights_.n_workers();
  const auto& partners = charging ? situation_.vehicles : situation_.workers;
  const auto& partner_rows = charging ? weights_.vehicles : weights_.workers;
  PlaceLook look;
  look.charging = charging;
  look.site = site;
  look.idle_uavs = weights_.n_uavs();
  look.idle_partners = n_partners;
  look.busy_uavs = static_cast<int>(situation_.uavs.size()) - look.idle_uavs;
  look.busy_partners = static_cast<int>(partners.size()) - n_partners;
  for (int u = 0; u < weights_.n_uavs(); ++u) {
    if (only_uav != kAny && u != only_uav) continue;
    const AgentState& uav = situation_.uavs[At(weights_.uavs[At(u)])];
    if (!(charging ? weights_.chargeable(u, column) : weights_.senseable(u, column))) {
      RangeNeed need{UavId(uav.id), weights_.range_m(u), legs.way_m(u, column), 0, 0, {}};
      if (!charging) {
        need.cost_m = situation_.site->tasks[At(site)].cost_m;
        need.to_charge_m = situation_.site->task_to_charge_m[At(site)];
      }
      look.OfferShort(need);
      continue;
    }
    ++look.uavs_in_range;
    for (int p = 0; p < n_partners; ++p) {
      if (only_partner != kAny && p != only_partner) continue;
      const AgentState& partner = partners[At(partner_rows[At(p)])];
      ++look.pairs;
      PairLook pair;
      pair.uav = UavId(uav.id);
      pair.partner = partner.id;
      pair.end_us = charging ? feasible_.ChargeEnd(u, column, p) : feasible_.SenseEnd(u, column, p);
      if (charging ? feasible_.Charge(u, column, p) : feasible_.Sense(u, column, p)) {
        pair.weight = charging ? weights_.Charge(u, column, p) : weights_.Sense(u, column, p);
        pair.latest_us = std::min(LatestEnd(uav, rules), LatestEnd(partner, rules));
        ++look.pairs_feasible;
        look.Offer(pair);
      } else if (!charging && !InTime(u, column, p)) {
        const TimeUs there_us =
            situation_.now_us +
            std::max(TravelUs(legs.way_m(u, column), uav.speed_m_s),
                     TravelUs(weights_.worker_task.way_m(p, column), partner.speed_m_s));
        look.OfferExpired(pair, there_us, situation_.site->tasks[At(site)].expires_us);
      } else if (!charging || feasible_.free_places(column) > 0) {
        look.OfferLate(pair, rules.limit_us, uav, partner);
      }
    }
  }
  if (look.pairs_feasible > 0) return look;
  if (look.idle_uavs == 0) {
    look.obstacle = Obstacle::kNoUav;
  } else if (look.idle_partners == 0) {
    look.obstacle = Obstacle::kNoPartner;
  } else if (charging && feasible_.free_places(column) == 0) {
    look.obstacle = Obstacle::kNoPlace;
  } else if (look.uavs_in_range == 0) {
    look.obstacle = Obstacle::kRange;
  } else {
    look.obstacle = look.pairs_after_expiry > 0   ? Obstacle::kExpiry
                    : look.pairs_after_window > 0 ? Obstacle::kWindow
                                                  : Obstacle::kLimit;
  }
  return look;
}

std::optional<double> Look::WeightOf(const Action& action) const {
  const int u = action.uav.valid() ? RowOf(AgentKind::kUav, action.uav.value) : -1;
  const int w = action.worker.valid() ? RowOf(AgentKind::kWorker, action.worker.value) : -1;
  const int v = action.vehicle.valid() ? RowOf(AgentKind::kVehicle, action.vehicle.value) : -1;
  if ((action.uav.valid() && u < 0) || (action.worker.valid() && w < 0) ||
      (action.vehicle.valid() && v < 0)) {
    return {};
  }
  int x = -1;
  if (action.task.valid()) {
    const auto found = std::lower_bound(weights_.tasks.begin(), weights_.tasks.end(), action.task);
    if (found == weights_.tasks.end() || *found != action.task) return {};
    x = static_cast<int>(found - weights_.tasks.begin());
  }
  const int y = action.charge.value;
  const auto when = [](bool offered, auto&& weight) {
    return offered ? std::optional<double>(weight()) : std::nullopt;
  };
  switch (action.kind) {
    case ActionKind::kUavStays:
    case ActionKind::kWorkerStays:
    case ActionKind::kVehicleStays:
      return weights_.stay;
    case ActionKind::kUavToTask:
      return when(feasible_.UavToTask(u, x), [&] { return weights_.uav_to_task(u, x); });
    case ActionKind::kWorkerToTask:
      return when(feasible_.WorkerToTask(w, x), [&] { return weights_.worker_to_task(w, x); });
    case ActionKind::kUavToCharge:
      return when(feasible_.UavToCharge(u, y), [&] { return weights_.uav_to_charge(u, y); });
    case ActionKind::kVehicleToCharge:
      return when(feasible_.VehicleToCharge(v, y),
                  [&] { return weights_.vehicle_to_charge(v, y); });
    case ActionKind::kSense:
      return when(feasible_.Sense(u, x, w), [&] { return weights_.Sense(u, x, w); });
    case ActionKind::kCharge:
      return when(feasible_.Charge(u, y, v), [&] { return weights_.Charge(u, y, v); });
    default:
      return {};
  }
}

}  // namespace muster::scheduler
