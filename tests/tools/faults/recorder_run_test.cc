// What befalls the recorder, the process that writes a mission's log: all that lcm-logger and the
// launcher survive with --logger lcm, it survives.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/bus/multicast.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/faults/mission_test.h"
#include "tests/tools/launch/live_log.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class RecorderRunTest : public MissionTest {
 protected:
  std::vector<std::string> With(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"run", scenario_, "--quiet", "--out", Run()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  std::string Run() const { return folder_.File("run"); }
  /// A mission that ends well; it is audited and decided again (Muster::Wait).
  Json Mission(const std::vector<std::string>& more) {
    Muster muster(folder_, "run", With(more));
    EXPECT_EQ(muster.Wait(), 0) << muster.output();
    Json report = Report();
    EXPECT_EQ(report["digest"], undisturbed_) << muster.output();
    EXPECT_TRUE(report["log"]["complete"].get<bool>()) << report["log"];
    for (const Json& fault : report["faults"]) {
      EXPECT_FALSE(fault["applied_s"].is_null()) << fault << muster.output();
    }
    return report;
  }
};

std::int64_t GarbageIn(const std::string& log) {
  EventLogReader reader(log, EventLogReader::Tail::kFinal);
  while (reader.Next()) {
  }
  return reader.garbage_bytes();
}

TEST_F(RecorderRunTest, DecidesAndRecordsAsLcmLoggerDoes) {
  const Json report = Mission({});
  EXPECT_FALSE(fs::exists(Run() + "/lcm-logger.stderr"));
  EXPECT_TRUE(fs::exists(Run() + "/recorder.stderr"));
  std::set<std::string> names;
  for (const Json& process : report["processes"]) {
    names.insert(process["name"]);
    EXPECT_TRUE(process["ended"].get<bool>()) << process;
  }
  EXPECT_EQ(names, (std::set<std::string>{"launcher", "recorder", "scheduler", "uav", "vehicle",
                                          "worker", "world"}));
  // What is not a mission's is in it, too: here LCM's own test of its socket.
  EventLogReader reader(Run() + "/mission.lcm", EventLogReader::Tail::kFinal);
  std::int64_t number = 0, before_us = 0;
  std::set<std::string> channels;
  while (const auto event = reader.Next()) {
    EXPECT_EQ(event->number, number++);
    EXPECT_GE(event->received_us, before_us);
    before_us = event->received_us;
    channels.insert(event->packet.channel);
  }
  EXPECT_TRUE(channels.contains("ROUND_TRIP_OF_MUSTER"));
  EXPECT_EQ(reader.garbage_bytes(), 0);
}

TEST_F(RecorderRunTest, StockLogplayerPlaysWhatItWrites) {
  Mission({});
  const std::string play =
      fmt::format("exec lcm-logplayer -v -s 1000 -l '{}' {}/mission.lcm",
                  MissionUrl(static_cast<std::uint16_t>(20000 + getpid() % 4000 * 10 + 6)), Run());
  Child player({"play", {"/bin/sh", "-c", play}, folder_.File("played")});
  ASSERT_TRUE(Eventually([&] { return player.Poll().has_value(); }));
  EXPECT_TRUE(player.Poll()->clean()) << TextOf(folder_.File("played"));
}

TEST_F(RecorderRunTest, KilledFromOutsideAtRandomTicks) {
  for (const bool bad_network : {false, true}) {
    Muster muster(folder_, "run", With({"--rate", "1800", "--drop", bad_network ? "0.1" : "0"}));
    LiveLog log(Run());
    for (const auto& [victim, at] : {std::pair("recorder", 60), std::pair("uav", 130),
                                     std::pair("recorder", 200), std::pair("world", 260)}) {
      ASSERT_TRUE(Eventually([&, tick = at, name = victim] {
        log.Read();
        return (log.tick() >= tick && log.pid(name) > 0) || muster.child().Poll();
      }));
      ASSERT_FALSE(muster.child().Poll()) << muster.output();
      ASSERT_EQ(kill(log.pid(victim), SIGKILL), 0);
    }
    ASSERT_EQ(muster.Wait(), 0) << muster.output();
    const Json report = Report();
    EXPECT_EQ(report["digest"], undisturbed_);
    EXPECT_TRUE(report["log"]["complete"].get<bool>()) << report["log"];
    EXPECT_EQ(report["events"]["process_lost"], 4);
    EXPECT_EQ(report["events"]["process_back"], 4);
    for (const char* file : {"/mission.lcm", "/mission.lcm.1", "/mission.lcm.2"}) {
      EXPECT_EQ(GarbageIn(Run() + file), 0) << file;
    }
    fs::remove_all(Run());
  }
}

