#include "base/text_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "base/check.h"
#include "tests/temporary_folder.h"

namespace muster {
namespace {

std::string RefusalOf(const std::string& file, std::size_t most_bytes = 1 << 20) {
  try {
    ReadTextFile(file, "a plan", most_bytes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(TextFile, IsReadWhole) {
  const TemporaryFolder folder;
  for (const std::string& text :
       {std::string(), std::string("a\0\r\nb", 5), std::string(200'000, 'x')}) {
    std::ofstream(folder.File("a"), std::ios::binary) << text;
    EXPECT_EQ(ReadTextFile(folder.File("a"), "a plan"), text);
  }
}

TEST(TextFile, IsRefusedWithTheReason) {
  const TemporaryFolder folder;
  const std::string file = folder.File("a");
  std::ofstream(file) << std::string(100'000, 'x');
  EXPECT_EQ(RefusalOf(file, 100'000), "");
  EXPECT_EQ(RefusalOf(file, 99'999),
            file + ": cannot read a plan from it: found more than 99999 bytes");
  EXPECT_EQ(RefusalOf("/dev/zero"),
            "/dev/zero: cannot read a plan from it: found more than 1048576 bytes");
  EXPECT_EQ(RefusalOf("/"), "/: cannot read a plan from it: Is a directory");
  EXPECT_EQ(RefusalOf("/nowhere/plan.json"),
            "/nowhere/plan.json: cannot read a plan from it: No such file or directory");
}

}  // namespace
}  // namespace muster
