#include "tools/launch/run_command.h"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/program.h"
#include "base/say.h"
#include "model/scenario_json.h"
#include "protocol/run_process.h"
#include "tools/files/log_files.h"
#include "tools/files/run_directory.h"
#include "tools/files/scenario_file.h"
#include "tools/launch/launch.h"
#include "tools/launch/manifest.h"
#include "tools/scenario/order_text.h"

namespace muster::tools {
namespace {

std::optional<SealKey> KeyOf(const LaunchOptions& options, std::int64_t run_id) {
  if (!options.sealed) return {};
  SealKey key = options.key_file.empty()
                    ? SealKey::Fresh(run_id)
                    : SealKey::Load(options.key_file).Of(run_id, options.key_file);
  key.per_process = options.sealed_per_process;
  return key;
}

/// The orders that are given with the mission, a line each; first who may order at all.
std::string LinesOf(const std::vector<world::PlannedOrder>& orders, PersonsDesk* persons) {
  if (persons == nullptr) return OrderLines(orders);
  return persons->SignedLines(persons->Planned()) + persons->SignedLines(orders);
}

/// The run directory with what is known before the mission: scenario, key, orders, manifest.
RunDirectory MakeDirectory(const Launch& launch, const std::string& orders, ManifestInput manifest,
                           MissionIdentity* mission) {
  const LaunchOptions& options = launch.options;
  const Scenario& scenario = launch.scenario;
  RunDirectory directory =
      options.out.empty()
          ? RunDirectory::MakeNew("runs", RunStem(scenario.name, options.policy, scenario.seed))
          : RunDirectory::Take(options.out);
  manifest.scenario_json = ScenarioToJson(scenario);
  mission->scenario_file = directory.File("scenario.json");
  WriteScenarioFile(scenario, mission->scenario_file);
  if (launch.seal) launch.seal->Write(directory);
  if (launch.persons) directory.WriteSecret(kLauncherKeyFile, launch.persons->Secret());
  if (!orders.empty()) {
    mission->orders_file = directory.File(kOrdersFile);
    directory.Write(kOrdersFile, orders);
  }
  manifest.policy = options.policy;
  manifest.seed = scenario.seed;
  manifest.run_id = mission->run_id;
  manifest.lcm_url = mission->lcm_url;
  manifest.sealed = mission->key.has_value();
  manifest.scenario_file = options.scenario_file;
  directory.Write("manifest.json", ManifestJson(manifest));
  if (!options.quiet) {
    Say("recording in {}\n", directory.path());
    PrintWhatToStart(options, *mission, directory);
  }
  return directory;
}

}  // namespace

int RunCommand(int argc, const char* const* argv) {
  auto options = ParseLaunchOptions(argc, argv);
  if (!options) return kExitOk;

  // What is wrong with the request or the host is found before the first file is written.
  Launch launch;
  std::vector<world::PlannedOrder> orders;
  launch.scenario = ResolveScenario(*options, &orders);
  MarkDriven(options->drivers, &launch.scenario);
  launch.options = *std::move(options);
  PrepareLaunch(&launch);
  const StopSignals stop;
  ManifestInput manifest;
  manifest.command_line = {argv, argv + argc};
  manifest.folder = std::filesystem::current_path().string();
  manifest.start_wall_us = HostNow().wall_us;
  launch.mission.run_id = manifest.start_wall_us;
  launch.mission.key = KeyOf(launch.options, launch.mission.run_id);
  if (!launch.options.persons_file.empty()) {
    launch.persons.emplace(launch.options.persons_file, launch.mission.run_id,
                           manifest.start_wall_us, SigningKey::Fresh());
  }
  return Conduct(&launch, stop, [&](MissionIdentity* mission) {
    return MakeDirectory(launch, LinesOf(orders, launch.persons ? &*launch.persons : nullptr),
                         manifest, mission);
  });
}

}  // namespace muster::tools
