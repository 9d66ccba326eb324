#pragma once

#include <map>
#include <string>
#include <vector>

#include "model/agent.h"
#include "tools/faults/fault_plan.h"
#include "tools/record/run_record.h"

namespace muster::tools {

/// What scoring faults needs of a mission's log.
struct FaultEvidence {
  RunRecord record;
  /// Wall time of the first clock_t of each mission time, microseconds.
  std::map<TimeUs, std::int64_t> clock_wall_us;
  /// What an agent reported: whether it was free, and which decision it last obeyed.
  struct Word {
    bool idle = false;
    std::int32_t decision = -1;
  };
  std::map<std::pair<AgentKind, std::int32_t>, std::map<TimeUs, Word>> words;  ///< by agent, time
  std::string undisturbed_digest;  ///< "": not asked for

  void Add(const Packet& packet);
};

/// One line of the table.
struct FaultScore {
  std::string fault;     ///< id, kind and target
  std::string check;     ///< "visible effect", or an expectation's name
  std::string expected;  ///< as in "at most 2 ticks"
  std::string observed;
  bool met = false;
  std::string recovery;  ///< on the fault's first line: how long it took; "" elsewhere
};

/// Scores every fault of the plan: that it had a visible effect, and each of its expectations. An
/// expectation without anything to test it on (no partner, no task under way) is not met.
std::vector<FaultScore> ScoreFaults(const FaultPlan& plan, const FaultEvidence& evidence);

/// As a table for people, aligned.
std::string ToTable(const std::vector<FaultScore>& scores);

}  // namespace muster::tools
