#include "tools/host/progress.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "tools/launch/mission_view.h"

namespace muster::tools {
namespace {

header_t Header(const char* sender) {
  header_t header;
  header.run_id = 1;
  header.sender = sender;
  header.boot_id = header.seq = header.sim_us = header.wall_us = 0;
  return header;
}

Packet Clock(std::int64_t tick, std::int8_t phase) {
  clock_t clock;
  clock.header = Header("world");
  clock.tick = tick;
  clock.tick_us = tick * 30 * kSecondUs;
  clock.limit_us = 3 * 3600 * kSecondUs;
  clock.decision = clock.required_decision = -1;
  clock.phase = phase;
  return {std::string(channel::kClock), Encode(clock)};
}

Packet World(std::int64_t tick, int done) {
  world_state_t world;
  world.header = Header("world");
  world.tick = tick;
  world.done = done;
  world.n_tasks = 4;
  world.task_status = {3, 3, 0, 0};
  world.n_activities = 0;
  return {std::string(channel::kWorld), Encode(world)};
}

Packet Status(const char* sender, ProcessState state) {
  process_status_t status;
  status.header = Header(sender);
  status.name = sender;
  status.pid = 1;
  status.state = static_cast<std::int8_t>(state);
  status.tick = 0;
  status.received = status.lost = status.rejected = status.resent = status.rss_bytes = 0;
  status.cpu_s = 0;
  return {std::string(channel::kProcess), Encode(status)};
}

TEST(MissionView, KeepsTheNewestWhateverTheOrder) {
  MissionView mission;
  EXPECT_FALSE(mission.started());
  mission.Add(Clock(0, 0));  // ready, not running
  EXPECT_FALSE(mission.started());
  mission.Add(Clock(7, 1));
  mission.Add(World(7, 2));
  mission.Add(Clock(3, 1));
  mission.Add(World(3, 1));
  EXPECT_EQ(mission.tick(), 7);
  EXPECT_EQ(mission.done(), 2);
  EXPECT_EQ(mission.tasks(), 4);
  EXPECT_FALSE(mission.end_announced());
  mission.Add(Clock(360, 2));
  EXPECT_TRUE(mission.end_announced());
}

TEST(MissionView, RemembersTheHighestStateOfAProcess) {
  MissionView mission;
  EXPECT_EQ(mission.StateOf("uav"), ProcessState::kStarting);
  mission.Add(Status("uav", ProcessState::kEnded));
  mission.Add(Status("uav", ProcessState::kRunning));
  EXPECT_EQ(mission.StateOf("uav"), ProcessState::kEnded);
  EXPECT_EQ(mission.StateOf("worker"), ProcessState::kStarting);
}

TEST(Progress, OneLineSaysHowFarItIs) {
  MissionView mission;
  EXPECT_EQ(ProgressLine(mission, 0, 0), "waiting for all processes");
  mission.Add(Clock(167, 1));
  mission.Add(World(167, 2));
  // 5010 s of mission in 2 s.
  EXPECT_EQ(ProgressLine(mission, 1, 2 * kSecondUs),
            "1:23:30 of 3:00:00  tick 167  tasks 2/4  decisions 0  log lag 1  speed 2505x");
}

std::string Shown(ProgressPrinter::Style style) {
  std::FILE* file = std::tmpfile();
  ProgressPrinter printer(file, style);
  printer.Show("a longer line", 0);
  printer.Show("short", kSecondUs);
  printer.Break();
  std::string text(static_cast<std::size_t>(std::ftell(file)), '\0');
  std::rewind(file);
  EXPECT_EQ(std::fread(text.data(), 1, text.size(), file), text.size());
  std::fclose(file);
  return text;
}

TEST(Progress, RedrawsOverTheWholeOldLineAndNeedsNoEscapes) {
  EXPECT_EQ(Shown(ProgressPrinter::Style::kInPlace), "\ra longer line\rshort        \n");
  EXPECT_EQ(Shown(ProgressPrinter::Style::kLines), "a longer line\nshort\n");
  EXPECT_EQ(Shown(ProgressPrinter::Style::kNone), "");
}

}  // namespace
}  // namespace muster::tools
