#include "tools/audit/values.h"

#include <fmt/format.h>

#include <cmath>

namespace muster::tools::audit {
namespace {

constexpr double kCellSide_m = 1000;

/// " uav:3 worker:5" of those that there are.
std::string Ids(int uav, int worker, int vehicle, int task, int charge) {
  std::string text;
  const auto add = [&text](const char* name, int id) {
    if (id >= 0) text += fmt::format(" {}:{}", name, id);
  };
  add("uav", uav);
  add("worker", worker);
  add("vehicle", vehicle);
  add("task", task);
  add("charge", charge);
  return text;
}

}  // namespace

bool Near(double a_m, double b_m) { return std::abs(a_m - b_m) <= kTolerance_m; }
bool NearUs(std::int64_t a, std::int64_t b) {
  return a == b || (a != kForever && b != kForever && std::abs(a - b) <= kToleranceUs);
}
bool Within(double value, Interval range, double tolerance) {
  return range.low - tolerance <= value && value <= range.high + tolerance;
}
bool SameCell(Place a, Place b) {
  return std::floor(a.x_m / kCellSide_m) == std::floor(b.x_m / kCellSide_m) &&
         std::floor(a.y_m / kCellSide_m) == std::floor(b.y_m / kCellSide_m);
}

EventKey KeyOf(const event_t& e) {
  return {e.at_us, e.kind, e.uav_id, e.worker_id, e.vehicle_id, e.task_id, e.charge_id};
}

std::string Name(const EventKey& key) {
  const auto& [at, kind, uav, worker, vehicle, task, charge] = key;
  return fmt::format("{}{} at {} us", Spaced(ToString<EventKind>(kind)),
                     Ids(uav, worker, vehicle, task, charge), at);
}

std::string Name(const action_t& a) {
  return (IsWord<ActionKind>(a.kind) ? std::string(ToString<ActionKind>(a.kind))
                                     : fmt::format("kind {}", a.kind)) +
         Ids(a.uav_id, a.worker_id, a.vehicle_id, a.task_id, a.charge_id);
}

std::string Name(const Activity& a) {
  return fmt::format("{} of uav:{} and {}:{} at {}:{} in [{}, {}] us", ToString(a.kind), a.uav,
                     ToString<AgentKind>(a.partner_class()), a.partner,
                     a.senses() ? "task" : "charge", a.site, a.start_us, a.end_us);
}

std::string_view TaskWords(std::int64_t status) {
  return status == TaskStatus::kSensing ? "being sensed" : ToString<TaskStatus>(status);
}

Activity FromWire(const activity_t& a) {
  return {
      static_cast<ActivityKind>(a.kind), a.uav_id, a.partner_id, a.site_id, a.start_us, a.end_us};
}

}  // namespace muster::tools::audit
