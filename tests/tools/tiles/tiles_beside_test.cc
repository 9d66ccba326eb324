#include "tools/tiles/tiles_beside.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/temporary_folder.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

void Touch(const std::string& file, const std::string& text = "x") { std::ofstream(file) << text; }

TEST(TilesBeside, TheFileWithTheScenariosNameIsItsBaseMap) {
  const TemporaryFolder folder;
  const std::string scenario = folder.File("town.json");
  EXPECT_EQ(TilesBeside(""), "");
  EXPECT_EQ(TilesBeside(scenario), "");
  Touch(folder.File("other.mbtiles"));
  fs::create_directory(folder.File("town.mbtiles"));
  EXPECT_EQ(TilesBeside(scenario), "") << "a folder is no file of tiles";
  Touch(folder.File("town.pmtiles"));
  EXPECT_EQ(TilesBeside(scenario), folder.File("town.pmtiles"));
}

TEST(TilesBeside, ARunHasThatOfItsOwnScenarioOrOfTheOneItWasStartedWith) {
  const TemporaryFolder folder;
  const std::string run = folder.File("run");
  fs::create_directory(run);
  EXPECT_EQ(TilesOfRun(run), "");
  for (const char* const manifest : {"{", "[]", "{}", R"({"scenario": 3})",
                                     R"({"scenario": {"file": 3}})", R"({"scenario": {}})"}) {
    Touch(run + "/manifest.json", manifest);
    EXPECT_EQ(TilesOfRun(run), "") << manifest;
  }
  Touch(folder.File("town.mbtiles"));
  Touch(run + "/manifest.json",
        R"({"folder": ")" + folder.path().string() + R"(", "scenario": {"file": "town.json"}})");
  EXPECT_EQ(TilesOfRun(run), folder.File("town.mbtiles"));
  EXPECT_EQ(TilesOfRun(run + "/mission.lcm"), folder.File("town.mbtiles"));
  Touch(run + "/scenario.pmtiles");
  EXPECT_EQ(TilesOfRun(run), run + "/scenario.pmtiles");
}

}  // namespace
}  // namespace muster::tools
