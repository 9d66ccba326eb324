#include "protocol/sender.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <muster/event_t.hpp>

namespace muster {
namespace {

log_status_t Mark(const std::string& sender, std::int64_t boot_id, std::int64_t next_seq) {
  log_status_t status{};
  log_mark_t mark{};
  mark.sender = sender;
  mark.boot_id = boot_id;
  mark.next_seq = next_seq;
  status.marks = {mark};
  status.n = 1;
  return status;
}

std::vector<Packet> FlushAt(Sender* sender, TimeUs now_us) {
  std::vector<Packet> out;
  sender->Flush({now_us, 0}, &out);
  return out;
}

std::int64_t SeqOf(const Packet& packet) { return Decode<event_t>(packet.bytes)->header.seq; }

SentPacket Say(Sender* sender, std::int64_t at_us = 0) {
  event_t event{};
  event.at_us = at_us;
  return sender->Send("MUSTER_EVENT", event, at_us, {});
}

TEST(Sender, NumbersWithoutGapsAndStampsTheHeader) {
  Sender sender({7, "world", 2}, 0);
  Say(&sender);
  Say(&sender, 30);
  const std::vector<Packet> out = FlushAt(&sender, 0);
  ASSERT_EQ(out.size(), 2u);
  const event_t second = *Decode<event_t>(out[1].bytes);
  EXPECT_EQ(second.header.run_id, 7);
  EXPECT_EQ(second.header.sender, "world");
  EXPECT_EQ(second.header.boot_id, 2);
  EXPECT_EQ(second.header.seq, 1);
  EXPECT_EQ(second.header.sim_us, 30);
  EXPECT_TRUE(sender.drained());
}

TEST(Sender, ResendIsTheSameBytes) {
  Sender sender({1, "world", 0}, 0);
  const SentPacket packet = Say(&sender);
  const std::vector<Packet> first = FlushAt(&sender, 0);
  sender.Resend(packet);
  EXPECT_EQ(FlushAt(&sender, 10), first);
  EXPECT_EQ(sender.resent(), 1);
  EXPECT_EQ(sender.next_seq(), 1);
}

TEST(Sender, HoldsBackBeyondTheWindowUntilTheLogHasIt) {
  Sender sender({1, "world", 0}, 3);
  for (int i = 0; i < 5; ++i) Say(&sender);
  EXPECT_EQ(FlushAt(&sender, 0).size(), 3u);
  EXPECT_TRUE(FlushAt(&sender, 100).empty());
  sender.Acknowledge(Mark("world", 0, 2));
  const std::vector<Packet> more = FlushAt(&sender, 200);
  ASSERT_EQ(more.size(), 2u);
  EXPECT_EQ(SeqOf(more[0]), 3);
  EXPECT_FALSE(sender.drained());
  sender.Acknowledge(Mark("world", 0, 5));
  EXPECT_TRUE(sender.drained());
  EXPECT_EQ(sender.wake_us(), kNever);
  EXPECT_TRUE(FlushAt(&sender, 300).empty());
  EXPECT_EQ(sender.wake_us(), kNever);
}

TEST(Sender, AnothersMarkIsNotItsOwn) {
  Sender sender({1, "world", 1}, 3);
  Say(&sender);
  FlushAt(&sender, 0);
  sender.Acknowledge(Mark("uav", 1, 1));
  sender.Acknowledge(Mark("world", 0, 1));
  EXPECT_FALSE(sender.drained());
}

TEST(Sender, AMarkBeyondWhatWasSentAcknowledgesNoMore) {
  Sender sender({1, "world", 0}, 2);
  for (int i = 0; i < 4; ++i) Say(&sender);
  FlushAt(&sender, 0);
  sender.Acknowledge(Mark("world", 0, 1'000'000));
  const std::vector<Packet> rest = FlushAt(&sender, 1);
  ASSERT_EQ(rest.size(), 2u);
  EXPECT_EQ(SeqOf(rest[0]), 2);
}

TEST(Sender, RepairsTheOldestFirstWithBackOff) {
  Sender sender({1, "world", 0}, 10);
  for (int i = 0; i < 6; ++i) Say(&sender);
  FlushAt(&sender, 0);
  const TimeUs first = sender.wake_us();
  ASSERT_LT(first, kNever);
  const std::vector<Packet> repair = FlushAt(&sender, first);
  ASSERT_FALSE(repair.empty());
  EXPECT_EQ(SeqOf(repair[0]), 0);
  EXPECT_EQ(sender.wake_us() - first, 2 * first);
}

TEST(Sender, APacketThatStillWaitsIsNotSentTwice) {
  Sender sender({1, "world", 0}, 1);
  Say(&sender);
  const SentPacket waiting = Say(&sender);
  sender.Resend(waiting);
  EXPECT_EQ(FlushAt(&sender, 0).size(), 1u);
  EXPECT_EQ(sender.resent(), 0);
}

TEST(Sender, RepairsFourAtATimeAndOnlyWhatIsOut) {
  Sender sender({1, "world", 0}, 6);
  for (int i = 0; i < 8; ++i) Say(&sender);
  EXPECT_EQ(FlushAt(&sender, 0).size(), 6u);
  EXPECT_TRUE(FlushAt(&sender, sender.wake_us() - 1).empty());
  EXPECT_EQ(FlushAt(&sender, sender.wake_us()).size(), 4u);
  EXPECT_EQ(sender.resent(), 4);
  sender.Acknowledge(Mark("world", 0, 6));
  EXPECT_EQ(FlushAt(&sender, 1000).size(), 2u);  // the rest, for the first time
  EXPECT_EQ(FlushAt(&sender, sender.wake_us()).size(), 2u);
  EXPECT_EQ(sender.resent(), 6);
}

TEST(Sender, BacksOffToHalfASecondAndAnewAfterAnAcknowledgement) {
  Sender sender({1, "world", 0}, 6);
  Say(&sender);
  Say(&sender);
  FlushAt(&sender, 0);
  std::vector<TimeUs> waits;
  TimeUs now = 0;
  for (int i = 0; i < 8; ++i) {
    waits.push_back(sender.wake_us() - now);
    now = sender.wake_us();
    FlushAt(&sender, now);
  }
  EXPECT_EQ(waits, (std::vector<TimeUs>{20'000, 40'000, 80'000, 160'000, 320'000, 500'000, 500'000,
                                        500'000}));
  sender.Acknowledge(Mark("world", 0, 1));
  FlushAt(&sender, now);
  EXPECT_EQ(sender.wake_us() - now, 20'000);
}

TEST(Sender, ManySmallMessagesAreOutAtATimeWhereTheWindowIsOneOfBytes) {
  Sender sender({1, "world", 0}, {2, 2000});
  std::vector<SentPacket> said;
  for (int i = 0; i < 100; ++i) said.push_back(Say(&sender));
  const std::size_t fit = 2000 / said[0]->bytes.size();
  ASSERT_GT(fit, 4u);
  EXPECT_EQ(FlushAt(&sender, 0).size(), fit);
  EXPECT_TRUE(sender.holds_back());
  sender.Acknowledge(Mark("world", 0, 3));
  EXPECT_EQ(FlushAt(&sender, 1).size(), 3u);
  EXPECT_EQ(FlushAt(&sender, sender.wake_us()).size(), fit) << "small ones are repaired together";
  sender.Acknowledge(Mark("world", 0, 100));
  EXPECT_EQ(FlushAt(&sender, 30'000).size(), fit);
}

TEST(Sender, AMessageThatJustFitsTheWindowIsSent) {
  const auto sent = [](std::size_t fewer) {
    Sender sender({1, "world", 0}, 0);
    const std::size_t size = Say(&sender)->bytes.size();
    Sender held({1, "world", 0}, {1, 3 * size - fewer});
    for (int i = 0; i < 5; ++i) Say(&held);
    return FlushAt(&held, 0).size();
  };
  EXPECT_EQ(sent(0), 3u);
  EXPECT_EQ(sent(1), 2u) << "a byte too few for the third";
}

// Processes that were slow because there were many of them made it worse by repairing.
TEST(Sender, WaitsForAcknowledgementsThatTakeLong) {
  Sender sender({1, "world", 0}, 2);
  Say(&sender);
  FlushAt(&sender, 0);
  EXPECT_EQ(sender.wake_us(), 20'000);
  sender.Acknowledge(Mark("world", 0, 1));
  Say(&sender);
  FlushAt(&sender, 15'000);
  EXPECT_EQ(sender.wake_us(), 75'000);
  FlushAt(&sender, 75'000);
  sender.Acknowledge(Mark("world", 0, 2));
  Say(&sender);
  FlushAt(&sender, 400'000);
  EXPECT_EQ(sender.wake_us(), 460'000) << "of what was said twice nobody knows how long it took";
}

TEST(BackOff, WhatHasWaitedForLongIsSaidLessOften) {
  BackOff repeat(2'000, 40'000, kSecondUs);
  repeat.Start(0);
  int said = 0;
  std::map<TimeUs, int> by;
  for (TimeUs now = repeat.due_us(); now < 100 * kSecondUs; now = repeat.due_us()) {
    ASSERT_TRUE(repeat.Fire(now));
    ASSERT_LE(repeat.due_us() - now, std::clamp<TimeUs>(now / 8, 40'000, kSecondUs));
    by[now] = ++said;
  }
  EXPECT_EQ(std::prev(by.upper_bound(kSecondUs / 4))->second, 9);
  EXPECT_LE(std::prev(by.upper_bound(10 * kSecondUs))->second, 45);
  EXPECT_LE(said, 45 + 90);
}

TEST(RepeatBudget, RepeatsAsMuchAsWasSaidAndThenOneRoundASecond) {
  RepeatBudget budget;
  TimeUs over_us = -kNever / 2;
  constexpr std::size_t kMessage = 100'000;
  std::size_t bytes = 0;
  const auto ask = [&](TimeUs from_us, TimeUs until_us) {
    bytes = 0;
    for (TimeUs now = from_us; now < until_us; now += 1000) {
      if (budget.Take(kMessage, now, &over_us)) bytes += kMessage;
    }
    return bytes;
  };
  EXPECT_LE(ask(0, kSecondUs), 2 * 256 * 1024 + kMessage);
  EXPECT_LE(ask(kSecondUs, 11 * kSecondUs), 10 * 256 * 1024 + 11 * kMessage);
  EXPECT_GE(bytes, 10 * kMessage) << "nobody is stuck";
  for (int i = 0; i < 50; ++i) budget.NoteFirst(kMessage, 11 * kSecondUs);
  EXPECT_EQ(ask(11 * kSecondUs, 11 * kSecondUs + kSecondUs / 4), 0U)
      << "it takes so long to be read";
  EXPECT_GE(ask(12 * kSecondUs, 13 * kSecondUs), 50 * kMessage);
}

TEST(RepeatBudget, OneAskerTakesNothingOfTheOther) {
  RepeatBudget budget;
  TimeUs one_us = -kNever / 2, other_us = -kNever / 2;
  constexpr std::size_t kMessage = 10'000'000;
  EXPECT_TRUE(budget.Take(kMessage, 0, &one_us));
  EXPECT_FALSE(budget.Take(kMessage, 600'000, &one_us));
  EXPECT_TRUE(budget.Take(kMessage, 600'001, &other_us));
}

TEST(Sender, SaysAgainOnceWhatManyHaveAskedFor) {
  Sender sender({1, "world", 0}, 0);
  const SentPacket packet = Say(&sender);
  FlushAt(&sender, 0);
  for (int i = 0; i < 5; ++i) sender.Resend(packet);
  EXPECT_EQ(FlushAt(&sender, 1000).size(), 1U);
}

TEST(Sender, WithoutARecorderNothingIsKept) {
  Sender sender({1, "world", 0}, 0);
  const SentPacket packet = Say(&sender);
  Say(&sender);
  EXPECT_FALSE(sender.drained());
  EXPECT_EQ(FlushAt(&sender, 0).size(), 2u);
  EXPECT_TRUE(sender.drained());
  sender.Acknowledge(Mark("world", 0, 1));
  EXPECT_TRUE(FlushAt(&sender, 1'000'000).empty());
  EXPECT_EQ(sender.wake_us(), kNever);
  sender.Resend(packet);
  EXPECT_FALSE(sender.drained());
}

}  // namespace
}  // namespace muster
