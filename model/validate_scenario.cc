#include <fmt/format.h>

#include "base/check.h"
#include "base/number_text.h"
#include "lcmtypes/bounds.h"
#include "model/scenario_json.h"

namespace muster {
namespace {

constexpr TimeUs kMaxDecisions = 1'000'000;
constexpr double kMaxWorth = 1e6;

/// The one list of rules, also for scenarios that were built in memory.
class Validator {
 public:
  Validator(const Scenario& scenario, std::string_view file) : scenario_(scenario), file_(file) {}

  void Run(bool may_lack_tasks) const {
    const Rules& rules = scenario_.rules;
    AboveZero("area_km[0]", scenario_.width_m, kFarthest_m);
    AboveZero("area_km[1]", scenario_.height_m, kFarthest_m);
    if (scenario_.origin) {
      Within("origin.latitude_deg", scenario_.origin->latitude_deg, kOne, -90, 90);
      Within("origin.longitude_deg", scenario_.origin->longitude_deg, kOne, -180, 180);
    }
    if (rules.limit_us <= 0 || !TimeFits(rules.limit_us)) {
      Fail("limit_min", MinutesText(rules.limit_us), "a number above 0");
    }
    if (rules.interval_us <= 0 || rules.interval_us > rules.limit_us) {
      Fail("interval_min", MinutesText(rules.interval_us),
           fmt::format("a number above 0 and at most limit_min ({})", MinutesText(rules.limit_us)));
    }
    if (rules.limit_us / rules.interval_us > kMaxDecisions) {
      Fail("interval_min", MinutesText(rules.interval_us),
           fmt::format("at most {} intervals in limit_min ({})", kMaxDecisions,
                       MinutesText(rules.limit_us)));
    }
    if (rules.tick_us <= 0 || rules.interval_us % rules.tick_us != 0) {
      Fail("rules.tick_s", TimeToText(rules.tick_us, kSecond),
           fmt::format("a number of seconds that divides interval_min ({})",
                       MinutesText(rules.interval_us)));
    }
    Interval("wind", scenario_.disturbances.wind, kOne, kMostWind);
    Interval("communication_km", scenario_.disturbances.communication_m, kKm, kLongestWay_m);
    Interval("agent_failure", scenario_.disturbances.agent_failure, kOne, 1);
    Interval("match_failure", scenario_.disturbances.match_failure, kOne, 1);
    Agents("uavs", AgentKind::kUav);
    Agents("workers", AgentKind::kWorker);
    Agents("vehicles", AgentKind::kVehicle);
    for (std::size_t i = 0; i < kPriorities; ++i) {
      Within(fmt::format("rules.priority_worth[{}]", i), rules.priority_worth[i], kOne, 0,
             kMaxWorth);
    }
    Within("rules.late_worth", rules.late_worth, kOne, 0, 1);
    if (rules.patience_us < 0 || !TimeFits(rules.patience_us)) {
      Fail("rules.patience_min", MinutesText(rules.patience_us),
           fmt::format("a number in [0, {}]", kMaxMinutes));
    }
    if (!may_lack_tasks) NotEmpty("tasks", scenario_.tasks.size());
    for (std::size_t i = 0; i < scenario_.tasks.size(); ++i) {
      const Key key{"tasks", i};
      InArea(key, scenario_.tasks[i].at);
      Within(key("cost_km"), scenario_.tasks[i].cost_m, kKm, 0, kLongestWay_m);
      Times(key, scenario_.tasks[i]);
    }
    NotEmpty("charging_points", scenario_.charging_points.size());
    for (std::size_t i = 0; i < scenario_.charging_points.size(); ++i) {
      const Key key{"charging_points", i};
      const ChargingPoint& point = scenario_.charging_points[i];
      InArea(key, point.at);
      if (point.capacity && *point.capacity < 1) {
        Fail(key("capacity")(), fmt::to_string(*point.capacity),
             "an integer of at least 1, or null");
      }
    }
  }

 private:
  /// A key path that is only put together when a message needs it.
  struct LazyPath {
    std::string_view list;
    std::size_t index = 0;
    std::string_view key;
    std::string operator()() const {
      return list.empty() ? std::string(key) : fmt::format("{}[{}].{}", list, index, key);
    }
  };
  struct Key {
    std::string_view list;
    std::size_t index;
    LazyPath operator()(std::string_view key) const { return {list, index, key}; }
  };

  [[noreturn]] void Fail(std::string_view key, std::string_view found,
                         std::string_view expected) const {
    throw InputError(file_, key, found, expected);
  }

  static bool TimeFits(TimeUs t) { return t <= static_cast<TimeUs>(kMaxMinutes) * kMinuteUs; }
  static std::string MinutesText(TimeUs t) { return TimeToText(t, kMinute); }

