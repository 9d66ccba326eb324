#include "tools/files/scenario_file.h"

#include <filesystem>

#include "model/scenario_json.h"
#include "tools/files/pending_file.h"

namespace muster::tools {

void WriteScenarioFile(const Scenario& scenario, const std::string& file) {
  if (scenario.roads) {
    const std::filesystem::path folder = std::filesystem::path(file).parent_path();
    WriteFile((folder / scenario.roads->file).string(), scenario.roads->text);
  }
  WriteFile(file, ScenarioToJson(scenario));
}

}  // namespace muster::tools
