#include "lcmtypes/bus/memory_bus.h"

#include <gtest/gtest.h>

#include <vector>

#include "base/check.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

Packet Clock(std::uint8_t number) { return {std::string(channel::kClock), {number}}; }

TEST(MemoryBus, DeliversInOrderToAllMembersAndTheSender) {
  MemoryHub hub;
  const auto a = hub.Join();
  const auto b = hub.Join();
  const auto c = hub.Join();
  a->Publish(Clock(1));
  b->Publish(Clock(2));
  a->Publish(Clock(3));
  const std::vector<Packet> all{Clock(1), Clock(2), Clock(3)};
  EXPECT_EQ(a->Receive(0), all);
  EXPECT_EQ(b->Receive(0), all);
  EXPECT_EQ(c->Receive(0), all);
  EXPECT_TRUE(a->Receive(1'000'000'000).empty());
}

TEST(MemoryBus, MembersHearFromJoiningToLeaving) {
  MemoryHub hub;
  const auto a = hub.Join();
  a->Publish(Clock(1));
  auto late = hub.Join();
  a->Publish(Clock(2));
  EXPECT_EQ(late->Receive(0), std::vector<Packet>{Clock(2)});
  EXPECT_EQ(hub.members(), 2u);
  late.reset();
  EXPECT_EQ(hub.members(), 1u);
  a->Publish(Clock(3));
  EXPECT_EQ(a->Receive(0).size(), 3u);
}

TEST(MemoryBus, RefusesWhatTheChannelTableForbids) {
  MemoryHub hub;
  const auto bus = hub.Join();
  EXPECT_THROW(bus->Publish({"MUSTER_NOBODY_KNOWS", {1}}), SystemError);
  EXPECT_THROW(bus->Publish({std::string(channel::kClock), std::vector<std::uint8_t>(1025)}),
               SystemError);
  EXPECT_TRUE(bus->Receive(0).empty());
}

}  // namespace
}  // namespace muster
