#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tools/files/pending_file.h"

namespace muster::tools {

/// Files that appear together: they are written into a folder beside `path`, which takes that name
/// in Commit(). Without it nothing is left. Throws InputError when `path` exists, SystemError when
/// writing fails.
class NewFolder {
 public:
  explicit NewFolder(const std::string& path);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  /// An open file of the folder.
  class File {
   public:
    void Write(std::string_view text);

   private:
    friend class NewFolder;
    struct Close {
      void operator()(std::FILE* file) const { std::fclose(file); }
    };
    std::string path_;
    std::unique_ptr<std::FILE, Close> file_;
  };
  File& Add(const std::string& name);
  void Commit();

 private:
  PendingFile pending_;
  std::vector<std::unique_ptr<File>> files_;
};

}  // namespace muster::tools
