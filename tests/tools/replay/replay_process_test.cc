// The real `muster replay` on a pseudo-terminal, heard over LCM.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/fake_mission.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"
#include "tests/tools/replay/terminal.h"
#include "tools/explain/redecide.h"

namespace muster::tools {
namespace {

constexpr const char* kRight = "\x1b[C";
constexpr const char* kUp = "\x1b[A";
constexpr const char* kDown = "\x1bOB";  // as in application mode

class ReplayProcess : public ::testing::Test {
 protected:
  void SetUp() override {
    MUSTER_NEEDS_MULTICAST();
    bus_.emplace(url_);
    Write(Encoded(MakeFakeMission()));
  }
  void Write(std::vector<Packet> packets) {
    packets_ = std::move(packets);
    std::filesystem::remove(log_);
    EventLogWriter writer(log_);
    // What stock LCM programs leave in every log; it is not played.
    writer.Write(1, {"LCM_SELF_TEST", {'l', 'c', 'm'}});
    for (const Packet& packet : packets_) writer.Write(1, packet);
    writer.Flush();
  }
  std::vector<std::string> Argv(const std::vector<std::string>& more) const {
    std::vector<std::string> argv = {MUSTER_PROGRAM, "replay", log_, "--lcm-url", url_};
    argv.insert(argv.end(), more.begin(), more.end());
    return argv;
  }
  void Listen() {
    for (Packet& packet : bus_->Receive(0)) {
      if (FindChannel(packet.channel) != nullptr) heard_.push_back(std::move(packet));
    }
  }
  /// Looks at the terminal and listens until it holds.
  template <class Condition>
  bool Until(Terminal* terminal, Condition holds) {
    return Eventually([&] {
      terminal->Look();
      Listen();
      return holds();
    });
  }
  bool StatusHas(Terminal* terminal, const std::string& pattern) {
    return Until(terminal,
                 [&] { return std::regex_search(terminal->status(), std::regex(pattern)); });
  }
  /// Packets of the log up to the schedule of that decision.
  std::vector<Packet> UpTo(std::int32_t decision) const {
    std::vector<Packet> packets;
    for (const Packet& packet : packets_) {
      packets.push_back(packet);
      if (packet.channel != channel::kSchedule) continue;
      if (Decode<schedule_t>(packet.bytes)->decision == decision) break;
    }
    return packets;
  }

