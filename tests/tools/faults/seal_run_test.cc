// Sealed missions by the real `muster run`: who has not the key changes nothing.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/bus/member_keys.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "protocol/inbox.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Of a mission among much else that this host does.
constexpr std::chrono::minutes kLongest{3};

/// A file as it is, with all its bytes.
std::string BytesOf(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class SealRunTest : public ::testing::Test {
 protected:
  void SetUp() override {
    MUSTER_NEEDS_MULTICAST();
    std::ofstream(scenario_) << ScenarioToJson(Generate(PresetByName("Random_1"), 1));
    Muster simulated(folder_, "simulated",
                     {"simulate", scenario_, "--policy", "mpq", "--out", folder_.File("virtual")});
    ASSERT_EQ(simulated.Wait(kLongest), 0) << simulated.output();
    expected_ = Report("virtual")["digest"];
  }
  Muster Start(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"run",   scenario_, "--policy",  "mpq",
                                          "--out", Run(),     "--lcm-url", MissionUrl(port_)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Muster(folder_, "run", arguments);
  }
  std::string Run() const { return folder_.File("run"); }
  std::string KeyFile() const { return Run() + "/seal.key"; }
  Json Report(const std::string& name = "run") const {
    return Json::parse(TextOf(folder_.File(name) + "/report.json"), nullptr, false);
  }
  /// What that command says of it, and its exit code.
  std::pair<std::string, int> Ask(const std::vector<std::string>& arguments) const {
    Muster muster(folder_, "asked", arguments);
    const int code = muster.Wait(kLongest);
    return {muster.output(), code};
  }
  std::string WriteKey() const {
    const std::string file = folder_.File("mission.key");
    std::ofstream(file) << std::string(64, 'a') << "\n";
    EXPECT_EQ(chmod(file.c_str(), 0600), 0);
    return file;
  }
  static bool UnderWay(Muster* muster) {
    return Eventually([&] {
      return muster->output().find("tick ") != std::string::npos || muster->child().Poll();
    });
  }

  const std::uint16_t port_ = static_cast<std::uint16_t>(20000 + getpid() % 4000 * 10 + 8);
  TemporaryFolder folder_;
  std::string scenario_ = folder_.File("scenario.json");
  Json expected_;
};

/// Command lines and environments of all processes that this one may look at, and their files.
std::string SeenOfProcesses() {
  std::string seen;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/proc", ignored)) {
    if (entry.path().filename().string().find_first_not_of("0123456789") != std::string::npos) {
      continue;
    }
    seen += BytesOf(entry.path() / "cmdline") + BytesOf(entry.path() / "environ");
  }
  return seen;
}

TEST_F(SealRunTest, DecidesAsWithoutAndKeepsItsKey) {
  Muster muster = Start({"--seal", "--rate", "3600", "--fault", "process_killed:uav@60"});
  ASSERT_TRUE(UnderWay(&muster)) << muster.output();
  const std::string key = TextOf(KeyFile()).substr(0, 64);
  ASSERT_EQ(key.size(), 64U);
  const std::string seen = SeenOfProcesses();
  EXPECT_NE(seen.find("--key"), std::string::npos);
  EXPECT_EQ(seen.find(key), std::string::npos);
  ASSERT_EQ(muster.Wait(kLongest), 0) << muster.output();
  EXPECT_EQ(Report()["digest"], expected_);
  EXPECT_NE(muster.output().find("sealed         0 packets without the right tag refused"),
            std::string::npos)
      << muster.output();
  struct stat status {};
  ASSERT_EQ(stat(KeyFile().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  std::string raw;
  for (std::size_t i = 0; i < key.size(); i += 2) {
    raw += static_cast<char>(std::stoi(key.substr(i, 2), nullptr, 16));
  }
  for (const auto& entry : fs::directory_iterator(Run())) {
    if (entry.path() == KeyFile()) continue;
    const std::string bytes = BytesOf(entry.path());
    EXPECT_EQ(bytes.find(key), std::string::npos) << entry.path();
    EXPECT_EQ(bytes.find(raw), std::string::npos) << entry.path();
  }
}

TEST_F(SealRunTest, ItsLogIsReadWithoutTheKeyAndProvenWithIt) {
  Muster muster = Start({"--key", WriteKey()});
  ASSERT_EQ(muster.Wait(kLongest), 0) << muster.output();
  EXPECT_EQ(Report()["digest"], expected_);
  const auto [info, info_code] = Ask({"log", "info", Run()});
  EXPECT_EQ(info_code, 0);
  EXPECT_NE(info.find(" messages have a tag\n"), std::string::npos) << info;
  for (const std::string& key : {KeyFile(), WriteKey()}) {
    const auto [said, code] = Ask({"audit", Run(), "--key", key});
    EXPECT_EQ(code, 0) << said;
    EXPECT_NE(said.find(" messages have the right tag\n"), std::string::npos) << said;
  }
  // Nothing is needed to read it.
  const std::string log = folder_.File("alone.lcm");
  fs::copy_file(Run() + "/mission.lcm", log);
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"audit", log}, {"redecide", log}, {"log", "info", log}}) {
    const auto [said, code] = Ask(command);
    EXPECT_EQ(code, 0) << command.front() << said;
  }
  // Copies keep the tags.
  const std::string copy = folder_.File("copy.lcm");
  EXPECT_EQ(Ask({"log", "repair", log, "--out", copy}).second, 0);
  EXPECT_EQ(Ask({"audit", copy, "--key", KeyFile()}).second, 0);
}

