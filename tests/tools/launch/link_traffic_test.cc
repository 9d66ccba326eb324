#include "tools/launch/link_traffic.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::tools {
namespace {

Packet OfSize(std::size_t bytes) { return {"CHANNEL", std::vector<std::uint8_t>(bytes)}; }

Packet From(const std::string& sender, std::size_t text) {
  scenario_t scenario{};
  scenario.header.sender = sender;
  scenario.json = std::string(text, 'x');
  return {std::string(channel::kScenario), Encode(scenario)};
}

TEST(LinkTraffic, CountsTheHeadersOfEachDatagramAndFragment) {
  // 8 of LCM, 8 of the channel, 8 of UDP; 20 of IP and 18 of Ethernet a fragment of 1480.
  EXPECT_EQ(WireBytes(OfSize(100)), 100 + 24 + 38);
  EXPECT_EQ(WireBytes(OfSize(1456)), 1456 + 24 + 38);
  EXPECT_EQ(WireBytes(OfSize(1457)), 1457 + 24 + 2 * 38);
  // Two datagrams of LCM's fragments: 65487 and 34521 bytes with the channel.
  EXPECT_EQ(WireBytes(OfSize(100'000)), 100'008 + 2 * 28 + (45 + 24) * 38);
}

TEST(LinkTraffic, ALinkCarriesWhatItsOwnSayAndWhatAllOthersSay) {
  HostList hosts;
  hosts.hosts = {{"field", "", "field", "", {"uav"}, 1},
                 {"road", "", "road", "", {"vehicle"}, 100}};
  LinkTraffic traffic(hosts, "here");
  const Packet uav = From("uav", 50'000), vehicle = From("vehicle", 10'000),
               world = From("world", 1'000);
  traffic.Add(uav, 5 * kSecondUs);
  traffic.Add(uav, 6 * kSecondUs);
  traffic.Add(vehicle, 6 * kSecondUs);
  traffic.Add(world, 7 * kSecondUs);
  traffic.Add({"OTHER", {1, 2, 3}}, 8 * kSecondUs);
  const auto links = traffic.links();
  ASSERT_EQ(links.size(), 3u);
  EXPECT_EQ(links[0].host, "here");
  EXPECT_EQ(links[0].sent_bytes, WireBytes(world));
  EXPECT_EQ(links[0].heard_bytes, 2 * WireBytes(uav) + WireBytes(vehicle));
  EXPECT_EQ(links[1].sent_bytes, 2 * WireBytes(uav));
  EXPECT_EQ(links[1].heard_bytes, WireBytes(vehicle) + WireBytes(world));
  EXPECT_DOUBLE_EQ(links[1].mean_mbit_s, static_cast<double>(2 * WireBytes(uav)) * 8e-6 / 2);
  EXPECT_DOUBLE_EQ(links[1].busiest_mbit_s, static_cast<double>(WireBytes(uav)) * 8e-6);
  EXPECT_DOUBLE_EQ(links[2].busiest_mbit_s, links[2].mean_mbit_s) << "never less";
  EXPECT_NE(traffic.Text().find("limited by     no link"), std::string::npos) << traffic.Text();
  traffic.Add(From("uav", 200'000), 7 * kSecondUs);
  EXPECT_NE(traffic.Text().find("limited by     the link of field, 12"), std::string::npos)
      << traffic.Text();
}

TEST(LinkTraffic, WithoutRatesNothingIsSaidOfLimits) {
  const HostList hosts;
  LinkTraffic traffic(hosts, "here");
  EXPECT_EQ(traffic.Text(),
            "link here      sent 0.0 MB, heard 0.0 MB; 0.0 Mbit/s, busiest second 0.0\n");
}

}  // namespace
}  // namespace muster::tools
