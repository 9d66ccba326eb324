#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace muster::tools {

/// Where one mission leaves what it leaves behind (docs/guide/running.md).
class RunDirectory {
 public:
  /// Makes `path` with its parents, or takes it when it exists and is empty. Throws InputError when
  /// it holds something: a run is never written over another.
  static RunDirectory Take(const std::string& path);

  /// Makes the first of ROOT/STEM, ROOT/STEM-2, ROOT/STEM-3, ... that does not exist; several
  /// launchers may do so at the same time.
  static RunDirectory MakeNew(const std::string& root, const std::string& stem);

  /// One that there is, of a mission that goes on. Throws InputError when it is no folder.
  static RunDirectory Open(const std::string& path);

  const std::string& path() const { return path_; }
  std::string File(std::string_view name) const;
  /// Writes a whole file or, on failure (SystemError), none.
  void Write(std::string_view name, std::string_view text) const;
  /// The same for its owner's eyes alone (mode 0600).
  void WriteSecret(std::string_view name, std::string_view text) const;

  /// Removes the directory if it has no log: its mission has not begun. One that was there before
  /// stays, empty as it was; one that was opened stays as it is.
  void RemoveWithoutLog() const;

 private:
  enum class Ours { kNothing, kFiles, kFolder };
  RunDirectory(std::string path, Ours ours) : path_(std::move(path)), ours_(ours) {}
  std::string path_;
  Ours ours_;
};

/// The run below a folder that was started last.
struct NewestRun {
  std::string path;      ///< ROOT/NAME; "": there is none
  bool goes_on = false;  ///< it has no report, and its log was written to within ten minutes
};
NewestRun FindNewestRun(const std::string& root);

/// "NAME-POLICY-SEED" with what does not suit a file name (anything but letters, digits, '.', '_'
/// and '-') as '_', and no more than 60 characters of the policy.
std::string RunStem(std::string_view scenario_name, std::string_view policy, std::uint64_t seed);

}  // namespace muster::tools
