#include "tools/tiles/vector_tile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "base/random.h"
#include "tests/tools/tiles/made_tiles.h"
#include "tools/tiles/ground_class.h"

namespace muster::tools {
namespace {

using Part = std::vector<std::int32_t>;

const std::vector<Part>& Of(const GroundShapes& ground, GroundClass its_class) {
  return ground.shapes[static_cast<std::size_t>(its_class)];
}

TEST(VectorTile, ShapesAndNamesOfThreeSchemas) {
  const std::string bytes =
      LayerBytes("transportation", {{2, {{"class", "primary"}}, {{{0, 0}, {10, 5}, {10, 5}}}},
                                    {2, {{"class", "ferry"}}, {{{0, 0}, {1, 1}}}}}) +
      LayerBytes("roads", {{2, {{"kind", "highway"}}, {{{1, 2}, {3, 4}}, {{5, 6}, {7, 8}}}}}) +
      LayerBytes("streets", {{2, {{"kind", "footway"}}, {{{9, 9}, {8, 8}}}}}) +
      LayerBytes("water", {{3, {}, {{{0, 0}, {4, 0}, {4, 4}}, {{1, 1}, {1, 2}, {2, 2}}}},
                           {2, {}, {{{0, 0}, {5, 5}}}}}) +
      LayerBytes("landcover", {{3, {{"class", "wood"}}, {{{0, 0}, {1, 0}, {1, 1}}}}}) +
      LayerBytes("building", {{3, {}, {{{0, 0}, {1, 0}, {1, 1}}}}}) +
      LayerBytes("poi", {{1, {{"name", "A shop"}, {"class", "town"}}, {{{3, 3}}}}}) +
      LayerBytes("place", {{1, {{"class", "town"}, {"name:latin", "Vaduz"}}, {{{100, 200}}}},
                           {1, {{"class", "town"}, {"name", "Beside the tile"}}, {{{-5, 200}}}}}) +
      LayerBytes(
          "places",
          {{1, {{"kind", "locality"}, {"kind_detail", "city"}, {"name", "Port"}}, {{{7, 7}}}}});
  const auto ground = ReadVectorTile(bytes);
  ASSERT_TRUE(ground);
  EXPECT_EQ(Of(*ground, GroundClass::kMainRoad), (std::vector<Part>{{0, 0, 10, 5}}));
  EXPECT_EQ(Of(*ground, GroundClass::kMotorway), (std::vector<Part>{{1, 2, 3, 4}, {5, 6, 7, 8}}));
  EXPECT_EQ(Of(*ground, GroundClass::kPath), (std::vector<Part>{{9, 9, 8, 8}}));
  EXPECT_EQ(Of(*ground, GroundClass::kWater),
            (std::vector<Part>{{0, 0, 4, 0, 4, 4}, {1, 1, 1, 2, 2, 2}}));
  EXPECT_EQ(Of(*ground, GroundClass::kWaterway), (std::vector<Part>{{0, 0, 5, 5}}));
  EXPECT_EQ(Of(*ground, GroundClass::kGreen).size(), 1U);
  EXPECT_EQ(Of(*ground, GroundClass::kBuilding).size(), 1U);
  EXPECT_TRUE(Of(*ground, GroundClass::kStreet).empty());
  ASSERT_EQ(ground->names.size(), 2U);
  EXPECT_EQ(ground->names[0].text, "Vaduz");
  EXPECT_EQ(std::tuple(ground->names[0].x, ground->names[0].y, ground->names[0].rank),
            std::tuple(100, 200, 1));
  EXPECT_EQ(std::tuple(ground->names[1].text, ground->names[1].rank), std::tuple("Port", 0));
}

TEST(VectorTile, StreetsAreNamedWhereTheyAreLongAndStraight) {
  const std::string bytes =
      LayerBytes("transportation_name",
                 {{2, {{"class", "minor"}, {"name", "Mill Lane"}}, {{{0, 0}, {100, 0}}}},
                  // The same street, longer: around a corner, of which the second part is longer.
                  {2,
                   {{"class", "minor"}, {"name", "Mill Lane"}},
                   {{{0, 1000}, {300, 1000}, {300, 1500}, {310, 2000}}}},
                  {2, {{"class", "rail"}, {"name", "Railway"}}, {{{0, 0}, {100, 0}}}},
                  {2, {{"class", "path"}, {"name", "Steps"}}, {{{0, 0}, {900, 0}}}},
                  // Its middle is in the next tile.
                  {2, {{"class", "path"}, {"name", "Outside"}}, {{{4000, 10}, {4200, 10}}}},
                  {2, {{"class", "minor"}}, {{{0, 0}, {800, 0}}}}}) +
      LayerBytes("roads", {{2, {{"kind", "highway"}, {"name", "A 13"}}, {{{9, 9}, {9, 99}}}}}) +
      LayerBytes("poi", {{2, {{"class", "minor"}, {"name", "No street"}}, {{{0, 0}, {90, 0}}}}});
  const auto ground = ReadVectorTile(bytes);
  ASSERT_TRUE(ground);
  ASSERT_EQ(ground->streets.size(), 3U);
  const auto row = [&](std::size_t i) {
    const auto& [along, rank, text] = ground->streets[i];
    return std::tuple(text, rank, along.x, along.y, along.dx, along.dy);
  };
  EXPECT_EQ(row(0), std::tuple("A 13", 6, 9, 9, 0, 90));
  EXPECT_EQ(row(1), std::tuple("Mill Lane", 7, 300, 1000, 10, 1000));
  EXPECT_EQ(row(2), std::tuple("Steps", 8, 0, 0, 900, 0));
  // Lines of roads are drawn as well, those that only carry names are not.
  EXPECT_EQ(Of(*ground, GroundClass::kMotorway).size(), 1U);
  EXPECT_TRUE(Of(*ground, GroundClass::kStreet).empty());
}

TEST(LongestStretch, BendsALittleAndStaysInTheTile) {
  const auto of = [](const std::vector<std::int32_t>& places) {
    const auto found = LongestStretch(places);
    return found ? std::vector<std::int32_t>{found->x, found->y, found->dx, found->dy}
                 : std::vector<std::int32_t>();
  };
  using Four = std::vector<std::int32_t>;
  EXPECT_EQ(of({0, 0, 100, 40, 200, 0}), (Four{0, 0, 200, 0})) << "40 units off";
  EXPECT_EQ(of({0, 0, 100, 50, 200, 0}), (Four{0, 0, 100, 50})) << "50 units off: the first of two";
  EXPECT_EQ(of({0, 0, 300, 0, 100, 0}), (Four{0, 0, 300, 0})) << "it goes back";
  EXPECT_EQ(of({9000, 0, 100, 0, 400, 0}), (Four{100, 0, 300, 0})) << "from far outside";
  EXPECT_EQ(of({-100, 50, 60, 50}), Four()) << "its middle is outside";
  EXPECT_EQ(of({-60, 50, 100, 50}), (Four{-60, 50, 160, 0}));
  EXPECT_EQ(of({5, 5}), Four());
  EXPECT_EQ(of({5, 5, 5, 5}), Four());
}

TEST(VectorTile, AnyExtentIsBroughtToOurUnits) {
  const auto ground =
      ReadVectorTile(LayerBytes("building", {{3, {}, {{{0, 0}, {512, 0}, {512, 256}}}}}, 512));
  ASSERT_TRUE(ground);
  EXPECT_EQ(Of(*ground, GroundClass::kBuilding),
            (std::vector<Part>{{0, 0, kTileUnits, 0, kTileUnits, kTileUnits / 2}}));
}

TEST(VectorTile, WhatIsNoTileIsNone) {
  const std::string good = LayerBytes("building", {{3, {}, {{{0, 0}, {512, 0}, {512, 256}}}}});
  EXPECT_FALSE(ReadVectorTile("hello"));
  EXPECT_FALSE(ReadVectorTile(good.substr(0, good.size() - 2)));
  // Tags beyond the layer's keys.
  std::string layer;
  protozero::pbf_writer writer(layer);
  writer.add_string(1, "building");
  {
    protozero::pbf_writer feature(writer, 2);
    const std::array<std::uint32_t, 2> tags = {7, 7};
    feature.add_packed_uint32(2, tags.begin(), tags.end());
    feature.add_enum(3, 3);
  }
  std::string tile;
  protozero::pbf_writer(tile).add_message(3, layer);
  EXPECT_FALSE(ReadVectorTile(tile));
  EXPECT_TRUE(ReadVectorTile(""));  // an empty sea
}

TEST(VectorTile, AnyDamageIsSurvived) {
  const std::string good =
      LayerBytes(
          "roads",
          {{2, {{"kind", "primary"}, {"name", "High Street"}}, {{{0, 0}, {10, 5}, {20, 5}}}}}) +
      LayerBytes("place", {{1, {{"class", "town"}, {"name", "Vaduz"}}, {{{100, 200}}}}});
  int read = 0;
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    Random random(seed, Stream::kTest);
    std::string bytes = good;
    for (std::uint32_t n = 1 + random.Below(4); n > 0; --n) {
      bytes[random.Below(static_cast<std::uint32_t>(bytes.size()))] =
          static_cast<char>(random.Below(256));
    }
    read += ReadVectorTile(bytes).has_value();
  }
  EXPECT_GT(read, 1000);  // where a name or a place alone is another
}

TEST(GroundClass, AreasAndLinesAreToldApart) {
  EXPECT_EQ(ClassOf("water", "lake", true), GroundClass::kWater);
  EXPECT_EQ(ClassOf("water", "river", false), GroundClass::kWaterway);
  EXPECT_EQ(ClassOf("landuse", "residential", true), GroundClass::kBuiltUp);
  EXPECT_EQ(ClassOf("roads", "residential", false), GroundClass::kStreet);
  EXPECT_EQ(ClassOf("roads", "residential", true), std::nullopt);
  EXPECT_EQ(ClassOf("buildings", "", true), GroundClass::kBuilding);
  EXPECT_EQ(ClassOf("mountain_peak", "", true), std::nullopt);
  EXPECT_EQ(RankOf("hamlet"), 4);
  EXPECT_EQ(RankOf("county"), std::nullopt);
}

}  // namespace
}  // namespace muster::tools
