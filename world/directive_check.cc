#include "world/directive_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "base/number_text.h"
#include "model/feasibility.h"

namespace muster::world {
namespace {

constexpr double kFull_m = 1;  ///< a UAV that lacks less range than this is charged

std::string AgentName(const AgentState& agent) {
  return fmt::format("{}:{}", ToString(agent.kind), agent.id);
}

std::string Km(double metres) { return fmt::format("{:.1f} km", metres / 1000); }

class Check {
 public:
  Check(TimeUs t, const Scenario& scenario) : t_(t), scenario_(scenario) {}

  void Pin(const Directive& one, const AgentState& agent) const {
    const Task& task = scenario_.tasks[static_cast<std::size_t>(one.task)];
    const std::string there = fmt::format("task {}", one.task);
    for (const Directive& other : scenario_.directives) {
      const bool forbids = other.kind == Directive::Kind::kForbid && !other.area &&
                           other.task == one.task && other.agents[agent.kind] == agent.id;
      const bool off_limits =
          other.area && other.of_class == agent.kind && IsInside(*other.area, task.at);
      if (!forbids && !off_limits) continue;
      throw InputError(fmt::format("order {} forbids {} {}", other.order, AgentName(agent), there));
    }
    const double way_m = WayTo(agent, task.at, there);
    if (agent.kind == AgentKind::kUav) {
      const double home_m = NearestChargeM(*scenario_.ways, task.at, scenario_.charging_points);
      if (!CanSense(RangeOf(agent), way_m, task.cost_m, home_m)) {
        throw InputError(fmt::format("{} lacks range for {}: it needs {}, and has {}",
                                     AgentName(agent), there, Km(way_m + task.cost_m + home_m),
                                     Km(RangeOf(agent))));
      }
    }
    const TimeUs arrive_us = FreeAt(agent) + TravelUs(way_m, agent.speed_m_s);
    const auto late = [&](std::string_view than) {
      throw InputError(fmt::format("{} can be at {} at {}, after {}", AgentName(agent), there,
                                   TimeToText(arrive_us, kMinute) + " min", than));
    };
    if (!task.AllowsStart(arrive_us)) late("it expires");
    const TimeUs latest_us = LatestEnd(agent, scenario_.rules);
    if (latest_us != kNever && arrive_us > latest_us) late("it leaves or the mission ends");
  }

  void Charge(const Directive& one, const AgentState& uav) const {
    const double range_m = RangeOf(uav);
    if (!IsBusy(uav) && range_m >= uav.range_full_m - kFull_m) {
      throw InputError(fmt::format("{} is charged already", AgentName(uav)));
    }
    double nearest_m = INFINITY;
    for (std::size_t y = 0; y < scenario_.charging_points.size(); ++y) {
      if (one.charge >= 0 && static_cast<std::size_t>(one.charge) != y) continue;
      nearest_m = std::min(nearest_m, Way(uav, scenario_.charging_points[y].at));
    }
    if (CanReachCharge(range_m, nearest_m)) return;
    throw InputError(std::isinf(nearest_m)
                         ? fmt::format("no way leads {} to a charging point", AgentName(uav))
                         : fmt::format("{} does not reach {}: that is {}, and it has range for {}",
                                       AgentName(uav),
                                       one.charge < 0 ? "any charging point"
                                                      : fmt::format("charge:{}", one.charge),
                                       Km(nearest_m), Km(range_m)));
  }

  void GoTo(const Directive& one, const AgentState& agent) const {
    const Point at = scenario_.ways->StopNear(agent.kind, one.place).at;
    if (IsOffLimits(scenario_.directives, agent.kind, at)) {
      throw InputError(
          fmt::format("the place lies in an area that is forbidden to {}s", ToString(agent.kind)));
    }
    const double way_m = WayTo(agent, at, "that place");
    if (agent.kind == AgentKind::kUav && way_m > RangeOf(agent)) {
      throw InputError(fmt::format("{} lacks range for that place: it is {} away, and it has {}",
                                   AgentName(agent), Km(way_m), Km(RangeOf(agent))));
    }
  }

 private:
  bool IsBusy(const AgentState& agent) const { return agent.busy_until_us > t_; }
  TimeUs FreeAt(const AgentState& agent) const {
    return IsBusy(agent) && agent.busy_until_us != kNever ? agent.busy_until_us : t_;
  }
  double RangeOf(const AgentState& uav) const {
    return IsBusy(uav) ? uav.range_full_m : RangeAt(uav, t_, scenario_.tasks);
  }
  double Way(const AgentState& agent, Point to) const {
    return scenario_.ways->Length(agent.kind, agent.to, to);
  }
  double WayTo(const AgentState& agent, Point to, std::string_view there) const {
    const double way_m = Way(agent, to);
    if (std::isfinite(way_m)) return way_m;
    throw InputError(fmt::format("no way leads {} to {}: closed roads or zones lie between",
                                 AgentName(agent), there));
  }

  TimeUs t_;
  const Scenario& scenario_;
};

}  // namespace

void CheckAgent(TimeUs t, const AgentState& agent) {
  if (agent.failed) throw InputError(AgentName(agent) + " has failed");
  if (agent.online_until_us <= t && agent.busy_until_us <= t) {
    throw InputError(AgentName(agent) + " has left");
  }
}

void CheckDirective(const Directive& directive, TimeUs t, const Agents& agents,
                    const Scenario& scenario) {
  const Check check(t, scenario);
  for (const AgentKind kind : kAgentKinds) {
    const std::int32_t id = directive.agents[kind];
    if (id < 0) continue;
    const AgentState& agent = agents[kind][static_cast<std::size_t>(id)];
    CheckAgent(t, agent);
    if (directive.kind == Directive::Kind::kPin) check.Pin(directive, agent);
    if (directive.kind == Directive::Kind::kGoTo) check.GoTo(directive, agent);
    if (directive.kind == Directive::Kind::kChargeNow && kind == AgentKind::kUav) {
      check.Charge(directive, agent);
    }
  }
  if (directive.kind != Directive::Kind::kForbid || directive.area) return;
  const AgentKind kind = directive.agent_kind();
  for (const Directive& other : scenario.directives) {
    if (other.kind == Directive::Kind::kPin && other.task == directive.task &&
        other.agents[kind] == directive.agents[kind]) {
      throw InputError(fmt::format("order {} pins {}:{} to task {}: unpin it first", other.order,
                                   ToString(kind), directive.agents[kind], directive.task));
    }
  }
}

}  // namespace muster::world
