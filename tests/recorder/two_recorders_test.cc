// Two recorders, each with a log of its own, and what the others are told of both.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "lcmtypes/channels.h"
#include "recorder/recorder_process.h"
#include "tests/recorder/messages.h"

namespace muster::recorder {
namespace {

constexpr TimeUs kSecondsPatienceUs = 5 * kSecondUs;
constexpr TimeUs kTurnUs = 1'000;

using Marks = std::map<std::pair<std::string, std::int64_t>, std::int64_t>;

/// Both recorders on a bus, on which each may miss packets. What one of them hears is in its log.
class TwoRecorders : public ::testing::Test {
 protected:
  /// A packet on the bus.
  void Say(const Packet& packet) {
    if (first_hears_) {
      Hear(&first_, packet, &for_first_);
      if (packet.channel != channel::kCopy) in_first_log_.push_back(packet);
    }
    if (second_lives_ && second_hears_) Hear(&second_, packet, &for_second_);
  }
  /// Time goes on, and both say what they have to say.
  void Pass(TimeUs us) {
    for (TimeUs passed = 0; passed < us; passed += kTurnUs) {
      now_.monotonic_us += kTurnUs;
      std::vector<Packet> out;
      first_.Step(std::exchange(for_first_, {}), now_, &out);
      if (second_lives_) second_.Step(std::exchange(for_second_, {}), now_, &out);
      said_ += out.size();
      for (const Packet& packet : out) {
        if (packet.channel == channel::kLog) NoteMarks(packet);
        Say(packet);
      }
    }
  }
  /// What the others have been told is in the logs of that sender's first start.
  std::int64_t Told(const std::string& sender) const {
    const auto found = told_.find({sender, 0});
    return found == told_.end() ? 0 : found->second;
  }

  RecorderProcess first_{
      {1, process_name::kRecorder, 0}, 1024, {}, Part::kFirst, kSecondsPatienceUs};
  RecorderProcess second_{{1, process_name::kSecondRecorder, 0}, 1024, {}, Part::kSecond};
  bool first_hears_ = true, second_hears_ = true, second_lives_ = true;
  std::vector<Packet> in_first_log_;
  std::size_t said_ = 0;
  Now now_{1'000'000, 0};

