#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/units.h"
#include "lcmtypes/words.h"
#include "tools/report/mission_feed.h"

namespace muster::tools {

/// What `muster top` shows of a mission: how far it is, what each agent does, how the processes and
/// the bus are. Rates and ages come from the wall time in the messages, so a log that is read later
/// tells the same.
class TopView {
 public:
  enum class Look { kPlain, kHead, kBad };
  struct Line {
    std::string text;
    Look look = Look::kPlain;
  };

  void Add(const Packet& packet);
  /// The display at that wall time (microseconds since the Unix epoch), at most `width` columns;
  /// 0: as wide as it gets. ASCII.
  std::vector<Line> Lines(std::int64_t now_us, std::size_t width) const;

  /// The same facts as a JSON object; ready() only.
  std::string Json(std::int64_t now_us) const;

  /// The mission's scenario is known and the world has told its state.
  bool ready() const { return feed_.ready() && feed_.timeline().done().version > 0; }
  bool ended() const { return feed_.ready() && feed_.timeline().ended(); }

  /// Rates are means over so much time.
  static constexpr std::int64_t kWindowUs = 5'000'000;
  /// So much older than the newest is no late message: the host's clock was set back.
  static constexpr std::int64_t kSetBackUs = 60 * kSecondUs;

 private:
  struct Traffic {
    std::deque<std::pair<std::int64_t, std::size_t>> recent;  // wall time, bytes
    std::size_t bytes = 0;                                    // of recent
    std::int64_t last_us = 0;
  };
  struct Rate {
    double messages = 0, bytes = 0;  // a second
  };
  static void Forget(Traffic* traffic, std::int64_t before_us);
  static Rate RateOf(const Traffic& traffic, std::int64_t now_us);
  struct ProcessRow {
    std::string name;
    std::string_view state;
    double decides_s = -1;  // for how long it says that it is deciding; -1: it is not
    double age_s = -1;      // of its newest message; -1: none
    bool late = false;
    Rate rate;
    double cpu_frac = -1;  // of one core since its last status; -1: not known
    const Timeline::ProcessSample* last = nullptr;
  };
  /// The time of which a display tells: a mission that is over, of its last message.
  std::int64_t ToldUs(std::int64_t now_us) const;
  std::array<int, kNames<TaskStatus>.size()> TaskCounts() const;
  std::array<int, kNames<AgentStatus>.size()> AgentCounts(AgentKind kind) const;
  std::vector<ProcessRow> Processes(std::int64_t now_us) const;
  /// Names of those that have said nothing for long.
  std::vector<std::string> SilentProcesses(std::int64_t now_us) const;
  std::string MissionLine() const;
  std::string TaskLine() const;
  std::string AirLine() const;  ///< "": UAVs are not kept apart
  std::string BusLine(std::int64_t now_us) const;
  void AddAgents(std::vector<Line>* lines) const;
  void AddAttention(std::int64_t now_us, std::vector<Line>* lines) const;
  void AddProcesses(std::int64_t now_us, std::vector<Line>* lines) const;

  MissionFeed feed_;
  std::map<std::string, Traffic> senders_;
  Traffic all_;
};

}  // namespace muster::tools
