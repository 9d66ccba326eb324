#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "base/check.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "protocol/mission_reader.h"
#include "simulation/simulator.h"
#include "tests/temporary_folder.h"
#include "tests/tools/fake_mission.h"
#include "tests/tools/trials/road_missions.h"
#include "tools/audit/auditor.h"
#include "tools/files/log_files.h"
#include "tools/log/export.h"
#include "tools/log/log_edit.h"
#include "tools/log/log_info.h"
#include "tools/log/mission_stream.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

class LogTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_.File(name); }
  void WriteLog(const std::string& name, const std::vector<Packet>& packets) const {
    EventLogWriter writer(Path(name));
    for (std::size_t i = 0; i < packets.size(); ++i) {
      writer.Write(1'000'000 + static_cast<std::int64_t>(i), packets[i]);
    }
    writer.Flush();
  }
  static std::vector<Packet> ReadLog(const std::string& path) {
    LogSource source(path);
    std::vector<Packet> packets;
    while (auto message = source.Next()) packets.push_back(std::move(message->packet));
    return packets;
  }
  std::string Text(const std::string& name) const {
    std::ifstream file(Path(name), std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }
  std::vector<std::string> Lines(const std::string& name) const {
    std::vector<std::string> lines;
    std::stringstream text(Text(name));
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }

  const TemporaryFolder folder_;
  const std::vector<Packet> packets_ = Encoded(MakeFakeMission());
};

TEST_F(LogTest, ReadsTheFilesOfARunInOrderAndAgain) {
  WriteLog("mission.lcm", {packets_.begin(), packets_.begin() + 50});
  WriteLog("mission.lcm.1", {packets_.begin() + 50, packets_.end()});
  EXPECT_EQ(ReadLog(folder_.path().string()), packets_);
  LogSource source(folder_.path().string());
  while (source.Next()) {
  }
  EXPECT_EQ(source.file(), 1u);
  source.Rewind();
  EXPECT_EQ(source.Next()->packet, packets_[0]);
  EXPECT_THROW(LogFilesOf(Path("none")), InputError);
  fs::create_directory(Path("empty"));
  EXPECT_THROW(LogFilesOf(Path("empty")), InputError);
}

TEST_F(LogTest, InfoCountsRepeatsGapsAndGarbage) {
  std::vector<Packet> packets = packets_;
  packets.push_back(packets_[7]);
  packets.push_back({"CAMERA", {1, 2, 3}});
  packets.push_back({std::string(channel::kClock), {9}});
  std::erase(packets, packets_[20]);
  WriteLog("mission.lcm", packets);
  std::ofstream(Path("mission.lcm"), std::ios::app) << "torn";
  const LogInfo info = ReadLogInfo(folder_.path().string());
  EXPECT_EQ(info.messages, static_cast<std::int64_t>(packets.size()));
  EXPECT_EQ(info.garbage_bytes, 4);
  EXPECT_EQ(info.channels.at("CAMERA").bytes, 3);
  EXPECT_EQ(info.channels.at("MUSTER_CLOCK").undecodable, 1);
  EXPECT_EQ(info.channels.at("MUSTER_SCHEDULE").messages, 3);
  EXPECT_EQ(info.channels.at("MUSTER_SCHEDULE").last_sim_us, 20 * kMinuteUs);
  std::int64_t repeats = 0, missing = 0;
  for (const auto& [key, sender] : info.senders) {
    EXPECT_EQ(std::get<0>(key), 7);
    repeats += sender.repeats;
    for (const auto& gap : sender.Gaps()) missing += gap.last - gap.first + 1;
  }
  EXPECT_EQ(info.senders.size(), 5u);
  EXPECT_EQ(repeats, 1);
  EXPECT_EQ(missing, 1);
  EXPECT_NE(ToText(info).find("MUSTER_SCHEDULE"), std::string::npos);
  EXPECT_EQ(ToJson(info)["senders"].size(), 5u);
}