  TemporaryFolder folder_;
  const std::string log_ = folder_.File("mission.lcm");
  const std::string url_ = fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=2097152",
                                       21'000 + getpid() % 10'000);
  std::optional<LcmBus> bus_;
  std::vector<Packet> packets_;
  std::vector<Packet> heard_;
};

TEST_F(ReplayProcess, KeysPauseStepAndChangeTheRate) {
  Terminal terminal(Argv({"--start-paused", "--rate", "60"}));
  ASSERT_TRUE(StatusHas(&terminal, "^0:00:00  paused  decision -1  0 messages"))
      << terminal.shown();
  EXPECT_TRUE(terminal.raw());

  // Right arrow: to the next decision and no further, still paused.
  for (const int decision : {0, 1}) {
    terminal.Press(kRight);
    const std::vector<Packet> expected = UpTo(decision);
    ASSERT_TRUE(StatusHas(&terminal, fmt::format("^0:{}0:00  paused  decision {}  {} messages  ",
                                                 decision, decision, expected.size())))
        << terminal.status();
    ASSERT_TRUE(Until(&terminal, [&] { return heard_.size() >= expected.size(); }));
    EXPECT_EQ(heard_, expected);
  }

  // Space goes on at the rate asked for, up doubles it, down halves it.
  terminal.Press(" ");
  ASSERT_TRUE(StatusHas(&terminal, "  60x  ")) << terminal.status();
  terminal.Press(kUp);
  ASSERT_TRUE(StatusHas(&terminal, "  120x  ")) << terminal.status();
  terminal.Press(std::string(kDown) + kDown);
  ASSERT_TRUE(StatusHas(&terminal, "  30x  ")) << terminal.status();
  // A tick is 60 s of the mission: the next message is never farther.
  ASSERT_TRUE(StatusHas(&terminal, "next message in [1-5][0-9]\\.[0-9] s$")) << terminal.status();

  // Space holds: the line is drawn again and says the same, and nothing more is heard.
  terminal.Press(" ");
  ASSERT_TRUE(StatusHas(&terminal, "  paused  ")) << terminal.status();
  const std::string held = terminal.status();
  std::smatch counted;
  ASSERT_TRUE(std::regex_search(held, counted, std::regex("  ([0-9]+) messages")));
  const auto n = std::stoul(counted[1]);
  ASSERT_TRUE(Until(&terminal, [&] { return heard_.size() >= n; }));
  const std::size_t drawn = terminal.shown().size();
  ASSERT_TRUE(Until(&terminal, [&] { return terminal.shown().size() > drawn + 4 * held.size(); }));
  EXPECT_EQ(terminal.status(), held);
  EXPECT_EQ(heard_.size(), n);
  EXPECT_TRUE(std::equal(heard_.begin(), heard_.end(), packets_.begin()));

  terminal.Press("q");
  ASSERT_TRUE(Until(&terminal, [&] { return terminal.ended().has_value(); }));
  EXPECT_EQ(terminal.ended(), 0);
  EXPECT_FALSE(terminal.raw()) << "the terminal is left as it was";
}

TEST_F(ReplayProcess, FasterAndFasterPlaysTheRest) {
  Terminal terminal(Argv({"--start-paused", "--start-offset", "900"}));
  ASSERT_TRUE(StatusHas(&terminal, "^0:15:00  paused")) << terminal.shown();
  std::string keys = " ";
  for (int i = 0; i < 20; ++i) keys += kUp;  // beyond the fastest rate: as fast as it goes
  terminal.Press(keys);
  ASSERT_TRUE(Until(&terminal, [&] { return terminal.ended().has_value(); })) << terminal.shown();
  EXPECT_EQ(terminal.ended(), 0);
  std::vector<Packet> expected;
  TimeUs log_us = 0;
  for (const Packet& packet : packets_) {
    log_us = std::max(log_us, DecodeHeader(packet)->sim_us);
    if (packet.channel == channel::kScenario || log_us >= 15 * kMinuteUs) {
      expected.push_back(packet);
    }
  }
  ASSERT_TRUE(Until(&terminal, [&] { return heard_.size() >= expected.size(); }));
  EXPECT_EQ(heard_, expected);
}

TEST_F(ReplayProcess, LoopsUntilItIsEnded) {
  Terminal terminal(Argv({"--rate", "max", "--loop"}));
  const auto scenarios = [&] {
    return std::count_if(heard_.begin(), heard_.end(),
                         [](const Packet& p) { return p.channel == channel::kScenario; });
  };
  ASSERT_TRUE(Until(&terminal, [&] { return scenarios() >= 4; })) << terminal.shown();
  EXPECT_FALSE(terminal.ended());
  terminal.Press("q");
  ASSERT_TRUE(Until(&terminal, [&] { return terminal.ended().has_value(); }));
  EXPECT_EQ(terminal.ended(), 0);
  ASSERT_GE(heard_.size(), 3 * packets_.size());
  for (std::size_t i = 0; i < 3 * packets_.size(); ++i) {
    ASSERT_EQ(heard_[i], packets_[i % packets_.size()]) << i;
  }
}

TEST_F(ReplayProcess, PlaysWithoutATerminalAndOnlyTheChannelsAskedFor) {
  const auto expect = [&](const std::vector<std::string>& flags,
                          const std::function<bool(const std::string&)>& plays) {
    heard_.clear();
    std::vector<std::string> arguments = {"replay", log_, "--lcm-url", url_, "--rate", "max"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    Muster replay(folder_, "replay", arguments);
    EXPECT_EQ(replay.Wait(), 0) << replay.output();
    std::vector<Packet> expected;
    for (const Packet& packet : packets_) {
      if (plays(packet.channel)) expected.push_back(packet);
    }
    EXPECT_TRUE(Eventually([&] {
      Listen();
      return heard_.size() >= expected.size();
    }));
    EXPECT_EQ(heard_, expected);
    EXPECT_NE(replay.output().find(fmt::format("played {} messages", expected.size())),
              std::string::npos)
        << replay.output();
  };
  expect({}, [](const std::string&) { return true; });
  expect({"--without", "MUSTER_SCHEDULE|MUSTER_EVENT"}, [](const std::string& name) {
    return name != channel::kSchedule && name != channel::kEvent;
  });
  expect({"--channels", "MUSTER_(CLOCK|WORLD)"}, [](const std::string& name) {
    return name == channel::kClock || name == channel::kWorld;
  });
}

TEST_F(ReplayProcess, RefusesWhatCannotBe) {
  for (const std::vector<std::string>& flags :
       std::vector<std::vector<std::string>>{{"--start-paused"},  // nobody could press a key
                                             {"--rate", "0"},
                                             {"--rate", "fast"},
                                             {"--start-offset", "-1"},
                                             {"--channels", "("}}) {
    std::vector<std::string> arguments = {"replay", log_, "--lcm-url", url_};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    Muster replay(folder_, "replay", arguments);
    EXPECT_EQ(replay.Wait(), 2) << flags[0];
    EXPECT_NE(replay.output().find(flags[0]), std::string::npos) << replay.output();
  }
}

/// A real scheduler hears a replay as it hears a mission, and decides what the log says.
TEST_F(ReplayProcess, ASchedulerDecidesOnAReplay) {
  GeneratorSettings settings = PresetByName("Random_10");
  settings.rules.limit_us = 60 * kMinuteUs;
  std::vector<Packet> packets;
  Simulate(ScenarioToJson(Generate(settings, 1)), "mpq",
           [&](const Packet& packet) { packets.push_back(packet); });
  Write(packets);
  std::vector<schedule_t> logged;
  for (const Packet& packet : packets_) {
    if (packet.channel == channel::kSchedule) logged.push_back(*Decode<schedule_t>(packet.bytes));
  }
  ASSERT_EQ(logged.size(), 6u);

  Child scheduler({"scheduler",
                   {MUSTER_SCHEDULER, "--lcm-url", url_, "--run-id", "1", "--boot-id", "7",
                    "--policy", "mpq", "--quiet"},
                   folder_.File("scheduler.output")});
  ASSERT_TRUE(Eventually([&] {
    Listen();
    return std::any_of(heard_.begin(), heard_.end(),
                       [](const Packet& p) { return DecodeHeader(p)->sender == "scheduler"; });
  })) << TextOf(folder_.File("scheduler.output"));

  Terminal terminal(Argv({"--start-paused", "--without", "MUSTER_SCHEDULE"}));
  ASSERT_TRUE(StatusHas(&terminal, "paused")) << terminal.shown();
  for (const schedule_t& expected : logged) {
    terminal.Press(kRight);
    std::optional<schedule_t> decided;
    ASSERT_TRUE(Until(&terminal,
                      [&] {
                        for (const Packet& packet : heard_) {
                          if (packet.channel != channel::kSchedule) continue;
                          const auto schedule = Decode<schedule_t>(packet.bytes);
                          if (schedule->decision == expected.decision) decided = schedule;
                        }
                        return decided.has_value();
                      }))
        << "decision " << expected.decision << ": " << terminal.status();
    EXPECT_EQ(decided->header.boot_id, 7);
    EXPECT_EQ(FirstDifference(*decided, expected), "");
  }
  EXPECT_FALSE(scheduler.Poll()) << TextOf(folder_.File("scheduler.output"));
}

}  // namespace
}  // namespace muster::tools
