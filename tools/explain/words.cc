#include "tools/explain/words.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/host/progress.h"

namespace muster::tools {
namespace {

using scheduler::Obstacle;
using scheduler::PairLook;
using scheduler::PlaceLook;
using scheduler::RangeNeed;

std::string RangeWords(const RangeNeed& need, bool charging) {
  const std::string uav = AgentName(AgentKind::kUav, need.uav.value) + FreeWords(need.free_us);
  if (charging) {
    return fmt::format("{} has {} of range and is {} away", uav, Km(need.range_m), Km(need.way_m));
  }
  return fmt::format("{} has {} of range and needs {}: {} to the task, {} to sense, {} to charge",
                     uav, Km(need.range_m), Km(need.needs_m()), Km(need.way_m), Km(need.cost_m),
                     Km(need.to_charge_m));
}

/// ", worker:7 goes 14.20 km by road (5.10 km straight)"; "" where ways are straight.
std::string RoadWords(const PairLook& pair, bool charging) {
  if (!pair.partner_way) return "";
  return fmt::format(", {} goes {} by road ({} straight)", PartnerOf(pair, charging),
                     Km(pair.partner_way->ground_m), Km(pair.partner_way->straight_m));
}

std::string LateWords(const PairLook& pair, bool charging) {
  if (pair.end_us == kNever) return PairWords(pair, charging) + " would never be done";
  const std::string done = fmt::format("{} would be done at {}{}", PairWords(pair, charging),
                                       ClockText(pair.end_us), RoadWords(pair, charging));
  if (!pair.window_of) {
    return fmt::format("{}, the mission ends at {}", done, ClockText(pair.latest_us));
  }
  return fmt::format("{}, but {} goes offline at {}", done,
                     *pair.window_of == AgentKind::kUav ? AgentName(AgentKind::kUav, pair.uav.value)
                                                        : PartnerOf(pair, charging),
                     ClockText(pair.latest_us));
}

/// "free", or "idle or free within 2 decisions".
std::string Free(const PlaceLook& look) {
  if (look.soon_decisions == 0) return "free";
  return fmt::format("idle or free within {}", Plural(look.soon_decisions, "decision"));
}

/// ", 2 not ready"
std::string NotReady(int agents) {
  return agents > 0 ? fmt::format(", {} not ready", agents) : std::string();
}

}  // namespace

std::string AgentName(AgentKind kind, std::int32_t id) {
  return fmt::format("{}:{}", ToString(kind), id);
}

std::string Words(const Action& action) {
  const std::string uav = AgentName(AgentKind::kUav, action.uav.value);
  const std::string worker = AgentName(AgentKind::kWorker, action.worker.value);
  const std::string vehicle = AgentName(AgentKind::kVehicle, action.vehicle.value);
  switch (action.kind) {
    case ActionKind::kUavStays:
      return uav + " stays";
    case ActionKind::kWorkerStays:
      return worker + " stays";
    case ActionKind::kVehicleStays:
      return vehicle + " stays";
    case ActionKind::kUavToTask:
      return fmt::format("{} goes to task:{}", uav, action.task.value);
    case ActionKind::kWorkerToTask:
      return fmt::format("{} goes to task:{}", worker, action.task.value);
    case ActionKind::kUavToCharge:
      return fmt::format("{} goes to charge:{}", uav, action.charge.value);
    case ActionKind::kVehicleToCharge:
      return fmt::format("{} goes to charge:{}", vehicle, action.charge.value);
    case ActionKind::kSense:
      return fmt::format("{} and {} sense task:{}", uav, worker, action.task.value);
    case ActionKind::kCharge:
      return fmt::format("{} charges {} at charge:{}", vehicle, uav, action.charge.value);
    case ActionKind::kGoTo:
      return fmt::format("{} goes to ({:.2f}, {:.2f}) km",
                         action.uav.valid()      ? uav
                         : action.worker.valid() ? worker
                                                 : vehicle,
                         action.to.x_m / 1000, action.to.y_m / 1000);
    case ActionKind::kNone:
      break;
  }
  return "nothing";
}

std::vector<Action> OnlyIn(const std::vector<Action>& some, const std::vector<Action>& others) {
  std::vector<Action> left;
  for (const Action& action : some) {
    const bool both = std::any_of(others.begin(), others.end(), [&](Action other) {
      other.weight = action.weight;
      return other == action;
    });
    if (!both && !IsStay(action.kind)) left.push_back(action);
  }
  return left;
}

int MovesIn(const schedule_t& schedule) {
  return static_cast<int>(
      std::count_if(schedule.actions.begin(), schedule.actions.end(),
                    [](const action_t& a) { return !IsStay(static_cast<ActionKind>(a.kind)); }));
}

nlohmann::ordered_json ActionJson(const action_t& action) {
  return {{"kind", action.kind},          {"symbol", ToString<ActionKind>(action.kind)},
          {"uav", action.uav_id},         {"worker", action.worker_id},
          {"vehicle", action.vehicle_id}, {"task", action.task_id},
          {"charge", action.charge_id},   {"weight", action.weight}};
}

std::string Km(double metres) { return fmt::format("{:.2f} km", metres / 1000); }

std::string Until(TimeUs t) { return t == kNever ? "an unknown time" : ClockText(t); }

std::string PartnerOf(const PairLook& pair, bool charging) {
  return AgentName(charging ? AgentKind::kVehicle : AgentKind::kWorker, pair.partner);
}

std::string FreeWords(const std::optional<TimeUs>& free_us) {
  return free_us ? fmt::format(" (free at {})", ClockText(*free_us)) : std::string();
}

std::string PairWords(const PairLook& pair, bool charging) {
  return fmt::format("{}{} and {}{}", AgentName(AgentKind::kUav, pair.uav.value),
                     FreeWords(pair.uav_free_us), PartnerOf(pair, charging),
                     FreeWords(pair.partner_free_us));
}

std::string ObstacleWords(const PlaceLook& look) {
  const char* partner = look.charging ? "vehicle" : "worker";
  switch (look.obstacle) {
    case Obstacle::kNone:
      return "possible";
    case Obstacle::kNoUav:
      return fmt::format("no UAV is {} ({} under way{}{})", Free(look), look.busy_uavs,
                         look.soon_decisions > 0 ? " for longer" : "", NotReady(look.unready_uavs));
    case Obstacle::kNoPartner:
      return fmt::format("no {} is {} ({} under way{}{})", partner, Free(look), look.busy_partners,
                         look.soon_decisions > 0 ? " for longer" : "",
                         NotReady(look.unready_partners));
    case Obstacle::kNoPlace:
      return "the charging point is full";
    case Obstacle::kRange:
      return fmt::format("range (constraint {}): {}", look.charging ? 5 : 6,
                         look.nearest_range ? RangeWords(*look.nearest_range, look.charging) : "");
    case Obstacle::kNoRoad:
      return fmt::format("no road leads there for any {} that is {}", partner, Free(look));
    case Obstacle::kClosed: {
      const Closure& closure = *look.closure;
      return fmt::format("cut off for every {} that is {}, since {} by the closure {}", partner,
                         Free(look), ClockText(closure.since_us),
                         closure.name.empty() ? closure.order : closure.name);
    }
    case Obstacle::kZone:
      return look.closure
                 ? fmt::format(
                       "it lies in the zone {} or its margin, which UAVs keep out of "
                       "since {}",
                       look.closure->name.empty() ? look.closure->order : look.closure->name,
                       ClockText(look.closure->since_us))
                 : std::string("zones keep every UAV from it, or from charging after it");
    case Obstacle::kForbidden:
      return "the commander forbids it to all who could do it";
    case Obstacle::kNoUse:
      return "charging would enable no further task";
    case Obstacle::kExpiry:
      return look.nearest_time ? fmt::format("the task expires at {}, {} would be there at {}{}",
                                             ClockText(look.nearest_time->latest_us),
                                             PairWords(*look.nearest_time, false),
                                             ClockText(look.nearest_time->end_us),
                                             RoadWords(*look.nearest_time, false))
                               : "the task expires before";
    case Obstacle::kWindow:
    case Obstacle::kLimit:
      return fmt::format("{}: {}",
                         look.obstacle == Obstacle::kWindow ? "online window" : "time limit",
                         look.nearest_time ? LateWords(*look.nearest_time, look.charging) : "");
  }
  return "";
}

std::string Plural(int n, const char* what) {
  return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
}

std::string BlockedWords(int places, const PlaceLook& nearest) {
  const bool numbers =
      nearest.obstacle == Obstacle::kRange || nearest.obstacle == Obstacle::kWindow ||
      nearest.obstacle == Obstacle::kLimit || nearest.obstacle == Obstacle::kExpiry;
  return fmt::format("not {}: {}{}", Plural(places, nearest.charging ? "charging point" : "task"),
                     numbers ? fmt::format("at {}:{}, which comes nearest, ",
                                           nearest.charging ? "charge" : "task", nearest.site)
                             : "",
                     ObstacleWords(nearest));
}

std::string UnderWayWords(const std::optional<Activity>& activity) {
  if (!activity) return "under way";
  const std::string pair =
      fmt::format("uav:{} and worker:{}", activity->uav.value, activity->partner);
  if (activity->start_us == kNever) return fmt::format("under way: {} are going there", pair);
  return fmt::format("under way: {} sense it from {} to {}", pair, ClockText(activity->start_us),
                     Until(activity->end_us));
}

std::string BusyWords(AgentKind kind, const AgentState& state) {
  Action action;
  action.kind = state.action;
  action.to = state.to;
  const auto set = [&](AgentKind of, std::int32_t id) {
    if (of == AgentKind::kUav) action.uav = UavId(id);
    if (of == AgentKind::kWorker) action.worker = WorkerId(id);
    if (of == AgentKind::kVehicle) action.vehicle = VehicleId(id);
  };
  set(kind, state.id);
  if (IsPair(state.action)) {
    const bool charging = state.action == ActionKind::kCharge;
    set(kind != AgentKind::kUav ? AgentKind::kUav
        : charging              ? AgentKind::kVehicle
                                : AgentKind::kWorker,
        state.partner);
    (charging ? action.charge.value : action.task.value) = state.target;
  } else if (state.site() >= 0) {
    const bool charging =
        state.action == ActionKind::kUavToCharge || state.action == ActionKind::kVehicleToCharge;
    (charging ? action.charge.value : action.task.value) = state.target;
  }
  return fmt::format("busy until {}: {} (since decision {})", Until(state.busy_until_us),
                     Words(action), state.decision);
}

}  // namespace muster::tools
