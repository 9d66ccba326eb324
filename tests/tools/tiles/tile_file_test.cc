#include "tools/tiles/tile_file.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>

#include "base/random.h"
#include "tests/error_of.h"
#include "tests/temporary_folder.h"
#include "tests/tools/tiles/made_tiles.h"
#include "tools/tiles/pmtiles.h"

namespace muster::tools {
namespace {

const std::string kPicture = "\x89PNG one";

class TileFileTest : public ::testing::Test {
 protected:
  std::string File(const char* name) const { return folder_.File(name); }
  std::string ErrorOfFile(const std::string& file) const {
    const std::string error = ErrorOf([&] { OpenTiles(file); });
    EXPECT_TRUE(error.starts_with(file)) << error;
    return error;
  }
  TemporaryFolder folder_;
};

TEST_F(TileFileTest, MbtilesCountRowsFromTheSouth) {
  WriteMbtiles(File("a.mbtiles"),
               {{"format", "png"},
                {"bounds", "9.4,47.0,9.7,47.3"},
                {"attribution", "<a href=\"x\">&copy; A &amp; B</a>"}},
               {{{3, 2, 1}, kPicture}, {{4, 5, 3}, "\x89PNG two"}});
  const auto tiles = OpenTiles(File("a.mbtiles"));
  EXPECT_EQ(tiles->Read({3, 2, 1}), kPicture);
  EXPECT_EQ(tiles->Read({4, 5, 3}), "\x89PNG two");
  EXPECT_EQ(tiles->Read({3, 2, 6}), std::nullopt);
  EXPECT_FALSE(tiles->info().vector);
  EXPECT_EQ(tiles->info().type, "image/png");
  EXPECT_EQ(tiles->info().min_zoom, 3);
  EXPECT_EQ(tiles->info().max_zoom, 4);
  EXPECT_EQ(tiles->info().box.south, 47.0);
  EXPECT_EQ(tiles->info().box.east, 9.7);
  EXPECT_EQ(tiles->info().attribution, "© A & B");
}

/// Numbers of the specification: zoom by zoom, along Hilbert's curve.
TEST(Pmtiles, NumbersOfTiles) {
  EXPECT_EQ(PmtilesNumber({0, 0, 0}), 0U);
  EXPECT_EQ(PmtilesNumber({1, 0, 0}), 1U);
  EXPECT_EQ(PmtilesNumber({1, 0, 1}), 2U);
  EXPECT_EQ(PmtilesNumber({1, 1, 1}), 3U);
  EXPECT_EQ(PmtilesNumber({1, 1, 0}), 4U);
  EXPECT_EQ(PmtilesNumber({2, 0, 0}), 5U);
  EXPECT_EQ(PmtilesNumber({12, 3423, 1763}), 19078479U);
  // Along the curve each tile is beside the one before.
  std::array<TileId, 256> by_number;
  for (int column = 0; column < 16; ++column) {
    for (int row = 0; row < 16; ++row) {
      by_number.at(PmtilesNumber({4, column, row}) - PmtilesNumber({4, 0, 0})) = {4, column, row};
    }
  }
  for (std::size_t i = 1; i < by_number.size(); ++i) {
    EXPECT_EQ(std::abs(by_number[i].column - by_number[i - 1].column) +
                  std::abs(by_number[i].row - by_number[i - 1].row),
              1)
        << i;
  }
}

TEST_F(TileFileTest, PmtilesWithAndWithoutLeaves) {
  const Tiles made = {{{3, 2, 1}, kPicture}, {{4, 5, 3}, "\x89PNG two"}, {{4, 5, 4}, "three"}};
  for (const bool leaves : {false, true}) {
    SCOPED_TRACE(leaves);
    WriteBytes(File("a.pmtiles"), PmtilesBytes(made, 2, R"({"attribution": "somebody"})", leaves));
    const auto tiles = OpenTiles(File("a.pmtiles"));
    for (const auto& [id, bytes] : made) EXPECT_EQ(tiles->Read(id), bytes);
    EXPECT_EQ(tiles->Read({4, 5, 5}), std::nullopt);
    EXPECT_EQ(tiles->Read({0, 0, 0}), std::nullopt);
    EXPECT_EQ(tiles->info().min_zoom, 3);
    EXPECT_EQ(tiles->info().max_zoom, 4);
    EXPECT_EQ(tiles->info().box.west, -180);
    EXPECT_EQ(tiles->info().attribution, "somebody");
  }
}

TEST_F(TileFileTest, WhatIsWrongIsSaid) {
  WriteBytes(File("text"), "hello");
  EXPECT_NE(ErrorOfFile(File("text")).find("expected map tiles: an MBTiles or a PMTiles file"),
            std::string::npos);
  EXPECT_NE(ErrorOfFile(File("none")).find("cannot read"), std::string::npos);
  EXPECT_NE(ErrorOfFile(folder_.File(".")).find("expected map tiles"), std::string::npos);
  WriteBytes(File("cut"), std::string("SQLite format 3\0", 16) + "and no more");
  EXPECT_NE(ErrorOfFile(File("cut")).find("MBTiles"), std::string::npos);
  WriteMbtiles(File("empty"), {{"format", "png"}}, {});
  EXPECT_NE(ErrorOfFile(File("empty")).find("tiles: found none"), std::string::npos);
  WriteMbtiles(File("other"), {{"format", "terrain"}}, {{{0, 0, 0}, "bytes"}});
  EXPECT_NE(ErrorOfFile(File("other")).find("format: found terrain, expected png"),
            std::string::npos);

  const std::string good = PmtilesBytes({{{0, 0, 0}, kPicture}}, 2, "{}", false);
  const auto with = [&](std::size_t at, char byte) {
    std::string bytes = good;
    bytes[at] = byte;
    WriteBytes(File("bad"), bytes);
    return ErrorOfFile(File("bad"));
  };
  EXPECT_NE(with(7, 2).find("version: found 2, expected a PMTiles file of version 3"),
            std::string::npos);
  EXPECT_NE(with(98, 4).find("tile compression: found number 4"), std::string::npos);
  EXPECT_NE(with(99, 9).find("tile type: found number 9"), std::string::npos);
  EXPECT_NE(with(101, 60).find("zoom: found 0 to 60"), std::string::npos);
  WriteBytes(File("bad"), good.substr(0, 100));
  EXPECT_NE(ErrorOfFile(File("bad")).find("header: found the end of the file"), std::string::npos);
}

TEST_F(TileFileTest, ATableWithoutAnIndexDoesNotHoldUp) {
  Tiles made;
  for (int column = 0; column < 200; ++column) made[{8, column, 0}] = kPicture;
  WriteMbtiles(File("a"), {{"format", "png"}}, made);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(File("a").c_str(), &database), SQLITE_OK);
  // A view that multiplies the tiles beyond all use.
  for (const char* sql :
       {"alter table tiles rename to few",
        "create view tiles as select few.* from few, few a, few b, few c, few d"}) {
    ASSERT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK);
  }
  sqlite3_close(database);
  EXPECT_NE(ErrorOfFile(File("a")).find("takes too long"), std::string::npos);
}

