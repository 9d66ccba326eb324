#include "tools/live/live_command.h"

#include <fmt/format.h>

#include <cstdio>

#include "base/program.h"
#include "lcmtypes/bus/multicast.h"
#include "tools/host/stop_signals.h"
#include "tools/live/live_server.h"
#include "tools/live/packet_source.h"
#include "tools/report/page.h"

namespace muster::tools {
namespace {

constexpr TimeUs kLookUs = 100'000;

}  // namespace

int LiveCommand(int argc, const char* const* argv) {
  cxxopts::Options options(
      argv[0],
      "Shows a mission in a browser of this host while it goes on: a run that is being written, "
      "or\n"
      "what is heard on the bus (of muster run --lcm-url, or of muster replay). Ctrl-C ends it.");
  options.add_options()("run", "Run directory, log file or LCM URL (udpm://...)",
                        cxxopts::value<std::string>()->default_value(DefaultUrl()))(
      "port", "Port on 127.0.0.1; 0: any free one",
      cxxopts::value<std::string>()->default_value(std::to_string(kDefaultLivePort)), "N");
  options.parse_positional({"run"});
  options.positional_help("[RUN|URL]");
  const auto parsed = ParseOptions(&options, argc, argv);
  if (!parsed) return kExitOk;
  RequirePage();
  const int port = ParsePort("--port", (*parsed)["port"].as<std::string>());
  const auto source = OpenPacketSource((*parsed)["run"].as<std::string>());
  const StopSignals stop;
  LiveFeed feed(source->name());
  LiveServer server(port);
  server.Start(&feed);
  fmt::print("{}\n", server.url());
  std::fflush(stdout);
  while (stop.count() == 0) feed.Add(source->Read(kLookUs));
  return kExitOk;
}

}  // namespace muster::tools
