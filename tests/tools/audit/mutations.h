#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <variant>
#include <vector>

#include "tests/tools/fake_mission.h"

namespace muster::tools {

/// An edit of a valid log that breaks one invariant.
struct Mutation {
  const char* name;
  const char* invariant;  ///< that the first violation must name
  std::int64_t at_us;     ///< its mission time
  const char* mentions;   ///< what its text must contain
  std::function<void(FakeLog*)> edit;
};

std::vector<Mutation> LockstepMutations();  ///< of sequence numbers and the lockstep
std::vector<Mutation> DecisionMutations();  ///< of decisions
std::vector<Mutation> AgentMutations();     ///< of agents
std::vector<Mutation> OutcomeMutations();   ///< of sensing, charging, tasks and events

std::vector<Mutation> Mutations();  ///< all of these

inline constexpr std::int64_t kMin = 60'000'000;

/// Reports of one agent at the ticks [first, last].
void EditAgent(FakeLog* log, int kind, int id, std::int64_t first, std::int64_t last,
               const std::function<void(agent_t&)>& edit);
void EditDecision(FakeLog* log, int decision, const std::function<void(schedule_t&)>& edit);
void EditActivity(FakeLog* log, int kind, int uav, const std::function<void(activity_t&)>& edit);
void EditEvents(FakeLog* log, int kind, const std::function<void(event_t&)>& edit);
void EditScenario(FakeLog* log, const std::function<void(nlohmann::json&)>& edit);
/// What a UAV has at the start, in the scenario and in its first report.
void SetFirstRange(FakeLog* log, int uav, double range_km);

template <class Message>
void Remove(FakeLog* log, const std::function<bool(const Message&)>& which) {
  std::erase_if(*log, [&](const FakeMessage& m) {
    const auto* body = std::get_if<Message>(&m.body);
    return body != nullptr && which(*body);
  });
}

}  // namespace muster::tools
