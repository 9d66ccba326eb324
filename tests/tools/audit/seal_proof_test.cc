#include "tools/audit/seal_proof.h"

#include <gtest/gtest.h>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/seal.h"
#include "lcmtypes/channels.h"

namespace muster::tools::audit {
namespace {

const SealKey kKey = SealKey::Parse(std::string(64, '7'), "here");

LogEvent ClockOf(std::int64_t number, std::int64_t run_id) {
  clock_t clock{};
  clock.header.run_id = run_id;
  clock.header.sender = "world";
  clock.header.seq = 10 + number;
  clock.header.sim_us = 1000 * number;
  LogEvent event;
  event.number = number;
  event.packet = {std::string(channel::kClock), Encode(clock)};
  return event;
}

LogEvent Sealed(LogEvent event, std::int64_t run_id) {
  event.tag = Seal(kKey.Of(run_id, "here")).TagOf(event.packet);
  return event;
}

TEST(SealProof, CountsWhatIsProvenAndWhatIsNotAndNamesTheFirst) {
  SealProof proof(kKey, "here");
  EXPECT_TRUE(proof.Takes(Sealed(ClockOf(0, 5), 5), "a.lcm"));
  EXPECT_EQ(proof.first_refused(), "");
  EXPECT_FALSE(proof.Takes(ClockOf(1, 5), "a.lcm"));
  EXPECT_FALSE(proof.Takes(Sealed(ClockOf(2, 5), 6), "b.lcm"));
  LogEvent changed = Sealed(ClockOf(3, 5), 5);
  changed.packet.bytes.back() ^= 1;
  EXPECT_FALSE(proof.Takes(changed, "b.lcm"));
  EXPECT_TRUE(proof.Takes(Sealed(ClockOf(4, 5), 5), "b.lcm"));
  EXPECT_EQ(proof.proven(), 2);
  EXPECT_EQ(proof.refused(), 3);
  EXPECT_EQ(proof.first_refused(),
            "a.lcm, event 1 on MUSTER_CLOCK, which says that it is of world (start 0, seq 11): no "
            "tag");
  EXPECT_EQ(proof.first_refused_us(), 1000);
}

TEST(SealProof, OfAnotherRunHasAnotherKey) {
  SealProof proof(kKey, "here");
  EXPECT_TRUE(proof.Takes(Sealed(ClockOf(0, 5), 5), "a.lcm"));
  EXPECT_TRUE(proof.Takes(Sealed(ClockOf(1, 6), 6), "a.lcm"));
  SealProof of_one_run(kKey.Of(5, "here"), "here");
  EXPECT_TRUE(of_one_run.Takes(Sealed(ClockOf(0, 5), 5), "a.lcm"));
  EXPECT_FALSE(of_one_run.Takes(Sealed(ClockOf(1, 6), 6), "a.lcm"));
}

TEST(SealProof, OtherChannelsWantNone) {
  SealProof proof(kKey, "here");
  LogEvent other = ClockOf(0, 5);
  other.packet.channel = "LCM_SELF_TEST";
  EXPECT_TRUE(proof.Takes(other, "a.lcm"));
  EXPECT_EQ(proof.proven() + proof.refused(), 0);
}

}  // namespace
}  // namespace muster::tools::audit
