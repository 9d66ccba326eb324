#include "tools/explain/words.h"

#include <fmt/format.h>

#include <algorithm>

#include "world/model/action.h"

namespace muster::tools {

std::string ClockWords(TimeUs t) {
  const std::int64_t s = t / kSecondUs;
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

int MovesIn(const schedule_t& schedule) {
  return static_cast<int>(std::count_if(schedule.actions.begin(), schedule.actions.end(),
                                        [](const action_t& a) { return a.kind > 2; }));
}

nlohmann::ordered_json ActionJson(const action_t& action) {
  return {{"kind", action.kind},          {"symbol", Symbol(static_cast<ActionKind>(action.kind))},
          {"uav", action.uav_id},         {"worker", action.worker_id},
          {"vehicle", action.vehicle_id}, {"task", action.task_id},
          {"charge", action.charge_id},   {"weight", action.weight}};
}

}  // namespace muster::tools
