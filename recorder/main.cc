#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/check.h"
#include "base/folder_lock.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "protocol/run_process.h"
#include "recorder/recorder_process.h"

namespace muster::recorder {
namespace {

constexpr int kDefaultWindow = 3;
/// Of two recorders each hears with later marks what the other one has. New marks do not wait for
/// that.
constexpr int kWindowOfTwo = 1024;
constexpr double kMostPatienceS = 1e6;
constexpr TimeUs kLastWordUs = kSecondUs;
constexpr TimeUs kLookUs = 20'000;

/// Says that it ends, and waits until that is in the log.
void SayLastWord(RecorderProcess* process, LossyBus* bus) {
  process->End();
  process->ReportStatus(HostUsage(), HostNow());
  const TimeUs deadline_us = MonotonicUs() + kLastWordUs;
  std::vector<Packet> heard;
  while (!process->finished() && MonotonicUs() < deadline_us) {
    std::vector<Packet> out;
    process->Step(heard, HostNow(), &out);
    for (const Packet& packet : out) bus->Publish(packet);
    heard = bus->Receive(kLookUs);
  }
}

/// The logs that are in the folder, in the order in which they were written, and the next one.
struct LogFiles {
  std::vector<std::string> earlier;
  std::string next;
};
LogFiles FilesIn(const std::string& folder, std::optional<FolderLock>* lock) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw SystemError(fmt::format("cannot make folder {}: {}", folder, error.message()));
  }
  lock->emplace(folder);
  const std::string first = (std::filesystem::path(folder) / "mission.lcm").string();
  LogFiles files = {{}, first};
  while (std::filesystem::exists(files.next)) {
    files.earlier.push_back(files.next);
    files.next = fmt::format("{}.{}", first, files.earlier.size());
  }
  return files;
}

LogFiles FilesOf(const Arguments& arguments, std::optional<FolderLock>* lock) {
  if (arguments.Has("log") == arguments.Has("into")) {
    throw InputError("command line", "LOG", arguments.Has("log") ? "LOG and --into" : "neither",
                     "LOG or --into FOLDER: where to write");
  }
  if (arguments.Has("into")) return FilesIn(arguments.Get("into"), lock);
  return {arguments.All("after"), arguments.Get("log")};
}

int Main(int argc, char** argv) {
  Options options("muster-recorder",
                  "The recorder of a mission: writes all messages to a log in lcm-logger's format, "
                  "and tells the other processes what it holds");
  options.Positional("log", "LOG");
  options.Add(
      "into", "FOLDER",
      "Write the next of mission.lcm, mission.lcm.1, ... in FOLDER, and continue those that "
      "are there");
  options
      .Add("first-boot", "N",
           "Leave out messages with a boot id below N: they come from an earlier launcher's "
           "processes")
      .Integer(0)
      .Default(0);
  options
      .Add(
          "second-after", "S",
          "There is a second recorder (--name recorder-2): messages count as logged when both have "
          "them. After S seconds of silence the second recorder no longer counts")
      .Number(Above0(kMostPatienceS));
  options
      .Add("after", "LOG", "The log of an earlier start of the recorder, which this one continues")
      .Repeated();
  AddProcessOptions(&options, process_name::kRecorder);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const bool is_second = arguments->Get("name") == process_name::kSecondRecorder;
  ProcessFlags flags = ReadProcessFlags(
      *arguments, is_second ? process_name::kSecondRecorder : process_name::kRecorder);
  const Part part = is_second                        ? Part::kSecond
                    : arguments->Has("second-after") ? Part::kFirst
                                                     : Part::kOnly;
  if (flags.window == 0) flags.window = part == Part::kOnly ? kDefaultWindow : kWindowOfTwo;
  std::optional<FolderLock> lock;
  const LogFiles files = FilesOf(*arguments, &lock);
  const TimeUs patience_us =
      part == Part::kFirst ? ToUs(arguments->Get<double>("second-after")) : 0;

  RecorderProcess process(flags.identity, flags.window, flags.seal, part, patience_us);
  process.SetFirstBoot(arguments->Get<std::int64_t>("first-boot"));
  for (const std::string& earlier : files.earlier) {
    if (const std::int64_t torn = CutTornTail(earlier); torn > 0) {
      Say("{}: {} bytes of a torn event cut off\n", earlier, torn);
    }
    EventLogReader reader(earlier, EventLogReader::Tail::kFinal);
    while (auto event = reader.Next()) {
      process.OnLogged(flags.seal ? WithTag(std::move(event->packet), event->tag) : event->packet);
    }
  }
  BatchLogWriter log(files.next);
  LcmTap tap;
  for (const std::string_view name :
       {channel::kClock, channel::kFault, channel::kProcess, channel::kLog, channel::kCopy}) {
    tap.heard.emplace_back(name);
  }
  tap.on_message = [&](const Packet& packet) {
    if (!process.Wants(packet)) return;
    log.Add(HostNow().wall_us, packet);
    process.OnLogged(packet);
  };
  tap.on_burst = [&] { log.Flush(); };
  const auto bus = OpenBus(flags, GuardedChannels::kAny, tap);
  const int code = RunProcess(&process, bus.get(), flags.quiet);
  SayLastWord(&process, bus.get());
  return code;
}

}  // namespace
}  // namespace muster::recorder

int main(int argc, char** argv) {
  return muster::GuardedMain("muster-recorder", [&] { return muster::recorder::Main(argc, argv); });
}
