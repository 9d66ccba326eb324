#include "tools/files/log_files.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "base/check.h"
#include "lcmtypes/bus/member_keys.h"

namespace muster::tools {

std::vector<std::string> LogFilesOf(const std::string& run) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (fs::is_regular_file(run, ignored)) return {run};
  if (!fs::is_directory(run, ignored)) {
    throw InputError(fmt::format("{}: no such run directory or log file", run));
  }
  std::vector<std::string> files;
  const fs::path first = fs::path(run) / "mission.lcm";
  fs::path next = first;
  for (int i = 1; fs::is_regular_file(next, ignored); ++i) {
    files.push_back(next.string());
    next = fmt::format("{}.{}", first.string(), i);
  }
  if (files.empty()) throw InputError(fmt::format("{}: no mission.lcm in this directory", run));
  return files;
}

std::optional<SealKey> KeyBeside(const std::string& log_file) {
  const std::string file = (std::filesystem::path(log_file).parent_path() / kSealKeyFile).string();
  std::ifstream in(file, std::ios::binary);
  std::string text;
  if (!std::getline(in, text)) return {};
  const SealKey key = SealKey::Parse(text, file);
  if (!key.run_id) throw InputError(file, "key", "a key without a run id", "the key of this run");
  return key;
}

std::optional<Seal> SealBeside(const std::string& log_file) {
  const std::string file =
      (std::filesystem::path(log_file).parent_path() / kSealPublicFile).string();
  std::ifstream in(file, std::ios::binary);
  std::string text;
  if (std::getline(in, text)) return Seal(MemberKeys::Parse(text, file));
  const std::optional<SealKey> key = KeyBeside(log_file);
  if (!key) return {};
  if (!key->per_process) return Seal(*key);
  throw InputError(file, "members", "no such file",
                   "the senders of this mission, sealed per process");
}

std::unique_ptr<EventLogReader> OpenLog(const std::string& file, EventLogReader::Tail tail) {
  auto reader = std::make_unique<EventLogReader>(file, tail);
  reader->OnlyWith(SealBeside(file));
  return reader;
}

}  // namespace muster::tools
