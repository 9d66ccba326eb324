#include "protocol/drive.h"

#include <gtest/gtest.h>

#include <functional>
#include <utility>
#include <vector>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "tests/lcmtypes/queue_bus.h"

namespace muster {
namespace {

/// A process in the state that it is told to be in.
class Told : public Process {
 public:
  explicit Told(std::int64_t boot_id = 0, int window = 0) : Process({1, "uav", boot_id}, window) {}
  using Process::set_state;
  /// What its next step computes.
  std::function<void()> computation;

 private:
  void OnMessage(const Message&, const Packet&, const Now&) override {}
  void OnStep(const Now&) override {
    if (computation) Compute(std::exchange(computation, {}));
  }
  TimeUs OwnWakeUs() const override { return kNever; }
  std::int64_t tick() const override { return 0; }
};

class DriveTest : public ::testing::Test {
 protected:
  DriveTest()
      : queue_(new testing::QueueBus),
        bus_(std::unique_ptr<Bus>(queue_), 1, "uav", [] { return std::int64_t{0}; }),
        drive_(&process_, &bus_) {}

  /// Heartbeats sent by a turn at that time.
  std::size_t Turn(TimeUs now_us) {
    queue_->sent.clear();
    drive_.Turn({}, {now_us, 0}, [] { return Usage(); });
    return queue_->sent.size();
  }

