#include "tools/launch/resume_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "base/text_file.h"
#include "model/scenario_json.h"
#include "protocol/run_process.h"
#include "tools/files/log_files.h"
#include "tools/files/run_directory.h"
#include "tools/files/scenario_file.h"
#include "tools/host/build_info.h"
#include "tools/launch/launch.h"
#include "tools/launch/manifest.h"
#include "tools/live/live_server.h"
#include "tools/orders/order_socket.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

/// A second recorder that has ended by itself would be started again sooner if its launcher lived.
constexpr TimeUs kGoneUs = 5 * kSecondUs;
constexpr int kLookAgainUs = 200'000;

/// What may differ from the command line that the mission was started with.
constexpr const char* kReplaceable[] = {"rate", "hosts", "live", "second-log"};

std::optional<Arguments> Parse(int argc, const char* const* argv) {
  Options options("muster resume",
                  "Goes on with a mission whose launcher has gone: killed, interrupted, or without "
                  "power. Its processes start again from the log in its run directory, with the "
                  "options that it was started with.");
  options.Positional("run", "RUN").Required("the mission's run directory");
  options.Add("rate", "RATE", "Another speed, as in muster run --rate");
  options.Add("hosts", "FILE", "Another host list (docs/guide/hosts.md)");
  options.Add("second-log", "FOLDER",
              "Another folder for the second log, new, empty or of this mission");
  options.Add("live", "PORT", "Show the mission in browsers of this host; PORT 0: any free port")
      .Integer(0, 65535)
      .Implied(fmt::to_string(kDefaultLivePort));
  options.Flag("when-gone",
               "RUN is a second log: wait until nobody has written there for 5 s. If the mission "
               "has not ended then and was not stopped, go on with it");
  options.Quiet();
  return options.Parse(argc, argv);
}

/// Waits until the folder has been free for kGoneUs, and takes it.
FolderLock LockWhenGone(const std::string& run) {
  Say("waiting until nobody writes in {}\n", run);
  for (TimeUs free_since_us = MonotonicUs();; usleep(kLookAgainUs)) {
    try {
      FolderLock lock(run);
      if (MonotonicUs() >= free_since_us + kGoneUs) return lock;
    } catch (const InputError&) {
      free_since_us = MonotonicUs();
    }
  }
}

/// The words of a command line without that option and its value.
std::vector<std::string> Without(const std::vector<std::string>& words, const std::string& option) {
  std::vector<std::string> rest;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i].starts_with(option + "=")) continue;
    if (words[i] != option) {
      rest.push_back(words[i]);
    } else if (option != "--live") {  // whose value is behind a "=" or none
      ++i;
    }
  }
  return rest;
}

/// The mission's command line, with what this one replaces in it.
LaunchOptions OptionsOf(const EarlierCommand& earlier, const Arguments& arguments) {
  std::vector<std::string> words = earlier.command_line;
  for (const std::string name : kReplaceable) {
    if (!arguments.Has(name)) continue;
    words = Without(words, "--" + name);
    words.push_back(fmt::format("--{}={}", name, arguments.Get(name)));
  }
  if (arguments.Has("quiet")) words.emplace_back("--quiet");
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  std::optional<LaunchOptions> options =
      ParseLaunchOptions(static_cast<int>(argv.size()), argv.data());
  MUSTER_CHECK(options.has_value(), "a mission was started with it");
  return *std::move(options);
}

/// RUN may be what was the second log: then there is none from here on.
void LeaveOutOwnFolder(const std::string& run, LaunchOptions* options) {
  std::error_code error;
  if (options->second_log.empty() || !fs::equivalent(options->second_log, run, error)) return;
  Say("muster: {} was the second log: there is none from here on, unless --second-log names one\n",
      run);
  options->second_log.clear();
  for (Host& host : options->hosts.hosts) {
    std::erase(host.processes, process_name::kSecondRecorder);
  }
}

