#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "protocol/mission_reader.h"
#include "scheduler/fusion.h"
#include "scheduler/situation.h"

namespace muster::tools {

/// Collects the situations that a mission's decisions rest on from its packets, in any order.
class SituationRecorder {
 public:
  void Add(const Packet& packet);

  /// Those whose messages are complete, ascending by decision. `fuse_s`, when given, gets the wall
  /// time that fusing each took.
  std::vector<scheduler::Situation> Situations(std::vector<double>* fuse_s = nullptr);
  /// Decisions of the mission, complete or not; 0 before the scenario is known.
  std::int32_t n_decisions() const { return static_cast<std::int32_t>(fusions_.size()); }

 private:
  void Begin();
  /// A message of a tick whose orders are known.
  void Take(const Message& message);
  scheduler::Fusion& FusionAt(std::int64_t tick);

  MissionReader reader_;
  std::shared_ptr<const Scenario> scenario_;
  std::map<std::int64_t, scheduler::Fusion> fusions_;  ///< by tick
  /// By tick, until its orders are known: they may ask for a decision.
  std::map<std::int64_t, std::vector<Message>> waiting_;
};

/// The situations of a mission: of a run directory or log file, or of a scenario file, which is
/// then simulated with `policy`. Throws InputError, SystemError.
std::vector<scheduler::Situation> SituationsOf(const std::string& run_or_scenario,
                                               const std::string& policy);

/// The situation of one decision. Throws InputError when the mission has none of that number.
scheduler::Situation SituationOf(const std::string& run_or_scenario, const std::string& policy,
                                 std::int32_t decision);

}  // namespace muster::tools
