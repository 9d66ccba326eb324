#include "tools/launch/end_watch.h"

#include <gtest/gtest.h>

namespace muster::tools {
namespace {

TEST(EndWatch, SaysForWhomAndHowLong) {
  EndWatch watch;
  EXPECT_FALSE(watch.Line({}, 0));
  const EndWatch::Waiting waiting{{"uav", "9 messages of world (start 0) in the log"}, 9, false};
  EXPECT_FALSE(watch.Line(waiting, 1 * kSecondUs));
  EXPECT_FALSE(watch.Line(waiting, 3 * kSecondUs));
  EXPECT_EQ(watch.Line(waiting, 4 * kSecondUs),
            "the mission has been over for 3 s: it waits for uav, 9 messages of world (start 0) in "
            "the log");
  EXPECT_FALSE(watch.Line(waiting, 6 * kSecondUs));
  EXPECT_TRUE(watch.Line(waiting, 7 * kSecondUs));
  EXPECT_FALSE(watch.Line({}, 8 * kSecondUs));
  EXPECT_FALSE(watch.Line(waiting, 9 * kSecondUs)) << "anew";
}

TEST(EndWatch, GivesUpGapsThatStandWhileAllRun) {
  EndWatch watch;
  const auto at = [&](double s, std::int64_t gaps, bool may_be_filled) {
    watch.Line({{"the log"}, gaps, may_be_filled}, ToUs(s));
    return watch.hopeless(ToUs(s));
  };
  EXPECT_FALSE(at(0, 5, false));
  EXPECT_FALSE(at(9.9, 5, false));
  EXPECT_FALSE(at(9.95, 4, false)) << "one came";
  EXPECT_FALSE(at(19.9, 4, false));
  EXPECT_FALSE(at(19.91, 4, true)) << "somebody is stopped";
  EXPECT_FALSE(at(29.9, 4, false));
  EXPECT_TRUE(at(29.92, 7, false)) << "more of them is no progress";
  EXPECT_FALSE(at(30, 0, false));
  EXPECT_FALSE(at(50, 0, false));
}

TEST(EndWatch, WhoLivesAndSpeaksOnFillsNoGap) {
  EndWatch watch;
  for (int s = 0; s < 10; ++s) {
    // A heartbeat is heard, and then it is in the log.
    for (const std::int64_t gaps : {10, 9}) {
      watch.Line({{"the log"}, gaps, false}, ToUs(s + 0.1 * static_cast<double>(10 - gaps)));
    }
    EXPECT_FALSE(watch.hopeless(ToUs(s + 0.1))) << s;
  }
  watch.Line({{"the log"}, 9, false}, ToUs(10.2));
  EXPECT_TRUE(watch.hopeless(ToUs(10.2)));
}

}  // namespace
}  // namespace muster::tools