/// Files that the command line names count from the folder where it was given.
void ReturnToFolder(const std::string& folder) {
  std::error_code error;
  if (!folder.empty()) fs::current_path(folder, error);
  if (error) {
    Say("muster: {} is not here: relative file names of the mission's command line are looked up "
        "in {}\n",
        folder, fs::current_path().string());
  }
}

/// What is known of the mission before the command line is read again.
void ReadRun(const std::string& run, const EarlierCommand& command, Launch* launch) {
  const std::string scenario_file = (fs::path(run) / "scenario.json").string();
  // A second log's folder has none.
  if (!fs::exists(scenario_file)) WriteScenarioFile(ScenarioInLog(run), scenario_file);
  launch->scenario = LoadScenario(scenario_file);
  launch->mission.run_id = command.run_id;
  launch->earlier = ReadEarlierRun(run, launch->scenario, command.run_id);
  launch->mission.key = KeyBeside(launch->earlier.log_files.front());
  if (command.sealed && !launch->mission.key) {
    throw InputError((fs::path(run) / kSealKeyFile).string(), "key", "none",
                     "the key of this run, which is sealed");
  }
  if (launch->earlier.has_ended && fs::exists(fs::path(run) / "report.json")) {
    throw InputError(fmt::format("{}: this mission has ended; its report is {}", run,
                                 (fs::path(run) / "report.json").string()));
  }
}

void TakePersons(const std::string& run, Launch* launch) {
  if (launch->options.persons_file.empty()) return;
  const std::string file = (fs::path(run) / kLauncherKeyFile).string();
  launch->persons.emplace(
      launch->options.persons_file, launch->mission.run_id, HostNow().wall_us,
      SigningKey::Parse(ReadSecretLine(file, "the launcher's key", 1000), file));
  const std::string name(LauncherNameWith(launch->options.logger));
  launch->persons->GoOn(launch->earlier.persons, launch->earlier.StartsOf(name));
}

}  // namespace

int ResumeCommand(int argc, const char* const* argv) {
  const auto arguments = Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string run = fs::absolute(arguments->Get("run")).string();
  RunDirectory directory = RunDirectory::Open(run);
  const EarlierCommand earlier = ReadManifest(run);
  if (earlier.commit != kCommit) {
    Say("muster: this mission was started by another build ({}, this is {}): it may decide "
        "otherwise from here on\n",
        earlier.commit, kCommit);
  }
  Launch launch;
  const bool waits = arguments->Has("when-gone");
  launch.lock.emplace(waits ? LockWhenGone(run) : FolderLock(run));
  // A launcher that was killed has left its socket.
  std::error_code none;
  fs::remove(fs::path(run) / kOrderSocket, none);
  ReadRun(run, earlier, &launch);
  if (waits && (launch.earlier.has_ended || launch.earlier.was_stopped)) {
    Say("{}: this mission {}\n", run, launch.earlier.has_ended ? "has ended" : "was stopped");
    return kExitOk;
  }
  ReturnToFolder(earlier.folder);
  launch.options = OptionsOf(earlier, *arguments);
  LeaveOutOwnFolder(run, &launch.options);
  if (!launch.options.lcm_url.empty()) launch.earlier.KeepApart();
  MarkDriven(launch.options.drivers, &launch.scenario);
  PrepareLaunch(&launch);
  const StopSignals stop;
  TakePersons(run, &launch);
  return Conduct(&launch, stop, [&](MissionIdentity* mission) {
    mission->scenario_file = directory.File("scenario.json");
    // This launcher may have more processes: a second recorder.
    if (launch.seal) launch.seal->Write(directory);
    if (const std::string orders = directory.File(kOrdersFile); fs::exists(orders)) {
      mission->orders_file = orders;
    }
    if (!launch.options.quiet) {
      Say("going on in {} from tick {}\n", run, launch.earlier.tick);
      PrintWhatToStart(launch.options, *mission, directory);
    }
    return directory;
  });
}

}  // namespace muster::tools
