#include "recorder/recorder_process.h"

#include <gtest/gtest.h>

#include <map>
#include <muster/answer_t.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/channels.h"
#include "tests/recorder/messages.h"

namespace muster::recorder {
namespace {

/// The process and what it says; all of that gets into the log.
class Told {
 public:
  explicit Told(std::optional<Seal> seal = {}, std::int64_t boot_id = 0)
      : recorder({1, "recorder", boot_id}, 3, std::move(seal)) {}

  /// The marks that it has said since the last call: next_seq by sender and start.
  std::map<std::pair<std::string, std::int64_t>, std::int64_t> Marks(TimeUs after_us = 0) {
    now.monotonic_us += after_us;
    std::vector<Packet> out;
    recorder.Step({}, now, &out);
    std::map<std::pair<std::string, std::int64_t>, std::int64_t> marks;
    said = out.size();
    for (const Packet& packet : out) {
      const auto status = DecodeValid<log_status_t>(packet.bytes);
      if (!status) continue;
      for (const log_mark_t& mark : status->marks)
        marks[{mark.sender, mark.boot_id}] = mark.next_seq;
      if (hears_itself) recorder.OnLogged(packet);
    }
    return marks;
  }

  /// The log gets so many messages of that sender.
  void Logs(const std::string& sender, std::int64_t first, std::int64_t count) {
    for (std::int64_t seq = first; seq < first + count; ++seq) {
      recorder.OnLogged(MessageOf(sender, seq));
    }
  }

