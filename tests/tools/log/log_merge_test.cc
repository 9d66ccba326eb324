#include "tools/log/log_merge.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/random.h"
#include "lcmtypes/bus/event_log.h"
#include "tests/temporary_folder.h"
#include "tests/tools/fake_mission.h"
#include "tools/log/log_source.h"

namespace muster::tools {
namespace {

class LogMerge : public ::testing::Test {
 protected:
  std::string Log(const std::string& name, const std::vector<Packet>& packets) const {
    EventLogWriter writer(folder_.File(name));
    for (const Packet& packet : packets) writer.Write(1, packet);
    writer.Flush();
    return folder_.File(name);
  }
  std::vector<Packet> Merged(const std::vector<std::string>& logs) const {
    const std::string out = folder_.File("merged");
    std::filesystem::remove(out);
    result_ = MergeLogs(logs, out);
    LogSource source(out);
    std::vector<Packet> packets;
    while (auto message = source.Next()) packets.push_back(std::move(message->packet));
    return packets;
  }

  const TemporaryFolder folder_;
  const std::vector<Packet> all_ = Encoded(MakeFakeMission());
  mutable MergeResult result_;
};

TEST_F(LogMerge, TheFirstUntilItEndsThenTheOther) {
  const std::string a = Log("a", {all_.begin(), all_.begin() + 60});
  const std::string b = Log("b", {all_.begin() + 40, all_.end()});
  EXPECT_EQ(Merged({a, b}), all_);
  EXPECT_EQ(result_.added, (std::vector<std::int64_t>{60, std::ssize(all_) - 60}));
  EXPECT_EQ(Merged({b, a}), all_);
}

TEST_F(LogMerge, HolesAreFilledWhereTheyAre) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Random random(seed, Stream::kTest);
    std::vector<Packet> parts[3];
    for (const Packet& packet : all_) {
      const std::uint32_t sure = random.Below(3);
      for (std::uint32_t i = 0; i < 3; ++i) {
        if (i != sure && random.Below(4) == 0) continue;
        parts[i].push_back(packet);
        if (random.Below(8) == 0) parts[i].push_back(packet);  // a repeat
      }
    }
    std::vector<std::string> logs;
    for (int i = 0; i < 3; ++i) {
      logs.push_back(folder_.File(fmt::format("{}-{}", seed, i)));
      Log(fmt::format("{}-{}", seed, i), parts[i]);
    }
    std::vector<Packet> merged = Merged(logs);
    EXPECT_EQ(result_.written, std::ssize(all_));
    // Two messages that only logs after the first have, and that no log has both of, may change
    // places.
    const auto less = [](const Packet& a, const Packet& b) { return a.bytes < b.bytes; };
    std::vector<Packet> wanted = all_;
    std::sort(merged.begin(), merged.end(), less);
    std::sort(wanted.begin(), wanted.end(), less);
    EXPECT_EQ(merged, wanted);
  }
}

TEST_F(LogMerge, AnotherMissionIsRefusedAndNothingIsWritten) {
  FakeLog other = MakeFakeMission();
  for (FakeMessage& message : other) message.header().run_id = 99;
  const std::string a = Log("a", all_);
  const std::string b = Log("b", Encoded(other));
  try {
    MergeLogs({a, b}, folder_.File("out"));
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("b: run_id: found 99, expected"), std::string::npos)
        << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.File("out")));
  EXPECT_THROW(MergeLogs({a}, a), InputError);
}

}  // namespace
}  // namespace muster::tools
