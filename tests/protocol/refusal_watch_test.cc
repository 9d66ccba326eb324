#include "protocol/refusal_watch.h"

#include <gtest/gtest.h>

#include <memory>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/seal.h"
#include "lcmtypes/channels.h"
#include "tests/lcmtypes/queue_bus.h"

namespace muster {
namespace {

class Refusals : public ::testing::Test {
 protected:
  Refusals() { bus_.SetSeal(Seal(SealKey::Fresh(1))); }
  void Refuse(int n) {
    process_status_t status{};
    status.header.run_id = 1;
    status.header.sender = status.name = "world";
    status.host = "elsewhere";
    status.pid = 7;
    const Packet packet{std::string(channel::kProcess), Encode(status)};
    queue_->arriving.assign(static_cast<std::size_t>(n), packet);
    bus_.Receive(0);
  }
  /// How many the line tells of; -1: there is none.
  int Told(TimeUs now_us) {
    const std::optional<std::string> line = watch_.Line(bus_, now_us);
    return line ? std::stoi(*line) : -1;
  }

  testing::QueueBus* const queue_ = new testing::QueueBus;  // the bus's own
  LossyBus bus_{std::unique_ptr<Bus>(queue_), 1, "uav", [] { return 0; }};
  RefusalWatch watch_;
};

TEST_F(Refusals, AreToldAtOnceAndThenEveryTenSeconds) {
  EXPECT_EQ(Told(0), -1);
  Refuse(3);
  EXPECT_EQ(Told(1 * kSecondUs), 3);
  Refuse(2);
  EXPECT_EQ(Told(2 * kSecondUs), -1);
  Refuse(4);
  EXPECT_EQ(Told(11 * kSecondUs - 1), -1);
  EXPECT_EQ(Told(11 * kSecondUs), 6) << "what has come since";
  EXPECT_EQ(Told(60 * kSecondUs), -1);
  Refuse(1);
  EXPECT_EQ(Told(60 * kSecondUs), 1);
}

TEST_F(Refusals, SayWhomTheNewestClaimsToBe) {
  Refuse(1);
  EXPECT_EQ(watch_.Line(bus_, 0),
            "1 packet without the mission's tag refused, of somebody without its key, or damaged; "
            "the newest, on MUSTER_PROCESS, says that it is of world, pid 7 on elsewhere");
}

}  // namespace
}  // namespace muster
