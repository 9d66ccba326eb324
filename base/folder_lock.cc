#include "base/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>

#include "base/check.h"

namespace muster {

FolderLock::FolderLock(const std::string& folder)
    : folder_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (folder_.get() < 0) {
    throw SystemError(fmt::format("cannot open folder {}: {}", folder, std::strerror(errno)));
  }
  if (flock(folder_.get(), LOCK_EX | LOCK_NB) == 0) return;
  if (errno != EWOULDBLOCK) {
    throw SystemError(fmt::format("cannot lock folder {}: {}", folder, std::strerror(errno)));
  }
  throw InputError(fmt::format("{}: a running mission writes there", folder));
}

}  // namespace muster
