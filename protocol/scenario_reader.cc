#include "protocol/scenario_reader.h"

#include "model/scenario_json.h"

namespace muster {

ScenarioReader::Outcome ScenarioReader::Take(const Message& message) {
  if (const auto* scenario = std::get_if<scenario_t>(&message)) {
    told_ = *scenario;
  } else if (const auto* roads = std::get_if<roads_t>(&message)) {
    roads_ = *roads;
  } else {
    return Outcome::kNothing;
  }
  return told_ ? Combine() : Outcome::kWaits;
}

ScenarioReader::Outcome ScenarioReader::Combine() {
  try {
    scenario_ = ParseScenario({told_->json, roads_ ? roads_->roads : ""}, "MUSTER_SCENARIO");
    return Outcome::kWhole;
  } catch (const RoadsLacking&) {
    return Outcome::kWaits;
  } catch (const InputError&) {
    told_.reset();
    return Outcome::kRejected;
  }
}

}  // namespace muster