TEST_F(LogTest, RepairMakesADamagedLogPassTheAudit) {
  // A logger that was killed: a torn tail, then a second file that says some things again.
  WriteLog("mission.lcm", {packets_.begin(), packets_.begin() + 90});
  fs::resize_file(Path("mission.lcm"), fs::file_size(Path("mission.lcm")) - 5);
  std::vector<Packet> rest(packets_.begin() + 80, packets_.end());
  rest.push_back({std::string(channel::kClock), {1, 2}});
  WriteLog("mission.lcm.1", rest);
  LogSource source(folder_.path().string());
  const EditResult result = RepairLog(&source, Path("repaired.lcm"));
  EXPECT_EQ(result.written, static_cast<std::int64_t>(packets_.size()));
  EXPECT_GT(source.garbage_bytes(), 0);
  EXPECT_EQ(ReadLog(Path("repaired.lcm")), packets_);
  audit::Auditor auditor;
  for (const Packet& packet : ReadLog(Path("repaired.lcm"))) auditor.Add(packet);
  EXPECT_TRUE(auditor.Finish().empty());
  EXPECT_FALSE(fs::exists(Path("repaired.lcm.part")));
  EXPECT_THROW(RepairLog(&source, Path("repaired.lcm")), InputError);
}

TEST_F(LogTest, CutKeepsTheTimeSpanAndTheScenario) {
  WriteLog("mission.lcm", packets_);
  LogSource source(folder_.path().string());
  CutLog(&source, 10 * kMinuteUs, 11 * kMinuteUs, Path("cut.lcm"));
  const std::vector<Packet> cut = ReadLog(Path("cut.lcm"));
  std::vector<Packet> expected;
  for (const Packet& packet : packets_) {
    const std::int64_t t = DecodeHeader(packet)->sim_us;
    if (packet.channel == channel::kScenario || (10 * kMinuteUs <= t && t <= 11 * kMinuteUs)) {
      expected.push_back(packet);
    }
  }
  EXPECT_EQ(cut, expected);
  EXPECT_GT(cut.size(), 10u);
}

TEST_F(LogTest, CsvHasEveryRowOnce) {
  FakeLog log = MakeFakeMission();
  ForEach<event_t>(&log, [](event_t& e) {
    if (e.kind == 8) e.detail = "full, \"at last\"";
  });
  std::vector<Packet> packets = Encoded(log);
  packets.insert(packets.end(), packets.begin(), packets.end());  // everything twice
  WriteLog("mission.lcm", packets);
  LogSource source(folder_.path().string());
  ExportCsv(&source, Path("csv"));
  EXPECT_EQ(Lines("csv/agents.csv").size(), 1u + 31 * 5);
  EXPECT_EQ(Lines("csv/decisions.csv").size(), 1u + 3);
  EXPECT_EQ(Lines("csv/actions.csv").size(), 1u + 4 + 2 + 2);
  EXPECT_EQ(Lines("csv/events.csv").size(), 1u + 11);
  EXPECT_EQ(Lines("csv/actions.csv")[4], "0,7,UiTxWj,0,0,-1,0,-1,4000,1000,2.5\r");
  EXPECT_EQ(Lines("csv/events.csv")[1], "0,agent_online,0,-1,-1,-1,-1,,\r");
  EXPECT_NE(Text("csv/events.csv").find("552.666153,sensing_done,0,0,-1,0,-1,,\r\n"),
            std::string::npos)
      << Text("csv/events.csv");
  EXPECT_NE(Text("csv/events.csv").find(",\"full, \"\"at last\"\"\"\r\n"), std::string::npos);
  // Task 1: open, reserved at 11, sensing at 14, done at 16 min.
  EXPECT_NE(Text("csv/tasks.csv").find("16,960,1,done\r\n"), std::string::npos);
  EXPECT_EQ(Lines("csv/tasks.csv").size(), 1u + 2 * 4);
  EXPECT_FALSE(fs::exists(Path("csv/closed_roads.csv"))) << "there are no roads";
  EXPECT_THROW(ExportCsv(&source, Path("csv")), InputError);
  EXPECT_FALSE(fs::exists(Path("csv.part")));
}

