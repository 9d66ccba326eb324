#include "tools/files/packing.h"

#include <gtest/gtest.h>

#include <string>

namespace muster::tools {
namespace {

std::string FromHex(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return bytes;
}

/// "hello", and 100,000 zeros, by Python's gzip.
const std::string kHello = FromHex("1f8b0800000000000203cb48cdc9c9070086a6103605000000");
const std::string kZeros = FromHex(
    "1f8b0800000000000203edc13101000000c2a0f54f6d0d0fa00000000000000000000000000000000000"
    "000000000000000000000000000000000000000000000000000000000000000000000000000000000000"
    "000000000000000000000000000000000000000000000000000000000000000000000000008057037d95"
    "11d4a0860100");

TEST(Packing, GunzipGivesWhatWasPacked) {
  EXPECT_TRUE(IsGzip(kHello));
  EXPECT_FALSE(IsGzip("hello"));
  EXPECT_EQ(Gunzip(kHello, 5), "hello");
  EXPECT_EQ(Gunzip(kZeros, 100'000), std::string(100'000, '\0'));
}

TEST(Packing, WhatIsDamagedOrTooLargeIsNone) {
  EXPECT_EQ(Gunzip(kHello, 4), std::nullopt);
  EXPECT_EQ(Gunzip(kZeros, 99'999), std::nullopt);
  EXPECT_EQ(Gunzip("hello", 100), std::nullopt);
  EXPECT_EQ(Gunzip("", 100), std::nullopt);
  EXPECT_EQ(Gunzip(kHello.substr(0, 15), 100), std::nullopt);
  std::string damaged = kHello;
  damaged[damaged.size() - 5] ^= 1;  // of the check sum
  EXPECT_EQ(Gunzip(damaged, 100), std::nullopt);
}

TEST(Packing, Base64OfTheStandard) {  // RFC 4648, section 10
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
}

TEST(Packing, DeflateIsSmaller) {
  const std::string zeros(100'000, '0');
  EXPECT_LT(Deflate(zeros).size(), 1000U);
  EXPECT_EQ(Deflate("x").substr(0, 1), "\x78");  // zlib's first byte
}

}  // namespace
}  // namespace muster::tools
