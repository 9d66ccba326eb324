#include "tools/files/pending_file.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/check.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

std::string Target(const std::string& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status)) {
    throw InputError(path + ": found a device, a pipe or a socket, expected a file or a new name");
  }
  return fs::is_symlink(path, ignored) ? fs::weakly_canonical(path).string() : path;
}

}  // namespace

PendingFile::PendingFile(const std::string& path)
    : path_(Target(path)), temporary_(path_ + ".part") {
  std::remove(temporary_.c_str());  // of a program that was killed
}

PendingFile::~PendingFile() {
  if (!committed_) std::remove(temporary_.c_str());
}

void PendingFile::Commit() {
  std::error_code error;
  fs::rename(temporary_, path_, error);
  if (error) FailToWrite(path_, error.value());
  committed_ = true;
}

void FailToWrite(const std::string& path, int error) {
  throw SystemError(fmt::format("{}: cannot write: {}", path, std::strerror(error)));
}

void WriteFile(const std::string& path, std::string_view text, Readers readers) {
  PendingFile pending(path);
  const int fd = open(pending.temporary().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC,
                      readers == Readers::kOwner ? 0600 : 0666);
  std::FILE* const file = fd < 0 ? nullptr : fdopen(fd, "wb");
  if (file == nullptr) FailToWrite(path, errno);
  int error = std::fwrite(text.data(), 1, text.size(), file) == text.size() ? 0 : errno;
  if (std::fclose(file) != 0 && error == 0) error = errno;
  if (error != 0) FailToWrite(path, error);
  pending.Commit();
}

std::string ReadFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace muster::tools
