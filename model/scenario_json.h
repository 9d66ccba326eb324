#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "base/check.h"
#include "model/scenario.h"

namespace muster {

/// Reads a scenario file and the road file that it may name (docs/reference/scenario-format.md).
/// Throws InputError naming `file`, key, value found and value expected; SystemError when the file
/// cannot be read.
Scenario LoadScenario(const std::string& file);

/// A scenario as text: its file, and the road file that it names; "" where it names none.
struct ScenarioText {
  ScenarioText() = default;
  ScenarioText(const char* scenario_json) : json(scenario_json) {}
  ScenarioText(std::string scenario_json, std::string roads_json = {})
      : json(std::move(scenario_json)), roads(std::move(roads_json)) {}
  std::string json, roads;
};

/// That the text of a scenario's roads is not there, or is not the one that it names.
class RoadsLacking : public InputError {
 public:
  using InputError::InputError;
};

/// The same from text; `file` is only for messages. Throws RoadsLacking, too.
Scenario ParseScenario(const ScenarioText& text, std::string_view file);
ScenarioText TextOf(const Scenario& scenario);

/// The inverse of its first part: every optional key written out; parsing it again gives the same
/// scenario, bit for bit (numbers are written with the digits that it takes).
std::string ScenarioToJson(const Scenario& scenario);

/// A task as the file has it, without its id: {"x_km": ...}
std::string TaskToJson(const Task& task);

/// Throws InputError when a scenario that was built or changed in memory breaks a rule of the file.
/// `may_lack_tasks`: orders will bring them.
void ValidateScenario(const Scenario& scenario, std::string_view file, bool may_lack_tasks = false);

}  // namespace muster