  Told process_;
  testing::QueueBus* queue_;  ///< owned by bus_
  LossyBus bus_;
  Drive drive_;
};

/// It is back behind a cut, and writes a log that the mission has left. So do the others.
TEST(ProcessTest, TakesNoMarksOfAnEarlierLaunchersRecorder) {
  constexpr std::int64_t kBoot = kLauncherApart + 1;
  for (const bool computes : {false, true}) {
    Told process(kBoot, 1);
    std::vector<Packet> out;
    for (int i = 0; i < 2; ++i) process.Announce({}, {});
    process.Step(std::vector<Packet>(), {}, &out);
    const auto hear_marks_of = [&](std::int64_t recorders_boot) {
      log_status_t marks{};
      marks.header.run_id = 1;
      marks.header.sender = "recorder";
      marks.header.boot_id = recorders_boot;
      log_mark_t mark{};
      mark.sender = "uav";
      mark.boot_id = kBoot;
      mark.next_seq = 1;
      marks.marks = {mark};
      marks.n = 1;
      std::vector<Packet> arrived = {{std::string(channel::kLog), Encode(marks)}};
      computes ? process.Beat(&arrived, {}, {}, &out) : process.Step(arrived, {}, &out);
    };
    hear_marks_of(kLauncherApart - 1);
    EXPECT_EQ(out.size(), 1u);
    hear_marks_of(kBoot);
    EXPECT_EQ(out.size(), 2u) << "of which one may be out at a time";
  }
}

TEST_F(DriveTest, SaysItsStateWhenItChangesAndOnceASecond) {
  EXPECT_EQ(Turn(0), 0u) << "starting, as everybody knows";
  EXPECT_EQ(Turn(500'000), 0u);
  EXPECT_EQ(Turn(1'000'000), 1u);
  process_.set_state(ProcessState::kReady);
  EXPECT_EQ(Turn(1'100'000), 1u);
  EXPECT_EQ(Turn(2'000'000), 0u);
  EXPECT_EQ(Turn(2'100'000), 1u);
}

TEST_F(DriveTest, WhileItComputesItSaysThatItIsDecidingAndTakesOnlyWhatTheLogHolds) {
  process_.set_state(ProcessState::kRunning);
  Turn(0);
  std::vector<int> states;
  const auto note = [&] {
    for (const Packet& packet : queue_->sent) {
      states.push_back(DecodeValid<process_status_t>(packet.bytes)->state);
    }
    queue_->sent.clear();
  };
  log_status_t log{};
  log.header.run_id = 1;
  log.header.sender = "recorder";
  std::vector<Packet> arrived = {{std::string(channel::kLog), Encode(log)}, {"OTHER", {1}}};
  process_.set_run_long([&](const std::function<void()>& computation) {
    for (const TimeUs t : {100, 200}) {
      drive_.Beat(&arrived, {t, 0}, [] { return Usage(); });
      note();
    }
    computation();
  });
  bool computed = false;
  process_.computation = [&] { computed = true; };
  Turn(10);
  note();
  EXPECT_TRUE(computed);
  // Twice that it decides, then that it runs again.
  EXPECT_EQ(states, (std::vector<int>{5, 5, 2}));
  ASSERT_EQ(arrived.size(), 1U);
  EXPECT_EQ(arrived[0].channel, "OTHER");
  EXPECT_EQ(Turn(500'000), 0U);
}

/// A process that was cut off, and whose later start has spoken twice.
TEST_F(DriveTest, OnlyInASealedMissionALaterStartEndsAnEarlierOne) {
  process_status_t status{};
  status.header.run_id = 1;
  status.header.sender = status.name = "uav";
  status.header.boot_id = 1;
  status.host = "field";
  status.pid = 4711;
  const auto hear = [&](std::int64_t seq) {
    status.header.seq = seq;
    drive_.Turn({{std::string(channel::kProcess), Encode(status)}}, {10'000'000 + seq, 0},
                [] { return Usage(); });
  };
  Turn(0);
  for (const std::int64_t seq : {1, 2, 3}) hear(seq);  // anybody may have forged them
  bus_.SetSeal(Seal(SealKey::Fresh(1)));
  hear(4);
  hear(4);  // one message, said again
  status.header.boot_id = 0;
  hear(5);
  status.header.boot_id = 1;
  try {
    hear(6);
    FAIL() << "it goes on";
  } catch (const SystemError& error) {
    EXPECT_NE(std::string(error.what()).find("uav has been started again, pid 4711 on field"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(DriveTest, OneThatHasEndedWaitsForOthers) {
  process_.set_state(ProcessState::kEnded);
  EXPECT_EQ(Turn(0), 1u);
  EXPECT_EQ(Turn(5'000'000), 0u);
  EXPECT_GT(drive_.wake_us(5'000'000), 5'000'000) << "it would turn without a pause";
}

TEST_F(DriveTest, AppliesFaultsOnItsPacketsAndSaysSo) {
  fault_t fault{};
  fault.header.run_id = 1;
  fault.header.sender = "recorder";
  fault.kind = static_cast<std::int8_t>(FaultKind::kLoss);
  fault.target = "*";
  fault.for_us = kNever;
  fault.probability = 0.5;
  drive_.Turn({{std::string(channel::kFault), Encode(fault)}}, {}, [] { return Usage(); });
  EXPECT_EQ(bus_.faults().loss, 0.5);
  ASSERT_EQ(queue_->sent.size(), 1u);
  EXPECT_EQ(queue_->sent[0].channel, channel::kEvent);
}

class NamesakeTest : public DriveTest {
 protected:
  /// A turn in which that is heard of a process of the same name.
  void Hear(int pid, std::int64_t received, TimeUs now_us, std::int64_t boot_id = 0) {
    process_status_t status{};
    status.header.run_id = 1;
    status.header.sender = status.name = "uav";
    status.header.boot_id = boot_id;
    status.header.seq = seq_++;
    status.received = received;
    status.pid = pid;
    queue_->sent.clear();
    drive_.Turn({{std::string(channel::kProcess), Encode(status)}}, {now_us, 0}, [] {
      Usage own;
      own.pid = 10;
      return own;
    });
  }

 private:
  std::int64_t seq_ = 0;
};

TEST_F(NamesakeTest, WhoIsNewGivesWayToWhoIsThereAndSaysWhoItWas) {
  Hear(10, 0, 0);  // itself
  EXPECT_TRUE(queue_->sent.empty());
  Hear(11, 50, 1, 1);  // a later start is the launcher's affair
  EXPECT_TRUE(queue_->sent.empty());
  Hear(11, 50, 2);  // one may be damaged
  EXPECT_THROW(Hear(11, 50, 200'000), SystemError);
  ASSERT_EQ(queue_->sent.size(), 1U);
  EXPECT_EQ(DecodeValid<process_status_t>(queue_->sent[0].bytes)->pid, 10);
}

// Before it has heard that its name is taken it gives no orders.
TEST_F(NamesakeTest, WhoJoinsAMissionListensFirst) {
  clock_t clock{};
  clock.header.run_id = 1;
  clock.header.sender = "world";
  clock.tick = 7;
  clock.phase = NumberOf(ClockPhase::kRunning);
  const Packet joined = {std::string(channel::kClock), Encode(clock)};
  process_.set_state(ProcessState::kRunning);
  process_.Announce({}, {});
  drive_.Turn({joined}, {0, 0}, [] { return Usage(); });
  ASSERT_EQ(queue_->sent.size(), 1U);
  EXPECT_EQ(queue_->sent[0].channel, channel::kProcess);
  EXPECT_EQ(drive_.wake_us(250'000), 300'000);
  queue_->sent.clear();
  drive_.Turn({joined}, {300'000, 0}, [] { return Usage(); });
  ASSERT_EQ(queue_->sent.size(), 1U);
  EXPECT_EQ(queue_->sent[0].channel, channel::kEvent);
}

TEST_F(NamesakeTest, AClockOfItsOwnIsNoMissionToJoin) {
  clock_t clock{};
  clock.header.run_id = 1;
  clock.header.sender = "uav";  // as a world hears its own
  clock.tick = 1;
  process_.Announce({}, {});
  drive_.Turn({{std::string(channel::kClock), Encode(clock)}}, {0, 0}, [] { return Usage(); });
  ASSERT_EQ(queue_->sent.size(), 1U);
  EXPECT_EQ(queue_->sent[0].channel, channel::kEvent);
}

TEST_F(NamesakeTest, WhoIsThereStaysAndAnswers) {
  Hear(10, 0, 0);
  Hear(11, 0, 100);
  EXPECT_EQ(queue_->sent.size(), 1U) << "so that the other one hears of it";
  Hear(11, 0, 200);
  EXPECT_TRUE(queue_->sent.empty()) << "not each time";
  Hear(11, 5000, 6'000'000);
  EXPECT_EQ(queue_->sent.size(), 1U) << "nobody's word ends it later";
}

}  // namespace
}  // namespace muster
