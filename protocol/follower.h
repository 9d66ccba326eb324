#pragma once

#include <muster/clock_t.hpp>
#include <optional>
#include <string_view>

#include "model/scenario.h"
#include "protocol/process.h"

namespace muster {

/// A participant that follows the world's clock. It asks for the scenario until it has one, and
/// only then hears anything else.
class Follower : public Process {
 public:
  using Process::Process;

 protected:
  /// Once, when scenario() has come.
  virtual void OnScenario() = 0;
  /// As OnMessage and OnStep, with a scenario.
  virtual void OnMissionMessage(const Message& message, const Packet& packet, const Now& now) = 0;
  virtual void OnMissionStep(const Now& now) = 0;

  const std::optional<Scenario>& scenario() const { return scenario_; }

  /// Goes from ready to running to ended as the clock says.
  void Follow(const clock_t& clock);

  /// Requests what that channel carries, again and again while it is called.
  void Ask(std::string_view channel, TimeUs sim_us, const Now& now);
  void StopAsking() {
    request_.Stop();
    ForgetQuestions();
  }

  TimeUs OwnWakeUs() const override { return request_.due_us(); }

 private:
  void OnMessage(const Message& message, const Packet& packet, const Now& now) final;
  void OnStep(const Now& now) final;

  std::optional<Scenario> scenario_;
  BackOff request_{5'000, 200'000};
};

}  // namespace muster
