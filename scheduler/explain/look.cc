#include "scheduler/explain/look.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/index.h"
#include "model/air_ways.h"
#include "model/feasibility.h"

namespace muster::scheduler {
namespace {

TimeUs Later(TimeUs t, TimeUs duration) { return duration > kNever - t ? kNever : t + duration; }

/// Settings by which the idle agents alone take part.
HorizonSettings IdleOnly() {
  HorizonSettings settings;
  settings.soon_idle = false;
  return settings;
}

/// Only that agent, when one is asked for.
void Restrict(std::int32_t id, std::vector<Participant>* participants) {
  if (id < 0) return;
  std::erase_if(*participants, [id](const Participant& p) { return p.agent->id != id; });
}

std::optional<TimeUs> FreeUs(const Participant& participant) {
  if (participant.idle) return {};
  return participant.ready_us;
}

/// Of an instance's sites; -1: not one of them.
std::int32_t SiteIn(const PossiblePairs& pairs, bool charging, std::int32_t site) {
  const auto tasks_end = pairs.site_ids.begin() + pairs.n_tasks;
  const auto begin = charging ? tasks_end : pairs.site_ids.begin();
  const auto end = charging ? pairs.site_ids.end() : tasks_end;
  const auto found = std::find(begin, end, site);
  if (found == end) return -1;
  return static_cast<std::int32_t>(found - pairs.site_ids.begin());
}

/// All arcs of a site, in pairs: visit(uav arc, partner arc).
template <class Visit>
void ForEachPair(const Instance& instance, std::int32_t site, Visit visit) {
  for (auto i = instance.uav_begin[At(site)]; i < instance.uav_begin[At(site) + 1]; ++i) {
    for (auto j = instance.partner_begin[At(site)]; j < instance.partner_begin[At(site) + 1]; ++j) {
      visit(instance.uav_arcs[At(i)], instance.partner_arcs[At(j)]);
    }
  }
}

}  // namespace

std::string_view ToString(Obstacle obstacle) {
  constexpr std::string_view kNames[] = {
      "none",          "no idle uav", "no idle partner", "no free place", "range",
      "online window", "time limit",  "expiry",          "no road",       "closed road",
      "zone",          "forbidden",   "no use"};
  return kNames[static_cast<int>(obstacle)];
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

Look::Look(const Situation& situation, const HorizonSettings& settings)
    : situation_(situation),
      participants_(ParticipantsOf(situation, settings)),
      soon_decisions_(settings.soon_idle ? settings.soon_decisions : 0) {}

std::int32_t Look::IndexOf(AgentKind kind, std::int32_t id) const {
  const auto& of_kind = participants_[kind];
  const auto found =
      std::lower_bound(of_kind.begin(), of_kind.end(), id,
                       [](const Participant& p, std::int32_t i) { return p.agent->id < i; });
  if (found == of_kind.end() || found->agent->id != id) return -1;
  return static_cast<std::int32_t>(found - of_kind.begin());
}

std::vector<PlaceLook> Look::PlacesOf(AgentKind kind, std::int32_t id) const {
  const UavId uav = kind == AgentKind::kUav ? UavId(id) : UavId();
  std::vector<PlaceLook> places;
  if (kind != AgentKind::kVehicle) {
    const WorkerId worker = kind == AgentKind::kWorker ? WorkerId(id) : WorkerId();
    for (std::size_t x = 0; x < situation_.task_status.size(); ++x) {
      if (situation_.task_status[x] != TaskStatus::kOpen) continue;
      places.push_back(AtTask(TaskId(x), uav, worker));
    }
  }
  if (kind != AgentKind::kWorker) {
    const VehicleId vehicle = kind == AgentKind::kVehicle ? VehicleId(id) : VehicleId();
    for (std::size_t y = 0; y < situation_.site->charging_points.size(); ++y) {
      places.push_back(AtCharge(ChargeId(y), uav, vehicle));
    }
  }
  return places;
}

RangeNeed Look::NeedOf(const Participant& uav, const PlaceLook& look) const {
  RangeNeed need{UavId(uav.agent->id), uav.range_m, 0, 0, 0, FreeUs(uav)};
  const Site& places = *situation_.site;
  if (look.charging) {
    need.way_m = uav.agent->WayM(uav.at, places.charging_points[At(look.site)].at);
  } else {
    need.way_m = uav.agent->WayM(uav.at, places.tasks[At(look.site)].at);
    need.cost_m = places.tasks[At(look.site)].cost_m;
    need.to_charge_m = places.task_to_charge_m[At(look.site)];
  }
  return need;
}

PlaceLook Look::AtPlace(bool charging, std::int32_t site, std::int32_t uav,
                        std::int32_t partner) const {
  PlaceLook look;
  look.charging = charging;
  look.site = site;
  look.soon_decisions = soon_decisions_;
  const auto count = [&](AgentKind kind, int* idle, int* soon, int* busy, int* unready) {
    const auto& of_kind = participants_[kind];
    *idle = static_cast<int>(
        std::count_if(of_kind.begin(), of_kind.end(), [](const Participant& p) { return p.idle; }));
    *soon = static_cast<int>(of_kind.size()) - *idle;
    const auto& all = situation_.agents(kind);
    *unready = static_cast<int>(
        std::count_if(all.begin(), all.end(), std::mem_fn(&AgentState::not_ready)));
    *busy = static_cast<int>(all.size() - of_kind.size()) - *unready;
  };
  count(AgentKind::kUav, &look.idle_uavs, &look.soon_uavs, &look.busy_uavs, &look.unready_uavs);
  count(look.partner_kind(), &look.idle_partners, &look.soon_partners, &look.busy_partners,
        &look.unready_partners);
  AddPairs(uav, partner, &look);
  if (look.pairs_feasible > 0) {
    look.obstacle = Obstacle::kNone;
  } else if (look.idle_uavs + look.soon_uavs == 0) {
    look.obstacle = Obstacle::kNoUav;
  } else if (look.idle_partners + look.soon_partners == 0) {
    look.obstacle = Obstacle::kNoPartner;
  } else if (IsFull(look)) {
    look.obstacle = Obstacle::kNoPlace;
  } else if (look.uavs_in_range == 0) {
    look.obstacle = look.nearest_range        ? Obstacle::kRange
                    : IsForbiddenToSome(look) ? Obstacle::kForbidden
                                              : Obstacle::kNoUse;
  } else if (look.pairs == 0) {
    LookForWay(partner, &look);
  }
  if (look.nearest_time) LookAtRoad(&look);
  LookAtZones(&look);
  return look;
}

void Look::LookAtRoad(PlaceLook* look) const {
  const AgentKind kind = look->partner_kind();
  const Ways& ways = *situation_.site->ways;
  const std::int32_t index = IndexOf(kind, look->nearest_time->partner);
  if (ways.straight(kind) || index < 0) return;
  const Point from = participants_[kind][At(index)].at;
  const Point to = look->charging ? situation_.site->charging_points[At(look->site)].at
                                  : situation_.site->tasks[At(look->site)].at;
  const double ground_m = ways.GroundLength(kind, from, to);
  if (std::isfinite(ground_m)) {
    look->nearest_time->partner_way = {ground_m, Distance(from, to)};
  } else if (look->obstacle == Obstacle::kLimit || look->obstacle == Obstacle::kWindow ||
             look->obstacle == Obstacle::kExpiry) {
    look->closure = ClosureOnTheWay(kind, from, to);
    look->obstacle = look->closure ? Obstacle::kClosed : Obstacle::kNoRoad;
  }
}

bool Look::IsForbiddenToSome(const PlaceLook& look) const {
  const auto& forbidden = situation_.site->forbidden;
  return !look.charging && std::any_of(forbidden.begin(), forbidden.end(),
                                       [&](const auto& pair) { return pair.task == look.site; });
}

void Look::LookForWay(std::int32_t partner, PlaceLook* look) const {
  const AgentKind kind = look->partner_kind();
  const Ways& ways = *situation_.site->ways;
  look->obstacle = IsForbiddenToSome(*look) ? Obstacle::kForbidden : Obstacle::kNoPartner;
  const Point to = look->charging ? situation_.site->charging_points[At(look->site)].at
                                  : situation_.site->tasks[At(look->site)].at;
  const Participant* nearest = nullptr;
  for (const Participant& p : participants_[kind]) {
    if (partner >= 0 && p.agent->id != partner) continue;
    if (std::isfinite(ways.Length(kind, p.at, to))) return;
    if (nearest == nullptr || Distance(p.at, to) < Distance(nearest->at, to)) nearest = &p;
  }
  if (nearest == nullptr) return;
  look->closure = ClosureOnTheWay(kind, nearest->at, to);
  look->obstacle = look->closure ? Obstacle::kClosed : Obstacle::kNoRoad;
}

void Look::LookAtZones(PlaceLook* look) const {
  const auto* const ways = dynamic_cast<const AirWays*>(situation_.site->ways.get());
  if (ways == nullptr) return;
  const Point at = look->charging ? situation_.site->charging_points[At(look->site)].at
                                  : situation_.site->tasks[At(look->site)].at;
  if (const auto zone = ways->air().ZoneAt(at)) {
    look->obstacle = Obstacle::kZone;
    // Zones stand in the order of their closures.
    std::size_t n = *zone;
    for (const Closure& closure : situation_.site->closures) {
      if (closure.zone && n-- == 0) look->closure = closure;
    }
  } else if (look->obstacle == Obstacle::kRange && look->nearest_range &&
             std::isinf(look->nearest_range->needs_m())) {
    look->obstacle = Obstacle::kZone;
  }
}

std::optional<Closure> Look::ClosureOnTheWay(AgentKind kind, Point from, Point to) const {
  const RoadWays* open = situation_.site->open_roads.get();
  if (open == nullptr) return {};
  for (const Closure& closure : situation_.site->closures) {
    if (open->BarredAt(kind, from, to, 0, *open->Without(closure.roads))) return closure;
  }
  return {};
}

PaperLook::PaperLook(const Situation& situation)
    : Look(situation, IdleOnly()), weights_(situation) {}

void PaperLook::AddPairs(std::int32_t uav, std::int32_t partner, PlaceLook* look) const {
  const auto forbids = [&](const Participant& p) {
    return !look->charging && situation_.site->Forbids(*p.agent, look->site);
  };
  for (const Participant& of_uav : participants_.uavs) {
    if ((uav >= 0 && of_uav.agent->id != uav) || forbids(of_uav)) continue;
    const RangeNeed need = NeedOf(of_uav, *look);
    if (need.needs_m() > need.range_m) {
      look->OfferShort(need);
      continue;
    }
    ++look->uavs_in_range;
    for (const Participant& of_partner : participants_[look->partner_kind()]) {
      if ((partner >= 0 && of_partner.agent->id != partner) || forbids(of_partner)) continue;
      AddPair(need, *of_uav.agent, *of_partner.agent, look);
    }
  }
  look->obstacle = look->pairs_after_expiry > 0   ? Obstacle::kExpiry
                   : look->pairs_after_window > 0 ? Obstacle::kWindow
                                                  : Obstacle::kLimit;
}

void PaperLook::AddPair(const RangeNeed& need, const AgentState& uav, const AgentState& partner,
                        PlaceLook* look) const {
  const Site& site = *situation_.site;
  const bool charging = look->charging;
  const Action action = MakeAction(site, &uav, &partner, charging ? TaskId() : TaskId(look->site),
                                   charging ? ChargeId(look->site) : ChargeId());
  const TimeUs travel_us =
      std::max(TravelUs(need.way_m, uav.speed_m_s),
               TravelUs(partner.WayM(partner.to, action.to), partner.speed_m_s));
  const TimeUs there_us = Later(situation_.now_us, travel_us);
  PairLook pair;
  pair.uav = UavId(uav.id);
  pair.partner = partner.id;
  pair.end_us = Later(there_us, charging ? ChargingUs(uav.range_full_m, need.range_m - need.way_m,
                                                      partner.charge_rate_m_s)
                                         : SensingUs(need.cost_m, uav.speed_m_s));
  ++look->pairs;
  if (const auto weight = weights_.Of(action)) {
    pair.weight = *weight;
    pair.latest_us = std::min(LatestEnd(uav, site.rules), LatestEnd(partner, site.rules));
    ++look->pairs_feasible;
    look->Offer(pair);
  } else if (!charging && !site.tasks[At(look->site)].AllowsStart(there_us)) {
    look->OfferExpired(pair, there_us, site.tasks[At(look->site)].expires_us);
  } else if (!IsFull(*look)) {
    look->OfferLate(pair, site.rules.limit_us, uav, partner);
  }
}

HorizonLook::HorizonLook(const Situation& situation, const HorizonSettings& settings)
    : Look(situation, settings),
      settings_(settings),
      open_(OpenSitesOf(situation)),
      pairs_(FindPairs(situation, participants_, open_, settings)) {}

std::int32_t HorizonLook::SiteOf(bool charging, std::int32_t site) const {
  return SiteIn(pairs_, charging, site);
}

PairLook HorizonLook::MakeLook(const Participants& participants, const Match& match) const {
  const Participant& uav = participants.uavs[At(match.uav)];
  const Participant& partner =
      (match.charging ? participants.vehicles : participants.workers)[At(match.partner)];
  PairLook pair;
  pair.uav = UavId(uav.agent->id);
  pair.partner = partner.agent->id;
  pair.weight = match.weight;
  pair.end_us = match.end_us;
  pair.latest_us = std::min(uav.latest_us, partner.latest_us);
  pair.uav_free_us = FreeUs(uav);
  pair.partner_free_us = FreeUs(partner);
  return pair;
}

/// The pairs that the matching chose from.
void HorizonLook::AddFeasible(std::int32_t uav, std::int32_t partner, PlaceLook* look) const {
  const std::int32_t site = SiteOf(look->charging, look->site);
  if (site < 0) return;
  ForEachPair(pairs_.instance, site, [&](const auto& uav_arc, const auto& partner_arc) {
    if (!pairs_.instance.Compatible(uav_arc, partner_arc)) return;
    const PairLook pair =
        MakeLook(participants_, MatchOf(pairs_, participants_, site, uav_arc, partner_arc));
    if ((uav >= 0 && pair.uav.value != uav) || (partner >= 0 && pair.partner != partner)) return;
    ++look->pairs_feasible;
    look->Offer(pair);
  });
}

HorizonLook::Untimed HorizonLook::Build(const PlaceLook& look, std::int32_t uav,
                                        std::int32_t partner) const {
  Untimed untimed{uav, partner, participants_, {}};
  untimed.participants[look.charging ? AgentKind::kWorker : AgentKind::kVehicle].clear();
  Restrict(uav, &untimed.participants.uavs);
  Restrict(partner, &untimed.participants[look.partner_kind()]);
  OpenSites open = open_;
  // What charging is worth rests on the tasks that are open; nobody is there to sense them.
  if (!look.charging) {
    std::fill(open.place.begin(), open.place.end(), 0);
    std::fill(open.task.begin(), open.task.end(), 0);
    open.task[At(look.site)] = 1;
  }
  Participants endless = untimed.participants;
  for (const AgentKind kind : kAgentKinds) {
    for (Participant& p : endless[kind]) p.latest_us = kNever;
  }
  HorizonSettings settings = settings_;
  settings.chains = false;  // a part of the worth, which is not asked for
  if (look.charging || situation_.site->tasks[At(look.site)].expires_us == kNever) {
    untimed.pairs = FindPairs(situation_, endless, open, settings);
  } else {
    Site lasting = *situation_.site;
    lasting.tasks[At(look.site)].expires_us = kNever;
    Situation situation = situation_;
    situation.site = std::make_shared<const Site>(std::move(lasting));
    untimed.pairs = FindPairs(situation, endless, open, settings);
  }
  return untimed;
}

/// Why the other pairs are impossible: range, or time.
void HorizonLook::AddImpossible(std::int32_t uav, std::int32_t partner, PlaceLook* look) const {
  std::optional<Untimed> task;
  std::optional<Untimed>& untimed = look->charging ? charges_ : task;
  if (!untimed || untimed->uav != uav || untimed->partner != partner) {
    untimed = Build(*look, uav, partner);
  }
  const Participants& some = untimed->participants;
  const PossiblePairs& pairs = untimed->pairs;
  const std::int32_t site = SiteIn(pairs, look->charging, look->site);
  const Instance& instance = pairs.instance;
  std::vector<char> in_range(some.uavs.size(), 0);
  for (auto i = instance.uav_begin[At(site)]; i < instance.uav_begin[At(site) + 1]; ++i) {
    in_range[At(instance.uav_arcs[At(i)].uav)] = 1;
    ++look->uavs_in_range;
  }
  for (std::size_t u = 0; u < some.uavs.size(); ++u) {
    if (in_range[u]) continue;
    const Participant& p = some.uavs[u];
    if (!look->charging && situation_.site->Forbids(*p.agent, look->site)) continue;
    const RangeNeed need = NeedOf(p, *look);
    if (!look->charging || need.needs_m() > p.range_m) look->OfferShort(need);
  }
  ForEachPair(instance, site, [&](const auto& uav_arc, const auto& partner_arc) {
    const Match match = MatchOf(pairs, some, site, uav_arc, partner_arc);
    const PairLook pair = MakeLook(some, match);
    ++look->pairs;
    const TimeUs there_us = std::max(uav_arc.arrive_us, partner_arc.arrive_us);
    if (!look->charging) {
      const Task& task_there = situation_.site->tasks[At(look->site)];
      if (!task_there.AllowsStart(there_us)) {
        look->OfferExpired(pair, there_us, task_there.expires_us);
        return;
      }
    }
    if (pair.end_us <= pair.latest_us) return;
    look->OfferLate(pair, situation_.site->rules.limit_us, *some.uavs[At(match.uav)].agent,
                    *some[look->partner_kind()][At(match.partner)].agent);
  });
}

void HorizonLook::AddPairs(std::int32_t uav, std::int32_t partner, PlaceLook* look) const {
  if (IsFull(*look)) return;
  AddFeasible(uav, partner, look);
  AddImpossible(uav, partner, look);
  if (look->nearest_time) look->obstacle = look->nearest_time->obstacle;
}

}  // namespace muster::scheduler