TEST_F(LogTest, GeoJsonHasPlacesAndTimes) {
  WriteLog("mission.lcm", packets_);
  LogSource source(folder_.path().string());
  EXPECT_THROW(ExportGeoJson(&source, Path("geo"), {}), InputError);  // no origin
  ExportGeoJson(&source, Path("geo"), Origin{18.5, -72.3});
  const auto positions = nlohmann::json::parse(Text("geo/positions.geojson"));
  EXPECT_EQ(positions["features"].size(), 31u * 5);
  // Mission time 0 was at wall time 1 s.
  EXPECT_EQ(positions["features"][0]["properties"]["time"], "1970-01-01T00:00:01.000Z");
  EXPECT_EQ(positions["features"].back()["properties"]["time"], "1970-01-01T00:30:01.000Z");
  const auto at = positions["features"][0]["geometry"]["coordinates"];
  // 1 km is 0.00947 degrees of longitude at 18.5 N, 0.00904 of latitude.
  EXPECT_NEAR(at[0].get<double>(), -72.3 + 0.009471, 1e-5);
  EXPECT_NEAR(at[1].get<double>(), 18.5 + 0.009036, 1e-5);
  const auto trips = nlohmann::json::parse(Text("geo/trips.geojson"));
  ASSERT_EQ(trips["features"].size(), 5u);
  for (const auto& trip : trips["features"]) {
    double before = 0;
    // Where agents set out and arrive within ticks, and start and end; not one point a tick.
    EXPECT_LE(trip["geometry"]["coordinates"].size(), 8u);
    for (const auto& c : trip["geometry"]["coordinates"]) {
      ASSERT_EQ(c.size(), 4u);
      EXPECT_GT(c[3].get<double>(), before);
      before = c[3].get<double>();
    }
    EXPECT_EQ(before, 1801);
  }
  // Every position lies on its agent's trip at its time, to a metre: a way that is straight in the
  // map frame is slightly bent in degrees.
  for (const auto& position : positions["features"]) {
    const double t = position["properties"]["sim_s"].get<double>() + 1;
    const auto place = position["geometry"]["coordinates"];
    for (const auto& trip : trips["features"]) {
      if (trip["properties"]["agent"] != position["properties"]["agent"]) continue;
      const auto& line = trip["geometry"]["coordinates"];
      std::size_t i = 1;
      while (line[i][3].get<double>() < t) ++i;
      const double from = line[i - 1][3].get<double>();
      const double share = (t - from) / (line[i][3].get<double>() - from);
      for (const int axis : {0, 1}) {
        const double a = line[i - 1][axis].get<double>(), b = line[i][axis].get<double>();
        EXPECT_NEAR(a + (b - a) * share, place[axis].get<double>(), 5e-6);
      }
    }
  }
  const auto sites = nlohmann::json::parse(Text("geo/sites.geojson"));
  ASSERT_EQ(sites["features"].size(), 3u);
  EXPECT_EQ(sites["features"][1]["properties"]["done_time"], "1970-01-01T00:16:01.000Z");
}

std::vector<std::string> Cells(const std::string& line, char between) {
  std::vector<std::string> cells;
  std::stringstream text(line);
  for (std::string cell; std::getline(text, cell, between);) cells.push_back(cell);
  return cells;
}

/// A mission on streets, of which some are closed and one is opened again.
std::vector<Packet> RoadPackets(Scenario* at_end) {
  VirtualMission mission = RoadMission("horizon", 4);
  ScenarioRoads roads = *mission.scenario.roads;
  roads.closures = {
      {{RoadArea::Circle{{7000, 7000}, 2000}}, "bridge, north", 20 * kMinuteUs, 60 * kMinuteUs},
      {{RoadArea::Circle{{2000, 3000}, 900}}, "", 40 * kMinuteUs, kNever}};
  UseRoads(std::move(roads), "grid.roads.json", &mission.scenario);
  mission.scenario.origin = Origin{18.5, -72.3};
  std::vector<Packet> packets;
  MissionReader reader;
  Simulate(TextOf(mission.scenario), mission.policy, [&](const Packet& packet) {
    packets.push_back(packet);
    reader.Add(packet, [](const Message&, const Packet&) {});
  });
  *at_end = *reader.scenario();
  return packets;
}

