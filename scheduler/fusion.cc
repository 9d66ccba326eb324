#include "scheduler/fusion.h"

#include <algorithm>

#include "base/check.h"

namespace muster::scheduler {

Fusion::Fusion(const std::shared_ptr<const Scenario>& scenario)
    : held_(scenario),
      scenario_(*scenario),
      limits_(scenario_),
      site_(std::make_shared<const Site>(scenario_)) {}

void Fusion::Start(std::int64_t tick, TimeUs t, std::int32_t decision) {
  tick_ = tick;
  now_us_ = t;
  decision_ = decision;
  missing_ = 0;
  for (const AgentKind kind : kAgentKinds) {
    agents_[kind].assign(limits_.agents(kind), std::nullopt);
    missing_ += limits_.agents(kind);
  }
  activities_.reset();
  rulings_.reset();
}

bool Fusion::Take(const agent_states_t& states) {
  if (states.tick != tick_) return true;
  const auto kind = static_cast<AgentKind>(states.kind);
  std::vector<AgentState> agents;
  agents.reserve(states.agents.size());
  for (const agent_t& wire : states.agents) {
    const std::optional<AgentState> agent = FromWire(wire, kind, now_us_, limits_);
    if (!agent) return false;
    agents.push_back(*agent);
  }
  for (const AgentState& agent : agents) {
    auto& slot = agents_[kind][static_cast<std::size_t>(agent.id)];
    if (!slot) --missing_;
    slot = agent;
  }
  return true;
}

bool Fusion::Take(const world_state_t& world) {
  if (world.tick != tick_ || activities_) return true;
  if (world.task_status.size() != scenario_.tasks.size()) return false;
  std::vector<Activity> activities;
  for (const activity_t& wire : world.activities) {
    const std::optional<Activity> activity = FromWire(wire, limits_);
    if (!activity) return false;
    activities.push_back(*activity);
  }
  task_status_.clear();
  for (const std::int8_t status : world.task_status) {
    task_status_.push_back(static_cast<TaskStatus>(status));
  }
  activities_ = std::move(activities);
  return true;
}

bool Fusion::Take(const rulings_t& rulings) {
  if (rulings.tick != tick_ || rulings_) return true;
  if (!Possible(rulings, scenario_.rules)) return false;
  std::vector<Ruling> list;
  for (const ruling_t& wire : rulings.rulings) {
    const std::optional<Ruling> ruling = FromWire(wire, limits_);
    if (!ruling) return false;
    list.push_back(*ruling);
  }
  rulings_ = std::move(list);
  return true;
}

std::size_t Fusion::silent() const {
  if (missing_ == 0) return 0;
  return static_cast<std::size_t>(
      std::count_if(rulings_->begin(), rulings_->end(), [&](const Ruling& ruling) {
        return ruling.fails() &&
               !agents_[ruling.agent_kind][static_cast<std::size_t>(ruling.agent)];
      }));
}

Situation Fusion::Fuse(const OrderBook& orders) {
  MUSTER_CHECK(complete(), "tick={}", tick_);
  if (orders.takes_orders() && orders.tick() > tick_) {
    // A world that has started again may have gone back to before the newest orders.
    site_version_ = -1;
    Situation situation = Fuse(orders.UpTo(tick_));
    site_version_ = -1;
    return situation;
  }
  if (site_version_ != orders.version()) {
    site_version_ = orders.version();
    site_ = std::make_shared<const Site>(*orders.scenario());
  }
  const Scenario& scenario = *orders.scenario();
  const Verdict verdict(*activities_, *rulings_);
  Situation situation;
  situation.site = site_;
  situation.decision = decision_;
  situation.now_us = now_us_;
  situation.task_status = task_status_;
  situation.charging_load.assign(scenario_.charging_points.size(), 0);
  const auto settle = [&](AgentKind kind, std::vector<AgentState>* out) {
    for (const auto& reported : agents_[kind]) {
      if (!reported) continue;
      AgentState agent = *reported;
      // The orders of the tick may have come after the report.
      agent.ways = &scenario.WaysAt(now_us_);
      agent.leg_ways = agent.measured ? agent.ways : &scenario.WaysAt(agent.depart_us);
      Settle(&agent, verdict, now_us_, site_->tasks);
      // The process of a place may be lost as an agent joins in it.
      const bool failed = agent.failed;
      for (const TakenOrder& order : orders.TakenAt(tick_)) {
        Obey(&agent, order, now_us_, scenario);
      }
      if (failed || (!agent.online(now_us_) && agent.busy_until_us <= now_us_)) continue;
      out->push_back(agent);
    }
  };
  settle(AgentKind::kUav, &situation.uavs);
  settle(AgentKind::kWorker, &situation.workers);
  settle(AgentKind::kVehicle, &situation.vehicles);
  for (const AgentState& uav : situation.uavs) {
    if (uav.action == ActionKind::kCharge) {
      ++situation.charging_load[static_cast<std::size_t>(uav.target)];
    }
  }
  return situation;
}

}  // namespace muster::scheduler
