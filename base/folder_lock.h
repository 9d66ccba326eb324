#pragma once

#include <string>

#include "base/spawn.h"

namespace muster {

/// Keeps a folder for one process at a time, for as long as the lock lives. The lock ends with its
/// process, however that ends.
class FolderLock {
 public:
  /// Throws InputError where another process has it, and SystemError where `folder` is none.
  explicit FolderLock(const std::string& folder);

 private:
  Descriptor folder_;
};

}  // namespace muster
