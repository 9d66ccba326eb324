#include "tools/launch/stall_watch.h"

#include <gtest/gtest.h>

#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "tools/launch/namesakes.h"

namespace muster::tools {
namespace {

Packet Clock(TimeUs mission_us, int decision) {
  clock_t clock{};
  clock.header.sender = "world";
  clock.header.sim_us = clock.tick_us = mission_us;
  clock.phase = 1;
  clock.decision = decision;
  return {std::string(channel::kClock), Encode(clock)};
}

Packet States(const char* name, TimeUs mission_us) {
  agent_states_t states{};
  states.header.sender = name;
  states.header.sim_us = mission_us;
  return {std::string(channel::kUavs), Encode(states)};
}

Packet Schedule(TimeUs mission_us) {
  schedule_t schedule{};
  schedule.header.sender = "scheduler";
  schedule.header.sim_us = mission_us;
  return {std::string(channel::kSchedule), Encode(schedule)};
}

using Names = std::vector<std::string>;

TEST(StallWatch, NamesWhoIsMissingAndSaysWhenItGoesOn) {
  StallWatch watch({"world", "uav", "worker", "scheduler"}, kMinuteUs, 0);
  EXPECT_FALSE(watch.Line(100 * kSecondUs)) << "it has not begun";
  TimeUs now_us = 0;
  for (TimeUs t : {TimeUs{0}, kMinuteUs}) {
    watch.OnHeard(Clock(t, 0), now_us);
    for (const char* name : {"uav", "worker"}) watch.OnHeard(States(name, t), now_us);
    watch.OnHeard(Schedule(t), now_us);
    now_us += kSecondUs;
  }
  EXPECT_EQ(watch.Missing(), Names{});
  watch.OnHeard(Clock(2 * kMinuteUs, 1), now_us);
  watch.OnHeard(States("worker", 2 * kMinuteUs), now_us);
  EXPECT_EQ(watch.Missing(), Names{"uav"}) << "the scheduler needs its states";
  EXPECT_FALSE(watch.Line(now_us + 2 * kSecondUs));
  EXPECT_EQ(watch.Line(now_us + 3 * kSecondUs),
            "the mission has stood at 2.0 min for 3 s: it waits for uav (silent for 4 s)");
  EXPECT_FALSE(watch.Line(now_us + 5 * kSecondUs));
  EXPECT_TRUE(watch.Line(now_us + 6 * kSecondUs));
  watch.OnHeard(States("uav", 2 * kMinuteUs), now_us + 7 * kSecondUs);
  EXPECT_EQ(watch.Missing(), Names{"scheduler"});
  watch.OnHeard(Schedule(2 * kMinuteUs), now_us + 7 * kSecondUs);
  watch.OnHeard(Clock(3 * kMinuteUs, -1), now_us + 7 * kSecondUs);
  EXPECT_EQ(watch.Line(now_us + 7 * kSecondUs), "the mission goes on at 3.0 min");
  EXPECT_FALSE(watch.Line(now_us + 7 * kSecondUs));
}

Packet InState(const char* name, ProcessState state) {
  process_status_t status{};
  status.header.sender = status.name = name;
  status.state = static_cast<std::int8_t>(state);
  return {std::string(channel::kProcess), Encode(status)};
}

TEST(StallWatch, SaysWhoIsDecidingAndForHowLong) {
  StallWatch watch({"world", "uav", "scheduler-1", "scheduler-2"}, kMinuteUs, 0);
  watch.OnHeard(Clock(0, 0), 0);
  watch.OnHeard(States("uav", 0), 0);
  for (const char* name : {"scheduler-1", "scheduler-2"}) {
    proposal_t proposal{};
    proposal.header.sender = name;
    watch.OnHeard({std::string(channel::kProposal), Encode(proposal)}, 0);
  }
  watch.OnHeard(Clock(kMinuteUs, 1), kSecondUs);
  watch.OnHeard(States("uav", kMinuteUs), kSecondUs);
  for (TimeUs t = 2 * kSecondUs; t < 5 * kSecondUs; t += kSecondUs) {
    watch.OnHeard(InState("scheduler-2", ProcessState::kDeciding), t);
  }
  EXPECT_EQ(watch.Line(6 * kSecondUs),
            "the mission has stood at 1.0 min for 5 s: it waits for scheduler-1 (silent for 6 s), "
            "scheduler-2 (deciding for 4 s)");
  watch.OnHeard(InState("scheduler-2", ProcessState::kRunning), 6 * kSecondUs);
  EXPECT_NE(watch.Line(12 * kSecondUs)->find("scheduler-2 (silent for 6 s)"), std::string::npos);
}

TEST(StallWatch, NamesASchedulerThatIsAtItsFirstDecision) {
  StallWatch watch({"world", "uav", "scheduler"}, kMinuteUs, 0);
  watch.OnHeard(InState("scheduler", ProcessState::kRunning), 0);
  watch.OnHeard(Clock(0, 0), 0);
  watch.OnHeard(States("uav", 0), 0);
  watch.OnHeard(InState("scheduler", ProcessState::kDeciding), kSecondUs);
  EXPECT_EQ(watch.Line(4 * kSecondUs),
            "the mission has stood at 0.0 min for 4 s: it waits for scheduler (deciding for 3 s)");
}

TEST(StallWatch, GivesAPacedMissionItsTicks) {
  StallWatch watch({"world", "uav"}, 30 * kSecondUs, 1);
  watch.OnHeard(Clock(0, -1), 0);
  watch.OnHeard(States("uav", 0), 0);
  EXPECT_FALSE(watch.Line(32 * kSecondUs));
  EXPECT_EQ(watch.Line(33 * kSecondUs),
            "the mission has stood at 0.0 min for 33 s: it waits for the world or the log");
}

TEST(StallWatch, SaysHowLateAPacedMissionIs) {
  StallWatch watch({"world"}, 30 * kSecondUs, 30);
  const auto line = [&](TimeUs ticks, TimeUs now_us) {
    watch.OnHeard(Clock(ticks * 30 * kSecondUs, -1), now_us);
    return watch.Line(now_us);
  };
  EXPECT_FALSE(line(0, 0));
  EXPECT_FALSE(line(10, 14 * kSecondUs)) << "4 s late";
  EXPECT_EQ(line(20, 26 * kSecondUs),
            "the mission is 6 s behind its rate at 10.0 min: this host is too slow");
  EXPECT_FALSE(line(30, 38 * kSecondUs)) << "8 s, said at 6";
  EXPECT_TRUE(line(40, 53 * kSecondUs));
}

TEST(Patience, SaysAfterThreeSecondsAndThenTwiceAsLong) {
  Patience patience;
  std::vector<int> said;
  for (int s = 0; s < 30; ++s) {
    patience.WaitFor("uav", s * kSecondUs);
    if (patience.Due(s * kSecondUs)) said.push_back(s);
  }
  EXPECT_EQ(said, (std::vector<int>{3, 6, 12, 24}));
  patience.WaitFor("worker", 30 * kSecondUs);
  EXPECT_FALSE(patience.Due(32 * kSecondUs));
  EXPECT_TRUE(patience.Due(33 * kSecondUs));
  patience.WaitFor("", 40 * kSecondUs);
  EXPECT_FALSE(patience.Due(90 * kSecondUs));
}

TEST(Namesakes, NamesTwoLivingProcessesOfOneNameOnce) {
  Namesakes namesakes;
  std::int64_t seq = 0;
  const auto said_by = [&](std::int64_t boot_id, int pid, const char* host) {
    process_status_t status{};
    status.header.sender = status.name = "world";
    status.header.boot_id = boot_id;
    status.header.seq = seq++;
    status.pid = pid;
    status.host = host;
    return namesakes.OnHeard({"MUSTER_PROCESS", Encode(status)}, status.header, {});
  };
  EXPECT_FALSE(said_by(0, 10, "here"));
  EXPECT_FALSE(said_by(0, 10, "here"));
  EXPECT_FALSE(said_by(1, 11, "here"));  // started again
  const auto line = said_by(1, 11, "there");
  ASSERT_TRUE(line);
  EXPECT_EQ(line->rfind("two processes send as world: pid 11 on here and pid 11 on there", 0), 0U)
      << *line;
  EXPECT_FALSE(said_by(1, 12, "there"));
}

TEST(Namesakes, NamesWhomNumbersBetray) {
  Namesakes namesakes;
  const auto said = [&](std::int64_t seq, std::int64_t wall_us, std::int64_t tick,
                        const char* sender = "world") {
    clock_t clock{};
    clock.header.sender = sender;
    clock.header.seq = seq;
    clock.header.wall_us = wall_us;
    clock.tick = tick;
    clock.phase = NumberOf(ClockPhase::kRunning);
    return namesakes.OnHeard({"MUSTER_CLOCK", Encode(clock)}, clock.header, {}).value_or("");
  };
  // In any order, twice, late: still one sender.
  for (const std::int64_t seq : {0, 2, 1, 2, 300, 3, 300, 150}) {
    EXPECT_EQ(said(seq, 1000 + seq, seq), "") << seq;
  }
  EXPECT_NE(said(300, 1300, 301)
                .find("another process sends as world, too: its message 300 says "
                      "two things"),
            std::string::npos);
  EXPECT_EQ(said(300, 1300, 302), "") << "once";
  EXPECT_EQ(said(10'000, 50, 0, "uav"), "");
  EXPECT_NE(said(7, 60, 1, "uav").find("its message 10000 is older than its message 7"),
            std::string::npos);
}

TEST(Namesakes, NamesWhoIsAheadOfTheLogOrOfItsStarts) {
  Namesakes namesakes;
  const auto said = [&](const char* sender, std::int64_t boot_id, std::int64_t seq) {
    clock_t clock{};
    clock.header.sender = sender;
    clock.header.boot_id = boot_id;
    clock.header.seq = seq;
    return namesakes.OnHeard({"MUSTER_CLOCK", Encode(clock)}, clock.header, {50, 2}).value_or("");
  };
  EXPECT_EQ(said("world", 0, 1049), "");
  EXPECT_EQ(said("world", 1, 3), "");
  EXPECT_NE(said("world", 0, 1050).find("far ahead of its message 50"), std::string::npos);
  EXPECT_NE(said("uav", 2, 0).find("claims start 2, which never happened"), std::string::npos);
}

// The launcher of a large mission reads the log later than the recorder writes it.
TEST(Namesakes, WhatTheRecorderSaysCountsAsLogged) {
  Namesakes namesakes;
  const auto said = [&](std::int64_t seq) {
    clock_t clock{};
    clock.header.sender = process_name::kWorld;
    clock.header.seq = seq;
    return namesakes.OnHeard({"MUSTER_CLOCK", Encode(clock)}, clock.header, {50, 2}).value_or("");
  };
  EXPECT_EQ(said(60), "");
  log_status_t status{};
  status.header.sender = process_name::kRecorder;
  log_mark_t& mark = status.marks.emplace_back();
  mark.sender = process_name::kWorld;
  mark.next_seq = 2000;
  status.n = 1;
  namesakes.OnHeard({"MUSTER_LOG", Encode(status)}, status.header, {50, 2});
  EXPECT_EQ(said(2999), "");
  EXPECT_NE(said(3000).find("far ahead of its message 2000"), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
