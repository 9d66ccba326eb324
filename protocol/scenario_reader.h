#pragma once

#include <optional>

#include "model/scenario.h"
#include "protocol/inbox.h"

namespace muster {

/// Puts the scenario of a run together from its messages, which come in any order: scenario_t and,
/// if that names roads, roads_t.
class ScenarioReader {
 public:
  enum class Outcome {
    kNothing,   ///< the message says nothing of the scenario
    kWaits,     ///< the other message is not there yet
    kRejected,  ///< there can be no such scenario
    kWhole,     ///< scenario() is there now
  };
  Outcome Take(const Message& message);

  /// With the outcome kWhole.
  const Scenario& scenario() const { return *scenario_; }

 private:
  Outcome Combine();

  std::optional<scenario_t> told_;
  std::optional<roads_t> roads_;
  std::optional<Scenario> scenario_;
};

}  // namespace muster
