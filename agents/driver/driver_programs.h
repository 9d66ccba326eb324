#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "agents/core/driver_port.h"
#include "agents/driver/driver_program.h"

namespace muster::agents {

/// The drivers of a process's measured agents, a program each (docs/guide/drivers.md).
class DriverPrograms : public DriverPort {
 public:
  /// Of one agent; no id: of all that have none of their own.
  struct Command {
    std::optional<std::int32_t> id;
    std::vector<std::string> argv;
  };

  DriverPrograms(std::vector<Command> commands, const DriverSession::Rules& rules)
      : commands_(std::move(commands)), rules_(rules) {}
  /// Gives the drivers that were told bye a moment to end by themselves.
  ~DriverPrograms() override;

  void Begin(const Scenario& scenario, const AgentState& agent, TimeUs at) override;
  bool drives(std::int32_t id) const override { return CommandOf(id) != nullptr; }
  void GiveAltitude(const Clearance& clearance) override;
  void Tell(const AgentState& agent, TimeUs before, TimeUs at) override;
  bool Listen() override;
  std::vector<MeasuredReport> TakeReports(TimeUs at) override;
  std::vector<DriverMessage> TakeMessages() override;
  TimeUs patience_us() const override;
  void Bye(std::string_view reason) override;

 private:
  struct Driver {
    std::unique_ptr<DriverProgram> program;
    std::string problem = {};  ///< what was wrong with it; nothing that it says counts any more
    bool is_told = false;      ///< the problem has been reported
    DriverProgram::Clock::time_point waited_for_until = {};  ///< at a rate
  };
  const Command* CommandOf(std::int32_t id) const;
  /// Whether the mission waits for it now.
  bool IsAwaited(const Driver& driver) const;
  /// Hears what there is. `patient`: until its answer, or that time.
  void Hear(Driver* driver, bool patient, DriverProgram::Clock::time_point deadline);

  std::vector<Command> commands_;
  DriverSession::Rules rules_;
  AgentKind kind_ = AgentKind::kUav;
  std::map<std::int32_t, Driver> drivers_;  ///< by agent
};

}  // namespace muster::agents
