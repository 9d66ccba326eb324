#include "recorder/recorder.h"

#include <gtest/gtest.h>

#include <deque>
#include <limits>
#include <vector>

#include "base/random.h"
#include "lcmtypes/channels.h"
#include "tests/recorder/messages.h"

namespace muster::recorder {
namespace {

constexpr TimeUs kStepUs = 100;

/// lcm-logger as far as it matters: what it writes reaches the disk when a message arrives more
/// than 1 ms after the last time that it did.
class FakeLogger {
 public:
  void Write(const Packet& packet, TimeUs now_us) {
    buffer_.push_back(packet);
    if (now_us - flushed_us_ <= 1000) return;
    flushed_us_ = now_us;
    disk_.insert(disk_.end(), buffer_.begin(), buffer_.end());
    buffer_.clear();
  }
  /// What has reached the disk since the last call.
  std::vector<Packet> TakeNew() {
    const auto from = disk_.begin() + static_cast<std::ptrdiff_t>(read_);
    std::vector<Packet> news(from, disk_.end());
    read_ = disk_.size();
    return news;
  }
  std::size_t events() const { return disk_.size(); }

 private:
  std::vector<Packet> buffer_, disk_;
  std::size_t read_ = 0;
  TimeUs flushed_us_ = 0;
};

/// A recorder, a logger and one other process that says `messages` things, on a bus that loses.
struct Scene {
  explicit Scene(double loss, std::uint64_t seed, int window = 10)
      : lossy(loss), random(seed, Stream::kTest), other({1, "world", 0}, window) {}

  bool Lost() { return random.Uniform() < lossy; }

  void Broadcast(const Packet& packet, bool by_recorder) {
    if (!Lost()) logger.Write(packet, now.monotonic_us);
    if (!Lost()) heard.push_back(packet);
    if (by_recorder && packet.channel == channel::kLog && !Lost()) {
      const auto status = DecodeValid<log_status_t>(packet.bytes);
      ASSERT_TRUE(status);
      other.Acknowledge(*status);
    }
  }

  void Step() {
    now.monotonic_us += kStepUs;
    std::vector<Packet> out;
    other.Flush(now, &out);
    for (const Packet& packet : out) Broadcast(packet, false);
    for (const Packet& event : logger.TakeNew()) recorder.OnLogged(event, now);
    for (; !heard.empty(); heard.pop_front()) recorder.OnHeard(heard.front(), now);
    out.clear();
    recorder.Step(now, &out);
    for (const Packet& packet : out) Broadcast(packet, true);
  }

  template <class Condition>
  bool StepUntil(Condition done, TimeUs longest_us) {
    for (const TimeUs end_us = now.monotonic_us + longest_us; !done(); Step()) {
      if (now.monotonic_us >= end_us) return false;
    }
    return true;
  }

  void Say() {
    request_t request{};
    request.channel = std::string(channel::kScenario);
    other.Send(channel::kRequest, std::move(request), 0, now);
  }

  double lossy;
  Random random;
  Now now{1'000'000, 0};
  Recorder recorder{{1, "recorder", 0}};
  Sender other;
  FakeLogger logger;
  std::deque<Packet> heard;
};

TEST(Recorder, AcknowledgesWhatALossyLoggerHasUntilAllIsThere) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene(0.3, seed);
    scene.recorder.ReportStatus(ProcessState::kReady, -1, {}, scene.now);
    for (int i = 0; i < 100; ++i) {
      scene.Say();
      scene.Step();
    }
    ASSERT_TRUE(scene.StepUntil([&] { return scene.other.drained(); }, 60 * kSecondUs));
    EXPECT_EQ(scene.recorder.log().next_seq("world", 0), 100);

    scene.recorder.Finish(0, {}, scene.now);
    ASSERT_TRUE(scene.StepUntil([&] { return scene.recorder.finished(); }, 60 * kSecondUs));
    EXPECT_EQ(scene.recorder.log().missing(), 0);
    const std::int64_t own = scene.recorder.log().next_seq("recorder", 0);
    EXPECT_EQ(scene.recorder.log().messages(), 100 + own);
  }
}

