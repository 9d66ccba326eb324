#include "tools/log/new_folder.h"

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "world/model/check.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const std::string& path) {
  throw SystemError(path + ": cannot write: " + std::strerror(errno));
}

}  // namespace

NewFolder::NewFolder(std::string path) : path_(std::move(path)), temporary_(path_ + ".part") {
  if (fs::exists(path_)) {
    throw InputError("command line", "--out", path_, "a folder that does not exist");
  }
  std::error_code error;
  fs::remove_all(temporary_, error);
  fs::create_directories(temporary_, error);
  if (error) throw SystemError(temporary_ + ": cannot make: " + error.message());
}

NewFolder::~NewFolder() {
  files_.clear();
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
}

NewFolder::File& NewFolder::Add(const std::string& name) {
  auto file = std::make_unique<File>();
  file->path_ = temporary_ + "/" + name;
  file->file_.reset(std::fopen(file->path_.c_str(), "wb"));
  if (!file->file_) Fail(file->path_);
  files_.push_back(std::move(file));
  return *files_.back();
}

void NewFolder::File::Write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) Fail(path_);
}

void NewFolder::Commit() {
  for (const auto& file : files_) {
    if (std::fclose(file->file_.release()) != 0) Fail(file->path_);
  }
  files_.clear();
  std::error_code error;
  fs::rename(temporary_, path_, error);
  if (error) throw SystemError(path_ + ": cannot write: " + error.message());
}

}  // namespace muster::tools
