#pragma once

#include <string>
#include <string_view>

namespace muster::tools {

/// A file (or folder) that appears whole or not at all: it is written at temporary(), beside
/// `path`, and takes that name in Commit(), replacing a file there. Without Commit() the file at
/// temporary() goes with this object; a folder is its owner's to remove. A link
/// stays one: what it points to is replaced.
class PendingFile {
 public:
  /// Throws InputError where `path` is a device, a pipe or a socket: a file would take its place.
  explicit PendingFile(const std::string& path);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  const std::string& path() const { return path_; }
  const std::string& temporary() const { return temporary_; }
  /// The file must be closed. Throws SystemError.
  void Commit();

 private:
  const std::string path_, temporary_;
  bool committed_ = false;
};

/// "PATH: cannot write: WHY", where `error` is an errno.
[[noreturn]] void FailToWrite(const std::string& path, int error);

/// The users that may read a file: those that the umask allows, or its owner alone (mode 0600).
enum class Readers { kAsUsual, kOwner };

/// Writes a whole file, or leaves what was there. Throws SystemError.
void WriteFile(const std::string& path, std::string_view text, Readers readers = Readers::kAsUsual);

/// A whole file; "" where it cannot be read.
std::string ReadFile(const std::string& path);

}  // namespace muster::tools
