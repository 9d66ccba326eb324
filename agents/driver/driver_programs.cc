#include "agents/driver/driver_programs.h"

#include <algorithm>

#include "base/check.h"

namespace muster::agents {
namespace {

using Clock = DriverProgram::Clock;

/// Longest wait for drivers at a time, because packets come meanwhile.
constexpr std::chrono::milliseconds kMoment(5);
/// At a rate what it says of a tick counts for that tick if it comes within this share of one.
constexpr double kShareOfTick = 0.25;
/// So often it hears what drivers say by themselves.
constexpr TimeUs kPatienceUs = 10'000;
constexpr std::chrono::seconds kToEnd(1);

}  // namespace

DriverPrograms::~DriverPrograms() {
  // All have the same moment.
  const Clock::time_point now = Clock::now();
  for (auto& [id, driver] : drivers_) {
    driver.program->AwaitEnd(driver.program->session().over() ? now + kToEnd : now);
  }
}

const DriverPrograms::Command* DriverPrograms::CommandOf(std::int32_t id) const {
  const Command* of_all = nullptr;
  for (const Command& command : commands_) {
    if (command.id == id) return &command;
    if (!command.id) of_all = &command;
  }
  return of_all;
}

void DriverPrograms::Begin(const Scenario& scenario, const AgentState& agent, TimeUs at) {
  const Command* command = CommandOf(agent.id);
  MUSTER_CHECK(command != nullptr, "{}", agent.id);
  kind_ = agent.kind;
  drivers_[agent.id] = {
      std::make_unique<DriverProgram>(command->argv, scenario, agent, at, rules_)};
}

void DriverPrograms::GiveAltitude(const Clearance& clearance) {
  const auto found = drivers_.find(clearance.uav);
  if (found != drivers_.end()) found->second.program->session().GiveAltitude(clearance);
}

void DriverPrograms::Tell(const AgentState& agent, TimeUs before, TimeUs at) {
  const auto found = drivers_.find(agent.id);
  if (found == drivers_.end() || !found->second.problem.empty()) return;
  DriverSession& session = found->second.program->session();
  if (agent.failed) return session.Bye("it counts as failed");
  if (agent.online_until_us <= before && agent.action == ActionKind::kNone) {
    return session.Bye("its time is over");
  }
  const TimeUs wall_us = DriverProgram::WallUs();
  if (rules_.rate > 0) {
    const double tick_s = std::min(1.0, ToSeconds(at - before) / rules_.rate);
    found->second.waited_for_until =
        Clock::now() + std::chrono::microseconds(ToUs(tick_s * kShareOfTick));
  }
  session.Follow(agent, before, wall_us);
  session.Tick(at, wall_us);
}

void DriverPrograms::Hear(Driver* driver, bool patient, Clock::time_point deadline) {
  if (!driver->problem.empty() || driver->program->ended()) return;
  // What a driver says last is not what has ended it.
  const bool was_over = driver->program->session().over();
  const std::string problem = driver->program->Pump(patient, deadline);
  if (!was_over && !driver->program->session().over()) driver->problem = problem;
}

bool DriverPrograms::IsAwaited(const Driver& driver) const {
  const DriverSession& session = driver.program->session();
  if (!driver.problem.empty() || session.over()) return false;
  if (!session.greeted()) return true;
  if (session.answered()) return false;
  return rules_.rate <= 0 || Clock::now() < driver.waited_for_until;
}

bool DriverPrograms::Listen() {
  const Clock::time_point deadline = Clock::now() + kMoment;
  bool all = true;
  for (auto& [id, driver] : drivers_) {
    Hear(&driver, IsAwaited(driver), deadline);
    all = all && !IsAwaited(driver);
  }
  return all;
}

std::vector<MeasuredReport> DriverPrograms::TakeReports(TimeUs at) {
  std::vector<MeasuredReport> reports;
  for (auto& [id, driver] : drivers_) {
    for (MeasuredReport& report : driver.program->session().TakeReports(at)) {
      reports.push_back(std::move(report));
    }
    if (driver.problem.empty() || std::exchange(driver.is_told, true)) continue;
    reports.push_back({.agent_kind = kind_,
                       .agent = id,
                       .kind = MeasuredReport::Kind::kFailed,
                       .at_us = at,
                       .reason = driver.problem});
    driver.program->session().Bye("it has failed: " + driver.problem);
    driver.program->Pump(false, Clock::now());
  }
  return reports;
}

std::vector<DriverMessage> DriverPrograms::TakeMessages() {
  std::vector<DriverMessage> messages;
  for (auto& [id, driver] : drivers_) {
    for (DriverMessage& message : driver.program->session().TakeMessages()) {
      messages.push_back(std::move(message));
    }
  }
  return messages;
}

TimeUs DriverPrograms::patience_us() const { return rules_.rate > 0 ? kPatienceUs : kNever; }

void DriverPrograms::Bye(std::string_view reason) {
  for (auto& [id, driver] : drivers_) {
    driver.program->session().Bye(reason);
    driver.program->Pump(false, Clock::now());
  }
}

}  // namespace muster::agents
