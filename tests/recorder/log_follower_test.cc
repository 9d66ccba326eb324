#include "recorder/log_follower.h"

#include <gtest/gtest.h>

#include "tests/recorder/messages.h"

namespace muster::recorder {
namespace {

TEST(LogFollower, MarkStopsAtAHoleUntilItCloses) {
  LogFollower log(1);
  EXPECT_EQ(log.next_seq("uav", 0), 0);
  for (const std::int64_t seq : {0, 1, 4, 3}) EXPECT_TRUE(log.Add(MessageOf("uav", seq)));
  EXPECT_EQ(log.next_seq("uav", 0), 2);
  EXPECT_EQ(log.missing(), 1);
  EXPECT_TRUE(log.Add(MessageOf("uav", 2)));
  EXPECT_EQ(log.next_seq("uav", 0), 5);
  EXPECT_EQ(log.missing(), 0);
}

TEST(LogFollower, CountsADoubleOnce) {
  LogFollower log(1);
  EXPECT_TRUE(log.Add(MessageOf("uav", 0)));
  EXPECT_FALSE(log.Add(MessageOf("uav", 0)));
  EXPECT_EQ(log.messages(), 1);
  EXPECT_EQ(log.doubles(), 1);
}

TEST(LogFollower, KeepsSendersAndTheirStartsApart) {
  LogFollower log(1);
  log.Add(MessageOf("worker", 0, 0));
  log.Add(MessageOf("uav", 0, 0));
  log.Add(MessageOf("uav", 1, 0));
  log.Add(MessageOf("uav", 0, 1));
  const log_status_t status = log.Status();
  ASSERT_EQ(status.n, 3);
  ASSERT_EQ(status.marks.size(), 3u);
  EXPECT_EQ(status.marks[0].sender, "uav");
  EXPECT_EQ(status.marks[0].boot_id, 0);
  EXPECT_EQ(status.marks[0].next_seq, 2);
  EXPECT_EQ(status.marks[1].sender, "uav");
  EXPECT_EQ(status.marks[1].boot_id, 1);
  EXPECT_EQ(status.marks[1].next_seq, 1);
  EXPECT_EQ(status.marks[2].sender, "worker");
}

TEST(LogFollower, LeavesOutOtherRunsAndGarbage) {
  LogFollower log(1);
  EXPECT_FALSE(log.Add(MessageOf("uav", 0, 0, 2)));
  Packet torn = MessageOf("uav", 0);
  torn.bytes.pop_back();
  EXPECT_FALSE(log.Add(torn));
  EXPECT_FALSE(log.Add({"MUSTER_NOBODY_KNOWS", {1, 2, 3}}));
  EXPECT_FALSE(log.Add({"LCM_SELF_TEST", {1, 2, 3}}));  // no stranger: not ours to judge
  EXPECT_EQ(log.strangers(), 3);
  EXPECT_EQ(log.messages(), 0);
  EXPECT_EQ(log.Status().n, 0);
}

}  // namespace
}  // namespace muster::recorder