  /// In metres, at most `most_m`.
  void AboveZero(const LazyPath& key, double value_m, double most_m) const {
    if (value_m > 0 && value_m <= most_m) return;
    Fail(key(), ToText(value_m, kKm),
         fmt::format("a number above 0 and at most {}", ToText(most_m, kKm)));
  }
  void AboveZero(std::string_view key, double value_m, double most_m) const {
    AboveZero(LazyPath{"", 0, key}, value_m, most_m);
  }

  /// In metres a second, of going or of charging.
  void Rate(const LazyPath& key, double value_m_s) const {
    if (value_m_s >= kSlowest_m_s && value_m_s <= kFastest_m_s) return;
    Fail(key(), ToText(value_m_s, kKmPerMin),
         fmt::format("a number in [{}, {}]", kSlowest_km_min, kFastest_km_min));
  }

  /// low, high: in our unit.
  void Within(const LazyPath& key, double value, Unit unit, double low, double high) const {
    if (value >= low && value <= high) return;
    Fail(key(), ToText(value, unit),
         fmt::format("a number in [{}, {}]", ToText(low, unit), ToText(high, unit)));
  }
  void Within(std::string_view key, double value, Unit unit, double low, double high) const {
    Within(LazyPath{"", 0, key}, value, unit, low, high);
  }

  void InArea(const Key& key, Point at) const {
    Within(key("x_km"), at.x_m, kKm, 0, scenario_.width_m);
    Within(key("y_km"), at.y_m, kKm, 0, scenario_.height_m);
  }

  void Times(const Key& key, const Task& task) const {
    const auto at_least = [&](std::string_view name, TimeUs t, TimeUs low, std::string_view of) {
      if (t == kNever || (t >= low && TimeFits(t))) return;
      Fail(key(name)(), MinutesText(t),
           fmt::format("a number in [{}{}, {}]", MinutesText(low), of, kMaxMinutes));
    };
    at_least("reported_min", task.reported_us, 0, "");
    at_least("due_min", task.due_us, task.reported_us, " (reported_min)");
    at_least("expires_min", task.expires_us, task.due_us == kNever ? task.reported_us : task.due_us,
             task.due_us == kNever ? " (reported_min)" : " (due_min)");
    if (task.revisit_us <= 0) {
      Fail(key("revisit_min")(), MinutesText(task.revisit_us), "a number above 0");
    }
  }

  void Interval(std::string_view name, const Disturbances::Interval& interval, Unit unit,
                double most) const {
    const std::string key = fmt::format("disturbances.{}", name);
    Within(key + "[1]", interval.high, unit, 0, most);
    Within(key + "[0]", interval.low, unit, 0, interval.high);
  }

  void NotEmpty(std::string_view list, std::size_t size) const {
    if (size == 0) Fail(list, "an empty array", "at least one element");
    if (size > INT32_MAX) Fail(list, fmt::to_string(size), "at most 2147483647 elements");
  }

  void Agents(std::string_view list, AgentKind kind) const {
    const std::vector<AgentSpec>& agents = scenario_.agents(kind);
    NotEmpty(list, agents.size());
    for (std::size_t i = 0; i < agents.size(); ++i) {
      const AgentSpec& agent = agents[i];
      const Key key{list, i};
      InArea(key, agent.at);
      Rate(key("speed_km_per_min"), agent.speed_m_s);
      if (kind == AgentKind::kUav) {
        AboveZero(key("full_range_km"), agent.range_full_m, kLongestWay_m);
        Within(key("range_km"), agent.range_m, kKm, 0, agent.range_full_m);
      }
      if (kind == AgentKind::kVehicle) {
        Rate(key("charge_km_per_min"), agent.charge_rate_m_s);
      }
      if (agent.online_from_us < 0 || !TimeFits(agent.online_from_us)) {
        Fail(key("online_from_min")(), MinutesText(agent.online_from_us),
             fmt::format("a number in [0, {}]", kMaxMinutes));
      }
      if (agent.online_until_us < agent.online_from_us || !TimeFits(agent.online_until_us)) {
        Fail(key("online_until_min")(), MinutesText(agent.online_until_us),
             fmt::format("a number in [{} (online_from_min), {}]",
                         MinutesText(agent.online_from_us), kMaxMinutes));
      }
    }
  }

  const Scenario& scenario_;
  std::string_view file_;
};

}  // namespace

void ValidateScenario(const Scenario& scenario, std::string_view file, bool may_lack_tasks) {
  Validator(scenario, file).Run(may_lack_tasks);
}

}  // namespace muster
