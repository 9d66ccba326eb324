// A mission whose network goes away and comes back, in a network of the test's own.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "lcmtypes/bus/multicast.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "tests/lcmtypes/test_network.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;
using std::chrono::seconds;

void Ip(const std::string& arguments) {
  EXPECT_EQ(std::system(("ip " + arguments).c_str()), 0) << arguments;
}

/// What is taken away for a while, and how it comes back.
struct Outage {
  const char* name;
  void (*take)();
  void (*put_back)();
};
constexpr Outage kOutages[] = {
    {"Route", [] { Ip("route del 224.0.0.0/4"); }, [] { Ip("route add 224.0.0.0/4 dev lo"); }},
    // Its routes go with it.
    {"Loopback", [] { Ip("link set lo down"); },
     [] {
       Ip("link set lo up");
       Ip("route add 224.0.0.0/4 dev lo");
     }},
    // Another of the same name: no socket is a member of the group on it.
    {"Interface", [] { Ip("link del muster0"); },
     [] {
       Ip("link add muster0 type veth peer name muster1");
       Ip("link set muster0 up");
       Ip("link set muster1 up");
       Ip("addr add 10.76.1.1/24 dev muster0");
       Ip("route add 224.0.0.0/4 dev muster0");
     }},
};

struct Case {
  const Outage* outage;
  const char* on_loss;
  int lasts_s;
};

std::vector<Case> CasesThatLast(std::initializer_list<int> lengths_s) {
  std::vector<Case> cases;
  for (const Outage& outage : kOutages) {
    for (const char* on_loss : {"wait", "continue"}) {
      for (const int lasts_s : lengths_s) cases.push_back({&outage, on_loss, lasts_s});
    }
  }
  return cases;
}

class NetworkOutageTest : public ::testing::TestWithParam<Case> {
 protected:
  void ExpectNothingChanges();
  void SetUp() override {
    if (TestNetwork().kind != Network::Kind::kPrivate) GTEST_SKIP() << "no network of its own";
    if (std::system("ip route >/dev/null 2>&1") != 0) GTEST_SKIP() << "no ip(8)";
    std::ofstream(scenario_) << ScenarioToJson(Generate(PresetByName("Random_1"), 1));
  }
  Muster Start(std::vector<std::string> more) const {
    more.insert(more.begin(), {"run", scenario_, "--policy", "mpq", "--rate", "1800", "--lcm-url",
                               MissionUrl(port_), "--out", folder_.File("run")});
    return Muster(folder_, "run", more);
  }
  static bool Says(Muster* muster, std::string_view what) {
    return Eventually(
        [&] { return muster->output().find(what) != std::string::npos || muster->child().Poll(); });
  }
  Json Report(const std::string& name) const {
    return Json::parse(TextOf(folder_.File(name) + "/report.json"), nullptr, false);
  }

  const std::uint16_t port_ = static_cast<std::uint16_t>(20000 + getpid() % 4000 * 10 + 3);
  TemporaryFolder folder_;
  std::string scenario_ = folder_.File("scenario.json");
};

int Count(const std::string& text, std::string_view part) {
  int n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++n;
  return n;
}

void NetworkOutageTest::ExpectNothingChanges() {
  const auto [outage, on_loss, lasts_s] = GetParam();
  const bool other = outage == &kOutages[2];
  if (other) {
    Ip("route del 224.0.0.0/4");
    outage->put_back();
  }
  Muster muster = Start({"--on-loss", on_loss, "--lost-after", "0.5"});
  ASSERT_TRUE(Says(&muster, "tick ")) << muster.output();
  outage->take();
  ASSERT_TRUE(Says(&muster, "the network is gone")) << muster.output();
  std::this_thread::sleep_for(seconds(lasts_s));  // so long it is gone
  outage->put_back();
  EXPECT_EQ(muster.Wait(std::chrono::minutes(3)), 0) << muster.output();
  if (other) {
    Ip("link del muster0");
    Ip("route add 224.0.0.0/4 dev lo");
  }
  EXPECT_EQ(Count(muster.output(), "the network is gone"), 1) << muster.output();
  EXPECT_EQ(Count(muster.output(), "the network is back"), 1) << muster.output();
  const std::string world = TextOf(folder_.File("run") + "/world.stderr");
  EXPECT_EQ(Count(world, "world: the network is gone"), 1) << world;
  Muster simulated(folder_, "simulated",
                   {"simulate", scenario_, "--policy", "mpq", "--out", folder_.File("virtual")});
  ASSERT_EQ(simulated.Wait(), 0) << simulated.output();
  EXPECT_EQ(Report("run")["digest"], Report("virtual")["digest"]) << muster.output();
}

std::string NameOf(const ::testing::TestParamInfo<Case>& test) {
  const auto [outage, on_loss, lasts_s] = test.param;
  return fmt::format("{}_{}_{}s", outage->name, on_loss, lasts_s);
}

TEST_P(NetworkOutageTest, ChangesNothing) { ExpectNothingChanges(); }

INSTANTIATE_TEST_SUITE_P(Kinds, NetworkOutageTest, ::testing::ValuesIn(CasesThatLast({1})), NameOf);

class LongNetworkOutageTest : public NetworkOutageTest {};

TEST_P(LongNetworkOutageTest, ChangesNothing) { ExpectNothingChanges(); }

INSTANTIATE_TEST_SUITE_P(Kinds, LongNetworkOutageTest, ::testing::ValuesIn(CasesThatLast({5, 30})),
                         NameOf);

class NetworkLossTest : public NetworkOutageTest {};

TEST_P(NetworkLossTest, EndsTheMissionWithAReport) {
  Muster muster = Start({"--restarts", "0"});
  ASSERT_TRUE(Says(&muster, "tick ")) << muster.output();
  GetParam().outage->take();
  EXPECT_EQ(muster.Wait(), 3) << muster.output();
  GetParam().outage->put_back();
  EXPECT_NE(muster.output().find("muster: the network has been gone for 10 s: Network is unreach"),
            std::string::npos)
      << muster.output();
  EXPECT_FALSE(Report("run")["log"]["complete"].get<bool>());
  EXPECT_NE(muster.output().find("NOT COMPLETE"), std::string::npos) << muster.output();
}

INSTANTIATE_TEST_SUITE_P(Kinds, NetworkLossTest, ::testing::Values(Case{&kOutages[0], "wait", 0}),
                         [](const auto& test) { return test.param.outage->name; });

}  // namespace
}  // namespace muster::tools
