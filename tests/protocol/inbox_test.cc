#include "protocol/inbox.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "protocol/sender.h"
#include "tests/lcmtypes/sample_messages.h"

namespace muster {
namespace {

Packet ClockFrom(const std::string& sender, std::int64_t seq, std::int64_t run_id = 1) {
  clock_t clock{};
  clock.header.run_id = run_id;
  clock.header.sender = sender;
  clock.header.seq = seq;
  clock.decision = clock.required_decision = -1;
  return {"MUSTER_CLOCK", Encode(clock)};
}

TEST(Inbox, OpensWhatIsMeantForIt) {
  Inbox inbox(1, "uav");
  const auto message = inbox.Open(ClockFrom("world", 0));
  ASSERT_TRUE(message);
  EXPECT_TRUE(std::holds_alternative<clock_t>(*message));
  EXPECT_EQ(inbox.counters().received, 1);
}

TEST(Inbox, DropsWhatAnEarlierLaunchersProcessesSay) {
  Inbox inbox(1, "uav", kLauncherApart + 1);
  EXPECT_FALSE(inbox.Open(ClockFrom("world", 0)));
  EXPECT_EQ(inbox.counters().rejected, 1);
  clock_t clock{};
  clock.header.run_id = 1;
  clock.header.sender = "world";
  clock.header.boot_id = kLauncherApart + 1;
  clock.decision = clock.required_decision = -1;
  EXPECT_TRUE(inbox.Open({"MUSTER_CLOCK", Encode(clock)}));
  // The other way round an earlier launcher's process hears that it has a successor.
  EXPECT_TRUE(Inbox(1, "uav", 1).Open({"MUSTER_CLOCK", Encode(clock)}));
}

TEST(DecodeMessage, OpensOnEachChannelTheTypeOfTheTable) {
  for (const Channel& row : kChannels) {
    std::apply(
        [&](const auto&... samples) {
          const auto expect = [&]<class T>(const T& sample) {
            const auto message = DecodeMessage({std::string(row.name), Encode(sample)});
            const bool is_its_type = row.type == T::getTypeName();
            EXPECT_EQ(message.has_value(), is_its_type) << row.name << " " << T::getTypeName();
            if (message) {
              EXPECT_TRUE(std::holds_alternative<T>(*message)) << row.name;
            }
          };
          (expect(samples), ...);
        },
        SampleMessages());
  }
}

TEST(GapsIn, CountsTheNumbersThatAreMissingBelowTheHighest) {
  IntervalSet seqs;
  EXPECT_EQ(GapsIn(seqs), 0);
  seqs.Add(0);
  seqs.Add(1);
  EXPECT_EQ(GapsIn(seqs), 0);
  seqs.Add(5);
  EXPECT_EQ(GapsIn(seqs), 3);
  seqs.Add(3);
  EXPECT_EQ(GapsIn(seqs), 2);
}

TEST(Inbox, CountsAndDropsStrangersAndGarbage) {
  Inbox inbox(1, "uav");
  EXPECT_FALSE(inbox.Open(ClockFrom("world", 0, 2)));
  EXPECT_FALSE(inbox.Open({"MUSTER_CLOCK", {1, 2, 3}}));
  EXPECT_FALSE(inbox.Open({"MUSTER_NOTHING", ClockFrom("world", 0).bytes}));
  EXPECT_FALSE(inbox.Open({"MUSTER_WORLD", ClockFrom("world", 0).bytes}));
  EXPECT_EQ(inbox.counters().rejected, 4);
  EXPECT_EQ(inbox.counters().received, 0);
}

TEST(Inbox, CountsAndDropsWhoMayNotPublishThere) {
  Inbox inbox(1, "uav");
  EXPECT_FALSE(inbox.Open(ClockFrom("intruder", 0)));
  EXPECT_EQ(inbox.counters().rejected, 1);
}

TEST(Inbox, CountsAndDropsWhatIsNumberedAsIfTimeRanBackwards) {
  const auto clock = [](std::int64_t seq, std::int64_t sim_us) {
    Packet packet = ClockFrom("world", seq);
    auto message = *Decode<muster::clock_t>(packet.bytes);
    message.header.sim_us = sim_us;
    return Packet{packet.channel, Encode(message)};
  };
  Inbox inbox(1, "uav");
  EXPECT_TRUE(inbox.Open(clock(4, 60)));
  EXPECT_TRUE(inbox.Open(clock(2, 30)));  // an older one that was overtaken
  EXPECT_FALSE(inbox.Open(clock(5, 59)));
  EXPECT_TRUE(inbox.Open(clock(5, 60)));
  EXPECT_EQ(inbox.counters().rejected, 1);
}

TEST(Inbox, AHeartbeatMayHaveHeardMoreThanAWorldThatStartsAgainKnows) {
  process_status_t heartbeat{};
  heartbeat.header.run_id = 1;
  heartbeat.header.sender = heartbeat.name = "scheduler";
  heartbeat.header.seq = 3;
  heartbeat.header.sim_us = 90;
  heartbeat.host = "host";
  schedule_t schedule{};
  schedule.header = heartbeat.header;
  schedule.header.seq = 4;
  schedule.header.sim_us = 60;
  schedule.policy = "mpq";
  Inbox inbox(1, "world");
  EXPECT_TRUE(inbox.Open({"MUSTER_PROCESS", Encode(heartbeat)}));
  EXPECT_TRUE(inbox.Open({"MUSTER_SCHEDULE", Encode(schedule)}));
  schedule.header.seq = 5;
  schedule.header.sim_us = 59;
  EXPECT_FALSE(inbox.Open({"MUSTER_SCHEDULE", Encode(schedule)}));
}

TEST(Inbox, OwnMessagesAreNeitherTakenNorCounted) {
  Inbox inbox(1, "world");
  EXPECT_FALSE(inbox.Open(ClockFrom("world", 0)));
  EXPECT_EQ(inbox.counters().rejected, 0);
  EXPECT_EQ(inbox.counters().received, 0);
}

TEST(Inbox, WhoFloodsItWithNamesGetsNoMoreThanSomeThousand) {
  Inbox inbox(1, "uav");
  ASSERT_TRUE(inbox.Open(ClockFrom("world", 0)));
  process_status_t status{};
  status.header.run_id = 1;
  status.host = "host";
  const auto open = [&](int i) {
    status.header.sender = status.name = "name" + std::to_string(i);
    return inbox.Open({"MUSTER_PROCESS", Encode(status)}).has_value();
  };
  for (int i = 0; i < 9'999; ++i) ASSERT_TRUE(open(i)) << i;
  EXPECT_FALSE(open(9'999));
  EXPECT_FALSE(open(10'000));
  EXPECT_TRUE(open(9'998));
  EXPECT_TRUE(inbox.Open(ClockFrom("world", 1)));
}

// One flipped bit must not make a process deaf.
TEST(Inbox, ATimeThatNobodyConfirmsIsForgotten) {
  Inbox inbox(1, "uav");
  const auto open = [&](std::int64_t seq, std::int64_t sim_us) {
    request_t request{};
    request.header.run_id = 1;
    request.header.sender = "world";
    request.header.seq = seq;
    request.header.sim_us = sim_us;
    request.channel = channel::kUavs;
    return inbox.Open({std::string(channel::kRequest), Encode(request)}).has_value();
  };
  EXPECT_TRUE(open(1, 30));
  EXPECT_TRUE(open(2, 30 + (std::int64_t{1} << 40)));
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(open(3, 60));
  EXPECT_TRUE(open(3, 60));  // who waits for it asks again, and there is nothing else to say
  EXPECT_TRUE(open(4, 90));
  EXPECT_FALSE(open(5, 60));
}

}  // namespace
}  // namespace muster
