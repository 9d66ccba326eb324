#include "base/interval_set.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace muster {
namespace {

using Range = IntervalSet::Range;

TEST(IntervalSet, SaysWhatIsNewAndWhatIsMissing) {
  IntervalSet set;
  EXPECT_EQ(set.max(), -1);
  EXPECT_TRUE(set.Add(3));
  EXPECT_FALSE(set.Add(3));
  EXPECT_TRUE(set.Add(5));
  EXPECT_TRUE(set.Add(0));
  EXPECT_EQ(set.Missing(0, 6), (std::vector<Range>{{1, 2}, {4, 4}, {6, 6}}));
  EXPECT_TRUE(set.Add(4));  // joins two runs
  EXPECT_EQ(set.Missing(0, 5), (std::vector<Range>{{1, 2}}));
  EXPECT_EQ(set.Missing(4, 4), (std::vector<Range>{}));
  EXPECT_EQ(set.Missing(5, 4), (std::vector<Range>{}));
  EXPECT_EQ(set.max(), 5);
  EXPECT_EQ(set.size(), 4);
  EXPECT_EQ(set.next(), 1);
  set.Add(2);
  set.Add(1);
  EXPECT_EQ(set.next(), 6);
}

TEST(IntervalSet, ReachesToTheLargestInteger) {
  IntervalSet set;
  EXPECT_TRUE(set.Add(INT64_MAX));
  EXPECT_TRUE(set.Add(0));
  EXPECT_EQ(set.Missing(0, set.max()), (std::vector<Range>{{1, INT64_MAX - 1}}));
  EXPECT_TRUE(set.Add(INT64_MAX - 1));
  EXPECT_FALSE(set.Add(INT64_MAX));
  EXPECT_EQ(set.Missing(0, INT64_MAX), (std::vector<Range>{{1, INT64_MAX - 2}}));
}

TEST(IntervalSet, AgreesWithAPlainSetInAnyOrder) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    IntervalSet set;
    std::set<std::int64_t> plain;
    for (int i = 0; i < 40; ++i) {
      const auto value = static_cast<std::int64_t>(random() % 50);
      ASSERT_EQ(set.Add(value), plain.insert(value).second) << "round " << round;
    }
    std::set<std::int64_t> missing;
    for (const Range& range : set.Missing(0, 49)) {
      for (std::int64_t v = range.first; v <= range.last; ++v) missing.insert(v);
    }
    ASSERT_EQ(set.size(), static_cast<std::int64_t>(plain.size())) << "round " << round;
    for (std::int64_t v = 0; v < 50; ++v) {
      ASSERT_EQ(set.Contains(v), plain.contains(v)) << "round " << round;
      ASSERT_EQ(missing.contains(v), !plain.contains(v)) << "round " << round;
    }
  }
}

}  // namespace
}  // namespace muster
