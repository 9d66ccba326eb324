#include "tools/tiles/base_map.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/check.h"
#include "model/generator.h"
#include "tests/temporary_folder.h"
#include "tests/tools/tiles/made_tiles.h"

namespace muster::tools {
namespace {

/// 10 km at the equator, 0 degrees east: the south-west corner of the earth's four quarters'
/// middle.
Scenario Equator() {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  scenario.width_m = scenario.height_m = 10e3;
  scenario.origin = Origin{0, 0};
  return scenario;
}

/// All tiles from zoom 8 to 12 that the area and some more touch, each of so many bytes.
Tiles Around(std::size_t bytes) {
  Tiles tiles;
  for (int zoom = 8; zoom <= 12; ++zoom) {
    const int middle = 1 << (zoom - 1);
    for (int column = middle - 2; column <= middle + 2; ++column) {
      for (int row = middle - 3; row <= middle + 1; ++row) {
        tiles[{zoom, column, row}] = "\x89PNG" + std::string(bytes - 4, '.');
      }
    }
  }
  return tiles;
}

class BaseMapTest : public ::testing::Test {
 protected:
  std::unique_ptr<TileFile> Made(const Tiles& tiles, const std::string& format = "png",
                                 const std::string& bounds = "-1,-1,1,1") {
    WriteMbtiles(file_, {{"format", format}, {"bounds", bounds}, {"attribution", "us"}}, tiles);
    return OpenTiles(file_);
  }
  TemporaryFolder folder_;
  const std::string file_ = folder_.File("tiles.mbtiles");
};

TEST_F(BaseMapTest, TheHighestZoomThatFitsIsEmbedded) {
  const auto tiles = Made(Around(600));
  std::string told;
  // A tile at zoom 12 is 9.8 km wide: with a tenth of the area around it 4 columns and 4 rows at
  // most are touched; in base64 each is some 800 bytes.
  const auto all = EmbeddedBaseMap(*tiles, Equator(), 100'000, &told);
  EXPECT_EQ(all["zooms"], (nlohmann::ordered_json{12, 12}));
  EXPECT_EQ(all["tiles"].size(), 9U) << told;  // from 1 km west to 11 km east: 3 columns
  EXPECT_TRUE(all["tiles"].contains("12/2048/2047"));
  EXPECT_EQ(all["source"], "us");
  EXPECT_EQ(told, "9 tiles of zoom 12, 7 kB");
  const auto few = EmbeddedBaseMap(*tiles, Equator(), 3'500, &told);
  EXPECT_EQ(few["zooms"], (nlohmann::ordered_json{11, 11}));
  EXPECT_EQ(few["tiles"].size(), 4U);
}

TEST_F(BaseMapTest, WithTheBytesThatAreLeftTasksHaveTheNextZoom) {
  const auto tiles = Made(Around(600));
  Scenario scenario = Equator();
  scenario.charging_points = {{{1000, 9000}, 1}};
  // Two in the tile of the corner, one in that to the east of it, none outside the file.
  scenario.tasks = {{{500, 500}, 600}, {{800, 500}, 600}, {{9900, 500}, 600}};
  std::string told;
  const auto map = [&](std::size_t most_bytes) {
    const auto embedded = EmbeddedBaseMap(*tiles, scenario, most_bytes, &told);
    std::vector<std::string> closer;
    for (const auto& [key, tile] : embedded["tiles"].items()) {
      if (key.starts_with("12/")) closer.push_back(key);
    }
    EXPECT_EQ(embedded["zooms"], (nlohmann::ordered_json{11, closer.empty() ? 11 : 12}));
    return closer;
  };
  // Four tiles of zoom 11 take 3,208 bytes, each one more 802.
  EXPECT_EQ(map(3'500), std::vector<std::string>());
  EXPECT_EQ(map(4'500), (std::vector<std::string>{"12/2048/2047"}));
  EXPECT_EQ(map(5'500), (std::vector<std::string>{"12/2048/2047", "12/2049/2047"}));
  EXPECT_EQ(told, "4 tiles of zoom 11 and 2 of zoom 12 around tasks, 5 kB");
}

TEST_F(BaseMapTest, WhereEvenTheLowestTakesMoreTheMiddleIsThere) {
  const auto tiles = Made(Around(3000));
  std::string told;
  const auto map = EmbeddedBaseMap(*tiles, Equator(), 9'000, &told);
  EXPECT_EQ(map["zooms"], (nlohmann::ordered_json{8, 8}));
  EXPECT_EQ(map["tiles"].size(), 2U);
  EXPECT_NE(told.find("the middle of the area"), std::string::npos) << told;
}

TEST_F(BaseMapTest, AFileThatEndsAtALowerZoomThereIsShownAtThat) {
  Tiles made = Around(600);
  // At zoom 12 the file has one tile of nine.
  std::erase_if(
      made, [](const auto& tile) { return tile.first.zoom == 12 && tile.first.column != 2048; });
  std::erase_if(made,
                [](const auto& tile) { return tile.first.zoom == 12 && tile.first.row != 2047; });
  std::string told;
  const auto map = EmbeddedBaseMap(*Made(made), Equator(), 100'000, &told);
  EXPECT_EQ(told, "4 tiles of zoom 11 and 1 of zoom 12 around tasks, 4 kB");
  EXPECT_EQ(map["zooms"], (nlohmann::ordered_json{11, 12}));
}

TEST_F(BaseMapTest, ShapesAreTakenToThePagesUnits) {
  const auto tiles =
      Made({{{12, 2048, 2047},
             LayerBytes("transportation",
                        {{2, {{"class", "primary"}}, {{{0, 0}, {1, 1}, {400, 800}}}}}) +
                 LayerBytes("street_labels", {{2,
                                               {{"kind", "residential"}, {"name", "Long Lane"}},
                                               {{{400, 800}, {2400, 800}}}}}) +
                 LayerBytes("place", {{1, {{"class", "town"}, {"name", "Null"}}, {{{2048, 0}}}}})}},
           "pbf");
  std::string told;
  const auto map = EmbeddedBaseMap(*tiles, Equator(), 100'000, &told);
  const auto& tile = map["tiles"]["12/2048/2047"];
  EXPECT_EQ(map["units"], 1024);
  EXPECT_EQ(tile["shapes"].size(), 10U);
  EXPECT_EQ(tile["shapes"][8],
            (nlohmann::ordered_json{{0, 0, 100, 200}}));  // (1, 1) is rounded away
  EXPECT_EQ(tile["names"], (nlohmann::ordered_json{{512, 0, 1, "Null"}}));
  EXPECT_EQ(tile["streets"], (nlohmann::ordered_json{{100, 200, 500, 0, 7, "Long Lane"}}));
  EXPECT_TRUE(BaseMapOf(*tiles, Equator())["vector"]);
}

TEST_F(BaseMapTest, AFileWithoutATileWhereItSaysThatItHasSomeIsRefused) {
  const auto tiles = Made({{{12, 0, 0}, "\x89PNG"}});
  std::string told;
  try {
    EmbeddedBaseMap(*tiles, Equator(), 1000, &told);
    ADD_FAILURE() << told;
  } catch (const InputError& refused) {
    const std::string text = refused.what();
    EXPECT_NE(
        text.find("its tiles: found none in the area of scenario 'Random_1', 0.000 to 0.090 N"),
        std::string::npos)
        << text;
    EXPECT_NE(text.find("says that it has those of -1.000 to 1.000 N"), std::string::npos) << text;
  }
}

TEST_F(BaseMapTest, AnotherPlaceOrNoneIsRefused) {
  const auto tiles = Made(Around(600), "png", "8,46,10,48");
  std::string told;
  const auto error = [&](const Scenario& scenario) {
    try {
      EmbeddedBaseMap(*tiles, scenario, 1000, &told);
    } catch (const InputError& refused) {
      return std::string(refused.what());
    }
    return std::string();
  };
  EXPECT_NE(
      error(Equator()).find("its tiles: found 46.000 to 48.000 N, 8.000 to 10.000 E, expected "
                            "tiles of the area of scenario"),
      std::string::npos)
      << error(Equator());
  EXPECT_THROW(BaseMapOf(*tiles, Equator()), InputError);
  Scenario nowhere = Equator();
  nowhere.origin.reset();
  EXPECT_NE(error(nowhere).find("has no origin"), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
