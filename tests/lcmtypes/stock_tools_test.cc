// LCM's own programs write what we read and play what we write.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/channels.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/temporary_folder.h"

namespace muster {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// A program of LCM, ended with its scope.
class Program {
 public:
  explicit Program(std::vector<std::string> arguments) {
    pid_ = fork();
    if (pid_ != 0) return;
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  ~Program() {
    if (running()) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  bool running() {
    if (ended_) return false;
    ended_ = waitpid(pid_, nullptr, WNOHANG) == pid_;
    return !ended_;
  }

 private:
  pid_t pid_ = -1;
  bool ended_ = false;
};

class StockTools : public ::testing::Test {
 protected:
  void SetUp() override {
    MUSTER_NEEDS_MULTICAST();
    for (const char* program : {"lcm-logger", "lcm-logplayer"}) {
      if (std::system(("command -v " + std::string(program) + " >/dev/null").c_str()) != 0) {
        GTEST_SKIP() << program << " is not in PATH";
      }
    }
  }
  std::string log() const { return folder_.File("log"); }
  /// Of this process, should the tests have to share the host's network with others.
  std::string url() const {
    return MissionUrl(static_cast<std::uint16_t>(20000 + getpid() % 4000 * 10 + 9));
  }

 private:
  const TemporaryFolder folder_;
};

Packet Numbered(std::uint32_t number) {
  Packet packet{std::string(channel::kClock), std::vector<std::uint8_t>(200)};
  for (std::size_t i = 0; i < packet.bytes.size(); ++i) {
    packet.bytes[i] = static_cast<std::uint8_t>(number >> 8 * (i % 4));
  }
  return packet;
}

TEST_F(StockTools, LcmLoggersFileIsFollowedWhileItGrows) {
  Program logger({"lcm-logger", "-q", "--flush-interval=1", "--lcm-url=" + url(), log()});
  LcmBus bus(url());
  const auto deadline = Clock::now() + std::chrono::seconds(60);
  while (!fs::exists(log()) && Clock::now() < deadline) bus.Receive(1000);
  EventLogReader reader(log(), EventLogReader::Tail::kMayGrow);
  // The logger writes its buffer only when the next message comes late enough.
  std::vector<Packet> sent;
  std::vector<Packet> logged;
  while (logged.size() < 50 && Clock::now() < deadline && logger.running()) {
    sent.push_back(Numbered(static_cast<std::uint32_t>(sent.size())));
    bus.Publish(sent.back());
    bus.Receive(2000);
    while (auto event = reader.Next()) {
      if (event->packet.channel != channel::kClock) continue;
      EXPECT_GT(event->received_us, 1'600'000'000'000'000);
      logged.push_back(std::move(event->packet));
    }
  }
  ASSERT_GE(logged.size(), 50u);
  EXPECT_EQ(reader.garbage_bytes(), 0);
  // It starts late and may lose some: what it has is whole and in order.
  auto next = sent.begin();
  for (const Packet& packet : logged) {
    next = std::find(next, sent.end(), packet);
    ASSERT_NE(next, sent.end());
    ++next;
  }
}

TEST_F(StockTools, LcmLogplayerPlaysWhatTheWriterWrote) {
  std::vector<Packet> written;
  {
    EventLogWriter writer(log());
    for (std::uint32_t i = 0; i < 20; ++i) {
      written.push_back(Numbered(i));
      writer.Write(1'700'000'000'000'000 + 1000 * std::int64_t{i}, written.back());
    }
    written.push_back({std::string(channel::kScenario), std::vector<std::uint8_t>(300'000, 5)});
    writer.Write(1'700'000'000'100'000, written.back());
    writer.Flush();
  }
  LcmBus bus(url());
  Program player({"lcm-logplayer", "--lcm-url=" + url(), log()});
  std::vector<Packet> played;
  const auto deadline = Clock::now() + std::chrono::seconds(60);
  while (played.size() < written.size() && Clock::now() < deadline) {
    for (Packet& packet : bus.Receive(100'000)) played.push_back(std::move(packet));
  }
  EXPECT_EQ(played, written);
}

}  // namespace
}  // namespace muster
