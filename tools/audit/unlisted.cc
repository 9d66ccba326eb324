#include "tools/audit/unlisted.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "tools/audit/agent_model.h"

namespace muster::tools::audit {
namespace {

template <class T>
const T* Find(const std::vector<T>& all, std::int32_t id) {
  return id >= 0 && static_cast<std::size_t>(id) < all.size() ? &all[static_cast<std::size_t>(id)]
                                                              : nullptr;
}

/// Where the leg under way ends.
Place EndOfWay(const agent_t& told, int kind, std::int64_t told_us, const Scenario& scenario) {
  const bool to_charge = told.action == ActionKind::kUavToCharge ||
                         told.action == ActionKind::kVehicleToCharge ||
                         told.action == ActionKind::kCharge;
  if (told.action == ActionKind::kGoTo || told.action == ActionKind::kNone) {
    if (const auto stop = scenario.ways->StopOf(kind, told.target_id)) return *stop;
    // Straight on.
    const double part = static_cast<double>(told.arrive_us - told.depart_us) /
                        static_cast<double>(std::max<std::int64_t>(1, told_us - told.depart_us));
    return {told.from_x_m + part * (told.x_m - told.from_x_m),
            told.from_y_m + part * (told.y_m - told.from_y_m)};
  }
  const auto* charge = Find(scenario.charges, told.target_id);
  const auto* task = Find(scenario.tasks, told.target_id);
  if (to_charge) return charge == nullptr ? Place{told.x_m, told.y_m} : charge->at;
  return task == nullptr ? Place{told.x_m, told.y_m} : task->at;
}

/// The sensing or charging that its pair has told the end of, from told_us on; none: not yet.
std::optional<Activity> ActivityOf(const agent_t& told, AgentModel* model, std::int64_t told_us,
                                   const Scenario& scenario) {
  if (!model->pair() || model->busy_until_us == kForever || model->failed) return {};
  const bool is_uav = model->kind == kUav;
  Activity activity;
  activity.kind =
      told.action == ActionKind::kSense ? ActivityKind::kSensing : ActivityKind::kCharging;
  activity.end_us = told.busy_until_us;
  activity.start_us = told_us;
  const bool is_under_way =
      told.status == AgentStatus::kSensing || told.status == AgentStatus::kCharging;
  if (activity.senses()) {
    const auto* task = Find(scenario.tasks, told.target_id);
    const auto* uav = Find(scenario.agents[kUav], is_uav ? told.id : told.partner_id);
    if (task == nullptr || uav == nullptr) return {};
    const std::int64_t duration_us = DurationUs(task->cost_m, uav->speed_m_s);
    if (!is_under_way) activity.start_us = activity.end_us - duration_us;
    // What is left to sense.
    model->cost_m = !is_under_way || duration_us <= 0
                        ? task->cost_m
                        : task->cost_m * static_cast<double>(activity.end_us - told_us) /
                              static_cast<double>(duration_us);
    return activity;
  }
  if (is_under_way) return activity;
  const auto* vehicle = Find(scenario.agents[kVehicle], told.partner_id);
  if (!is_uav || vehicle == nullptr) return {};  // a vehicle says when it begins
  activity.start_us =
      activity.end_us -
      DurationUs(model->spec->range_full_m - model->RangeOnArrival(), vehicle->charge_rate_m_s);
  return activity;
}

}  // namespace

agent_t Unlisted(const agent_t& told, int kind, std::int64_t told_us, std::int64_t t,
                 const Scenario& scenario) {
  AgentModel model;
  model.kind = kind;
  model.id = told.id;
  model.spec = &scenario.agents[kind][static_cast<std::size_t>(told.id)];
  // A measured agent's leg is always one by the ways of the present.
  model.ways = model.leg_ways =
      &scenario.WaysAt(model.spec->measured ? told_us : std::min(told.depart_us, told_us));
  model.from = model.to = {told.x_m, told.y_m};
  model.depart_us = told_us;
  model.arrive_us = std::max(told_us, told.arrive_us);
  model.range_at_departure_m = told.range_left_m;
  model.action = static_cast<ActionKind>(told.action);
  model.busy_until_us = told.busy_until_us;
  model.failed = told.status == AgentStatus::kFailed;
  if (told_us < told.arrive_us) {
    const double moved = model.ways->Gone(kind, {told.from_x_m, told.from_y_m}, model.from);
    model.to = EndOfWay(told, kind, told_us, scenario);
    if (kind == kUav && scenario.separation && !model.spec->measured) {
      const double rest_m = model.ways->Length(kind, model.from, model.to);
      const std::int64_t rest_us = DurationUs(rest_m, model.spec->speed_m_s);
      model.hold_us =
          std::max<std::int64_t>(0, told.arrive_us - told_us - std::min(rest_us, told.arrive_us));
    }
    if (scenario.wind.high > 0 && moved > 0) {
      model.range_per_m = (told.range_at_departure_m - told.range_left_m) / moved;
    }
  }
  model.activity = ActivityOf(told, &model, told_us, scenario);
  agent_t now = told;
  const Place here = model.At(t);
  now.x_m = here.x_m;
  now.y_m = here.y_m;
  if (kind == kUav) now.range_left_m = std::max(0.0, model.RangeAt(t));
  now.status = static_cast<std::int8_t>(model.StatusAt(t));
  return now;
}

}  // namespace muster::tools::audit
