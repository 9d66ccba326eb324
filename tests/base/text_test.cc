#include "base/text.h"

#include <gtest/gtest.h>

namespace muster {
namespace {

TEST(ToNumber, TakesWholeFiniteNumbersOnly) {
  EXPECT_EQ(ToNumber("-0.5"), -0.5);
  EXPECT_EQ(ToNumber("1e3"), 1000);
  for (const char* text :
       {"", " 1", "1 ", "1x", "x", "nan", "inf", "-inf", "1e400", "0x10", "1,5"}) {
    EXPECT_EQ(ToNumber(text), std::nullopt) << text;
  }
}

TEST(ToInteger, TakesWholeIntegersOfTheRangeOnly) {
  EXPECT_EQ(ToInteger("0"), 0);
  EXPECT_EQ(ToInteger("-3", -3, 4), -3);
  EXPECT_EQ(ToInteger("4", -3, 4), 4);
  for (const char* text : {"", "-4", "5", "1.0", "1e0", "4 ", "99999999999999999999"}) {
    EXPECT_EQ(ToInteger(text, -3, 4), std::nullopt) << text;
  }
}

TEST(Split, HasOnePartMoreThanSeparators) {
  EXPECT_EQ(Split("a,,b", ','), (std::vector<std::string>{"a", "", "b"}));
  EXPECT_EQ(Split("", ','), std::vector<std::string>{""});
}

TEST(DidYouMean, NamesTheNearestOfTheNear) {
  const std::vector<std::string> commands = {"run", "report", "replay", "simulate"};
  EXPECT_EQ(DidYouMean("runn", commands), " (did you mean 'run'?)");
  EXPECT_EQ(DidYouMean("urn", commands), " (did you mean 'run'?)");
  EXPECT_EQ(DidYouMean("repaly", commands), " (did you mean 'replay'?)");
  EXPECT_EQ(DidYouMean("simlat", commands), " (did you mean 'simulate'?)");
  for (const char* far : {"", "x", "walk", "r", "simulation-of-everything"}) {
    EXPECT_EQ(DidYouMean(far, commands), "") << far;
  }
  EXPECT_EQ(DidYouMean(std::string(100'000, 'x'), commands), "");
}

TEST(FirstBytes, KeepsCharactersWhole) {
  EXPECT_EQ(FirstBytes("abc", 3), "abc");
  EXPECT_EQ(FirstBytes("abc", 2), "ab");
  EXPECT_EQ(FirstBytes("a\u00e9b", 2), "a");
  EXPECT_EQ(FirstBytes("a\u00e9b", 3), "a\u00e9");
  EXPECT_EQ(FirstBytes("\u4e2d", 2), "");
}

}  // namespace
}  // namespace muster
