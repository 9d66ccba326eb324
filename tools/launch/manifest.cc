#include "tools/launch/manifest.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/sha256.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "tools/host/build_info.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

Json TypeHashes() {
  Json hashes = Json::object();
  for (const Channel& channel : kChannels) {
    if (const auto hash = Fingerprint(channel.type)) {
      hashes[std::string(channel.type)] = fmt::format("0x{:016x}", *hash);
    }
  }
  return hashes;
}

}  // namespace

std::string UtcText(std::int64_t wall_us) {
  return fmt::format("{:%Y-%m-%dT%H:%M:}{:02d}.{:03d}Z",
                     fmt::gmtime(static_cast<std::time_t>(wall_us / 1'000'000)),
                     wall_us / 1'000'000 % 60, wall_us / 1000 % 1000);
}

std::string ManifestJson(const ManifestInput& input) {
  Json manifest;
  manifest["version"] = 1;
  manifest["command_line"] = input.command_line;
  manifest["start"] = UtcText(input.start_wall_us);
  manifest["policy"] = input.policy;
  manifest["seed"] = input.seed;
  manifest["run_id"] = input.run_id;
  manifest["lcm_url"] = input.lcm_url;
  manifest["sealed"] = input.sealed;
  manifest["scenario"] = {{"file", input.scenario_file}, {"sha256", Sha256(input.scenario_json)}};
  manifest["commit"] = kCommit;
  manifest["versions"] = {{"muster", kVersion},
                          {"lcm", kLcmVersion},
                          {"compiler", kCompiler},
                          {"build_type", kBuildType},
                          {"sanitizer", kSanitizer}};
  manifest["type_hashes"] = TypeHashes();
  // A path need not be UTF-8.
  return manifest.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace muster::tools
