#include "tools/files/new_folder.h"

#include <cerrno>
#include <filesystem>

#include "base/check.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

}  // namespace

NewFolder::NewFolder(const std::string& path) : pending_(path) {
  if (fs::exists(pending_.path())) {
    throw InputError("command line", "--out", pending_.path(), "a folder that does not exist");
  }
  std::error_code error;
  fs::remove_all(pending_.temporary(), error);
  fs::create_directories(pending_.temporary(), error);
  if (error) throw SystemError(pending_.temporary() + ": cannot make: " + error.message());
}

NewFolder::~NewFolder() {
  files_.clear();
  std::error_code ignored;
  fs::remove_all(pending_.temporary(), ignored);
}

NewFolder::File& NewFolder::Add(const std::string& name) {
  auto file = std::make_unique<File>();
  file->path_ = pending_.temporary() + "/" + name;
  file->file_.reset(std::fopen(file->path_.c_str(), "wb"));
  if (!file->file_) FailToWrite(file->path_, errno);
  files_.push_back(std::move(file));
  return *files_.back();
}

void NewFolder::File::Write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size())
    FailToWrite(path_, errno);
}

void NewFolder::Commit() {
  for (const auto& file : files_) {
    if (std::fclose(file->file_.release()) != 0) FailToWrite(file->path_, errno);
  }
  files_.clear();
  pending_.Commit();
}

}  // namespace muster::tools
