#pragma once

#include <string>

namespace muster::tools {

/// A folder below the system's for temporary files (TMPDIR), gone with this object.
class ScratchFolder {
 public:
  /// `stem`: what its name begins with. Throws SystemError when it cannot be made.
  explicit ScratchFolder(const std::string& stem);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::string& path() const { return path_; }
  std::string File(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace muster::tools