 private:
  static void Hear(RecorderProcess* recorder, const Packet& packet, std::vector<Packet>* queue) {
    if (packet.channel != channel::kCopy) recorder->OnLogged(packet);
    queue->push_back(packet);
  }
  void NoteMarks(const Packet& packet) {
    const auto status = DecodeValid<log_status_t>(packet.bytes);
    for (const log_mark_t& mark : status->marks) told_[{mark.sender, mark.boot_id}] = mark.next_seq;
  }
  std::vector<Packet> for_first_, for_second_;
  Marks told_;
};

TEST_F(TwoRecorders, AMessageCountsWhenBothLogsHaveIt) {
  Say(MessageOf("uav", 0));
  Pass(50'000);
  EXPECT_EQ(Told("uav"), 1);
  second_hears_ = false;
  Say(MessageOf("uav", 1));
  second_hears_ = true;
  Pass(50'000);
  EXPECT_EQ(Told("uav"), 1);
  Say(MessageOf("uav", 1));  // as the UAV's process repeats it
  Pass(50'000);
  EXPECT_EQ(Told("uav"), 2);
  first_hears_ = false;
  Say(MessageOf("uav", 2));
  first_hears_ = true;
  Pass(50'000);
  EXPECT_EQ(Told("uav"), 2);
}

TEST_F(TwoRecorders, SayNothingNewWhenNothingHappens) {
  Say(MessageOf("uav", 0));
  Pass(kSecondUs);
  const std::size_t before = said_;
  Pass(10 * kSecondUs);
  // The marks of each are repeated five times a second. Neither answers the other's.
  EXPECT_LE(said_ - before, 2u * 5 * 10 + 4);
  EXPECT_EQ(first_.log().missing() + second_.log().missing(), 0);
}

TEST_F(TwoRecorders, ASecondThatIsSilentIsNotWaitedForForEver) {
  Say(MessageOf("uav", 0));
  Pass(50'000);
  second_lives_ = false;
  Say(MessageOf("uav", 1));
  Pass(kSecondsPatienceUs - kSecondUs);
  EXPECT_EQ(Told("uav"), 1);
  EXPECT_FALSE(first_.goes_on_alone());
  Pass(2 * kSecondUs);
  EXPECT_EQ(Told("uav"), 2);
  EXPECT_TRUE(first_.goes_on_alone());
  // It lacks message 1 now, which nobody repeats, and does not hold up the mission.
  second_lives_ = true;
  Say(MessageOf("uav", 2));
  Pass(50'000);
  EXPECT_EQ(Told("uav"), 3);
}

TEST_F(TwoRecorders, ASecondWithAHoleDoesNotHoldUpAFirstThatStartsAgain) {
  Say(MessageOf("uav", 0));
  Pass(50'000);
  second_lives_ = false;
  Say(MessageOf("uav", 1));
  Pass(kSecondsPatienceUs + kSecondUs);
  ASSERT_EQ(Told("uav"), 2);
  // The first dies. Its next start finds its own words in its log.
  RecorderProcess again({1, process_name::kRecorder, 1}, 1024, {}, Part::kFirst,
                        kSecondsPatienceUs);
  for (const Packet& packet : in_first_log_) again.OnLogged(packet);
  again.OnLogged(MessageOf("uav", 2));
  const auto tells = [&](TimeUs for_us) {
    bool told = false;
    for (TimeUs passed = 0; passed < for_us; passed += kTurnUs) {
      now_.monotonic_us += kTurnUs;
      std::vector<Packet> of_first, of_second;
      second_.Step({}, now_, &of_second);
      again.Step(of_second, now_, &of_first);
      for (const Packet& packet : of_first) {
        const auto status = DecodeValid<log_status_t>(packet.bytes);
        for (const log_mark_t& mark : status ? status->marks : std::vector<log_mark_t>()) {
          told |= mark.sender == "uav" && mark.next_seq == 3;
        }
        again.OnLogged(packet);
      }
    }
    return told;
  };
  EXPECT_FALSE(tells(kSecondsPatienceUs - kSecondUs));
  EXPECT_TRUE(tells(2 * kSecondUs));
  EXPECT_TRUE(again.goes_on_alone());
}

TEST_F(TwoRecorders, OneThatHasNeverSpokenIsWaitedForHalfAMinute) {
  second_lives_ = false;
  Say(MessageOf("uav", 0));
  Pass(25 * kSecondUs);
  EXPECT_EQ(Told("uav"), 0);
  Pass(10 * kSecondUs);
  EXPECT_EQ(Told("uav"), 1);
}

TEST_F(TwoRecorders, OneThatEndsInMidMissionIsWaitedForAsItMayStartAgain) {
  Say(MessageOf("uav", 0));
  Pass(50'000);
  second_.End();  // as one does whose ssh has ended
  second_.ReportStatus({}, now_);
  Pass(50'000);
  second_lives_ = false;
  Say(MessageOf("uav", 1));
  Pass(kSecondsPatienceUs - kSecondUs);
  EXPECT_FALSE(first_.goes_on_alone());
  EXPECT_EQ(Told("uav"), 1);
  Pass(2 * kSecondUs);
  EXPECT_TRUE(first_.goes_on_alone());
}

TEST_F(TwoRecorders, AtTheMissionsEndOneThatEndsIsNotWaitedFor) {
  Say(MessageOf("uav", 0));
  Pass(50'000);
  second_.End();
  second_.ReportStatus({}, now_);
  Pass(50'000);
  EXPECT_FALSE(first_.goes_on_alone());
  clock_t clock{};
  clock.header.run_id = 1;
  clock.header.sender = "world";
  clock.phase = NumberOf(ClockPhase::kEnded);
  Say({std::string(channel::kClock), Encode(clock)});
  Pass(50'000);
  EXPECT_TRUE(first_.goes_on_alone());
}

TEST_F(TwoRecorders, LossDelaysButLosesNothing) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Random random(seed, Stream::kTest);
    RecorderProcess first({1, process_name::kRecorder, 0}, 1024, {}, Part::kFirst,
                          kSecondsPatienceUs);
    RecorderProcess second({1, process_name::kSecondRecorder, 0}, 1024, {}, Part::kSecond);
    std::vector<Packet> for_first, for_second;
    std::int64_t acknowledged = 0, said = 0;
    const auto publish = [&](const Packet& packet) {
      for (const auto& [recorder, queue] :
           {std::pair(&first, &for_first), std::pair(&second, &for_second)}) {
        if (random.Below(10) < 3) continue;
        if (packet.channel != channel::kCopy) recorder->OnLogged(packet);
        queue->push_back(packet);
      }
    };
    for (int step = 0; step < 20'000 && acknowledged < 200; ++step) {
      now_.monotonic_us += kTurnUs;
      if (said < 200 && said < acknowledged + 8) publish(MessageOf("uav", said++));
      if (step % 20 == 0) {
        for (std::int64_t seq = acknowledged; seq < said; ++seq) publish(MessageOf("uav", seq));
      }
      std::vector<Packet> out;
      first.Step(std::exchange(for_first, {}), now_, &out);
      second.Step(std::exchange(for_second, {}), now_, &out);
      for (const Packet& packet : out) {
        const auto status = DecodeValid<log_status_t>(packet.bytes);
        if (status && packet.channel == channel::kLog) {
          for (const log_mark_t& mark : status->marks) {
            if (mark.sender == "uav") acknowledged = std::max(acknowledged, mark.next_seq);
          }
        }
        publish(packet);
      }
      ASSERT_LE(acknowledged, first.log().next_seq("uav", 0));
      ASSERT_LE(acknowledged, second.log().next_seq("uav", 0));
    }
    EXPECT_EQ(acknowledged, 200);
    EXPECT_FALSE(first.goes_on_alone());
  }
}

}  // namespace
}  // namespace muster::recorder
