#include "tools/explain/phrases.h"

#include <fmt/format.h>

#include "lcmtypes/words.h"
#include "tools/explain/words.h"

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

std::string LateWords(const PairLook& pair, bool charging) {
  if (pair.end_us == kNever) return PairWords(pair, charging) + " would never be done";
  const std::string done =
      fmt::format("{} would be done at {}", PairWords(pair, charging), ClockWords(pair.end_us));
  if (!pair.window_of) {
    return fmt::format("{}, the mission ends at {}", done, ClockWords(pair.latest_us));
  }
  return fmt::format("{}, but {} goes offline at {}", done,
                     *pair.window_of == AgentKind::kUav ? AgentName(AgentKind::kUav, pair.uav.value)
                                                        : PartnerOf(pair, charging),
                     ClockWords(pair.latest_us));
}

/// "free", or "idle or free within 2 decisions".
std::string Free(const PlaceLook& look) {
  if (look.soon_decisions == 0) return "free";
  return fmt::format("idle or free within {}", Plural(look.soon_decisions, "decision"));
}

}  // namespace

std::string Km(double metres) { return fmt::format("{:.2f} km", metres / 1000); }

std::string Until(TimeUs t) { return t == kNever ? "an unknown time" : ClockWords(t); }

std::string PartnerOf(const PairLook& pair, bool charging) {
  return AgentName(charging ? AgentKind::kVehicle : AgentKind::kWorker, pair.partner);
}

std::string FreeWords(const std::optional<TimeUs>& free_us) {
  return free_us ? fmt::format(" (free at {})", ClockWords(*free_us)) : std::string();
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
      return fmt::format("no UAV is {} ({} under way{})", Free(look), look.busy_uavs,
                         look.soon_decisions > 0 ? " for longer" : "");
    case Obstacle::kNoPartner:
      return fmt::format("no {} is {} ({} under way{})", partner, Free(look), look.busy_partners,
                         look.soon_decisions > 0 ? " for longer" : "");
    case Obstacle::kNoPlace:
      return "the charging point is full";
    case Obstacle::kRange:
      return fmt::format("range (constraint {}): {}", look.charging ? 5 : 6,
                         look.nearest_range ? RangeWords(*look.nearest_range, look.charging) : "");
    case Obstacle::kNoUse:
      return "charging would enable no further task";
    case Obstacle::kExpiry:
      return look.nearest_time ? fmt::format("the task expires at {}, {} would be there at {}",
                                             ClockWords(look.nearest_time->latest_us),
                                             PairWords(*look.nearest_time, false),
                                             ClockWords(look.nearest_time->end_us))
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
  return fmt::format("under way: {} sense it from {} to {}", pair, ClockWords(activity->start_us),
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
  } else if (state.target >= 0) {
    const bool charging =
        state.action == ActionKind::kUavToCharge || state.action == ActionKind::kVehicleToCharge;
    (charging ? action.charge.value : action.task.value) = state.target;
  }
  return fmt::format("busy until {}: {} (since decision {})", Until(state.busy_until_us),
                     Words(action), state.decision);
}

void Lines::Begin(std::int32_t decision, TimeUs at_us) {
  lead_ = fmt::format("decision {:>3}  {}  ", decision, ClockWords(at_us));
}

void Lines::Add(const std::string& line) {
  *text_ += lead_ + line + "\n";
  lead_ = std::string(23, ' ');
}

void Lines::AddEvents(const std::vector<event_t>& events) {
  for (const event_t& event : events) {
    std::string who;
    const auto add = [&who](const char* name, std::int32_t id) {
      if (id >= 0) who += fmt::format(" {}:{}", name, id);
    };
    add("uav", event.uav_id);
    add("worker", event.worker_id);
    add("vehicle", event.vehicle_id);
    add("task", event.task_id);
    add("charge", event.charge_id);
    Add(fmt::format("* {} {}{}", ClockWords(event.at_us), Spaced(ToString<EventKind>(event.kind)),
                    who));
  }
}

}  // namespace muster::tools
