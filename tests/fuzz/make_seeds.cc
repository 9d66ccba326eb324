// make_seeds DIR: writes the fuzzers' first inputs, a folder a fuzzer.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>

#include "lcmtypes/bus/event_log.h"
#include "simulation/simulator.h"
#include "tests/fuzz/fuzz_mission.h"
#include "tests/lcmtypes/sample_messages.h"

namespace {

void Write(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

void WriteAll(const std::filesystem::path& folder) {
  using namespace muster;
  for (const char* name : {"codec", "event_log", "fault_plan", "hosts", "mission", "run",
                           "scenario", "solution", "table"}) {
    std::filesystem::remove_all(folder / name);  // an older version's
  }
  std::filesystem::create_directories(folder / "event_log");
  EventLogWriter log((folder / "event_log" / "all").string());
  const auto write = [&](const auto& message) {
    const std::vector<std::uint8_t> bytes = Encode(message);
    Write(folder / "codec" / message.getTypeName(), std::string(bytes.begin(), bytes.end()));
    log.Write(1, {"MUSTER_CLOCK", bytes});
  };
  std::apply([&](const auto&... messages) { (write(messages), ...); }, SampleMessages());
  log.Flush();

  const std::string json = fuzz::SmallMission();
  Write(folder / "scenario" / "small", json);

  std::string packets, all_packets;
  int tick = 0;
  tools::Simulate(json, "greedy-nearest", [&](const Packet& packet) {
    fuzz::AppendPacket(packet, &packets);
    fuzz::AppendPacket(packet, &all_packets);
    if (packet.channel != channel::kClock) return;
    Write(folder / "mission" / std::to_string(++tick), packets);
    packets.clear();
  });

  Write(folder / "run" / "all", all_packets);

  Write(folder / "hosts" / "two", R"({"version": 1,
    "lcm_url": "udpm://239.255.76.67:7667?ttl=1&recv_buf_size=2097152", "hosts": [
    {"name": "field", "ssh": "a@field", "folder": "/opt/bin", "processes": ["uav", "worker"]},
    {"name": "room", "netns": "room", "processes": ["scheduler"]}]})");
  Write(folder / "solution" / "indicator", "0\n1\n0\n0\n1\n0\n0\n0\n0\n0\n0\n1\n");
  Write(folder / "solution" / "nodes", "1 4\n11\n");
  Write(folder / "solution" / "mps", "# optimal\nn1 1\nn2 0\nn11 0.99999\n");
  Write(folder / "fault_plan" / "file", R"({"version": 1, "faults": [
    {"kind": "loss", "target": "*", "at_min": 3, "for_min": 10, "probability": 0.3},
    {"kind": "partition", "target": "uav|world", "at_min": 20, "for_s": 2, "id": "cut"},
    {"kind": "delay", "target": "uav", "at_min": 0.5, "delay_ms": 20},
    {"kind": "agent_silent", "target": "uav:1", "at_min": 5, "for_min": 10}]})");
  Write(folder / "fault_plan" / "flag", "loss:uav@3+10=0.3");
  Write(folder / "table" / "comma",
        "lat,lon,when\n1.5,2.5,2010-01-12 08:30:05\n\"1\",2,\"9:05 PM\"");
  Write(folder / "table" / "semicolon", "\xef\xbb\xbflatitude;longitude\n1;2\n");
  Write(folder / "table" / "geojson", R"({"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"name": "a", "n": 1, "ok": true, "none": null},
     "geometry": {"type": "Point", "coordinates": [2.5, 1.5]}},
    {"type": "Feature", "properties": null, "geometry": {"type": "Polygon", "coordinates": []}}]})");
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_seeds DIR\n");
    return 2;
  }
  WriteAll(argv[1]);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "make_seeds: %s\n", error.what());
  return 1;
}
