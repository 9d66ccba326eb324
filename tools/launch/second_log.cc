#include "tools/launch/second_log.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "base/check.h"
#include "tools/files/log_files.h"
#include "tools/files/pending_file.h"
#include "tools/launch/launch.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kManifestFile = "manifest.json";
constexpr std::size_t kMostInput = 32 * 1024;  ///< of a program that is started: a pipe holds more
constexpr int kPollUs = 10'000;

/// In this order: with the manifest the folder is complete.
std::vector<std::string> FilesFor(const RunDirectory& run) {
  std::vector<std::string> names;
  for (const std::string& name :
       {std::string(kSealKeyFile), std::string(kSealPublicFile), std::string(kLauncherKeyFile),
        std::string(kOrdersFile), std::string(kManifestFile)}) {
    if (fs::exists(run.File(name))) names.push_back(name);
  }
  return names;
}

void FillHere(const RunDirectory& run, const std::string& folder) {
  const std::string manifest = (fs::path(folder) / kManifestFile).string();
  if (fs::exists(manifest) && ReadFile(manifest) == ReadFile(run.File(kManifestFile))) return;
  CheckSecondFolder(folder);
  const RunDirectory second = RunDirectory::Take(folder);
  for (const std::string& name : FilesFor(run)) {
    second.WriteSecret(name, ReadFile(run.File(name)));
  }
}

/// Runs a shell command on that host, with `input` as its stdin.
void RunOn(const Host& host, const RunDirectory& run, const std::string& command,
           const std::string& input) {
  const std::string said = run.File("second-log.stderr");
  Child child({.name = host.name,
               .argv = {"/usr/bin/env", "ssh", "-o", "BatchMode=yes", "-o", "ConnectTimeout=10",
                        host.ssh, command},
               .output_file = said,
               .input = input});
  while (!child.Poll()) usleep(kPollUs);
  if (child.Poll()->clean()) return;
  throw SystemError(
      fmt::format("cannot prepare the second log on host {}: {}", host.name, LastLines(said, 1)));
}

void FillByShell(const RunDirectory& run, const std::string& folder, const Host& host) {
  const auto quoted = [&](const std::string& name) {
    return QuotedForShell((fs::path(folder) / name).string());
  };
  RunOn(host, run,
        fmt::format("umask 077; mkdir -p {0} && if test -e {1}; then cmp -s - {1} || "
                    "{{ echo {0} holds another run; exit 1; }}; else test -z \"$(ls {0})\" || "
                    "{{ echo {0} is not empty; exit 1; }}; fi",
                    QuotedForShell(folder), quoted(kManifestFile)),
        ReadFile(run.File(kManifestFile)));
  for (const std::string& name : FilesFor(run)) {
    const std::string text = ReadFile(run.File(name));
    for (std::size_t at = 0; at < text.size(); at += kMostInput) {
      RunOn(host, run, fmt::format("umask 077; cat {} {}", at == 0 ? ">" : ">>", quoted(name)),
            text.substr(at, kMostInput));
    }
  }
}

}  // namespace

void CheckSecondFolder(const std::string& folder) {
  std::error_code error;
  if (!fs::exists(folder, error) ||
      (fs::is_directory(folder, error) && fs::is_empty(folder, error)))
    return;
  throw InputError("command line", "--second-log", folder, "a new or empty folder");
}

void FillSecondFolder(const RunDirectory& run, const std::string& folder, const Host* host) {
  if (host == nullptr || host->ssh.empty()) return FillHere(run, folder);
  FillByShell(run, folder, *host);
}

}  // namespace muster::tools