/// What orders have added is there, at its place, and the room for more is not.
TEST_F(LogTest, ExportsHoldWhatOrdersAddedAndNotTheRoomForMore) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.rules.limit_us = 20 * kMinuteUs;  // the orders come at 5 min
  Scenario scenario = Generate(settings, 1);
  scenario.origin = Origin{18.5, -72.3};
  const std::size_t tasks = scenario.tasks.size(), uavs = scenario.uavs.size();
  AddRoom({5, {4, 4, 4}}, &scenario);
  std::vector<world::PlannedOrder> orders;
  for (const char* json :
       {R"({"id": "t", "at_min": 5, "order": "task_add", "task": {"x_km": 3, "y_km": 4}})",
        R"({"id": "u", "at_min": 5, "order": "agent_join", "class": "uav", "agent": {"x_km": 3, )"
        R"("y_km": 4, "speed_km_per_min": 1, "full_range_km": 30}})"}) {
    orders.push_back({ParseOrder(json, "order"), json});
  }
  std::vector<Packet> packets;
  Simulate(
      TextOf(scenario), "horizon", [&](const Packet& packet) { packets.push_back(packet); }, {},
      orders);
  WriteLog("mission.lcm", packets);
  LogSource source(folder_.path().string());
  ExportCsv(&source, Path("csv"));
  std::set<std::string> agents, of_tasks;
  for (const std::string& line : Lines("csv/agents.csv")) {
    const std::vector<std::string> cells = Cells(line, ',');
    agents.insert(cells[2] + cells[3]);
  }
  for (const std::string& line : Lines("csv/tasks.csv")) of_tasks.insert(Cells(line, ',')[2]);
  EXPECT_EQ(of_tasks.size(), 1 + tasks + 1);  // with the head
  EXPECT_TRUE(of_tasks.contains(std::to_string(tasks)));
  EXPECT_EQ(agents.size(), 1 + uavs + 1 + scenario.n_agents(AgentKind::kWorker) +
                               scenario.n_agents(AgentKind::kVehicle));
  EXPECT_TRUE(agents.contains("uav" + std::to_string(uavs)));

  ExportGeoJson(&source, Path("geo"), {});
  const auto sites = nlohmann::json::parse(Text("geo/sites.geojson"))["features"];
  const auto added = std::find_if(sites.begin(), sites.end(), [&](const auto& site) {
    return site["properties"]["site"] == fmt::format("task:{}", tasks);
  });
  ASSERT_NE(added, sites.end());
  EXPECT_NEAR((*added)["geometry"]["coordinates"][0].get<double>(), -72.3 + 3 / 105.5, 0.001);
  EXPECT_EQ(Text("geo/positions.geojson").find(fmt::format("\"uav:{}\"", uavs + 1)),
            std::string::npos);
  ExportMcap(&source, Path("run.mcap"));
  const std::string mcap = Text("run.mcap");
  EXPECT_NE(mcap.find(fmt::format("\"task:{}\"", tasks)), std::string::npos);
  EXPECT_EQ(mcap.find(fmt::format("\"task:{}\"", tasks + 1)), std::string::npos);
  EXPECT_EQ(mcap.find(fmt::format("\"uav:{}\"", uavs + 1)), std::string::npos);
}

TEST_F(LogTest, CsvHasTheWaysThatAgentsWentAndTheRoadsThatWereClosed) {
  Scenario scenario;
  WriteLog("mission.lcm", RoadPackets(&scenario));
  LogSource source(folder_.path().string());
  ExportCsv(&source, Path("csv"));
  const auto lines = Lines("csv/ways.csv");
  ASSERT_GT(lines.size(), 30u);
  int bent = 0, cut_short = 0;
  std::map<std::string, double> free_from;  // by agent
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const auto cells = Cells(lines[i], ',');
    ASSERT_EQ(cells.size(), 12u) << lines[i];
    const double depart = std::stod(cells[5]), arrive = std::stod(cells[6]);
    const double until = std::stod(cells[7]), straight = std::stod(cells[8]);
    const double way = std::stod(cells[9]);
    EXPECT_LT(depart, arrive);
    EXPECT_LE(until, arrive);
    EXPECT_GE(way, straight - 1e-9);
    double& free = free_from[cells[0] + cells[1]];
    EXPECT_GE(depart, free) << "one way after the other";
    free = until;
    cut_short += until < arrive ? 1 : 0;
    const auto points = Cells(cells[11], ';');
    bent += points.size() > 2 ? 1 : 0;
    EXPECT_TRUE(cells[0] != "uav" || points.size() == 2u) << lines[i];
  }
  EXPECT_GT(bent, 15);
  EXPECT_GT(cut_short, 0);

  std::set<std::int32_t> north, west;
  const Roads& roads = *scenario.roads->network;
  for (const std::int32_t r : RoadsIn(roads, {RoadArea::Circle{{7000, 7000}, 2000}}))
    north.insert(r);
  for (const std::int32_t r : RoadsIn(roads, {RoadArea::Circle{{2000, 3000}, 900}})) west.insert(r);
  ASSERT_FALSE(west.empty());
  const auto closed = Lines("csv/closed_roads.csv");
  ASSERT_EQ(closed.size(), 1 + north.size() + west.size());
  for (std::size_t i = 1; i < closed.size(); ++i) {
    const bool first = closed[i].find("\"bridge, north\"") != std::string::npos;
    const std::string times = first ? ",1200,3600," : ",2400,,";
    EXPECT_NE(closed[i].find(times), std::string::npos) << closed[i];
    EXPECT_EQ((first ? north : west).erase(std::stoi(closed[i])), 1u) << closed[i];
  }
}

