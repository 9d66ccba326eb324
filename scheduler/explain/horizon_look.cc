#include "scheduler/explain/horizon_look.h"

#include <algorithm>

#include "base/index.h"

namespace muster::scheduler {
namespace {

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
  const auto found = std::lower_bound(begin, end, site);
  if (found == end || *found != site) return -1;
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

HorizonLook::HorizonLook(const Situation& situation, const HorizonSettings& settings)
    : situation_(situation),
      settings_(settings),
      participants_(ParticipantsOf(situation, settings)),
      open_(OpenSitesOf(situation)),
      pairs_(FindPairs(situation, participants_, open_, settings)) {}

std::int32_t HorizonLook::IndexOf(AgentKind kind, std::int32_t id) const {
  const auto& of_kind = participants_[kind];
  const auto found =
      std::lower_bound(of_kind.begin(), of_kind.end(), id,
                       [](const Participant& p, std::int32_t i) { return p.agent->id < i; });
  if (found == of_kind.end() || found->agent->id != id) return -1;
  return static_cast<std::int32_t>(found - of_kind.begin());
}

std::int32_t HorizonLook::SiteOf(bool charging, std::int32_t site) const {
  return SiteIn(pairs_, charging, site);
}

PlaceLook HorizonLook::AtTask(TaskId task, UavId uav, WorkerId worker) const {
  return AtPlace(false, task.value, uav.value, worker.value);
}

PlaceLook HorizonLook::AtCharge(ChargeId charge, UavId uav, VehicleId vehicle) const {
  return AtPlace(true, charge.value, uav.value, vehicle.value);
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
  Restrict(partner,
           &untimed.participants[look.charging ? AgentKind::kVehicle : AgentKind::kWorker]);
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

/// What keeps the others from it: whose range, whose time.
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
    RangeNeed need{UavId(p.agent->id), p.range_m, 0, 0, 0, FreeUs(p)};
    const Site& places = *situation_.site;
    if (look->charging) {
      need.way_m = p.agent->WayM(p.at, places.charging_points[At(look->site)].at);
      if (need.needs_m() <= p.range_m) {
        ++look->uavs_without_use;
        continue;
      }
    } else {
      need.way_m = p.agent->WayM(p.at, places.tasks[At(look->site)].at);
      need.cost_m = places.tasks[At(look->site)].cost_m;
      need.to_charge_m = places.task_to_charge_m[At(look->site)];
    }
    look->OfferShort(need);
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
    const auto& partners = look->charging ? some.vehicles : some.workers;
    look->OfferLate(pair, situation_.site->rules.limit_us, *some.uavs[At(match.uav)].agent,
                    *partners[At(match.partner)].agent);
  });
}

PlaceLook HorizonLook::AtPlace(bool charging, std::int32_t site, std::int32_t uav,
                               std::int32_t partner) const {
  const AgentKind partner_kind = charging ? AgentKind::kVehicle : AgentKind::kWorker;
  PlaceLook look;
  look.charging = charging;
  look.site = site;
  look.soon_decisions = settings_.soon_idle ? settings_.soon_decisions : 0;
  const auto count = [&](AgentKind kind, int* idle, int* soon, int* busy) {
    const auto& of_kind = participants_[kind];
    *idle = static_cast<int>(
        std::count_if(of_kind.begin(), of_kind.end(), [](const Participant& p) { return p.idle; }));
    *soon = static_cast<int>(of_kind.size()) - *idle;
    *busy = static_cast<int>(situation_.agents(kind).size() - of_kind.size());
  };
  count(AgentKind::kUav, &look.idle_uavs, &look.soon_uavs, &look.busy_uavs);
  count(partner_kind, &look.idle_partners, &look.soon_partners, &look.busy_partners);
  const bool full = charging && open_.place[At(site)] <= 0;
  if (!full) {
    AddFeasible(uav, partner, &look);
    AddImpossible(uav, partner, &look);
  }
  if (look.pairs_feasible > 0) return look;
  if (look.idle_uavs + look.soon_uavs == 0) {
    look.obstacle = Obstacle::kNoUav;
  } else if (look.idle_partners + look.soon_partners == 0) {
    look.obstacle = Obstacle::kNoPartner;
  } else if (full) {
    look.obstacle = Obstacle::kNoPlace;
  } else if (look.uavs_in_range == 0) {
    look.obstacle = look.nearest_range ? Obstacle::kRange : Obstacle::kNoUse;
  } else {
    look.obstacle = look.nearest_time->obstacle;
  }
  return look;
}

}  // namespace muster::scheduler
