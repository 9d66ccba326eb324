#include "tools/report/coast.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <map>
#include <random>
#include <utility>

#include "base/check.h"
#include "tests/temporary_folder.h"
#include "tools/report/gshhg.h"

namespace muster::tools {
namespace {

constexpr std::int64_t kSide = ShoreGrid::kSide;
constexpr std::int64_t kHalf = 32768;  // about the middle of a bin's side

using Bins = std::map<std::pair<int, int>, ShoreGrid::Bin>;

/// Bins of ten degrees; those that are not named are sea.
ShoreGrid GridOf(Bins bins) {
  ShoreGrid grid;
  grid.bin_deg = 10;
  grid.columns = 36, grid.rows = 18;
  grid.source = "made up";
  grid.read = [bins = std::move(bins)](int column, int row) {
    const auto found = bins.find({column, row});
    return found == bins.end() ? ShoreGrid::Bin() : found->second;
  };
  return grid;
}

bool IsLand(const std::vector<std::vector<double>>& rings, double latitude, double longitude) {
  bool land = false;
  for (const auto& ring : rings) {
    const std::size_t n = ring.size() / 2;
    for (std::size_t i = 0, j = n - 1; i < n; j = i++) {
      const double y = ring[2 * i], x = ring[2 * i + 1], v = ring[2 * j], u = ring[2 * j + 1];
      if ((y > latitude) != (v > latitude) && longitude < (u - x) * (latitude - y) / (v - y) + x) {
        land = !land;
      }
    }
  }
  return land;
}

/// Land in the west of the bin at 0 E, 0 N: its shore runs down the middle.
Bins WesternLand() {
  Bins bins;
  bins[{0, 9}] = {{1, 0, 0, 1}, {{{kHalf, kSide}, {kHalf, 0}}}};
  return bins;
}

TEST(Coast, LandIsOnTheSideOfItsCorners) {
  for (const bool around : {false, true}) {
    Bins bins = WesternLand();
    auto& line = bins[{0, 9}].segments[0];
    if (around) std::swap(line[0], line[1]);
    const auto land = LandWithin(GridOf(bins), {1, 1, 9, 9});
    ASSERT_EQ(land.size(), 1U);
    EXPECT_TRUE(IsLand(land, 5, 2));
    EXPECT_FALSE(IsLand(land, 5, 8));
    EXPECT_FALSE(IsLand(land, 5, 0.5)) << "outside the box nothing is said";
    for (std::size_t i = 0; i < land[0].size(); ++i) {
      EXPECT_GE(land[0][i], 1);
      EXPECT_LE(land[0][i], 9);
    }
  }
}

TEST(Coast, AnIslandInFourBinsIsOneRing) {
  Bins bins;  // a diamond around 10 E, 0 N, cut by the bins' sides
  bins[{0, 8}] = {{0, 0, 1, 0}, {{{kHalf, kSide}, {kSide, kHalf}}}};
  bins[{1, 8}] = {{0, 0, 0, 1}, {{{kHalf, kSide}, {0, kHalf}}}};
  bins[{0, 9}] = {{0, 1, 0, 0}, {{{kSide, kHalf}, {kHalf, 0}}}};
  bins[{1, 9}] = {{1, 0, 0, 0}, {{{0, kHalf}, {kHalf, 0}}}};
  const auto land = LandWithin(GridOf(bins), {-9, 1, 9, 19});
  ASSERT_EQ(land.size(), 1U);
  EXPECT_EQ(land[0].size() / 2, 5U) << "no side of a bin is in it";
  EXPECT_TRUE(IsLand(land, 0.1, 10.1));
  EXPECT_TRUE(IsLand(land, 0, 6));
  EXPECT_FALSE(IsLand(land, 4, 14));
}

TEST(Coast, ALakeInLandAndAnIslandInTheLake) {
  Bins bins;
  const auto square = [](std::int64_t from, std::int64_t to) {
    return std::vector<ShoreGrid::Place>{
        {from, from}, {to, from}, {to, to}, {from, to}, {from, from}};
  };
  bins[{0, 9}] = {{1, 1, 1, 1}, {square(13107, 52428), square(26214, 39321)}};
  const auto land = LandWithin(GridOf(bins), {0.5, 0.5, 9.5, 9.5});
  EXPECT_TRUE(IsLand(land, 1, 1));
  EXPECT_FALSE(IsLand(land, 3, 3));
  EXPECT_TRUE(IsLand(land, 5, 5));
  EXPECT_TRUE(LandWithin(GridOf({}), {0.5, 0.5, 9.5, 9.5}).empty()) << "open sea";
}

TEST(Coast, TheMeridianAndNegativeLongitudesAreNoBorder) {
  Bins bins = WesternLand();
  bins[{35, 9}] = {{1, 1, 1, 1}, {}};
  const auto land = LandWithin(GridOf(bins), {1, -9, 9, 9});
  EXPECT_TRUE(IsLand(land, 5, -5));
  EXPECT_TRUE(IsLand(land, 5, 4));
  EXPECT_FALSE(IsLand(land, 5, 6));
}

TEST(Coast, AShoreThatEndsWithinTheBinsIsRefused) {
  Bins bins = WesternLand();
  bins[{0, 9}].segments[0][1].y = 77;
  EXPECT_THROW(LandWithin(GridOf(bins), {1, 1, 9, 9}), InputError);
}

TEST(Coast, ManyShoresAcrossABoxAlternate) {
  // Upright strips of random widths, in any order and direction: land and water take turns.
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    SCOPED_TRACE(round);
    std::vector<std::int64_t> at;
    for (std::int64_t x = 1 + static_cast<std::int64_t>(random() % 9000); x < kSide;
         x += 2000 + static_cast<std::int64_t>(random() % 9000)) {
      at.push_back(x);
    }
    const int first = static_cast<int>(random() % 2);
    const int last = (first + static_cast<int>(at.size())) % 2;
    Bins bins;
    bins[{0, 9}].corners = {first, last, last, first};
    for (const std::int64_t x : at) {
      std::vector<ShoreGrid::Place> line = {{x, 0}, {x, kHalf}, {x, kSide}};
      if (random() % 2 == 0) std::reverse(line.begin(), line.end());
      bins[{0, 9}].segments.push_back(line);
    }
    std::shuffle(bins[{0, 9}].segments.begin(), bins[{0, 9}].segments.end(), random);
    const auto land = LandWithin(GridOf(bins), {2, 0.00001, 8, 9.99999});
    int expected = first;
    std::int64_t from = 0;
    at.push_back(kSide);
    for (const std::int64_t x : at) {
      const double middle = static_cast<double>(from + x) / 2 / kSide * 10;
      EXPECT_EQ(IsLand(land, 5, middle), expected == 1) << middle;
      expected = 1 - expected;
      from = x;
    }
  }
}

Scenario At(double latitude, double longitude, double km) {
  Scenario scenario;
  scenario.name = "made up";
  scenario.width_m = scenario.height_m = 1000 * km;
  scenario.origin.emplace();
  scenario.origin->latitude_deg = latitude;
  scenario.origin->longitude_deg = longitude;
  return scenario;
}

TEST(Coast, ThePageHasDifferencesOfWholeUnits) {
  const auto coast = Coast(GridOf(WesternLand()), At(5, 4.7, 50));
  EXPECT_EQ(coast["source"], "made up");
  const auto box = coast["box"].get<std::vector<std::int64_t>>();
  ASSERT_EQ(coast["rings"].size(), 1U);
  std::int64_t latitude = 0, longitude = 0, east = 0;
  const auto ring = coast["rings"][0].get<std::vector<std::int64_t>>();
  for (std::size_t i = 0; i < ring.size(); i += 2) {
    latitude += ring[i], longitude += ring[i + 1];
    east = std::max(east, longitude);
    EXPECT_TRUE(latitude >= box[0] && latitude <= box[2] && longitude >= box[1]) << i;
  }
  EXPECT_EQ(east, 500'008);  // 32768 of 65535 of ten degrees
}

/// A file in netCDF's classic format (CDF-1): variables of one dimension each.
class ClassicFile {
 public:
  void Add(const std::string& name, int type, std::vector<int> values) {
    variables_.push_back({name, type, std::move(values)});
  }

  void Write(const std::string& path) const {
    std::string head = "CDF\x01";
    Put(&head, 0, 4);
    List(&head, 0x0A);
    for (const Variable& v : variables_) {
      Name(&head, "of " + v.name);
      Put(&head, static_cast<int>(v.values.size()), 4);
    }
    Put(&head, 0x0C, 4), Put(&head, 1, 4);  // one attribute
    Name(&head, "version");
    Put(&head, 2, 4), Put(&head, 3, 4);
    head.append("9.1").append(1, '\0');
    List(&head, 0x0B);
    std::size_t size = head.size();
    for (const Variable& v : variables_) size += 4 + (v.name.size() + 3) / 4 * 4 + 28;
    std::string body;
    for (int i = 0; const Variable& v : variables_) {
      Name(&head, v.name);
      Put(&head, 1, 4), Put(&head, i++, 4);
      Put(&head, 0, 4), Put(&head, 0, 4);  // no attributes
      Put(&head, v.type, 4);
      const int width = v.type == kShort ? 2 : 4;
      std::string data;
      for (const int value : v.values) Put(&data, value, width);
      data.resize((data.size() + 3) / 4 * 4);
      Put(&head, static_cast<int>(data.size()), 4);
      Put(&head, static_cast<int>(size + body.size()), 4);
      body += data;
    }
    std::ofstream(path, std::ios::binary) << head << body;
  }

  static constexpr int kShort = 3, kInt = 4;

 private:
  struct Variable {
    std::string name;
    int type;
    std::vector<int> values;
  };
  static void Put(std::string* to, int value, int bytes) {
    for (int i = bytes - 1; i >= 0; --i) {
      to->push_back(static_cast<char>(static_cast<unsigned>(value) >> (8 * i)));
    }
  }
  static void Name(std::string* to, const std::string& name) {
    Put(to, static_cast<int>(name.size()), 4);
    to->append(name).append((4 - name.size() % 4) % 4, '\0');
  }
  void List(std::string* to, int tag) const {
    Put(to, tag, 4);
    Put(to, static_cast<int>(variables_.size()), 4);
  }

  std::vector<Variable> variables_;
};

/// 36 x 18 bins of sea, but for land in the west of the one at 0 E, 0 N: bin 8 * 36, from the
/// north.
ClassicFile MadeUp() {
  constexpr std::size_t kBin = 8 * 36;
  std::vector<int> levels(36 * 18), first(36 * 18), n(36 * 18);
  levels[kBin] = (1 << 9) | 1;  // south-west and north-west
  n[kBin] = 2;
  ClassicFile file;
  file.Add("Bin_size_in_minutes", ClassicFile::kInt, {600});
  file.Add("N_bins_in_360_longitude_range", ClassicFile::kInt, {36});
  file.Add("N_bins_in_180_degree_latitude_range", ClassicFile::kInt, {18});
  file.Add("Embedded_node_levels_in_a_bin", ClassicFile::kShort, levels);
  file.Add("Id_of_first_segment_in_a_bin", ClassicFile::kInt, first);
  file.Add("N_segments_in_a_bin", ClassicFile::kShort, n);
  // Two points of level 1, and three of a grounding line, which is not a shore.
  file.Add("Embedded_npts_levels_exit_entry_for_a_segment", ClassicFile::kInt,
           {(2 << 9) | (1 << 6) | 2, (3 << 9) | (6 << 6)});
  file.Add("Id_of_first_point_in_a_segment", ClassicFile::kInt, {0, 2});
  file.Add("Relative_longitude_from_SW_corner_of_bin", ClassicFile::kShort,
           {40000, 40000, 1, 2, 3});
  file.Add("Relative_latitude_from_SW_corner_of_bin", ClassicFile::kShort, {65535, 0, 1, 2, 3});
  return file;
}

class Gshhg : public ::testing::Test {
 protected:
  void SetUp() override {
    MadeUp().Write(path_);
    try {
      OpenGshhg(path_);
    } catch (const InputError& error) {
      if (std::string(error.what()).find("needs libnetcdf") != std::string::npos) {
        GTEST_SKIP() << error.what();
      }
      throw;
    }
  }
  TemporaryFolder folder_;
  std::string path_ = folder_.File("made_up.nc");
};

TEST_F(Gshhg, IsReadBinByBin) {
  const ShoreGrid grid = OpenGshhg(path_);
  EXPECT_EQ(grid.source, "GSHHG 9.1");
  const auto land = LandWithin(grid, {1, 1, 9, 9});
  EXPECT_TRUE(IsLand(land, 5, 6));  // 40000 of 65535 of ten degrees: 6.1
  EXPECT_FALSE(IsLand(land, 5, 6.2));
  EXPECT_FALSE(IsLand(LandWithin(grid, {-9, 1, -1, 9}), -5, 5));
}

TEST_F(Gshhg, WhatIsMissingIsSaid) {
  std::string missing;
  EXPECT_TRUE(CoastOf("none", At(5, 5, 30), &missing).is_null());
  Scenario nowhere = At(5, 5, 30);
  nowhere.origin.reset();
  EXPECT_TRUE(CoastOf("auto", nowhere, &missing).is_null());
  EXPECT_EQ(missing, "");
  EXPECT_THROW(CoastOf(path_, nowhere, &missing), InputError);
  EXPECT_THROW(CoastOf(folder_.File("none.nc"), At(5, 5, 30), &missing), InputError);
  EXPECT_EQ(CoastOf(path_, At(5, 5, 30), &missing)["rings"].size(), 1U);
}

TEST_F(Gshhg, AFileThatIsDamagedIsRefused) {
  std::ifstream in(path_, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  const std::string damaged = folder_.File("damaged.nc");
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, std::size_t{200}}) {
    std::ofstream(damaged, std::ios::binary) << whole.substr(0, size);
    EXPECT_THROW(OpenGshhg(damaged), InputError) << size;
  }
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    std::string other = whole;
    for (int i = 0; i < 6; ++i) other[random() % other.size()] = static_cast<char>(random());
    std::ofstream(damaged, std::ios::binary) << other;
    try {
      LandWithin(OpenGshhg(damaged), {1, 1, 9, 9});
    } catch (const InputError&) {  // read, or refused, and nothing else
    }
  }
}

/// Debian's own data, where they are installed: the bay of Port-au-Prince and its city.
TEST(GshhgInstalled, KnowsWaterAndLandOfHaiti) {
  if (InstalledGshhg().empty()) GTEST_SKIP() << "gmt-gshhg-full is not installed";
  std::string missing;
  const auto coast = CoastOf("auto", At(18.411458, -72.466874, 30), &missing);
  if (!missing.empty()) GTEST_SKIP() << missing;
  EXPECT_GE(coast["rings"].size(), 1U);
  const auto land = LandWithin(OpenGshhg(InstalledGshhg()), {18.2, -72.7, 18.9, -72});
  EXPECT_FALSE(IsLand(land, 18.60, -72.45));
  EXPECT_TRUE(IsLand(land, 18.53, -72.32));
}

}  // namespace
}  // namespace muster::tools
