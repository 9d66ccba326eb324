#include "tools/top/top_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "protocol/run_process.h"
#include "tools/host/stop_signals.h"
#include "tools/live/packet_source.h"
#include "tools/top/screen.h"
#include "tools/top/top_view.h"

namespace muster::tools {
namespace {

constexpr TimeUs kLookUs = 100'000;
constexpr TimeUs kRedrawUs = 500'000;
constexpr TimeUs kPrintUs = 2 * kSecondUs;
constexpr TimeUs kPatienceUs = 5 * kSecondUs;
constexpr TimeUs kListenUs = 2 * kSecondUs;  // for rates and everybody's status

bool TerminalOut() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDOUT_FILENO) != 0 && terminal != nullptr && std::string_view(terminal) != "dumb";
}

void Print(const TopView& view) {
  for (const TopView::Line& line : view.Lines(HostNow().wall_us, 0)) {
    fmt::print("{}\n", line.text);
  }
  std::fflush(stdout);
}

/// All that is in a log, or what is heard in a while; then one snapshot.
int Once(PacketSource* source, const StopSignals& stop, bool json) {
  TopView view;
  const TimeUs start_us = MonotonicUs();
  TimeUs ready_us = kNever;
  while (true) {
    if (stop.count() > 0) return kExitInterrupted;
    // A log that is being written always has more a moment later: what is there now counts.
    const std::vector<Packet> packets = source->Read(source->is_log() ? 0 : kLookUs);
    for (const Packet& packet : packets) view.Add(packet);
    const TimeUs now_us = MonotonicUs();
    if (view.ready() && ready_us == kNever) ready_us = now_us;
    if (packets.empty() && (source->is_log() || view.ended())) break;
    if (!source->is_log() && now_us - (ready_us == kNever ? start_us : ready_us) >
                                 (ready_us == kNever ? kPatienceUs : kListenUs)) {
      break;
    }
  }
  if (!view.ready()) {
    throw SystemError(source->is_log() ? "there is no mission in the log yet"
                                       : fmt::format("no mission was heard within {} s",
                                                     kPatienceUs / kSecondUs));
  }
  if (json) {
    fmt::print("{}\n", view.Json(HostNow().wall_us));
  } else {
    Print(view);
  }
  return kExitOk;
}

}  // namespace

int TopCommand(int argc, const char* const* argv) {
  Options options(
      argv[0],
      "Shows a mission in the terminal while it goes on: agents by status, processes, rates,\n"
      "losses, ages. q or Ctrl-C ends it. In a pipe it prints a snapshot every two seconds.\n"
      "Without RUN or URL it shows the newest run of the folder runs, if that goes on, and\n"
      "otherwise what is heard on the bus.");
  options.Positional("run", "[RUN|URL]");
  options.Flag("once", "Print one snapshot and exit");
  options.Flag("json", "Print one snapshot as JSON and exit");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const auto source =
      OpenPacketSource(arguments->Has("run") ? arguments->Get("run") : MissionHere());
  const StopSignals stop;
  if (arguments->Has("once") || arguments->Has("json")) {
    return Once(source.get(), stop, arguments->Has("json"));
  }

  TopView view;
  std::optional<Screen> screen;
  if (TerminalOut()) screen.emplace();
  TimeUs due_us = 0;
  while (stop.count() == 0 && !(screen && screen->QuitPressed())) {
    for (const Packet& packet : source->Read(kLookUs)) view.Add(packet);
    const TimeUs now_us = MonotonicUs();
    if (now_us < due_us) continue;
    due_us = now_us + (screen ? kRedrawUs : kPrintUs);
    if (screen) {
      screen->Show(view.Lines(HostNow().wall_us, screen->width()));
    } else {
      Print(view);
      fmt::print("\n");
    }
  }
  return kExitOk;
}

}  // namespace muster::tools
