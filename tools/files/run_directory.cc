#include "tools/files/run_directory.h"

#include <fmt/format.h>

#include <cctype>
#include <chrono>
#include <filesystem>
#include <system_error>

#include "base/check.h"
#include "tools/files/pending_file.h"

namespace muster::tools {
namespace fs = std::filesystem;
namespace {

void MakeParents(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) {
    throw SystemError(fmt::format("cannot make folder {}: {}", path.string(), error.message()));
  }
}

}  // namespace

RunDirectory RunDirectory::Take(const std::string& path) {
  std::error_code error;
  if (fs::exists(path, error) && !(fs::is_directory(path, error) && fs::is_empty(path, error))) {
    throw InputError("--out", path,
                     fs::is_directory(path, error) ? "a folder with files" : "a file",
                     "a new or empty folder");
  }
  const Ours ours = fs::exists(path, error) ? Ours::kFiles : Ours::kFolder;
  MakeParents(path);
  // No program is to take a file of it for an option.
  return {path.starts_with('-') ? "./" + path : path, ours};
}

RunDirectory RunDirectory::MakeNew(const std::string& root, const std::string& stem) {
  MakeParents(root);
  for (int n = 1;; ++n) {
    const fs::path path = fs::path(root) / (n == 1 ? stem : fmt::format("{}-{}", stem, n));
    std::error_code error;
    if (fs::create_directory(path, error)) return {path.string(), Ours::kFolder};
    if (error && error != std::errc::file_exists) {
      throw SystemError(fmt::format("cannot make folder {}: {}", path.string(), error.message()));
    }
  }
}

RunDirectory RunDirectory::Open(const std::string& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    throw InputError(fmt::format("{}: no such run directory", path));
  }
  return {path, Ours::kNothing};
}

std::string RunDirectory::File(std::string_view name) const {
  return (fs::path(path_) / name).string();
}

void RunDirectory::Write(std::string_view name, std::string_view text) const {
  WriteFile(File(name), text);
}

void RunDirectory::WriteSecret(std::string_view name, std::string_view text) const {
  WriteFile(File(name), text, Readers::kOwner);
}

void RunDirectory::RemoveWithoutLog() const {
  std::error_code error;
  if (ours_ == Ours::kNothing || fs::exists(File("mission.lcm"), error) || error) return;
  if (ours_ == Ours::kFolder) {
    fs::remove_all(path_, error);
    return;
  }
  for (const auto& entry : fs::directory_iterator(path_, error)) fs::remove_all(entry, error);
}

NewestRun FindNewestRun(const std::string& root) {
  NewestRun newest;
  fs::file_time_type started{};
  std::error_code error;
  for (fs::directory_iterator entry(root, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code none;
    const fs::file_time_type at = fs::last_write_time(entry->path() / "manifest.json", none);
    if (none || (!newest.path.empty() && at <= started)) continue;
    started = at;
    newest.path = entry->path().string();
  }
  if (newest.path.empty()) return newest;
  const fs::path path = newest.path;
  const fs::file_time_type written = fs::last_write_time(path / "mission.lcm", error);
  newest.goes_on = !error && !fs::exists(path / "report.json", error) &&
                   fs::file_time_type::clock::now() - written < std::chrono::minutes(10);
  return newest;
}

std::string RunStem(std::string_view scenario_name, std::string_view policy, std::uint64_t seed) {
  // A policy may be a command, a file name has an end.
  constexpr std::size_t kLongest = 60;
  std::string stem = fmt::format("{}-{}-{}", scenario_name, policy.substr(0, kLongest), seed);
  for (char& c : stem) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '_' && c != '-') {
      c = '_';
    }
  }
  if (stem.front() == '.') stem.front() = '_';
  return stem;
}

}  // namespace muster::tools
