#include "protocol/drive.h"

#include <gtest/gtest.h>

#include "lcmtypes/channels.h"
#include "tests/lcmtypes/queue_bus.h"

namespace muster {
namespace {

/// A process in the state that it is told to be in.
class Told : public Process {
 public:
  Told() : Process({1, "uav", 0}, 0) {}
  using Process::set_state;

 private:
  void OnMessage(const Message&, const Packet&, const Now&) override {}
  void OnStep(const Now&) override {}
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

TEST_F(DriveTest, SaysItsStateWhenItChangesAndOnceASecond) {
  EXPECT_EQ(Turn(0), 0u) << "starting, as everybody knows";
  EXPECT_EQ(Turn(500'000), 0u);
  EXPECT_EQ(Turn(1'000'000), 1u);
  process_.set_state(ProcessState::kReady);
  EXPECT_EQ(Turn(1'100'000), 1u);
  EXPECT_EQ(Turn(2'000'000), 0u);
  EXPECT_EQ(Turn(2'100'000), 1u);
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

}  // namespace
}  // namespace muster