TEST_F(RecorderRunTest, KilledStoppedAndWithoutRoomByAPlan) {
  // The loss from the start: while the mission makes up for delays it could be over before a packet
  // comes.
  const Json report = Mission({"--rate", "3600",                               //
                               "--fault", "loss:recorder@0+60=0.5",            //
                               "--fault", "process_killed:recorder@30",        //
                               "--fault", "process_stopped:recorder@70+0.3s",  //
                               "--fault", "disk_full:recorder@90+0.3s",        //
                               "--fault", "partition:recorder|world@110+1s",   //
                               "--fault", "process_killed:lcm-logger@130+0.2s"});
  EXPECT_EQ(report["events"]["process_lost"], 3);
  EXPECT_EQ(report["events"]["process_back"], 3);
  EXPECT_TRUE(fs::exists(Run() + "/mission.lcm.3"));
}

TEST_F(RecorderRunTest, AllAtOnce) {
  std::vector<std::string> faults;
  for (const char* victim : {"world", "uav", "worker", "vehicle", "scheduler", "recorder"}) {
    faults.insert(faults.end(), {"--fault", fmt::format("process_killed:{}@80.5", victim)});
  }
  EXPECT_EQ(Mission(InTime(faults))["events"]["process_lost"], 6);
}

TEST_F(RecorderRunTest, EverybodysPacketsAreLostAndStrangersSpeak) {
  const Json report =
      Mission(InTime({"--fault", "loss:*@30+30=0.2", "--fault", "duplication:*@0=0.1", "--fault",
                      "corruption:recorder@20+20=0.1", "--fault", "foreign:*@10+100"}));
  for (const Json& fault : report["faults"]) EXPECT_GT(fault["packets"], 0) << fault;
}

TEST_F(RecorderRunTest, WhomItHoldsUpIsNotLost) {
  std::vector<std::string> more = GoingOn();
  more.insert(more.end(),
              {"--fault", fmt::format("process_stopped:recorder@60+{}s", 4 * kSlowness)});
  const Json report = Mission(more);
  EXPECT_EQ(report["events"]["process_lost"], 0);
}

TEST_F(RecorderRunTest, SealsAndIsSealed) {
  Muster muster(folder_, "run", With(InTime({"--seal", "--fault", "process_killed:recorder@60"})));
  ASSERT_EQ(muster.Wait(), 0) << muster.output();
  EXPECT_EQ(Report()["digest"], undisturbed_);
  EXPECT_NE(muster.output().find("0 packets without the right tag"), std::string::npos)
      << muster.output();
  Muster audit(folder_, "audit", {"audit", Run(), "--key", Run() + "/seal.key"});
  EXPECT_EQ(audit.Wait(), 0) << audit.output();
}

TEST_F(RecorderRunTest, ASecondOneUnderItsNameIsRefused) {
  Muster muster(folder_, "run",
                With({"--rate", "600", "--lcm-url",
                      MissionUrl(static_cast<std::uint16_t>(20000 + getpid() % 4000 * 10 + 7))}));
  LiveLog log(Run());
  ASSERT_TRUE(Eventually([&] {
    log.Read();
    return (log.tick() >= 3 && log.pid("recorder") > 0) || muster.child().Poll();
  })) << muster.output();
  const Json manifest = Json::parse(TextOf(Run() + "/manifest.json"));
  Child second(
      {"second",
       {(fs::path(MUSTER_PROGRAM).parent_path() / "muster-recorder").string(), "--lcm-url",
        manifest["lcm_url"], "--run-id", std::to_string(manifest["run_id"].get<std::int64_t>()),
        folder_.File("second.lcm")},
       folder_.File("second")});
  ASSERT_TRUE(Eventually([&] { return second.Poll().has_value(); }));
  EXPECT_EQ(second.Poll()->Text(), "exited with code 3");
  EXPECT_NE(TextOf(folder_.File("second")).find("recorder speaks already, pid "),
            std::string::npos);
  muster.child().Signal(SIGINT);
  EXPECT_EQ(muster.Wait(), 130) << muster.output();
}

}  // namespace
}  // namespace muster::tools
