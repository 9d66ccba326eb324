#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "agents/driver/driver_line.h"
#include "model/measured.h"

namespace muster::agents {

/// What a mission has to say to the driver of one agent, and what it says back
/// (docs/guide/drivers.md), as a pure state machine: states, times and its lines in, lines for it
/// and reports out. A wrong line changes nothing; the reason is reported.
/// Mission times end in `at`, wall times are monotonic.
class DriverSession {
 public:
  struct Rules {
    double rate = 0;  ///< mission seconds a wall second; 0: as fast as it goes
    TimeUs greeting_us = 10 * kSecondUs;
    /// When it owes an answer, and is silent for so long, it is lost.
    TimeUs lost_after_us = 5 * kSecondUs;

    /// By when after its start it has to greet: many start slowly on a busy host.
    TimeUs HelloByUs() const { return std::max(greeting_us, lost_after_us); }
  };

  /// Greets. `agent`: as it is at that time. The scenario must outlive the session.
  DriverSession(const Scenario& scenario, const AgentState& agent, TimeUs at, TimeUs wall_us,
                const Rules& rules);

  /// What the mission knows of the agent at that time: tells the driver what it has to do, where
  /// that has changed. `why`: for a cancel.
  void Follow(const AgentState& agent, TimeUs at, TimeUs wall_us,
              std::string_view why = "its partner or its task is gone");
  /// Tells the driver the time.
  void Tick(TimeUs at, TimeUs wall_us);
  /// The mission is over for it. No line of it counts any more.
  void Bye(std::string_view reason);

  /// Takes a line. Returns what is wrong with it; "": nothing.
  [[nodiscard]] std::string Hear(std::string_view line, TimeUs wall_us);
  /// What is wrong with its silence by then; "": nothing.
  [[nodiscard]] std::string Silence(TimeUs wall_us) const;

  /// What it is to be told, without newlines, since the last call.
  std::vector<std::string> TakeLines();
  /// What it has reported since the last call, in order, for a tick at that time. Its failure is
  /// the last. What is of a later time, and cannot be so by that tick, waits for the next, and with
  /// it what was said after it; words on a command that is over by now are left out.
  std::vector<MeasuredReport> TakeReports(TimeUs at);

  bool greeted() const { return greeted_; }
  const std::string& name() const { return name_; }
  /// Something is asked of it, for which it has an answer to give.
  bool asked() const { return asked_ && !over_; }
  /// Whether it has said where it is at the time that it was told. At a rate it need not unless
  /// something is asked of it; as fast as it goes the mission waits for it.
  bool answered() const { return answered_ || over_; }
  /// It has said that it cannot go on, or was told bye.
  bool over() const { return over_; }

 private:
  struct Command {
    enum class Kind : std::int8_t { kGoTo, kSense, kCharge };
    Kind kind = Kind::kGoTo;
    std::int32_t decision = -1;
  };

  void Say(const nlohmann::ordered_json& line);
  /// Says it with a number of its own.
  void Order(Command::Kind kind, const nlohmann::ordered_json& line);
  void GoTo(TimeUs at);
  void BeginActivity();
  void Cancel(TimeUs at, std::string_view why);
  TimeUs MissionUs(TimeUs wall_us) const;
  /// Whether it is a word on another command than the mission has it do now.
  bool IsOver(const MeasuredReport& report) const;

  std::string Take(const DriverLine& said, TimeUs now_us);
  std::string TakePlace(const DriverLine& said, TimeUs now_us);
  std::string TakeWord(const DriverLine& said, TimeUs now_us);
  std::string Report(MeasuredReport report, TimeUs now_us);

  const Scenario& scenario_;
  const Rules rules_;
  const DriverPlaces places_;
  AgentState agent_;                     ///< as the mission knows it, and it has said since
  AgentState taken_;                     ///< as the mission knows it, with what it has taken since
  TimeUs at_ = 0;                        ///< that it was told
  TimeUs started_us_ = 0, told_us_ = 0;  ///< wall: of its start, and of at_
  std::vector<Command> commands_;        ///< all so far; ids count from 1
  bool asked_ = false;                   ///< the last of them is not answered
  bool open_ = false;                    ///< what it began is neither finished nor cancelled
  bool activity_told_ = false;
  std::int32_t sent_ = -1;  ///< decision that the last goto is about
  bool greeted_ = false, answered_ = true, over_ = false;
  std::optional<TimeUs> owes_since_us_;  ///< wall
  std::string name_;
  std::vector<std::string> lines_;
  std::vector<MeasuredReport> reports_;
};

}  // namespace muster::agents
