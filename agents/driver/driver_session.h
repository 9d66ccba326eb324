#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "agents/core/driver_port.h"
#include "agents/driver/driver_line.h"
#include "model/clearance.h"
#include "model/measured.h"

namespace muster::agents {

/// The talk between a mission and the driver of one agent (docs/guide/drivers.md), as a pure state
/// machine: agent states, times and the driver's lines in; lines for the driver and reports out. A
/// wrong line changes nothing; the reason is returned. `at` is a mission time; wall times are
/// monotonic.
class DriverSession {
 public:
  struct Rules {
    double rate = 0;  ///< mission seconds a wall second; 0: as fast as it goes
    TimeUs greeting_us = 10 * kSecondUs;
    /// A driver that owes an answer and is silent for longer is lost.
    TimeUs lost_after_us = 5 * kSecondUs;

    /// Time after its start until which it has to greet. Many start slowly on a busy host.
    TimeUs HelloByUs() const { return std::max(greeting_us, lost_after_us); }
  };

  /// Greets. `agent`: as it is at that time. The scenario must outlive the session.
  DriverSession(const Scenario& scenario, const AgentState& agent, TimeUs at, TimeUs wall_us,
                const Rules& rules);

  /// Takes what the mission knows of the agent at that time, and tells the driver what to do if
  /// that has changed. `why`: the reason of a cancel.
  void Follow(const AgentState& agent, TimeUs at, TimeUs wall_us,
              std::string_view why = "its partner or its task is gone");
  /// The altitude that it is to fly at from now on. It is told with where it is sent, or, by the
  /// next Follow(), alone.
  void GiveAltitude(const Clearance& clearance);
  /// Tells the driver the time.
  void Tick(TimeUs at, TimeUs wall_us);
  /// Tells the driver that the mission is over for it. No line of it counts any more.
  void Bye(std::string_view reason);

  /// Takes a line. Returns what is wrong with it; "": nothing. When it is over only messages count.
  [[nodiscard]] std::string Hear(std::string_view line, TimeUs wall_us);
  /// What is wrong if it stays silent until then; "": nothing.
  [[nodiscard]] std::string Silence(TimeUs wall_us) const;

  /// The lines for it since the last call, without newlines.
  std::vector<std::string> TakeLines();
  /// What it has reported since the last call, in order, for a tick at that time. Its failure is
  /// the last report. A report about a later time that is impossible at that tick waits for the
  /// next tick, and so do all reports after it. Reports on a command that is over by now are left
  /// out.
  std::vector<MeasuredReport> TakeReports(TimeUs at);

  /// What it has said to people since the last call: at most 20 messages, and 20 calls for help.
  std::vector<DriverMessage> TakeMessages() { return std::exchange(messages_, {}); }

  bool greeted() const { return greeted_; }
  const std::string& name() const { return name_; }
  /// Whether it owes an answer to a command.
  bool asked() const { return asked_ && !over_; }
  /// Whether it has said where it is at the time of the last Tick(). Without a rate the mission
  /// waits for that; at a rate only if it owes an answer.
  bool answered() const { return answered_ || over_; }
  /// Whether it has said that it cannot go on, or was told bye.
  bool over() const { return over_; }
  /// Whether it says that the agent cannot set out yet.
  bool waits() const { return !waits_for_.empty(); }

 private:
  struct Command {
    enum class Kind : std::int8_t { kGoTo, kSense, kCharge };
    Kind kind = Kind::kGoTo;
    std::int32_t decision = -1;
  };

  void Say(const nlohmann::ordered_json& line);
  /// Says it with an id of its own.
  void Order(Command::Kind kind, const nlohmann::ordered_json& line);
  void GoTo(TimeUs at);
  /// The corners of a way of the agent.
  nlohmann::ordered_json ViaJson(const Ways& ways, Point from, Point to) const;
  /// Says which zones a UAV has to keep out of from now on, and which not any more.
  void TellZones(TimeUs at);
  void TellAltitude(TimeUs at);
  /// Says to a UAV by which corners it comes from where it is to where it began, as far as that is
  /// new.
  void TellWayHome();
  /// Says when it and its partner are expected to be there, as far as that is new.
  void TellMeeting(TimeUs at);
  void BeginActivity();
  void Cancel(TimeUs at, std::string_view why);
  TimeUs MissionUs(TimeUs wall_us) const;
  /// Whether it is about another command than the present one.
  bool IsOver(const MeasuredReport& report) const;

  std::string Take(const DriverLine& said, TimeUs now_us);
  void TakeMessage(const DriverLine& said);
  std::string TakePlace(const DriverLine& said, TimeUs now_us);
  std::string TakeWord(const DriverLine& said, TimeUs now_us);
  std::string Report(MeasuredReport report, TimeUs now_us);
  /// Where the mission takes a free agent for ready and its driver does not, or the other way
  /// round, reports what the driver says.
  void TellReady();

  const Scenario& scenario_;
  const Rules rules_;
  const DriverPlaces places_;
  AgentState agent_;  ///< as the mission knows it, with what the driver has said since
  AgentState taken_;  ///< as the mission knows it, with the reports taken since
  const Point home_;  ///< where it was when it was greeted
  TimeUs at_ = 0;     ///< the mission time that it was told
  TimeUs started_us_ = 0, told_us_ = 0;  ///< wall: of its start, and of at_
  std::vector<Command> commands_;        ///< all so far; ids count from 1
  bool asked_ = false;                   ///< the last of them is not answered
  bool open_ = false;                    ///< what it began is neither finished nor cancelled
  bool activity_told_ = false;
  std::set<std::string> zones_;  ///< ids of those in force, as told
  std::string way_home_ = "[]";  ///< its corners, as told
  std::optional<Clearance> clearance_;
  bool altitude_told_ = true;
  std::int32_t sent_ = -1;  ///< decision that the last goto is about
  TimeUs set_out_us_ = 0;   ///< when the leg began that it is about
  TimeUs meeting_told_us_ = kNever;
  bool greeted_ = false, answered_ = true, over_ = false;
  std::optional<TimeUs> owes_since_us_;  ///< wall
  std::string name_;
  std::string waits_for_, told_waits_for_;  ///< "": it is ready
  std::vector<std::string> lines_;
  std::vector<MeasuredReport> reports_;
  std::vector<DriverMessage> messages_;
};

}  // namespace muster::agents
