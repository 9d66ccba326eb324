#include "world/peers.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace muster::world {
namespace {

using Presence = Peers::Presence;

/// Steps every 0.1 s; the limit is 1 s.
class PeersTest : public ::testing::Test {
 protected:
  void RunTo(TimeUs until_us) {
    for (; now_us_ < until_us; now_us_ += kSecondUs / 10) peers_.NoteAwake(now_us_);
  }
  Peers peers_{kSecondUs, true};
  TimeUs now_us_ = 0;
};

TEST_F(PeersTest, WhoOwesNothingMayBeSilent) {
  peers_.Hear("uav", 0);
  RunTo(100 * kSecondUs);
  peers_.AwaitFrom(now_us_);
  EXPECT_FALSE(peers_.Overdue("uav", now_us_));
  RunTo(101 * kSecondUs);
  EXPECT_TRUE(peers_.Overdue("uav", now_us_));
}

TEST_F(PeersTest, WhoIsSilentForAsLongAsItOwesAnAnswerIsOverdue) {
  peers_.Hear("uav", 0);
  peers_.AwaitFrom(0);
  RunTo(kSecondUs);
  EXPECT_FALSE(peers_.Overdue("uav", kSecondUs - 1));
  EXPECT_TRUE(peers_.Overdue("uav", kSecondUs));
}

TEST_F(PeersTest, WhoSpeaksButDoesNotAnswerHasThreeTimesAsLong) {
  peers_.AwaitFrom(0);
  for (int second = 0; second < 3; ++second) {
    RunTo(second * kSecondUs);
    peers_.Hear("uav", now_us_ - 1);
    EXPECT_FALSE(peers_.Overdue("uav", now_us_)) << second;
  }
  RunTo(3 * kSecondUs);
  peers_.Hear("uav", now_us_);
  EXPECT_TRUE(peers_.Overdue("uav", now_us_));
}

TEST_F(PeersTest, WhoSaysThatItIsDecidingHasTimeAsLongAsItSaysSo) {
  peers_.AwaitFrom(0);
  for (int second = 0; second < 100; ++second) {
    RunTo(second * kSecondUs);
    peers_.Hear("scheduler", now_us_ - 1);
    peers_.SetDeciding("scheduler", true);
    EXPECT_FALSE(peers_.Overdue("scheduler", now_us_)) << second;
  }
  RunTo(100 * kSecondUs);
  EXPECT_TRUE(peers_.Overdue("scheduler", now_us_)) << "it has died of it";
  peers_.Hear("scheduler", now_us_);
  EXPECT_FALSE(peers_.Overdue("scheduler", now_us_));
  peers_.SetDeciding("scheduler", false);
  EXPECT_TRUE(peers_.Overdue("scheduler", now_us_)) << "it has decided, and is deaf";
}

TEST_F(PeersTest, TimeInWhichTheWorldWasHeldUpDoesNotCount) {
  peers_.Hear("uav", 0);
  peers_.AwaitFrom(0);
  peers_.NoteAwake(0);
  now_us_ = 100 * kSecondUs;
  peers_.NoteAwake(now_us_);
  EXPECT_FALSE(peers_.Overdue("uav", now_us_));
  RunTo(101 * kSecondUs);
  EXPECT_TRUE(peers_.Overdue("uav", now_us_));
}

TEST_F(PeersTest, AFirstStartAwaitsWhomItHasNotHeardALaterOneHasTheLimit) {
  EXPECT_FALSE(peers_.Overdue("uav", 1000 * kSecondUs));
  Peers again(kSecondUs, false);
  again.AwaitFrom(0);
  EXPECT_FALSE(again.Overdue("uav", kSecondUs - 1));
  EXPECT_TRUE(again.Overdue("uav", kSecondUs));
}

TEST_F(PeersTest, WhoIsLostReturnsByBeingHeard) {
  EXPECT_EQ(peers_.presence("uav"), Presence::kThere);
  peers_.set_presence("uav", Presence::kLost);
  peers_.set_presence("worker", Presence::kLost);
  EXPECT_TRUE(peers_.Overdue("uav", 0)) << "at once";
  peers_.Hear("uav", 0);
  EXPECT_EQ(peers_.presence("uav"), Presence::kReturning);
  EXPECT_EQ(peers_.NamesOf(Presence::kLost), std::vector<std::string>{"worker"});
  EXPECT_EQ(peers_.NamesOf(Presence::kReturning), std::vector<std::string>{"uav"});
  EXPECT_FALSE(peers_.Overdue("uav", 0));
}

}  // namespace
}  // namespace muster::world
