#include "tools/live/live_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <string>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "tools/host/stop_signals.h"
#include "tools/live/live_server.h"
#include "tools/live/packet_source.h"
#include "tools/report/page.h"
#include "tools/tiles/tile_file.h"
#include "tools/tiles/tiles_beside.h"

namespace muster::tools {
namespace {

constexpr TimeUs kLookUs = 100'000;

/// The file that was asked for, or else the one that was found; null: neither, or kNoTiles. Throws
/// InputError where the one that was asked for is no file of tiles.
std::unique_ptr<const TileFile> TilesFor(const std::string& asked, const std::string& found) {
  if (asked == kNoTiles) return nullptr;
  if (!asked.empty()) return OpenTiles(asked);
  try {
    return found.empty() ? nullptr : OpenTiles(found);
  } catch (const InputError& error) {
    fmt::print(stderr, "no base map: {}\n", error.what());
    return nullptr;
  }
}

}  // namespace

int LiveCommand(int argc, const char* const* argv) {
  Options options(
      argv[0],
      "Shows a mission in a browser of this host while it goes on: a run that is being written,\n"
      "or what is heard on the bus (of muster run --lcm-url, or of muster replay). Ctrl-C ends "
      "it.\n"
      "Without RUN or URL it shows the newest run of the folder runs, if that goes on, and\n"
      "otherwise what is heard on the bus.");
  options.Positional("run", "[RUN|URL]");
  options.Add("port", "N", "Port on 127.0.0.1; 0: any free one")
      .Integer(0, 65535)
      .Default(kDefaultLivePort);
  options.Add(
      "tiles", "FILE",
      "Base map: an MBTiles or PMTiles file, or none (default: the file beside the scenario "
      "that has its name)");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  RequirePage();
  const int port = arguments->Get<int>("port");
  const std::string run = arguments->Has("run") ? arguments->Get("run") : MissionHere();
  const auto source = OpenPacketSource(run);
  const StopSignals stop;
  LiveFeed feed(source->name(), TilesFor(arguments->Has("tiles") ? arguments->Get("tiles") : "",
                                         source->is_log() ? TilesOfRun(run) : ""));
  LiveServer server(port);
  if (source->is_log()) server.AnswerAbout(run);
  server.Start(&feed);
  fmt::print("{}\n", server.url());
  std::fflush(stdout);
  while (stop.count() == 0) feed.Add(source->Read(kLookUs));
  return kExitOk;
}

}  // namespace muster::tools