TEST_F(LogTest, VolumesFollowEachOtherInTimeAndStayBelowTheCeiling) {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  scenario.rules.limit_us = 60 * kMinuteUs;
  UseAir({}, &scenario);
  std::vector<Packet> packets;
  Simulate(ScenarioToJson(scenario), "horizon",
           [&](const Packet& packet) { packets.push_back(packet); });
  WriteLog("mission.lcm", packets);
  LogSource source(folder_.path().string());
  EXPECT_THROW(ExportVolumes(&source, Path("none.json"), {}, 0), InputError);  // no origin
  EXPECT_FALSE(fs::exists(Path("none.json")));
  ExportVolumes(&source, Path("volumes.json"), Origin{18.5, -72.3}, 100);
  const auto flights = nlohmann::json::parse(Text("volumes.json"))["flights"];
  EXPECT_GT(flights.size(), 20u);
  for (const auto& flight : flights) {
    std::string end;
    for (const auto& volume : flight["volumes"]) {
      const std::string start = volume["time_start"]["value"];
      EXPECT_TRUE(end.empty() || start == end) << flight["uav"] << " " << start << " " << end;
      end = volume["time_end"]["value"];
      EXPECT_LE(start, end);
      const auto& space = volume["volume"];
      EXPECT_GE(space["altitude_lower"]["value"], 100.0);
      EXPECT_LE(space["altitude_upper"]["value"], 225.0);  // 120 m and half of 10 m
      EXPECT_NE(space.contains("outline_polygon"), space.contains("outline_circle"));
    }
  }
  WriteLog("plain.lcm", packets_);  // of a mission that does not keep UAVs apart
  LogSource other(Path("plain.lcm"));
  EXPECT_THROW(ExportVolumes(&other, Path("none.json"), Origin{18.5, -72.3}, 0), InputError);
}

TEST_F(LogTest, GeoJsonHasTheWaysThatAgentsWentAndTheRoads) {
  Scenario scenario;
  WriteLog("mission.lcm", RoadPackets(&scenario));
  LogSource source(folder_.path().string());
  ExportGeoJson(&source, Path("geo"), {});
  ExportCsv(&source, Path("csv"));
  const auto ways = nlohmann::json::parse(Text("geo/ways.geojson"));
  EXPECT_EQ(ways["features"].size() + 1, Lines("csv/ways.csv").size());
  for (const auto& way : ways["features"]) {
    EXPECT_GE(way["geometry"]["coordinates"].size(), 2u);
    EXPECT_LT(way["properties"]["depart"], way["properties"]["arrive"]);
  }
  const auto roads = nlohmann::json::parse(Text("geo/roads.geojson"));
  ASSERT_EQ(roads["features"].size(), scenario.roads->network->roads.size());
  std::size_t closed = 0;
  for (const auto& road : roads["features"]) closed += road["properties"]["closed"].size();
  EXPECT_EQ(closed + 1, Lines("csv/closed_roads.csv").size());
}

/// Whether a value is what a JSON Schema of MCAP says, as far as such schemas go here.
bool Fits(const nlohmann::json& value, const nlohmann::json& schema) {
  const std::string type = schema.value("type", "");
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "array") {
    return value.is_array() && std::all_of(value.begin(), value.end(), [&](const auto& item) {
             return Fits(item, schema["items"]);
           });
  }
  if (type != "object" || !value.is_object()) return false;
  for (const auto& [key, field] : value.items()) {
    if (!schema["properties"].contains(key) || !Fits(field, schema["properties"][key])) {
      return false;
    }
  }
  return true;
}

/// The records of an MCAP file: opcode, offset, content.
struct Record {
  int op;
  std::uint64_t start;
  std::string content;
};

template <class T>
T Get(const std::string& bytes, std::size_t at) {
  T value = 0;
  for (std::size_t i = sizeof(T); i-- > 0;) {
    value = static_cast<T>(value << 8 | static_cast<unsigned char>(bytes.at(at + i)));
  }
  return value;
}

std::vector<Record> Records(const std::string& bytes, std::size_t at, std::size_t end) {
  std::vector<Record> records;
  while (at < end) {
    const auto size = Get<std::uint64_t>(bytes, at + 1);
    records.push_back({bytes[at], at, bytes.substr(at + 9, size)});
    at += 9 + size;
  }
  EXPECT_EQ(at, end);
  return records;
}

