#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "agents/driver/driver_session.h"
#include "base/line_program.h"

namespace muster::agents {

/// The words of --driver 'COMMAND', the program as a path. Throws InputError when there is none.
std::vector<std::string> DriverCommand(std::string_view command);

/// A driver as a child process: carries lines between it and its session. The edge of a pure core.
class DriverProgram {
 public:
  using Clock = LineProgram::Clock;

  /// Starts and greets it. Throws SystemError when it cannot be started. The scenario must outlive
  /// this object.
  DriverProgram(const std::vector<std::string>& argv, const Scenario& scenario,
                const AgentState& agent, TimeUs at, const DriverSession::Rules& rules);

  DriverSession& session() { return *session_; }
  const DriverSession& session() const { return *session_; }

  /// Writes the session's lines and reads those of the driver. `patient`: reads until the driver
  /// has answered the time that it was told, or the deadline; otherwise reads what is there now.
  /// Returns the first thing that is wrong ("": nothing): a line, after which it goes on; its
  /// silence; its end.
  std::string Pump(bool patient, Clock::time_point deadline);
  /// Whether it has ended; Pump has said how.
  bool ended() const { return program_ == nullptr; }
  /// After bye: waits until the deadline for the program to end by itself, and returns how it
  /// ended.
  /// "": it has not ended. Then its stdin is closed, and this object's destructor kills it.
  std::string AwaitEnd(Clock::time_point deadline);

  /// Monotonic, as the session's wall times.
  static TimeUs WallUs(Clock::time_point now = Clock::now());

 private:
  void WriteLines();

  std::unique_ptr<LineProgram> program_;
  std::unique_ptr<DriverSession> session_;
};

}  // namespace muster::agents
