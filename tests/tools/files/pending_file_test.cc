#include "tools/files/pending_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/check.h"
#include "tests/temporary_folder.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

class PendingFileTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_ / name; }
  std::string Text(const std::string& name) const {
    std::stringstream text;
    text << std::ifstream(Path(name)).rdbuf();
    return text.str();
  }
  std::size_t Entries() const {
    const fs::directory_iterator entries(folder_.path());
    return static_cast<std::size_t>(std::distance(begin(entries), end(entries)));
  }

  const TemporaryFolder folder_;
};

TEST_F(PendingFileTest, KeepsTheOldFileUntilTheNewOneIsWhole) {
  std::ofstream(Path("a")) << "old";
  PendingFile pending(Path("a"));
  EXPECT_EQ(fs::path(pending.temporary()).parent_path(), folder_.path());
  std::ofstream(pending.temporary()) << "new";
  EXPECT_EQ(Text("a"), "old");
  pending.Commit();
  EXPECT_EQ(Text("a"), "new");
  EXPECT_EQ(Entries(), 1u);
}

TEST_F(PendingFileTest, LeavesNothingWithoutCommit) {
  std::ofstream(Path("a")) << "old";
  try {
    PendingFile pending(Path("a"));
    std::ofstream(pending.temporary()) << "half";
    throw InputError("no more");
  } catch (const InputError&) {
  }
  EXPECT_EQ(Text("a"), "old");
  EXPECT_EQ(Entries(), 1u);
}

TEST_F(PendingFileTest, StartsAnewAfterAProgramThatWasKilled) {
  std::ofstream(Path("a.part")) << "a long beginning";
  PendingFile pending(Path("a"));
  EXPECT_FALSE(fs::exists(pending.temporary()));
}

TEST_F(PendingFileTest, SaysWhyItCannotTakeItsName) {
  fs::create_directories(Path("folder/in the way"));
  {
    PendingFile pending(Path("folder"));
    std::ofstream(pending.temporary()) << "new";
    try {
      pending.Commit();
      ADD_FAILURE() << "replaced a folder";
    } catch (const SystemError& error) {
      EXPECT_EQ(error.what(), Path("folder") + ": cannot write: Is a directory");
    }
  }
  EXPECT_EQ(Entries(), 1u);
  EXPECT_TRUE(fs::exists(Path("folder/in the way")));
}

TEST_F(PendingFileTest, DoesNotTouchAnothersFolderInItsWay) {
  fs::create_directories(Path("a.part/precious"));
  EXPECT_THROW(WriteFile(Path("a"), "new"), SystemError);
  EXPECT_TRUE(fs::exists(Path("a.part/precious")));
}

TEST_F(PendingFileTest, ReplacesWhatALinkPointsTo) {
  fs::create_directory(Path("other"));
  std::ofstream(Path("other/a")) << "old";
  fs::create_symlink("other/a", Path("a"));
  WriteFile(Path("a"), "new");
  EXPECT_TRUE(fs::is_symlink(Path("a")));
  EXPECT_EQ(Text("other/a"), "new");
}

TEST_F(PendingFileTest, RefusesToTakeThePlaceOfWhatIsNoFile) {
  ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
  EXPECT_THROW(WriteFile(Path("pipe"), "new"), InputError);
  EXPECT_TRUE(fs::is_fifo(Path("pipe")));
  EXPECT_EQ(Entries(), 1u);
}

TEST_F(PendingFileTest, WriteFileReplacesAWholeFile) {
  WriteFile(Path("a"), "old");
  WriteFile(Path("a"), std::string("n\0w", 3));
  EXPECT_EQ(Text("a"), std::string("n\0w", 3));
  EXPECT_EQ(Entries(), 1u);
  EXPECT_THROW(WriteFile(Path("no/such/folder"), ""), SystemError);
}

TEST_F(PendingFileTest, WriteFileOnAFullDiskKeepsTheOldFile) {
  WriteFile(Path("a"), "old");
  // A limit on file size stands for the full disk.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{4096, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string said;
  try {
    WriteFile(Path("a"), std::string(100'000, 'x'));
  } catch (const SystemError& error) {
    said = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(said, Path("a") + ": cannot write: File too large");
  EXPECT_EQ(Text("a"), "old");
  EXPECT_EQ(Entries(), 1u);
}

}  // namespace
}  // namespace muster::tools
