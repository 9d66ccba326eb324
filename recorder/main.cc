#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

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
constexpr TimeUs kLastWordUs = kSecondUs;
constexpr TimeUs kLookUs = 20'000;

/// Says that it ends, and waits until that is in the log.
void SayLastWord(RecorderProcess* process, LossyBus* bus) {
  process->End();
  process->ReportStatus(HostUsage(), HostNow());
  const TimeUs deadline_us = MonotonicUs() + kLastWordUs;
  while (!process->finished() && MonotonicUs() < deadline_us) {
    std::vector<Packet> out;
    process->Step({}, HostNow(), &out);
    for (const Packet& packet : out) bus->Publish(packet);
    bus->Receive(kLookUs);
  }
}

int Main(int argc, char** argv) {
  Options options("muster-recorder",
                  "The recorder of a mission: writes all messages to a log in lcm-logger's format, "
                  "and tells the other processes what it holds");
  options.Positional("log", "LOG").Required("the file to write, which must not exist");
  options
      .Add("after", "LOG", "The log of an earlier start of the recorder, which this one continues")
      .Repeated();
  AddProcessOptions(&options, process_name::kRecorder);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  ProcessFlags flags = ReadProcessFlags(*arguments, process_name::kRecorder);
  if (flags.window == 0) flags.window = kDefaultWindow;

  RecorderProcess process(flags.identity, flags.window, flags.seal);
  for (const std::string& earlier : arguments->All("after")) {
    if (const std::int64_t torn = CutTornTail(earlier); torn > 0) {
      Say("{}: {} bytes of a torn event cut off\n", earlier, torn);
    }
    EventLogReader reader(earlier, EventLogReader::Tail::kFinal);
    while (auto event = reader.Next()) {
      process.OnLogged(flags.seal ? WithTag(std::move(event->packet), event->tag) : event->packet);
    }
  }
  BatchLogWriter log(arguments->Get("log"));
  LcmTap tap;
  for (const std::string_view name : {channel::kClock, channel::kFault, channel::kProcess}) {
    tap.heard.emplace_back(name);
  }
  tap.on_message = [&](const Packet& packet) {
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
