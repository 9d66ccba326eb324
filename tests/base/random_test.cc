#include "base/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>

namespace muster {
namespace {

using Block = std::array<std::uint32_t, 4>;

/// Philox4x32-10 written down from Salmon et al., "Parallel random numbers: as easy as 1, 2, 3"
/// (SC 2011), apart from the library that the product uses.
Block Philox(Block counter, std::uint32_t key0, std::uint32_t key1) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = 0xD2511F53ull * counter[0];
    const std::uint64_t b = 0xCD9E8D57ull * counter[2];
    counter = {
        static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key0, static_cast<std::uint32_t>(b),
        static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key1, static_cast<std::uint32_t>(a)};
    key0 += 0x9E3779B9u;
    key1 += 0xBB67AE85u;
  }
  return counter;
}

// The known-answer vectors that the authors publish with Random123 (kat_vectors, philox4x32 10).
TEST(Random, ReferenceGivesThePublishedVectors) {
  EXPECT_EQ(Philox({0, 0, 0, 0}, 0, 0), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(Philox({~0u, ~0u, ~0u, ~0u}, ~0u, ~0u),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(Philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0xa4093822, 0x299f31d0),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Random, FirstWordsAreThePublishedVectorOfZeros) {
  Random random(0, static_cast<Stream>(0));
  for (const std::uint32_t word : {0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u}) {
    EXPECT_EQ(random.NextWord(), word);
  }
}

TEST(Random, WordsArePhiloxOfSeedStreamEntityIndexAndBlock) {
  const std::uint64_t seed = 0x299f31d0a4093822;
  const std::uint64_t entity = 0x85a308d313198a2e;
  const std::uint32_t index = 0x03707344;
  const std::uint32_t stream = static_cast<std::uint32_t>(Stream::kTest);
  Random random(seed, Stream::kTest, entity, index);
  for (std::uint32_t block = 0; block < 5; ++block) {
    const Block expected =
        Philox({block, (stream << 24) ^ 0x85a308d3u, 0x13198a2eu, index}, 0xa4093822, 0x299f31d0);
    for (const std::uint32_t word : expected) EXPECT_EQ(random.NextWord(), word) << block;
  }
}

TEST(Random, EachPartOfTheKeyGivesItsOwnDraws) {
  std::set<std::uint32_t> first;
  for (const std::uint64_t seed : {1ull, 2ull, 1ull << 32}) {
    for (const Stream stream : {Stream::kTasks, Stream::kUavs, Stream::kTest}) {
      for (const std::uint64_t entity : {0ull, 1ull, 1ull << 32}) {
        for (const std::uint32_t index : {0u, 1u}) {
          first.insert(Random(seed, stream, entity, index).NextWord());
        }
      }
    }
  }
  EXPECT_EQ(first.size(), 3u * 3 * 3 * 2);
}

TEST(Random, UniformTakes53BitsOfTwoWords) {
  Random words(7, Stream::kTest);
  Random reals(7, Stream::kTest);
  for (int i = 0; i < 100; ++i) {
    const double high = words.NextWord() >> 5;
    const double low = words.NextWord() >> 6;
    EXPECT_EQ(reals.Uniform(), (high * 67108864.0 + low) / 9007199254740992.0);
  }
}

TEST(Random, UniformStaysInItsHalfOpenIntervalAndFillsIt) {
  Random random(11, Stream::kTest);
  double low = 1;
  double high = 0;
  double sum = 0;
  constexpr int kDraws = 100'000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.Uniform();
    ASSERT_TRUE(x >= 0 && x < 1) << x;
    low = std::min(low, x);
    high = std::max(high, x);
    sum += x;
  }
  EXPECT_LT(low, 1e-3);
  EXPECT_GT(high, 1 - 1e-3);
  EXPECT_NEAR(sum / kDraws, 0.5, 0.005);  // five standard errors
  for (int i = 0; i < 1000; ++i) {
    const double x = random.Uniform(-3, 5);
    ASSERT_TRUE(x >= -3 && x < 5) << x;
  }
  EXPECT_EQ(random.Uniform(2.5, 2.5), 2.5);
}

TEST(Random, BelowIsInBoundsAndUnbiased) {
  Random random(13, Stream::kTest);
  for (const std::uint32_t n : {1u, 2u, 3u, 7u, 1000u, 0x80000001u, 0xffffffffu}) {
    for (int i = 0; i < 1000; ++i) ASSERT_LT(random.Below(n), n);
  }
  std::array<int, 7> count{};
  for (int i = 0; i < 70'000; ++i) ++count[random.Below(7)];
  for (const int c : count) EXPECT_NEAR(c, 10'000, 465);  // five standard deviations
  // Without rejection, multiplying down to 3 * 2^30 would give every third number twice as often.
  std::array<int, 3> residue{};
  for (int i = 0; i < 30'000; ++i) ++residue[random.Below(3u << 30) % 3];
  for (const int c : residue) EXPECT_NEAR(c, 10'000, 410);
}

TEST(Random, ShufflePermutesAndReachesEveryOrder) {
  std::vector<int> items(100);
  std::iota(items.begin(), items.end(), 0);
  std::vector<int> shuffled = items;
  Random(17, Stream::kTest).Shuffle(shuffled);
  EXPECT_NE(shuffled, items);
  std::sort(shuffled.begin(), shuffled.end());
  EXPECT_EQ(shuffled, items);

  std::vector<int> none;
  Random(17, Stream::kTest).Shuffle(none);
  EXPECT_TRUE(none.empty());

  std::array<int, 6> count{};  // by order of three items
  Random random(19, Stream::kTest);
  for (int i = 0; i < 60'000; ++i) {
    std::vector<int> three = {0, 1, 2};
    random.Shuffle(three);
    ++count[static_cast<std::size_t>(2 * three[0] + (three[1] > three[2] ? 1 : 0))];
  }
  for (const int c : count) EXPECT_NEAR(c, 10'000, 457);
}

}  // namespace
}  // namespace muster