  RecorderProcess recorder;
  Now now{1'000'000, 0};
  std::size_t said = 0;
  bool hears_itself = true;
};

using Start = std::pair<std::string, std::int64_t>;

TEST(RecorderProcess, SaysWhatTheLogHoldsAtOnce) {
  Told told;
  told.Marks();
  told.Logs("uav", 0, kMemberWindow - 1);
  told.recorder.OnLogged(MessageOf("world", 0, 2));
  const auto marks = told.Marks();
  EXPECT_EQ(marks.at(Start("uav", 0)), kMemberWindow - 1);
  EXPECT_EQ(marks.at(Start("world", 2)), 1);
  // Its own marks in the log are no news.
  told.Marks();
  EXPECT_EQ(told.said, 0u);
  EXPECT_TRUE(told.recorder.finished());
}

TEST(RecorderProcess, RepeatsItsMarksFiveTimesASecondAndDoesNotAnswerItself) {
  Told told;
  told.Logs("uav", 0, kMemberWindow);
  told.Marks();
  std::size_t said = 0;
  for (int ms = 0; ms < 1000; ++ms) {
    told.Marks(1'000);
    said += told.said;
  }
  EXPECT_EQ(said, 5u);
}

TEST(RecorderProcess, TellsNobodyAnythingOnceALaterLauncherHasStarted) {
  for (const bool sealed : {true, false}) {
    const Seal seal(SealKey::Fresh(1));
    Told told(sealed ? std::optional(seal) : std::nullopt);
    const auto log = [&](const std::string& sender, std::int64_t boot_id) {
      Packet packet = MessageOf(sender, 0, boot_id);
      if (sealed) packet = seal.Closed(std::move(packet));
      told.recorder.OnLogged(packet);
    };
    told.hears_itself = false;
    log("uav", 0);
    EXPECT_TRUE(told.Marks(kSecondUs).contains({"uav", 0}));
    log("worker", kLauncherApart);
    told.Marks();
    // Without a seal a damaged number may say so.
    EXPECT_EQ(told.Marks(kSecondUs).contains({"worker", kLauncherApart}), !sealed);
  }
}

TEST(RecorderProcess, ALoneMessageWaitsForAMoment) {
  Told told;
  told.Marks();
  told.recorder.OnLogged(MessageOf("uav", 0));
  told.recorder.OnLogged(MessageOf("worker", 0));
  told.Marks();
  EXPECT_EQ(told.said, 0u);
  EXPECT_LE(told.recorder.wake_us(), told.now.monotonic_us + 5'000);
  const auto marks = told.Marks(5'000);
  EXPECT_EQ(marks.at(Start("uav", 0)), 1);
  EXPECT_EQ(marks.at(Start("worker", 0)), 1);
  // Nobody waits at the end of a window.
  told.Logs("uav", 1, kMemberWindow - 1);
  EXPECT_EQ(told.Marks().at(Start("uav", 0)), kMemberWindow);
}

TEST(RecorderProcess, TheWorldsEventsAreManyAndSmall) {
  Told told;
  told.Marks();
  const auto bytes = MessageOf("world", 0).bytes.size();
  const auto half = static_cast<std::int64_t>(kWorldWindowBytes / bytes) / 2;
  ASSERT_GT(half, 2 * kWorldWindow);
  told.Logs("world", 0, half - 1);
  told.Marks();
  EXPECT_EQ(told.said, 0u);
  told.Logs("world", half - 1, 2);
  EXPECT_EQ(told.Marks().at(Start("world", 0)), half + 1);
}

TEST(RecorderProcess, AFewLargeMessagesOfTheWorldsWaitForAMoment) {
  Told told;
  told.Marks();
  const auto large = [&](std::int64_t seq) {
    answer_t answer{};
    answer.header.run_id = 1;
    answer.header.sender = "world";
    answer.header.seq = seq;
    answer.data.resize(kWorldWindowBytes);
    answer.n = static_cast<std::int32_t>(answer.data.size());
    told.recorder.OnLogged({std::string(channel::kAnswer), Encode(answer)});
  };
  for (std::int64_t seq = 0; seq < kWorldWindow - 3; ++seq) large(seq);
  told.Marks();
  EXPECT_EQ(told.said, 0u);
  large(kWorldWindow - 3);
  EXPECT_EQ(told.Marks().at(Start("world", 0)), kWorldWindow - 2);
}

TEST(RecorderProcess, AHoleIsNoMark) {
  Told told;
  told.recorder.OnLogged(MessageOf("uav", 0));
  told.recorder.OnLogged(MessageOf("uav", 2));
  EXPECT_EQ(told.Marks().at(Start("uav", 0)), 1);
  told.recorder.OnLogged(MessageOf("uav", 1));
  told.Marks();
  EXPECT_EQ(told.Marks(5'000).at(Start("uav", 0)), 3);
}

TEST(RecorderProcess, WhoRepeatsItselfIsToldAgainButNotEachTime) {
  Told told;
  told.recorder.OnLogged(MessageOf("uav", 0));
  told.Marks();
  told.recorder.OnLogged(MessageOf("uav", 0));
  told.Marks(1);
  EXPECT_EQ(told.said, 0u);
  EXPECT_EQ(told.Marks(kMarksAgainUs).at(Start("uav", 0)), 1);
  // And now and then for whom nobody knows of.
  EXPECT_EQ(told.Marks(kMarksIdleUs).at(Start("uav", 0)), 1);
}

TEST(RecorderProcess, GoesOnFromAnEarlierStartsLog) {
  Told told({}, 1);
  told.recorder.OnLogged(MessageOf("uav", 0));
  told.recorder.OnLogged(MessageOf("recorder", 0));
  told.recorder.OnLogged(MessageOf("uav", 1));
  const auto marks = told.Marks();
  EXPECT_EQ(marks.at(Start("uav", 0)), 2);
  EXPECT_EQ(marks.at(Start("recorder", 0)), 1);
}

TEST(RecorderProcess, SaysLittleThatIsNotInTheLogItself) {
  Told told;
  told.hears_itself = false;
  std::size_t said = 0;
  for (std::int64_t seq = 0; seq < 20; ++seq) {
    told.recorder.OnLogged(MessageOf("uav", seq));
    told.Marks(1);
    said += told.said;
  }
  EXPECT_EQ(said, 3u);  // its window
  EXPECT_FALSE(told.recorder.finished());
}

TEST(RecorderProcess, WhatIsNotOfThisRunIsNothingThatItHolds) {
  Told told;
  told.recorder.OnLogged(MessageOf("uav", 0, 0, 2));
  told.recorder.OnLogged({"SOMEBODY_ELSES", {1, 2, 3}});
  told.recorder.OnLogged({"MUSTER_CLOCK", {}});
  EXPECT_TRUE(told.Marks().empty());
}

TEST(RecorderProcess, InASealedMissionOnlyMembersAreAcknowledged) {
  const SealKey key = SealKey::Fresh(1);
  const Seal seal(key);
  Told told(seal);
  told.recorder.OnLogged(MessageOf("uav", 0));
  EXPECT_FALSE(told.Marks().contains(Start("uav", 0)));
  told.recorder.OnLogged(seal.Closed(MessageOf("uav", 0)));
  told.recorder.OnLogged(seal.Closed(MessageOf("uav", 1)));
  told.Marks();
  EXPECT_EQ(told.Marks(5'000).at(Start("uav", 0)), 2);
}

}  // namespace
}  // namespace muster::recorder
