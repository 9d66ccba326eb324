#include "agents/driver/driver_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/check.h"
#include "base/command_text.h"
#include "base/spawn.h"

namespace muster::agents {
namespace {

/// So often it looks whether a driver has been silent for too long.
constexpr std::chrono::milliseconds kLook(100);

}  // namespace

std::vector<std::string> DriverCommand(std::string_view command) {
  const auto words = WordsOf(command);
  if (!words || words->empty()) {
    throw InputError("command line", "driver", Quote(command),
                     "a command, its quotation marks closed (docs/guide/drivers.md)");
  }
  const auto program = FindProgram(words->front());
  if (!program) {
    throw InputError("command line", "driver", Quote(words->front()),
                     "a program: a path, or a name in PATH (docs/guide/drivers.md)");
  }
  std::vector<std::string> argv = *words;
  argv.front() = *program;
  return argv;
}

DriverProgram::DriverProgram(const std::vector<std::string>& argv, const Scenario& scenario,
                             const AgentState& agent, TimeUs at, const DriverSession::Rules& rules)
    : program_(std::make_unique<LineProgram>(argv, kLongestDriverLine)),
      session_(std::make_unique<DriverSession>(scenario, agent, at, WallUs(), rules)) {
  WriteLines();
}

TimeUs DriverProgram::WallUs(Clock::time_point now) {
  return std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch()).count();
}

void DriverProgram::WriteLines() {
  for (const std::string& line : session_->TakeLines()) program_->Write(line);
}

std::string DriverProgram::Pump(bool patient, Clock::time_point deadline) {
  if (ended()) return {};
  WriteLines();
  while (true) {
    const bool awaits = patient && !(session_->greeted() && session_->answered());
    std::string line;
    const auto look = std::min(deadline, Clock::now() + kLook);
    switch (program_->Read(awaits ? look : Clock::now(), &line)) {
      case LineProgram::Outcome::kLine: {
        std::string problem = session_->Hear(line, WallUs());
        if (!problem.empty()) return problem;
        break;
      }
      case LineProgram::Outcome::kLate: {
        std::string problem = session_->Silence(WallUs());
        if (!problem.empty() || !awaits || Clock::now() >= deadline) return problem;
        break;
      }
      case LineProgram::Outcome::kTooLong:
        program_->Kill();
        program_.reset();
        return fmt::format("a line of more than {} KiB", kLongestDriverLine >> 10);
      case LineProgram::Outcome::kEnded: {
        const std::string end = program_->Kill();
        program_.reset();
        return fmt::format("its program {}", end);
      }
    }
  }
}

std::string DriverProgram::AwaitEnd(Clock::time_point deadline) {
  if (ended()) return {};
  WriteLines();
  std::string line;
  LineProgram::Outcome outcome = LineProgram::Outcome::kLine;
  while (outcome == LineProgram::Outcome::kLine) outcome = program_->Read(deadline, &line);
  std::string end;
  if (outcome == LineProgram::Outcome::kEnded) {
    end = program_->Kill();
    program_.reset();
  } else {
    program_->Finish();
  }
  return end;
}

}  // namespace muster::agents