TEST_F(SealRunTest, TheFirstMessageThatWasChangedIsNamed) {
  Muster muster = Start({"--seal"});
  ASSERT_EQ(muster.Wait(kLongest), 0) << muster.output();
  const std::string forged = folder_.File("forged.lcm");
  {
    EventLogReader reader(Run() + "/mission.lcm", EventLogReader::Tail::kFinal);
    EventLogWriter writer(forged);
    while (auto event = reader.Next()) {
      if (auto world = DecodeValid<world_state_t>(event->packet.bytes); world && world->tick == 9) {
        world->done += 1;
        event->packet.bytes = Encode(*world);
      }
      writer.Write(event->received_us, WithTag(event->packet, event->tag));
    }
    writer.Flush();
  }
  const auto [said, code] = Ask({"audit", forged, "--key", KeyFile()});
  EXPECT_EQ(code, 4) << said;
  EXPECT_NE(said.find("seal: "), std::string::npos) << said;
  EXPECT_NE(said.find("on MUSTER_WORLD, which says that it is of world (start 0, seq "),
            std::string::npos)
      << said;
  const auto [other, other_code] = Ask({"audit", Run(), "--key", WriteKey()});
  EXPECT_EQ(other_code, 4) << "another key: " << other;
}

TEST_F(SealRunTest, DamagedPacketsAreRefused) {
  Muster muster = Start({"--seal", "--quiet", "--rate", "3600", "--fault", "corruption:*@30+60=0.2",
                         "--fault", "loss:uav@50+30=0.2", "--fault", "process_killed:world@45"});
  ASSERT_EQ(muster.Wait(kLongest), 0) << muster.output();
  EXPECT_EQ(Report()["digest"], expected_);
  std::int64_t rejected = 0;
  const Json report = Report();
  for (const Json& process : report["processes"]) {
    rejected += process["rejected"].get<std::int64_t>();
  }
  EXPECT_GT(rejected, 0);
}

/// What is sent of a lie, given the tag of what was said.
using Sealing = std::function<std::vector<Packet>(const Packet& lie, const Tag& tag)>;

/// Speaks for every role: what it hears of them, changed.
class Impostor {
 public:
  /// `most`: lies of one sender on one channel, older and newer ones.
  Impostor(const std::string& url, int most, Sealing sealing)
      : bus_(url, kMostTagBytes), most_(most), sealing_(std::move(sealing)) {}

