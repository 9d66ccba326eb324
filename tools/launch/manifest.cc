#include "tools/launch/manifest.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/object_reader.h"
#include "base/sha256.h"
#include "base/text_file.h"
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

EarlierCommand ReadManifest(const std::string& run) {
  const std::string file = (std::filesystem::path(run) / "manifest.json").string();
  const JsonValue manifest = ParseJson(ReadTextFile(file, "how the mission was started"), file);
  const ObjectReader top(manifest, "", file);
  EarlierCommand earlier;
  for (const JsonValue& word : top.Array("command_line")) earlier.command_line.push_back(word.text);
  if (earlier.command_line.empty() || earlier.command_line.front() != "muster run") {
    top.Fail("command_line", top.Required("command_line", "a command line"),
             "the command line of a mission (muster run)");
  }
  earlier.run_id = top.Integer("run_id", 1, std::numeric_limits<std::int64_t>::max());
  earlier.sealed = top.Boolean("sealed", false);
  earlier.commit = top.String("commit");
  if (top.Has("folder")) earlier.folder = top.String("folder");
  return earlier;
}

std::string UtcText(std::int64_t wall_us) {
  return fmt::format("{:%Y-%m-%dT%H:%M:}{:02d}.{:03d}Z",
                     fmt::gmtime(static_cast<std::time_t>(wall_us / 1'000'000)),
                     wall_us / 1'000'000 % 60, wall_us / 1000 % 1000);
}

std::string ManifestJson(const ManifestInput& input) {
  Json manifest;
  manifest["version"] = 1;
  manifest["command_line"] = input.command_line;
  manifest["folder"] = input.folder;
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
