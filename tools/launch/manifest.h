#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace muster::tools {

/// What manifest.json says beside the versions and hashes of this build.
struct ManifestInput {
  std::vector<std::string> command_line;
  std::string folder;  ///< where it was given
  std::string policy;
  std::uint64_t seed = 0;
  std::int64_t run_id = 0;
  std::string lcm_url;
  bool sealed = false;
  std::string scenario_file;  ///< as the user named it
  std::string scenario_json;  ///< as resolved
  std::int64_t start_wall_us = 0;
};

/// The text of manifest.json, version 1.
std::string ManifestJson(const ManifestInput& input);

/// The command line of a manifest, and the folder where it was given.
struct EarlierCommand {
  std::vector<std::string> command_line;
  std::string folder;
  std::int64_t run_id = 0;
  bool sealed = false;
  std::string commit;  ///< of the build that started it
};
/// Reads RUN/manifest.json. Throws InputError naming the file where it is none of `muster run`.
EarlierCommand ReadManifest(const std::string& run);

/// "2025-01-31T12:00:00.000Z" of microseconds since the Unix epoch.
std::string UtcText(std::int64_t wall_us);

}  // namespace muster::tools