  /// Hears and speaks for a moment.
  void Turn() {
    for (Packet& packet : bus_.Receive(20'000)) {
      const Tag tag = CutTag(&packet);
      std::optional<Message> message = DecodeMessage(packet);
      if (!message || tag.empty()) continue;  // what is its own has none, or a wrong one
      const std::string sender = HeaderOf(*message).sender;
      if (++told_[{sender, packet.channel}] > most_) continue;
      for (const bool newer : {false, true}) {
        const Packet lie = Changed(*message, packet.channel, newer);
        for (const Packet& sent : sealing_(lie, tag)) bus_.Publish(sent);
      }
      senders_.insert(sender);
    }
  }
  const std::set<std::string>& senders() const { return senders_; }

 private:
  static void Twist(clock_t* m) { m->phase = NumberOf(ClockPhase::kEnded); }
  static void Twist(world_state_t* m) {
    for (std::int8_t& status : m->task_status) status = NumberOf(TaskStatus::kDone);
    m->done = m->n_tasks;
  }
  static void Twist(agent_states_t* m) {
    for (agent_t& agent : m->agents) agent.x_m += 100;
  }
  static void Twist(schedule_t* m) { m->actions.clear(), m->n = 0; }
  static void Twist(process_status_t* m) { m->state = NumberOf(ProcessState::kEnded); }
  static void Twist(log_status_t* m) {
    for (log_mark_t& mark : m->marks) mark.next_seq += 1000;
  }
  template <class T>
  static void Twist(T*) {}

  static Packet Changed(Message message, const std::string& channel, bool newer) {
    return std::visit(
        [&](auto m) {
          Twist(&m);
          if (newer) m.header.seq += 1;
          return Packet{channel, Encode(m)};
        },
        std::move(message));
  }

  LcmBus bus_;
  const int most_;
  Sealing sealing_;
  std::map<std::pair<std::string, std::string>, int> told_;
  std::set<std::string> senders_;
};

TEST_F(SealRunTest, AnImpostorOfEachRoleChangesNothingAndIsNamed) {
  Muster muster = Start({"--seal", "--quiet", "--rate", "3600"});
  // Without a tag, with a tag of no key, and with the tag of what was said.
  Impostor impostor(MissionUrl(port_), 200, [](const Packet& lie, const Tag& tag) {
    return std::vector{lie, WithTag(lie, Tag(kTagBytes, 0x55)), WithTag(lie, tag)};
  });
  while (!muster.child().Poll()) impostor.Turn();
  ASSERT_EQ(muster.Wait(kLongest), 0) << muster.output();
  EXPECT_EQ(impostor.senders(), (std::set<std::string>{"launcher", "recorder", "scheduler", "uav",
                                                       "vehicle", "worker", "world"}));
  EXPECT_EQ(Report()["digest"], expected_);
  EXPECT_NE(muster.output().find("of somebody without its key, or damaged; the newest, on MUSTER_"),
            std::string::npos)
      << muster.output();
  const Json report = Report();
  for (const Json& process : report["processes"]) {
    EXPECT_GT(process["rejected"].get<std::int64_t>(), 100) << process;
  }
  const auto [said, code] = Ask({"audit", Run()});
  EXPECT_EQ(code, 0) << said;
  EXPECT_NE(said.find(" without it left out, the first: "), std::string::npos) << said;
}

/// Signs whatever is said with that process's key.
Sealing SealingOfThief(const std::string& key_file, const std::string& stolen) {
  Json keys = Json::parse(TextOf(key_file));
  const Json key = keys["members"][stolen];
  for (Json& member : keys["members"]) member = key;
  const auto thief = std::make_shared<const MemberKeys>(MemberKeys::Parse(keys.dump(), key_file));
  return [thief, stolen](const Packet& lie, const Tag&) {
    std::vector<Packet> sent = {WithTag(lie, thief->Sign(lie))};
    const std::string& name = lie.channel;
    // What a process says of itself is its own to say.
    if (name == channel::kProcess || name == channel::kRequest || name == channel::kWorkers ||
        name == channel::kWorkerChanges) {
      return DecodeHeader(lie)->sender == stolen ? std::vector<Packet>() : sent;
    }
    std::optional<Message> message = DecodeMessage(lie);
    if (!message) return sent;
    const Packet as_itself = std::visit(
        [&](auto m) {
          m.header.sender = stolen;
          return Packet{name, Encode(m)};
        },
        *std::move(message));
    sent.push_back(WithTag(as_itself, thief->Sign(as_itself)));
    return sent;
  };
}

TEST_F(SealRunTest, SealedPerProcessAStolenKeySpeaksForNobodyElse) {
  Muster muster =
      Start({"--seal", "per-process", "--quiet", "--rate", "3600", "--processes", "uav=2"});
  const std::string key_file = Run() + "/keys/worker.key";
  ASSERT_TRUE(Eventually([&] { return fs::exists(key_file) || muster.child().Poll(); }));
  Impostor impostor(MissionUrl(port_), 20, SealingOfThief(key_file, "worker"));
  while (!muster.child().Poll()) impostor.Turn();
  ASSERT_EQ(muster.Wait(kLongest), 0) << muster.output();
  EXPECT_TRUE(impostor.senders().contains("world"));
  EXPECT_TRUE(impostor.senders().contains("scheduler"));
  EXPECT_EQ(Report()["digest"], expected_);
  const auto [said, code] = Ask({"audit", Run()});
  EXPECT_EQ(code, 0) << said;
  EXPECT_NE(said.find(" without it left out, the first: "), std::string::npos) << said;
  const auto [proof, proof_code] = Ask({"audit", Run(), "--key", Run() + "/seal.public"});
  EXPECT_EQ(proof_code, 4) << "as proof, what the thief has sent counts" << proof;
}

TEST_F(SealRunTest, SealedPerProcessAllComeBackAndTheLogIsProvenWithoutASecret) {
  Muster muster = Start({"--seal", "per-process", "--quiet", "--second-log", folder_.File("second"),
                         "--rate", "3600", "--fault", "process_killed:world@40", "--fault",
                         "process_killed:worker@80", "--fault", "process_killed:recorder@120"});
  ASSERT_EQ(muster.Wait(kLongest), 0) << muster.output();
  EXPECT_EQ(Report()["digest"], expected_);
  EXPECT_NE(muster.output().find("sealed         0 packets without the right tag refused"),
            std::string::npos)
      << muster.output();
  const std::string key = WriteKey();
  for (const std::string& proof : {Run() + "/seal.public", KeyFile()}) {
    const auto [said, code] = Ask({"audit", Run(), "--key", proof});
    EXPECT_EQ(code, 0) << said;
    EXPECT_NE(said.find(" messages have the right tag\n"), std::string::npos) << said;
  }
  const auto [said, code] = Ask({"audit", Run(), "--key", key});
  EXPECT_EQ(code, 2) << said;
  EXPECT_NE(said.find("seal.public: members: found keys that are not of this mission"),
            std::string::npos)
      << said;
  const Json keys = Json::parse(TextOf(Run() + "/seal.public"));
  Child wrong({"wrong",
               {(fs::path(MUSTER_PROGRAM).parent_path() / "muster-worker").string(), "--run-id",
                keys["run_id"].dump(), "--key", Run() + "/keys/uav.key"},
               folder_.File("wrong")});
  ASSERT_TRUE(Eventually([&] { return wrong.Poll().has_value(); }));
  EXPECT_NE(TextOf(folder_.File("wrong")).find("found a key of another process"), std::string::npos)
      << TextOf(folder_.File("wrong"));
  struct stat status {};
  ASSERT_EQ(stat((Run() + "/keys/uav.key").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
}

TEST_F(SealRunTest, OverSshTheKeyComesByStdin) {
  const std::string ssh = folder_.File("ssh");
  std::ofstream(ssh) << "#!/bin/sh\nfor last; do :; done\nexec sh -c \"$last\"\n";
  ASSERT_EQ(chmod(ssh.c_str(), 0700), 0);
  setenv("PATH", (folder_.path().string() + ":" + std::getenv("PATH")).c_str(), 1);
  std::ofstream(folder_.File("hosts.json")) << Json{
      {"version", 1},
      {"lcm_url", MissionUrl(port_, 1)},
      {"hosts", {{{"name", "there"}, {"ssh", "there"}, {"processes", {"uav", "scheduler"}}}}}};
  Muster muster(folder_, "run",
                {"run", scenario_, "--policy", "mpq", "--out", Run(), "--rate", "3600", "--hosts",
                 folder_.File("hosts.json")});
  ASSERT_TRUE(UnderWay(&muster)) << muster.output();
  const std::string seen = SeenOfProcesses();
  ASSERT_EQ(muster.Wait(kLongest), 0) << muster.output();
  EXPECT_EQ(Report()["digest"], expected_);
  const std::string key = TextOf(KeyFile()).substr(0, 64);
  ASSERT_EQ(key.size(), 64U) << "sealed by default";
  EXPECT_EQ(seen.find(key), std::string::npos);
}

TEST_F(SealRunTest, AProcessStartedByHandNeedsTheKey) {
  Muster muster = Start({"--seal", "--processes", "uav=0"});
  const std::string lead = "start yourself: ";
  ASSERT_TRUE(Eventually([&] {
    return muster.output().find("--key '") != std::string::npos || muster.child().Poll();
  })) << muster.output();
  const std::string said = muster.output();
  const std::size_t begin = said.find(lead) + lead.size();
  const std::string command = said.substr(begin, said.find('\n', begin) - begin);
  const std::string without = command.substr(0, command.find(" --key"));
  Child deaf({"uav", {"/bin/sh", "-c", "exec " + without}, folder_.File("deaf")});
  ASSERT_TRUE(Eventually([&] {
    return muster.output().find("without the mission's tag") != std::string::npos;
  })) << muster.output();
  EXPECT_NE(muster.output().find("says that it is of uav"), std::string::npos) << muster.output();
  Child uav({"uav", {"/bin/sh", "-c", "exec " + command}, folder_.File("uav")});
  EXPECT_EQ(muster.Wait(kLongest), 0) << muster.output() << TextOf(folder_.File("uav"));
  EXPECT_EQ(Report()["digest"], expected_);
}

}  // namespace
}  // namespace muster::tools
