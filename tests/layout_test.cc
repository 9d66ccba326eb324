// Arrows run down: a file includes only what its own folder holds or what stands above that folder
// in the lists of add_subdirectory in CMakeLists.txt and tools/CMakeLists.txt.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

namespace muster {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = MUSTER_SOURCE_DIR;

/// In one target of several folders: likewise, first what others stand on.
const std::vector<std::string> kOfScheduler = {"", "solver", "policies", "explain", "process"};

std::vector<std::string> Lines(const fs::path& file) {
  std::ifstream in(file);
  EXPECT_TRUE(in.is_open()) << file;
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> Subdirectories(const fs::path& list) {
  static const std::regex pattern(R"(\s*add_subdirectory\((\w+)\).*)");
  std::vector<std::string> names;
  for (const std::string& line : Lines(list)) {
    std::smatch match;
    if (std::regex_match(line, match, pattern)) names.push_back(match[1]);
  }
  return names;
}

/// The rooms of the house, the lowest first.
std::vector<std::string> Rooms() {
  std::vector<std::string> rooms;
  for (const std::string& folder : Subdirectories(kRoot / "CMakeLists.txt")) {
    if (folder == "tests") continue;
    if (folder == "scheduler") {
      for (const std::string& part : kOfScheduler) {
        rooms.push_back(part.empty() ? folder : folder + "/" + part);
      }
    } else if (folder == "tools") {
      for (const std::string& tool : Subdirectories(kRoot / "tools/CMakeLists.txt")) {
        rooms.push_back("tools/" + tool);
      }
      rooms.push_back("tools/cli");
    } else {
      rooms.push_back(folder);
    }
  }
  return rooms;
}

/// Index of the room with the longest name that the path begins with; -1: none.
int RoomOf(const std::string& path, const std::vector<std::string>& rooms) {
  int found = -1;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    if (!path.starts_with(rooms[i] + "/")) continue;
    if (found < 0 || rooms[i].size() > rooms[static_cast<std::size_t>(found)].size()) {
      found = static_cast<int>(i);
    }
  }
  return found;
}

struct Include {
  std::string file;
  int line = 0;
  std::string target;
  bool angled = false;
};

std::vector<Include> Includes() {
  static const std::regex pattern(R"(#include ([<"])([^>"]+)[>"].*)");
  std::vector<Include> includes;
  for (const std::string& folder : Subdirectories(kRoot / "CMakeLists.txt")) {
    if (folder == "tests") continue;
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cc") continue;
      int number = 0;
      for (const std::string& line : Lines(entry.path())) {
        ++number;
        std::smatch match;
        if (!std::regex_match(line, match, pattern)) continue;
        includes.push_back({fs::relative(entry.path(), kRoot), number, match[2], match[1] == "<"});
      }
    }
  }
  return includes;
}

TEST(Layout, EveryFolderHasItsPlace) {
  const std::vector<std::string> rooms = Rooms();
  EXPECT_GT(rooms.size(), 20U);
  for (const Include& include : Includes()) {
    EXPECT_GE(RoomOf(include.file, rooms), 0) << include.file;
  }
}

TEST(Layout, NothingIncludesWhatStandsAboveIt) {
  const std::vector<std::string> rooms = Rooms();
  for (const Include& include : Includes()) {
    if (include.angled || include.target.starts_with("muster/")) continue;  // generated types
    if (include.file == "scheduler/main.cc") continue;  // the program on top of its folder
    const int to = RoomOf(include.target, rooms);
    EXPECT_GE(to, 0) << fmt::format("{}:{} includes {}, which is no path from the root",
                                    include.file, include.line, include.target);
    EXPECT_LE(to, RoomOf(include.file, rooms)) << fmt::format(
        "{}:{} includes {}, which stands above it", include.file, include.line, include.target);
  }
}

TEST(Layout, OnlyTheBusKnowsLcm) {
  for (const Include& include : Includes()) {
    if (!include.angled || !include.target.starts_with("lcm/")) continue;
    EXPECT_TRUE(include.file.starts_with("lcmtypes/bus/")) << include.file;
  }
}

TEST(Layout, OnlyLearningKnowsLibtorch) {
  for (const Include& include : Includes()) {
    if (!include.angled || !include.target.starts_with("torch/")) continue;
    EXPECT_TRUE(include.file.starts_with("learning/")) << include.file;
    EXPECT_NE(include.file, "learning/trainer.h") << "what the command line knows";
  }
}

TEST(Layout, TheSchedulerCannotSeeTheTruth) {
  for (const Include& include : Includes()) {
    if (!include.file.starts_with("scheduler/")) continue;
    EXPECT_FALSE(include.target.starts_with("world/")) << include.file;
  }
}

TEST(Layout, TheAuditorSharesNoRuleWithWhatItJudges) {
  // Containers, how files are read, how errors of use and command lines are told, how bytes become
  // messages: no rule of a mission.
  const std::vector<std::string> shared = {
      "base/check.h",   "base/interval_set.h", "base/options.h",
      "base/program.h", "base/text_file.h",    "lcmtypes/",
      "muster/",        "tools/audit/",        "tools/files/"};
  for (const Include& include : Includes()) {
    if (!include.file.starts_with("tools/audit/") || include.angled) continue;
    EXPECT_TRUE(
        std::any_of(shared.begin(), shared.end(),
                    [&](const std::string& prefix) { return include.target.starts_with(prefix); }))
        << include.file << " includes " << include.target;
  }
}

TEST(Layout, EveryTestInJavaScriptIsInAListOfTests) {
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "tests")) {
    const std::string name = entry.path().filename();
    if (!name.ends_with(".test.mjs")) continue;
    ++files;
    fs::path folder = entry.path().parent_path();
    while (!fs::exists(folder / "CMakeLists.txt")) folder = folder.parent_path();
    // Listed with its name, or without its ending in a loop over the tests.
    const std::string stem = name.substr(0, name.size() - std::string(".test.mjs").size());
    const std::regex listed(
        fmt::format(R"(.*[/ ]{0}\.test\.mjs.*|\s*foreach\(test.*\b{0}\b.*)", stem));
    const std::vector<std::string> lines = Lines(folder / "CMakeLists.txt");
    EXPECT_TRUE(
        std::any_of(lines.begin(), lines.end(),
                    [&](const std::string& line) { return std::regex_match(line, listed); }))
        << entry.path() << " is in no list of " << folder / "CMakeLists.txt";
  }
  EXPECT_GT(files, 30);
}

}  // namespace
}  // namespace muster
