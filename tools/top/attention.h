#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/report/timeline.h"

namespace muster::tools {

/// One thing that goes wrong in a mission, as the page's attention panel has it.
struct Concern {
  std::string kind;  ///< "agents failed"
  std::string who;   ///< "uav:7"
  std::string note;  ///< "since 1:20:00"; may be empty
  bool bad = true;   ///< red; else of note only
};

/// Why a task will be late or lost, and how much that harms.
struct TaskRisk {
  double harm = 0;
  std::string note;
};

/// The risk of a task of that status; none when nothing speaks for one. `start_us`: of the sensing
/// by the pair that is on its way, where that is known. The page has the same rule (`timeRisk` in
/// attention.js); tests/tools/top/task_risks.json holds both to the same cases.
std::optional<TaskRisk> RiskOf(const Task& task, TaskStatus status, std::optional<TimeUs> start_us,
                               TimeUs now_us, TimeUs interval_us);

/// What is wrong with an agent: it has failed, cannot reach a charging point, waits for long for
/// its partner, or is low.
struct AgentTrouble {
  enum class Kind { kFailed, kStranded, kWait, kRange };
  Kind kind = Kind::kFailed;
  double harm = 0;  ///< seconds, metres or the share of the full range, by kind
  std::string note;
};

/// The trouble of an agent that has had that status since a time; none when all is well.
/// `nearest_m`: to the charging point that is nearest; none: there is no charging point. The page
/// has the same rule
/// (`troubleOf` in attention.js); tests/tools/top/agent_troubles.json holds both to the same cases.
std::optional<AgentTrouble> TroubleOf(AgentKind kind, AgentStatus status, TimeUs since_us,
                                      TimeUs now_us, double range_m, double range_full_m,
                                      const std::function<std::optional<double>()>& nearest_m);

/// What needs attention at the newest time that `timeline` knows: kinds in the page's order, the
/// most harmful first, each by harm. `silent`: processes that have sent nothing for long. A task is
/// at risk when it is due or expires within two intervals and no pair is on the way (also when an
/// order holds it), or when the pair that is on the way starts too late; priority weighs most. From
/// half of the mission's time on, other tasks without a pair count too. Time grows with agents and
/// tasks, and with charging points for each UAV that is low.
std::vector<Concern> Attention(const Timeline& timeline, const std::vector<std::string>& silent);

}  // namespace muster::tools
