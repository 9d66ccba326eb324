#include "tools/files/run_directory.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "base/check.h"
#include "tests/temporary_folder.h"
#include "tools/launch/manifest.h"

namespace muster::tools {
namespace {

class RunDirectoryTest : public ::testing::Test {
 protected:
  const TemporaryFolder root_;
};

TEST_F(RunDirectoryTest, NewFoldersDoNotCollide) {
  const std::string root = (root_ / "runs").string();
  EXPECT_EQ(RunDirectory::MakeNew(root, "a-mpq-1").path(), root + "/a-mpq-1");
  EXPECT_EQ(RunDirectory::MakeNew(root, "a-mpq-1").path(), root + "/a-mpq-1-2");
  EXPECT_EQ(RunDirectory::MakeNew(root, "a-mpq-1").path(), root + "/a-mpq-1-3");
}

TEST_F(RunDirectoryTest, TakesNewAndEmptyFoldersOnly) {
  const std::string path = (root_ / "deep" / "run").string();
  RunDirectory::Take(path);
  const RunDirectory again = RunDirectory::Take(path);
  again.Write("report.json", "{}\n");
  EXPECT_THROW(RunDirectory::Take(path), InputError);
  EXPECT_THROW(RunDirectory::Take(again.File("report.json")), InputError);
  std::ifstream in(again.File("report.json"));
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "{}\n");
}

TEST_F(RunDirectoryTest, SaysWhenAFolderCannotBeMade) {
  std::ofstream(root_ / "file") << "x";
  EXPECT_THROW(RunDirectory::Take((root_ / "file" / "run").string()), SystemError);
  EXPECT_THROW(RunDirectory::MakeNew((root_ / "file").string(), "run"), SystemError);
}

TEST_F(RunDirectoryTest, TheNewestRunIsFoundAndWhetherItGoesOn) {
  const std::string root = (root_ / "runs").string();
  EXPECT_EQ(FindNewestRun(root).path, "");
  const auto begin = [&](const char* name, int age_s) {
    const RunDirectory run = RunDirectory::Take(root + "/" + name);
    for (const char* file : {"manifest.json", "mission.lcm"}) {
      run.Write(file, "{}");
      std::filesystem::last_write_time(
          run.File(file),
          std::filesystem::file_time_type::clock::now() - std::chrono::seconds(age_s));
    }
    return run;
  };
  begin("b", 1000);
  EXPECT_EQ(FindNewestRun(root).path, root + "/b");
  EXPECT_FALSE(FindNewestRun(root).goes_on) << "nothing was written for 1000 s";
  const RunDirectory newest = begin("a", 10);
  begin("c", 2000);
  std::filesystem::create_directory(root + "/no run");
  EXPECT_EQ(FindNewestRun(root).path, root + "/a");
  EXPECT_TRUE(FindNewestRun(root).goes_on);
  newest.Write("report.json", "{}");
  EXPECT_EQ(FindNewestRun(root).path, root + "/a");
  EXPECT_FALSE(FindNewestRun(root).goes_on);
}

TEST(RunStem, IsAFileName) {
  EXPECT_EQ(RunStem("Random_1", "mpq", 7), "Random_1-mpq-7");
  EXPECT_EQ(RunStem("../Port au Prince", "mpq", 0), "_._Port_au_Prince-mpq-0");
  // A policy may be a command, and a file name has an end.
  EXPECT_EQ(RunStem("a", "external:" + std::string(300, 'x'), 1),
            "a-external_" + std::string(51, 'x') + "-1");
}

TEST(Manifest, NamesScenarioHashAndTypes) {
  ManifestInput input;
  input.command_line = {"muster run", "a.json"};
  input.seed = 18'446'744'073'709'551'615ULL;
  input.scenario_json = "abc";
  input.start_wall_us = 1'700'000'000'123'456;
  const auto manifest = nlohmann::json::parse(ManifestJson(input));
  EXPECT_EQ(manifest["version"], 1);
  EXPECT_EQ(manifest["seed"], 18'446'744'073'709'551'615ULL);
  // FIPS 180-4's example.
  EXPECT_EQ(manifest["scenario"]["sha256"],
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(manifest["start"], "2023-11-14T22:13:20.123Z");
  EXPECT_EQ(manifest["type_hashes"].size(), 19u);  // distinct types of the channel table
  EXPECT_FALSE(manifest["commit"].get<std::string>().empty());
}

}  // namespace
}  // namespace muster::tools
