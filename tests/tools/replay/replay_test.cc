#include <gtest/gtest.h>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "tests/tools/fake_mission.h"
#include "tools/replay/player.h"
#include "tools/replay/terminal_keys.h"

namespace muster::tools {
namespace {

class MemorySource : public MessageSource {
 public:
  explicit MemorySource(std::vector<Packet> packets) : packets_(std::move(packets)) {}
  std::optional<LogEvent> NextEvent() override {
    if (next_ == packets_.size()) return {};
    return LogEvent{0, 0, packets_[next_++]};
  }
  void Rewind() override { next_ = 0; }

 private:
  std::vector<Packet> packets_;
  std::size_t next_ = 0;
};

/// The fake mission: 30 min, 60 s a tick, decisions at 0, 10 and 20 min.
class PlayerTest : public ::testing::Test {
 protected:
  const std::vector<Packet> packets_ = Encoded(MakeFakeMission());
  MemorySource source_{packets_};
  std::vector<Packet> played_;
  TimeUs now_ = 5'000'000'000;

  void Step(Player* player) {
    const auto packets = player->Step(now_);
    EXPECT_LE(packets.size(), Player::kBatch);
    played_.insert(played_.end(), packets.begin(), packets.end());
  }
  /// As the command does it, until `until`.
  void Run(Player* player, TimeUs until) {
    Step(player);
    while (!player->ended() && player->WakeUs(now_) <= until) {
      ASSERT_GE(player->WakeUs(now_), now_);
      now_ = std::max(now_ + 1, player->WakeUs(now_));
      Step(player);
    }
    now_ = until;
    Step(player);
  }
  TimeUs LastSimUs() const { return DecodeHeader(played_.back())->sim_us; }
};

TEST_F(PlayerTest, PlaysEveryMessageInOrderByMissionTime) {
  Player player(&source_, {.rate = 60});
  Run(&player, now_ + 9'500'000);  // 9.5 s: 9.5 ticks
  EXPECT_EQ(LastSimUs(), 9 * kMinuteUs);
  EXPECT_NEAR(static_cast<double>(player.ToNextUs(now_)), 30e6, 100);
  EXPECT_EQ(player.decision(), 0);
  Run(&player, now_ + 30'000'000);
  EXPECT_TRUE(player.ended());
  EXPECT_EQ(played_, packets_);
  EXPECT_EQ(player.WakeUs(now_), kNever);
}

TEST_F(PlayerTest, AsFastAsItGoesStillBreathes) {
  Player player(&source_, {.rate = 0});
  const TimeUs start = now_;
  int steps = 0;
  while (!player.ended()) {
    Step(&player);
    ++steps;
    if (!player.ended()) now_ = player.WakeUs(now_);
  }
  EXPECT_EQ(played_, packets_);
  EXPECT_EQ(steps, static_cast<int>((packets_.size() + Player::kBatch - 1) / Player::kBatch));
  EXPECT_EQ(now_ - start, (steps - 1) * Player::kBatchPauseUs);
}

TEST_F(PlayerTest, PauseHoldsAndRateChangesFromHere) {
  Player player(&source_, {.rate = 60});
  Run(&player, now_ + 2'500'000);
  player.Press(Player::Key::kPause, now_);
  EXPECT_EQ(player.WakeUs(now_), kNever);
  Run(&player, now_ + 60'000'000);
  EXPECT_EQ(LastSimUs(), 2 * kMinuteUs);
  player.Press(Player::Key::kPause, now_);
  player.Press(Player::Key::kFaster, now_);
  EXPECT_EQ(player.rate(), 120);
  Run(&player, now_ + 1'000'000);  // from 2.5 min to 4.5 min
  EXPECT_EQ(LastSimUs(), 4 * kMinuteUs);
  player.Press(Player::Key::kSlower, now_);
  player.Press(Player::Key::kSlower, now_);
  EXPECT_EQ(player.rate(), 30);
}

TEST_F(PlayerTest, RateGoesUpToAsFastAsItGoesAndBack) {
  Player player(&source_, {.rate = 40'000});
  player.Press(Player::Key::kFaster, now_);
  EXPECT_EQ(player.rate(), 80'000);
  player.Press(Player::Key::kFaster, now_);
  EXPECT_EQ(player.rate(), 0);
  player.Press(Player::Key::kFaster, now_);
  EXPECT_EQ(player.rate(), 0);
  player.Press(Player::Key::kSlower, now_);
  EXPECT_EQ(player.rate(), 65536);
}

TEST_F(PlayerTest, StepsFromDecisionToDecision) {
  Player player(&source_, {.rate = 60, .paused = true});
  for (int decision = 0; decision < 3; ++decision) {
    player.Press(Player::Key::kNextDecision, now_);
    Run(&player, now_ + 1'000'000);
    EXPECT_EQ(player.decision(), decision);
    EXPECT_EQ(played_.back().channel, channel::kSchedule);
    EXPECT_EQ(LastSimUs(), decision * 10 * kMinuteUs);
    EXPECT_TRUE(player.paused());
  }
  player.Press(Player::Key::kNextDecision, now_);  // there is none: plays to the end
  Run(&player, now_ + 1'000'000);
  EXPECT_TRUE(player.ended());
  EXPECT_EQ(played_, packets_);
}

TEST_F(PlayerTest, AfterAStepItGoesOnFromThere) {
  Player player(&source_, {.rate = 60});
  Run(&player, now_ + 1'000'000);
  player.Press(Player::Key::kNextDecision, now_);
  Run(&player, now_ + 1'000'000);
  // Decision 1 at 10 min, then one second of playing, less the pauses between batches.
  EXPECT_GE(LastSimUs(), 10 * kMinuteUs);
  EXPECT_LE(LastSimUs(), 11 * kMinuteUs);
  Run(&player, now_ + 1'000'000);
  EXPECT_GE(LastSimUs(), 11 * kMinuteUs);
}

TEST_F(PlayerTest, StartOffsetKeepsTheScenario) {
  Player player(&source_, {.rate = 60, .start_offset_us = 15 * kMinuteUs});
  Run(&player, now_ + 500'000);
  ASSERT_GE(played_.size(), 2u);
  EXPECT_EQ(played_[0].channel, channel::kScenario);
  EXPECT_EQ(DecodeHeader(played_[1])->sim_us, 15 * kMinuteUs);
  EXPECT_EQ(LastSimUs(), 15 * kMinuteUs);
  Run(&player, now_ + 1'000'000);
  EXPECT_EQ(LastSimUs(), 16 * kMinuteUs);
}

TEST_F(PlayerTest, LoopsWithItsPace) {
  Player player(&source_, {.rate = 60, .loop = true});
  Run(&player, now_ + 45'000'000);  // 30 min, then 15 min again
  EXPECT_FALSE(player.ended());
  EXPECT_GT(played_.size(), packets_.size());
  EXPECT_GE(LastSimUs(), 14 * kMinuteUs);
  EXPECT_LE(LastSimUs(), 15 * kMinuteUs);
  for (std::size_t i = 0; i < played_.size(); ++i) {
    ASSERT_EQ(played_[i], packets_[i % packets_.size()]) << i;
  }
}

TEST_F(PlayerTest, FiltersChannelsButStillStepsByDecision) {
  PlayerOptions options{.rate = 60, .paused = true};
  options.plays = [](const std::string& channel) { return channel != channel::kSchedule; };
  Player player(&source_, options);
  player.Press(Player::Key::kNextDecision, now_);
  player.Press(Player::Key::kNextDecision, now_);
  Run(&player, now_ + 1'000'000);
  EXPECT_EQ(player.decision(), 0);
  for (const Packet& packet : played_) EXPECT_NE(packet.channel, channel::kSchedule);
}

TEST_F(PlayerTest, ALateMessageGoesWithItsNeighbours) {
  std::vector<Packet> packets = packets_;
  std::swap(packets[20], packets[100]);  // a resend of an old message, an early new one
  MemorySource source(packets);
  Player player(&source, {.rate = 60});
  Run(&player, now_ + 40'000'000);
  EXPECT_TRUE(player.ended());
  EXPECT_EQ(played_, packets);
}

TEST_F(PlayerTest, AnEmptyLogEnds) {
  MemorySource source({});
  Player player(&source, {.rate = 1, .loop = true});
  Step(&player);
  EXPECT_TRUE(player.ended());
}

TEST(KeyParser, KnowsKeysInAnyPieces) {
  using Key = Player::Key;
  KeyParser parser;
  const Pressed all = parser.Take(" \x1b[C\x1b[A\x1bOBx");
  EXPECT_EQ(all.keys, (std::vector{Key::kPause, Key::kNextDecision, Key::kFaster, Key::kSlower}));
  EXPECT_FALSE(all.quit);
  EXPECT_TRUE(parser.Take("\x1b").keys.empty());
  EXPECT_TRUE(parser.Take("[").keys.empty());
  EXPECT_EQ(parser.Take("C").keys, std::vector{Key::kNextDecision});
  EXPECT_TRUE(parser.Take("\x1b[D\x1b[3").keys.empty());  // left arrow, the start of Delete
  EXPECT_TRUE(parser.Take("q").quit);
}

}  // namespace
}  // namespace muster::tools
