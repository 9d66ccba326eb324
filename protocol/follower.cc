#include "protocol/follower.h"

#include "base/check.h"
#include "base/sha256.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"

namespace muster {

void Follower::OnMessage(const Message& message, const Packet& packet, const Now& now) {
  if (scenario_) return OnMissionMessage(message, packet, now);
  const auto* const scenario = std::get_if<scenario_t>(&message);
  if (scenario == nullptr) return;
  if (Sha256(scenario->json) != scenario->sha256) return inbox().Reject();
  try {
    scenario_ = ParseScenario(scenario->json, "scenario");
  } catch (const InputError&) {
    return inbox().Reject();
  }
  OnScenario();
}

void Follower::OnStep(const Now& now) {
  if (!scenario_) return Ask(channel::kScenario, 0, now);
  OnMissionStep(now);
}

void Follower::Follow(const clock_t& clock) {
  if (clock.phase == ClockPhase::kEnded) set_state(ProcessState::kEnded);
  if (clock.phase == ClockPhase::kRunning && state() == ProcessState::kReady)
    set_state(ProcessState::kRunning);
}

void Follower::Ask(std::string_view name, TimeUs sim_us, const Now& now) {
  if (request_.due_us() == kNever) request_.Start(now.monotonic_us);
  if (!request_.Fire(now.monotonic_us)) return;
  Request(name, sim_us, now);
}

}  // namespace muster