TEST_F(LogTest, McapIsIndexedAndHoldsEveryMessage) {
  WriteLog("mission.lcm", packets_);
  LogSource source(folder_.path().string());
  ExportMcap(&source, Path("run.mcap"));
  const std::string bytes = Text("run.mcap");
  const std::string magic = "\x89MCAP0\r\n";
  ASSERT_EQ(bytes.substr(0, 8), magic);
  ASSERT_EQ(bytes.substr(bytes.size() - 8), magic);
  const auto records = Records(bytes, 8, bytes.size() - 8);
  ASSERT_EQ(records.front().op, 0x01);
  ASSERT_EQ(records.back().op, 0x02);
  // The footer points at the summary, whose first record is a schema.
  const auto summary = Get<std::uint64_t>(records.back().content, 0);
  EXPECT_EQ(bytes[summary], 0x03);
  EXPECT_EQ(bytes[Get<std::uint64_t>(records.back().content, 8)], 0x0E);

  std::map<int, nlohmann::json> schemas;
  std::map<int, std::string> topics;
  std::map<std::string, int> schema_of;
  std::map<std::string, int> counts;
  std::uint64_t before = 0;
  for (const Record& chunk : records) {
    if (chunk.op != 0x06) continue;
    const std::size_t body = 8 + 8 + 8 + 4 + 4 + 8;  // no compression
    const auto inner = Records(chunk.content, body, chunk.content.size());
    for (const Record& r : inner) {
      if (r.op == 0x03) {
        std::size_t at = 2;  // then name, encoding and data, each with its length in front
        for (int i = 0; i < 2; ++i) at += 4 + Get<std::uint32_t>(r.content, at);
        schemas[Get<std::uint16_t>(r.content, 0)] = nlohmann::json::parse(r.content.substr(at + 4));
      }
      if (r.op == 0x04) {
        topics[Get<std::uint16_t>(r.content, 0)] =
            r.content.substr(8, Get<std::uint32_t>(r.content, 4));
        schema_of[topics[Get<std::uint16_t>(r.content, 0)]] = Get<std::uint16_t>(r.content, 2);
      }
      if (r.op != 0x05) continue;
      ++counts[topics.at(Get<std::uint16_t>(r.content, 0))];
      const auto time = Get<std::uint64_t>(r.content, 6);
      EXPECT_GE(time, before);
      before = time;
      const std::string& topic = topics.at(Get<std::uint16_t>(r.content, 0));
      const auto message = nlohmann::json::parse(r.content.substr(22), nullptr, false);
      ASSERT_TRUE(message.is_object());
      if (topic == "/scene") continue;  // foxglove's own schema
      EXPECT_TRUE(Fits(message, schemas.at(schema_of.at(topic)))) << topic << ": " << message;
    }
  }
  EXPECT_EQ(before, 1'801'000'000'000u);
  EXPECT_EQ(counts["MUSTER_SCHEDULE"], 3);
  EXPECT_EQ(counts["MUSTER_EVENT"], 11);
  EXPECT_GT(counts["/scene"], 30);
  int total = 0;
  for (const auto& [topic, n] : counts) total += topic == "/scene" ? 0 : n;
  EXPECT_EQ(total, static_cast<int>(packets_.size()));
  // Every chunk index points at a chunk, every message index in it at that channel's index.
  int chunks = 0;
  for (const Record& r : records) {
    if (r.op != 0x08) continue;
    ++chunks;
    EXPECT_EQ(bytes[Get<std::uint64_t>(r.content, 16)], 0x06);
    const auto map_size = Get<std::uint32_t>(r.content, 32);
    for (std::size_t at = 36; at < 36 + map_size; at += 10) {
      const auto offset = Get<std::uint64_t>(r.content, at + 2);
      EXPECT_EQ(bytes[offset], 0x07);
      EXPECT_EQ(Get<std::uint16_t>(bytes, offset + 9), Get<std::uint16_t>(r.content, at));
    }
  }
  EXPECT_GE(chunks, 1);
}

TEST_F(LogTest, ExportsNeedAScenario) {
  WriteLog("mission.lcm", {packets_.begin() + 1, packets_.end()});
  LogSource source(folder_.path().string());
  EXPECT_THROW(ExportCsv(&source, Path("csv")), InputError);
  EXPECT_THROW(ExportMcap(&source, Path("run.mcap")), InputError);
  EXPECT_FALSE(fs::exists(Path("csv")));
  EXPECT_FALSE(fs::exists(Path("run.mcap")));
}

}  // namespace
}  // namespace muster::tools
