#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/folder_lock.h"
#include "model/scenario.h"
#include "tools/files/run_directory.h"
#include "tools/host/stop_signals.h"
#include "tools/launch/earlier_run.h"
#include "tools/launch/launch_options.h"
#include "tools/launch/mission_seal.h"
#include "tools/orders/persons_desk.h"
#include "tools/tiles/base_map.h"

namespace muster::tools {

/// The orders that are given with a mission, in its run directory.
inline constexpr const char* kOrdersFile = "orders.jsonl";
/// What the launcher signs orders with, in the run directory of a mission with persons.
inline constexpr const char* kLauncherKeyFile = "launcher.key";

/// What `muster run` and `muster resume` prepare, each in its way, and launch in the same way.
struct Launch {
  LaunchOptions options;
  Scenario scenario;
  MissionIdentity mission;  ///< without its LCM URL and files, which are known later
  std::optional<PersonsDesk> persons;
  EarlierRun earlier;              ///< of a mission that goes on
  std::optional<FolderLock> lock;  ///< of its run directory

  std::string lcm_logger = {};                      ///< its program, where it writes the log
  std::unique_ptr<const TileFile> tiles = nullptr;  ///< null: no base map
  std::optional<MissionSeal> seal = {};             ///< none: not sealed
};

/// Finds what the launch needs on this host. Throws InputError and SystemError where hosts, faults
/// or the base map do not fit the mission, or lcm-logger is not there: before the first file is
/// written.
void PrepareLaunch(Launch* launch);

/// Launches it, waits for its end, writes the report and prints the summary. `directory` makes or
/// takes the run directory as soon as the LCM URL is known, and completes the mission. Returns the
/// exit code.
int Conduct(Launch* launch, const StopSignals& stop,
            const std::function<RunDirectory(MissionIdentity*)>& directory);

/// For the classes that the user wants to start by hand.
void PrintWhatToStart(const LaunchOptions& options, const MissionIdentity& mission,
                      const RunDirectory& directory);

}  // namespace muster::tools
