#include "tools/scenario/fields.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <optional>
#include <string>

#include "tests/error_of.h"

namespace muster::tools {
namespace {

TEST(RowFilter, MatchesCodesAndBeginnings) {
  const RowFilter filter = ParseFilter("--where", "category=1*,2d");
  EXPECT_EQ(filter.column, "category");
  for (const char* field : {"1", "1b", "5;1a", "2d", "7 ; 2d", "3;2d;9"}) {
    EXPECT_TRUE(filter.Matches(field)) << field;
  }
  for (const char* field : {"", "2", "2da", "21", "5;3", "d;2"}) {
    EXPECT_FALSE(filter.Matches(field)) << field;
  }
  EXPECT_TRUE(ParseFilter("--where", "a=b=c").Matches("b=c"));
  for (const char* bad : {"category", "=1", "category="}) {
    EXPECT_NE(ErrorOf([&] { ParseFilter("--where", bad); }).find("--where: found '"),
              std::string::npos);
  }
}

TEST(TimeOfDay, ReadsCommonWritings) {
  constexpr TimeUs kHour = 60 * kMinuteUs;
  EXPECT_EQ(TimeOfDay("05/07/2010 17:26"), 17 * kHour + 26 * kMinuteUs);
  EXPECT_EQ(TimeOfDay("2024-09-06 16:30:38.511"), 16 * kHour + 30 * kMinuteUs + 38'511'000);
  EXPECT_EQ(TimeOfDay("2020-01-20T00:01:04+08:00"), kMinuteUs + 4 * kSecondUs);
  EXPECT_EQ(TimeOfDay("2020-01-20T23:59:59Z"), 24 * kHour - kSecondUs);
  EXPECT_EQ(TimeOfDay("1/12/2010 3:15:00 PM"), 15 * kHour + 15 * kMinuteUs);
  EXPECT_EQ(TimeOfDay("12:05 am"), 5 * kMinuteUs);
  EXPECT_EQ(TimeOfDay("12:05PM"), 12 * kHour + 5 * kMinuteUs);
  EXPECT_EQ(TimeOfDay("7:30"), 7 * kHour + 30 * kMinuteUs);
  EXPECT_EQ(TimeOfDay("2020-01-20T07:30:00,5+08:00"), 7 * kHour + 30 * kMinuteUs + 500'000);
  EXPECT_EQ(TimeOfDay("20200120T0730"), 7 * kHour + 30 * kMinuteUs);
  EXPECT_EQ(TimeOfDay("20200120T073059.25Z"), 7 * kHour + 30 * kMinuteUs + 59'250'000);
  // 12 January 2010, 21:53:10 UTC.
  EXPECT_EQ(TimeOfDay("1263333190"), 21 * kHour + 53 * kMinuteUs + 10 * kSecondUs);
  EXPECT_EQ(TimeOfDay(" 1263333190.5 "), 21 * kHour + 53 * kMinuteUs + 10'500'000);
  EXPECT_EQ(TimeOfDay("1263333190123"), 21 * kHour + 53 * kMinuteUs + 10'123'000);
  for (const char* bad :
       {"20200120", "20200120073000", "202001200730", "2020", "-1263333190", "1263333190 s",
        "20200120T07", "20200120T2430", "T0730", "20200120T07305"}) {
    EXPECT_EQ(TimeOfDay(bad), std::nullopt) << bad;
  }
  for (const char* bad : {"", "NA", "2020-01-20", "24:00", "12:60", "12:00:61", "1:2", "123:45",
                          "13:00 PM", "a:b", ":30", "5:"}) {
    EXPECT_EQ(TimeOfDay(bad), std::nullopt) << bad;
  }
}

TEST(FieldTime, HasDateAndOffsetWhereTheFieldSaysThem) {
  using Date = std::optional<std::int64_t>;
  using Offset = std::optional<int>;
  const auto expect = [](const char* text, DateOrder order, TimeUs of_day_us, Date day,
                         Offset offset_min) {
    const auto time = ReadTime(text, order);
    ASSERT_TRUE(time) << text;
    EXPECT_EQ(time->of_day_us, of_day_us) << text;
    EXPECT_EQ(time->day, day) << text;
    EXPECT_EQ(time->offset_min, offset_min) << text;
  };
  constexpr TimeUs kHour = 60 * kMinuteUs;
  constexpr auto kNo = DateOrder::kUnknown;
  // Day 14625 is 2010-01-16, day 14795 5 July, day 14736 7 May of that year.
  expect("2010-01-16T09:00:00-05:00", kNo, 9 * kHour, 14'625, -300);
  expect("2010-01-16 09:00+0545", kNo, 9 * kHour, 14'625, 345);
  expect("20100116T090000Z", kNo, 9 * kHour, 14'625, 0);
  expect("20100116T0900-05", kNo, 9 * kHour, 14'625, -300);
  expect("2010-01-16 09:00", kNo, 9 * kHour, 14'625, std::nullopt);
  expect("1263632400", kNo, 9 * kHour, 14'625, 0);
  expect("05/07/2010 09:00", DateOrder::kDayFirst, 9 * kHour, 14'795, std::nullopt);
  expect("05/07/2010 09:00", DateOrder::kMonthFirst, 9 * kHour, 14'736, std::nullopt);
  expect("5.7.2010 9:00", DateOrder::kDayFirst, 9 * kHour, 14'795, std::nullopt);
  expect("05/07/2010 09:00", kNo, 9 * kHour, std::nullopt, std::nullopt);
  expect("13/07/2010 09:00", DateOrder::kMonthFirst, 9 * kHour, std::nullopt, std::nullopt);
  expect("2010-02-30 09:00", kNo, 9 * kHour, std::nullopt, std::nullopt);
  expect("09:00-05:00", kNo, 9 * kHour, std::nullopt, std::nullopt);
  EXPECT_FALSE(ReadTime("2010-01-16", kNo));
}

TEST(FieldTime, GoesToOtherClocks) {
  const FieldTime time = {30 * kMinuteUs, 14'625, 0};
  const FieldTime west = time.On(-300);
  EXPECT_EQ(west.of_day_us, (19 * 60 + 30) * kMinuteUs);
  EXPECT_EQ(west.day, 14'624);
  EXPECT_EQ(west.offset_min, -300);
  const FieldTime east = FieldTime{23 * 60 * kMinuteUs, 14'625, -300}.On(330);
  EXPECT_EQ(east.of_day_us, (9 * 60 + 30) * kMinuteUs);
  EXPECT_EQ(east.day, 14'626);
  EXPECT_EQ((FieldTime{kMinuteUs, 3, std::nullopt}.On(330).of_day_us), kMinuteUs);
}

TEST(FieldTime, AColumnTellsWhichNumberIsTheDay) {
  const auto order = [](std::initializer_list<const char*> texts) {
    DateOrderFinder finder;
    for (const char* text : texts) finder.Look(text);
    return finder.order();
  };
  EXPECT_EQ(order({"05/07/2010 17:26", "28/06/2010 23:06"}), DateOrder::kDayFirst);
  EXPECT_EQ(order({"05/07/2010 17:26", "06/28/2010 23:06"}), DateOrder::kMonthFirst);
  EXPECT_EQ(order({"05/07/2010 17:26", "12/12/2010"}), DateOrder::kUnknown);
  EXPECT_EQ(order({"28/06/2010", "06/28/2010"}), DateOrder::kUnknown);
  EXPECT_EQ(order({"2010-06-28", "17:26", ""}), DateOrder::kUnknown);
}

}  // namespace
}  // namespace muster::tools