TEST(Recorder, PokesTheLoggerWhileSomethingIsOnItsWay) {
  Scene scene(0, 1);
  scene.recorder.ReportStatus(ProcessState::kReady, -1, {}, scene.now);
  scene.Say();
  // Nobody else speaks: without pokes the last message would stay in the logger's buffer.
  ASSERT_TRUE(scene.StepUntil([&] { return scene.other.drained(); }, 20'000));
  EXPECT_TRUE(scene.StepUntil([&] { return !scene.recorder.behind(); }, 20'000));
}

TEST(Recorder, IsQuietWhenNothingHappens) {
  Scene scene(0, 1);
  scene.recorder.ReportStatus(ProcessState::kReady, -1, {}, scene.now);
  ASSERT_TRUE(scene.StepUntil([&] { return !scene.recorder.behind(); }, kSecondUs));
  const std::size_t events = scene.logger.events();
  for (int i = 0; i < 10 * kSecondUs / kStepUs; ++i) scene.Step();
  // Repeats only: at most five a second.
  EXPECT_LE(scene.logger.events(), events + 50);
  EXPECT_EQ(scene.recorder.log().messages(), scene.recorder.log().next_seq("recorder", 0));
}

TEST(Recorder, AnswersWhoeverHasNotHeardTheMark) {
  Recorder recorder({1, "recorder", 0});
  Now now{1'000'000, 0};
  std::vector<Packet> out;
  const auto step = [&] {
    out.clear();
    now.monotonic_us += 5'000;
    recorder.Step(now, &out);
  };
  // All is on disk, and known to be.
  recorder.OnHeard(MessageOf("uav", 0), now);
  recorder.OnLogged(MessageOf("uav", 0), now);
  step();
  ASSERT_EQ(out.size(), 1u);
  const Packet status = out.front();
  EXPECT_EQ(status.channel, channel::kLog);
  recorder.OnLogged(status, now);
  EXPECT_FALSE(recorder.behind());
  step();
  EXPECT_TRUE(out.empty());

  recorder.OnHeard(MessageOf("uav", 0), now);  // a repair of what is on disk
  step();
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out.front(), status);
  step();
  EXPECT_TRUE(out.empty());
}

TEST(Recorder, SaysAgainWhatAKilledStartCannot) {
  Recorder recorder({1, "recorder", 0});
  Now now{1'000'000, 0};
  std::vector<Packet> out;
  const auto resent = [&] {
    now.monotonic_us += kSecondUs;
    out.clear();
    recorder.Step(now, &out);
    std::erase_if(out, [](const Packet& packet) { return packet.channel == channel::kLog; });
    return out;
  };
  for (const std::int64_t seq : {0, 1, 3}) recorder.OnHeard(MessageOf("uav", seq), now);
  recorder.OnLogged(MessageOf("uav", 1), now);
  EXPECT_TRUE(resent().empty()) << "its own business while it lives";
  recorder.OnEnd("uav", 0, now);
  EXPECT_TRUE(recorder.behind());
  EXPECT_EQ(resent(), (std::vector<Packet>{MessageOf("uav", 0), MessageOf("uav", 3)}));
  EXPECT_EQ(resent().size(), 2u) << "until the log has them";
  recorder.OnLogged(MessageOf("uav", 0), now);
  recorder.OnLogged(MessageOf("uav", 3), now);
  EXPECT_TRUE(resent().empty());
  // Nobody knows seq 2: it is not waited for.
  EXPECT_EQ(recorder.log().missing(), 1);
}

TEST(Recorder, IgnoresOtherRuns) {
  Recorder recorder({1, "recorder", 0});
  const Now now{1'000'000, 0};
  recorder.OnHeard(MessageOf("uav", 7, 0, 2), now);
  EXPECT_FALSE(recorder.behind());
  EXPECT_FALSE(recorder.OnLogged(MessageOf("uav", 7, 0, 2), now));
  recorder.OnHeard(MessageOf("uav", 7, 0, 1), now);
  EXPECT_TRUE(recorder.behind());
}

TEST(Recorder, WaitsForNothingThatAnEarlierLaunchersProcessesSay) {
  Recorder recorder({1, "recorder", kLauncherApart + 1});
  recorder.OnHeard(MessageOf("uav", 7, 1), {1'000'000, 0});
  EXPECT_FALSE(recorder.behind());
  recorder.OnHeard(MessageOf("uav", 7, kLauncherApart + 1), {1'000'000, 0});
  EXPECT_TRUE(recorder.behind());
}

TEST(Recorder, AGapThatNobodyFillsCanBeGivenUp) {
  Recorder recorder({1, "recorder", 0});
  std::vector<Packet> out;
  const auto hear = [&](const Packet& packet) {
    recorder.OnHeard(packet, {});
    recorder.OnLogged(packet, {});
  };
  for (std::int64_t seq = 0; seq < 50; ++seq) hear(MessageOf("world", seq));
  EXPECT_TRUE(recorder.gaps().empty());
  hear(MessageOf("world", 1049));
  ASSERT_EQ(recorder.gaps().size(), 1u);
  EXPECT_EQ(recorder.gaps()[0].sender, "world");
  EXPECT_EQ(recorder.gaps()[0].messages, 999);
  EXPECT_TRUE(recorder.behind());
  recorder.GiveUp(recorder.gaps()[0]);
  EXPECT_TRUE(recorder.gaps().empty());
  EXPECT_FALSE(recorder.behind());
  hear(MessageOf("world", 2000));
  EXPECT_FALSE(recorder.behind()) << "whoever says it again holds nobody up";
  // Of a start that nobody has seen, and the highest number that a message may have.
  hear(MessageOf("uav", 9, 7));
  EXPECT_EQ(recorder.gaps()[0].messages, 9);
  hear(MessageOf("worker", std::numeric_limits<std::int64_t>::max()));
  EXPECT_EQ(recorder.gaps().size(), 1u) << "nobody says so many";
}

}  // namespace
}  // namespace muster::recorder
