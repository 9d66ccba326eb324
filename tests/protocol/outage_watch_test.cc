#include "protocol/outage_watch.h"

#include <gtest/gtest.h>

namespace muster {
namespace {

TEST(OutageWatch, SaysOnceThatItBeginsAndThatItEnds) {
  OutageWatch watch;
  EXPECT_FALSE(watch.Line("", 0));
  EXPECT_EQ(watch.lasts_us(5), 0);
  EXPECT_EQ(watch.Line("No such device", 1 * kSecondUs),
            "the network is gone (No such device): waiting until it is back");
  EXPECT_FALSE(watch.Line("Network is unreachable", 2 * kSecondUs));
  EXPECT_EQ(watch.lasts_us(3 * kSecondUs), 2 * kSecondUs);
  EXPECT_EQ(watch.reason(), "No such device");
  EXPECT_EQ(watch.Line("", 3 * kSecondUs), "the network is back after 2.0 s");
  EXPECT_EQ(watch.lasts_us(4 * kSecondUs), 0);
  EXPECT_EQ(watch.reason(), "");
}

}  // namespace
}  // namespace muster
