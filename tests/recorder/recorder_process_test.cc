#include "recorder/recorder_process.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/channels.h"
#include "tests/recorder/messages.h"

namespace muster::tools {
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

  RecorderProcess recorder;
  Now now{1'000'000, 0};
  std::size_t said = 0;
  bool hears_itself = true;
};

using Start = std::pair<std::string, std::int64_t>;

TEST(RecorderProcess, SaysWhatTheLogHoldsAtOnce) {
  Told told;
  told.Marks();
  for (std::int64_t seq = 0; seq < 3; ++seq) told.recorder.OnLogged(MessageOf("uav", seq));
  told.recorder.OnLogged(MessageOf("world", 0, 2));
  const auto marks = told.Marks();
  EXPECT_EQ(marks.at(Start("uav", 0)), 3);
  EXPECT_EQ(marks.at(Start("world", 2)), 1);
  // Its own marks in the log are no news.
  told.Marks();
  EXPECT_EQ(told.said, 0u);
  EXPECT_TRUE(told.recorder.finished());
}

TEST(RecorderProcess, ALoneMessageWaitsForAMoment) {
  Told told;
  told.Marks();
  told.recorder.OnLogged(MessageOf("uav", 0));
  told.recorder.OnLogged(MessageOf("worker", 0));
  told.Marks();
  EXPECT_EQ(told.said, 0u);
  EXPECT_LE(told.recorder.wake_us(), told.now.monotonic_us + 2'000);
  const auto marks = told.Marks(2'000);
  EXPECT_EQ(marks.at(Start("uav", 0)), 1);
  EXPECT_EQ(marks.at(Start("worker", 0)), 1);
  // Nobody waits long behind a second one.
  told.recorder.OnLogged(MessageOf("uav", 1));
  told.recorder.OnLogged(MessageOf("uav", 2));
  EXPECT_EQ(told.Marks().at(Start("uav", 0)), 3);
}

TEST(RecorderProcess, AHoleIsNoMark) {
  Told told;
  told.recorder.OnLogged(MessageOf("uav", 0));
  told.recorder.OnLogged(MessageOf("uav", 2));
  EXPECT_EQ(told.Marks().at(Start("uav", 0)), 1);
  told.recorder.OnLogged(MessageOf("uav", 1));
  told.Marks();
  EXPECT_EQ(told.Marks(2'000).at(Start("uav", 0)), 3);
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
  EXPECT_EQ(told.Marks().at(Start("uav", 0)), 2);
}

}  // namespace
}  // namespace muster::tools
