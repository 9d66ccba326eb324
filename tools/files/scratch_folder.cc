#include "tools/files/scratch_folder.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "base/check.h"

namespace muster::tools {

ScratchFolder::ScratchFolder(const std::string& stem)
    : path_((std::filesystem::temp_directory_path() / (stem + "_XXXXXX")).string()) {
  if (mkdtemp(path_.data()) == nullptr) {
    throw SystemError(fmt::format("cannot make {}: {}", path_, std::strerror(errno)));
  }
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace muster::tools
