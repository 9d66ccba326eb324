#include "learning/practice_mission.h"

#include <algorithm>
#include <memory>

#include "base/check.h"

namespace muster::learning {
namespace {

scheduler::Situation StartOfMission(const Scenario& scenario) {
  if (scenario.IsOpen()) {
    throw InputError(scenario.name, "tasks", "priorities or times",
                     "tasks that are known from the start and never expire");
  }
  if (scenario.disturbances != Disturbances()) {
    throw InputError(scenario.name, "disturbances", "some",
                     "none: missions to learn from are undisturbed");
  }
  scheduler::Situation situation;
  situation.site = std::make_shared<const scheduler::Site>(scenario);
  situation.task_status.assign(scenario.tasks.size(), TaskStatus::kOpen);
  situation.charging_load.assign(scenario.charging_points.size(), 0);
  return situation;
}

}  // namespace

PracticeMission::PracticeMission(const Scenario& scenario) : model_(StartOfMission(scenario)) {
  for (const AgentKind kind : kAgentKinds) {
    std::int32_t id = 0;
    for (const AgentSpec& spec : scenario.agents(kind)) {
      to_come_.push_back(StartOf(kind, id++, spec, *scenario.ways));
    }
  }
  Join();
}

void PracticeMission::Step(const std::vector<Action>& actions) {
  model_.Step(actions);
  Join();
}

void PracticeMission::Join() {
  const TimeUs now = situation().now_us;
  std::erase_if(to_come_, [&](const AgentState& agent) {
    if (agent.online_from_us > now) return false;
    if (agent.online(now)) model_.Add(agent);
    return true;
  });
}

double CompletionOf(const Scenario& scenario, scheduler::Policy* policy) {
  PracticeMission mission(scenario);
  while (!mission.over()) mission.Step(policy->Decide(mission.situation()).actions);
  return static_cast<double>(mission.done()) / static_cast<double>(scenario.tasks.size());
}

}  // namespace muster::learning
