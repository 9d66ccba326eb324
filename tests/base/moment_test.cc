#include "base/moment.h"

#include <gtest/gtest.h>

#include <string>

namespace muster {
namespace {

constexpr std::int64_t kSecond = 1'000'000;

TEST(Moment, IsASecondOfUtcAndAnOffset) {
  // 2010-01-16 is day 14625 since 1970-01-01: 40 years of 365 days, 10 leap days, 15 days.
  constexpr std::int64_t kDay = 14'625 * 86'400LL;
  const auto port_au_prince = ParseMoment("2010-01-16T09:00:00-05:00");
  ASSERT_TRUE(port_au_prince);
  EXPECT_EQ(port_au_prince->unix_us, (kDay + 14 * 3600) * kSecond);
  EXPECT_EQ(port_au_prince->offset_min, -300);
  EXPECT_EQ(port_au_prince->text, "2010-01-16T09:00:00-05:00");
  const auto kathmandu = ParseMoment("2010-01-16T00:30:00.25+05:45");
  ASSERT_TRUE(kathmandu);
  EXPECT_EQ(kathmandu->unix_us, (kDay - 5 * 3600 - 15 * 60) * kSecond + 250'000);
  EXPECT_EQ(kathmandu->offset_min, 345);
  EXPECT_EQ(ParseMoment("2010-01-16T14:00:00Z")->unix_us, port_au_prince->unix_us);
  EXPECT_EQ(ParseMoment("20100116T140000Z")->offset_min, 0);
  EXPECT_EQ(ParseMoment("1969-12-31T23:59:59Z")->unix_us, -kSecond);
}

TEST(Moment, IsNoneWithoutSecondsOffsetOrASaneDate) {
  for (const char* bad :
       {"", "2010-01-16", "2010-01-16T09:00:00", "2010-01-16T09:00Z", "09:00:00-05:00",
        "2010-02-30T09:00:00Z", "2010-13-16T09:00:00Z", "2010-01-16T24:00:00Z",
        "2010-01-16T09:60:00Z", "1899-12-31T23:59:59Z", "2200-01-01T00:00:00Z",
        "2010-01-16T09:00:00+14:01", "2010-01-16T09:00:00-23:00", "2010-01-16T09:00:00 EST",
        " 2010-01-16T09:00:00Z", "2010-01-16T09:00:00Z ", "1263333190", "now"}) {
    EXPECT_FALSE(ParseMoment(bad)) << bad;
  }
  EXPECT_FALSE(ParseMoment(std::string("2010-01-16T09:00:00Z\0", 21)));
  EXPECT_TRUE(ParseMoment("1900-01-01T00:00:00+14:00"));
  EXPECT_TRUE(ParseMoment("2199-12-31T23:59:59-14:00"));
}

TEST(Moment, IsWrittenInItsOffset) {
  const auto moment = ParseMoment("2010-01-16T09:00:00-05:00");
  EXPECT_EQ(MomentText(moment->unix_us, -300), "2010-01-16T09:00:00-05:00");
  EXPECT_EQ(MomentText(moment->unix_us, 630), "2010-01-17T00:30:00+10:30");
  EXPECT_EQ(MomentText(moment->unix_us + 999'999, 0), "2010-01-16T14:00:00+00:00");
  EXPECT_EQ(MomentText(-1, 0), "1969-12-31T23:59:59+00:00");
  EXPECT_EQ(OffsetText(-300), "UTC-05:00");
  EXPECT_EQ(OffsetText(345), "UTC+05:45");
}

TEST(Moment, OffsetsAreHoursAndMinutes) {
  EXPECT_EQ(ParseOffset("-05:00"), -300);
  EXPECT_EQ(ParseOffset("+05:45"), 345);
  EXPECT_EQ(ParseOffset("09:30"), 570);
  EXPECT_EQ(ParseOffset("Z"), 0);
  EXPECT_EQ(ParseOffset("+14:00"), 840);
  for (const char* bad :
       {"", "5", "-5:00", "0500", "14:01", "15:00", "05:60", "--5:00", "+-1:00", "EST", "05:00 "}) {
    EXPECT_FALSE(ParseOffset(bad)) << bad;
  }
}

}  // namespace
}  // namespace muster