TEST_F(TileFileTest, AnyDamageIsAnErrorOrATile) {
  const Tiles made = {{{3, 2, 1}, kPicture}, {{4, 5, 3}, "two"}, {{4, 5, 4}, "three"}};
  const std::string good = PmtilesBytes(made, 2, R"({"attribution": "somebody"})", true);
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    Random random(seed, Stream::kTest);
    std::string bytes = good;
    for (std::uint32_t n = 1 + random.Below(3); n > 0; --n) {
      bytes[7 + random.Below(static_cast<std::uint32_t>(bytes.size() - 7))] =
          static_cast<char>(random.Below(256));
    }
    WriteBytes(File("bad"), bytes);
    refused += !ErrorOf([&] {
                  const auto tiles = OpenTiles(File("bad"));
                  for (const auto& [id, of] : made) tiles->Read(id);
                }).empty();
  }
  EXPECT_GT(refused, 1000);
}

/// Files as others make them.
TEST(SharedTiles, AreRead) {
  const char* const root = std::getenv("MUSTER_SHARED");
  const std::string folder = std::string(root ? root : MUSTER_SHARED_DEFAULT) + "/data/tiles/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no map tiles in " << folder;
  const auto vector = OpenTiles(folder + "boston_buildings.mbtiles");
  EXPECT_TRUE(vector->info().vector);
  EXPECT_EQ(vector->info().attribution, "© OpenMapTiles © OpenStreetMap contributors");
  const auto pictures = OpenTiles(folder + "usgs_mt_whitney.pmtiles");
  EXPECT_EQ(pictures->info().type, "image/webp");
  EXPECT_EQ(pictures->info().min_zoom, 8);
  EXPECT_EQ(pictures->info().max_zoom, 15);
  // The middle that its header names.
  int found = 0;
  for (int column = 0; column < 256; ++column) {
    for (int row = 0; row < 256; ++row) {
      const auto tile = pictures->Read({8, column, row});
      if (!tile) continue;
      EXPECT_EQ(PictureType(*tile), "image/webp");
      ++found;
    }
  }
  EXPECT_GT(found, 0);
}

}  // namespace
}  // namespace muster::tools
