#include "tests/fuzz/mutated_inputs.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/temporary_folder.h"

namespace muster::fuzz {
namespace {

namespace fs = std::filesystem;

TEST(MutatedInputs, AreTheSeedsTheirBeginningsAndMutations) {
  const MutatedInputs inputs({"abc", "0123456789"}, 7, {5, 4, 100});
  ASSERT_EQ(inputs.size(), 2u + 3 + 5 + 4);
  const std::vector<std::string> first = {"abc", "0123456789", "",     "a",      "ab",
                                          "",    "01",         "0123", "012345", "01234567"};
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(inputs.At(i), first[i]) << i;
}

TEST(MutatedInputs, FollowFromTheRandomSeedAlone) {
  const MutatedInputs::Limits limits{0, 500, 200};
  const std::vector<std::string> seeds = {"{\"n\": 12, \"list\": [1, 2]}", std::string(40, '\0')};
  const MutatedInputs inputs(seeds, 7, limits), again(seeds, 7, limits), other(seeds, 8, limits);
  std::size_t differ = 0;
  std::set<std::string> distinct;
  for (std::size_t i = inputs.size(); i-- > 0;) {  // in whatever order they are asked for
    EXPECT_EQ(inputs.At(i), again.At(i)) << i;
    EXPECT_LE(inputs.At(i).size(), limits.longest) << i;
    if (inputs.At(i) != other.At(i)) ++differ;
    distinct.insert(inputs.At(i));
  }
  EXPECT_GT(differ, 400u);
  EXPECT_GT(distinct.size(), 400u);
}

TEST(MutatedInputs, ReachWhatBreaksParsers) {
  const MutatedInputs inputs({"{\"n\": 12, \"list\": [1, 2]}"}, 7, {0, 2000, 4096});
  std::size_t nested = 0, huge = 0, nul = 0, longer = 0;
  for (std::size_t i = 1; i < inputs.size(); ++i) {
    const std::string input = inputs.At(i);
    nested += input.find("[[[[[[[[[[[[") != std::string::npos;
    huge += input.find(" 1e999") != std::string::npos;
    nul += input.find('\0') != std::string::npos;
    longer += input.size() > 1000;
  }
  EXPECT_GT(nested, 0u);
  EXPECT_GT(huge, 0u);
  EXPECT_GT(nul, 0u);
  EXPECT_GT(longer, 0u);
}

class FuzzReplay : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directory(folder_ / "seeds"); }

  /// Exit code; what it said is in said_.
  int Run(const std::string& arguments) {
    const std::string command =
        "cd '" + folder_.path().string() + "' && '" MUSTER_PLANTED "' " + arguments + " 2>&1";
    FILE* const pipe = popen(command.c_str(), "r");
    if (pipe == nullptr) return -1;
    said_.clear();
    std::array<char, 4096> buffer;
    while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
      said_.append(buffer.data(), n);
    }
    const int status = pclose(pipe);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  void Seed(const std::string& text) { std::ofstream(folder_ / "seeds" / "seed") << text; }

  const TemporaryFolder folder_;
  std::string said_;
};

TEST_F(FuzzReplay, SaysNothingOfATargetThatSurvives) {
  Seed("bcdef");
  EXPECT_EQ(Run("seeds 10 0 10"), 0) << said_;
  EXPECT_EQ(said_, "planted_replay: 6 inputs, random seed 1\n");
}

TEST_F(FuzzReplay, KeepsTheInputThatEndedTheTarget) {
  Seed("abcdef");
  EXPECT_EQ(Run("seeds 10 0 10"), 1);
  EXPECT_NE(said_.find("at input 4 (random seed 1)"), std::string::npos) << said_;
  const fs::path kept = folder_ / "planted_replay.failed-4";
  std::stringstream text;
  text << std::ifstream(kept).rdbuf();
  EXPECT_EQ(text.str(), "abc");
  EXPECT_NE(said_.find(kept.string()), std::string::npos) << said_;
  EXPECT_NE(Run(kept.string()), 0) << "the input alone ends it too";
}

TEST_F(FuzzReplay, AllowsNoMemoryThatTheInputDoesNotJustify) {
  Seed("mmmmm");
  EXPECT_EQ(Run("seeds 10 0 10"), 1);
  EXPECT_NE(said_.find("at input 5"), std::string::npos) << said_;
}

}  // namespace
}  // namespace muster::fuzz
