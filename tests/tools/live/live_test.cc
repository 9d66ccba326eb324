#include <arpa/inet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/sha256.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "tests/temporary_folder.h"
#include "tests/tools/fake_mission.h"
#include "tests/tools/launch/process_test_util.h"
#include "tests/tools/tiles/made_tiles.h"
#include "tools/live/live_server.h"
#include "tools/live/packet_source.h"
#include "tools/orders/alert_feed.h"
#include "tools/report/page.h"
#include "tools/top/top_view.h"

namespace muster::tools {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLong{60'000};  // far beyond what anything here takes

std::vector<Packet> Mission() { return Encoded(MakeFakeMission()); }

/// Everything that a reader is told until `done` tasks are done and the mission has ended.
std::vector<nlohmann::json> ReadToEnd(LiveFeed* feed, LiveFeed::Reader* reader) {
  std::vector<nlohmann::json> chunks;
  while (true) {
    const auto text = feed->Next(reader, kLong);
    if (!text) return chunks;
    chunks.push_back(nlohmann::json::parse(*text));
    if (chunks.back()["ended"] == true) return chunks;
  }
}

TEST(LiveFeed, TellsEveryReaderAllOfItWheneverHeComes) {
  const std::vector<Packet> packets = Mission();
  LiveFeed feed("run");
  LiveFeed::Reader early;
  const auto half = packets.begin() + static_cast<std::ptrdiff_t>(packets.size() / 2);
  feed.Add({packets.begin(), half});
  const auto first = feed.Next(&early, kLong);
  ASSERT_TRUE(first);
  EXPECT_EQ(nlohmann::json::parse(*first)["name"], "run");
  feed.Add({half, packets.end()});
  const std::vector<nlohmann::json> rest = ReadToEnd(&feed, &early);
  ASSERT_FALSE(rest.empty());
  EXPECT_FALSE(rest.back().contains("scenario"));
  EXPECT_EQ(rest.back()["report"]["tasks_done"], 2);

  LiveFeed::Reader late;
  const std::vector<nlohmann::json> all = ReadToEnd(&feed, &late);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0]["scenario"]["uavs"], 2);
  EXPECT_EQ(all[0]["decisions"][1].size(), 3U);
}

TEST(LiveFeed, GoesOnWithTheNextMissionAfterTheEndOfOne) {
  LiveFeed feed("");
  LiveFeed::Reader reader;
  feed.Add(Mission());
  ReadToEnd(&feed, &reader);
  FakeLog next = MakeFakeMission();
  for (FakeMessage& message : next) message.header().run_id = 8;
  feed.Add(Encoded(next));
  const std::vector<nlohmann::json> chunks = ReadToEnd(&feed, &reader);
  ASSERT_FALSE(chunks.empty());
  EXPECT_TRUE(chunks.front().contains("scenario"));
  EXPECT_EQ(chunks.back()["report"]["run_id"], 8);
}

TEST(LiveFeed, ClosedItTellsWhatThereIsAndThenNothing) {
  LiveFeed feed("run");
  feed.Add(Mission());
  feed.Close();
  LiveFeed::Reader reader;
  EXPECT_FALSE(ReadToEnd(&feed, &reader).empty());
  EXPECT_FALSE(feed.Next(&reader, kLong));  // at once
}

class LiveServed : public ::testing::Test {
 protected:
  LiveServed() : server_(std::in_place, 0), client_(Origin()) {
    server_->Start(&feed_);
    client_.set_read_timeout(60);
  }
  std::string Origin() const { return server_->url().substr(0, server_->url().size() - 1); }

  LiveFeed feed_{"run"};
  std::optional<LiveServer> server_;
  httplib::Client client_;
};

TEST_F(LiveServed, ThePageIsThereForBrowsersOfThisHostOnly) {
  if (PageTemplate().empty()) GTEST_SKIP() << "built without the report page";
  const auto page = client_.Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_NE(page->body.find("text/x-muster-live"), std::string::npos);
  EXPECT_NE(page->body.find("connect-src 'self'"), std::string::npos);
  EXPECT_EQ(client_.Get("/elsewhere")->status, 404);
  for (const char* path : {"/", "/events"}) {
    const auto strange = client_.Get(path, {{"Host", "evil.example"}});
    ASSERT_TRUE(strange);
    EXPECT_EQ(strange->status, 403) << path;
    EXPECT_TRUE(strange->body.empty());
  }
}

TEST_F(LiveServed, OtherMapsGetTheMissionAsItIs) {
  EXPECT_EQ(client_.Get("/mission.geojson")->status, 404);
  FakeLog log = MakeFakeMission();
  ForEach<scenario_t>(&log, [](scenario_t& scenario) {
    scenario.json.insert(scenario.json.find("\"seed\""),
                         R"("origin": {"latitude_deg": 46.85, "longitude_deg": 7.3}, )");
    scenario.sha256 = Sha256(scenario.json);
  });
  feed_.Add(Encoded(log));
  nlohmann::json map;
  ASSERT_TRUE(Eventually([&] {
    const auto got = client_.Get("/mission.geojson");
    if (!got || got->status != 200) return false;
    map = nlohmann::json::parse(got->body);
    return map["features"][0]["properties"]["status"] == "done" &&
           map["features"][1]["properties"]["status"] == "done";
  }));
  ASSERT_EQ(map["features"].size(), 8U);  // 2 tasks, 1 charging point, 5 agents
  EXPECT_EQ(map["features"][0]["id"], "task:0");
  EXPECT_EQ(map["features"][0]["properties"]["uav"], 0);
  const auto& uav = map["features"][3];
  EXPECT_EQ(uav["id"], "uav:0");
  // At (6, 1) km: a degree is 111.2 km to the north and 76.2 km to the east there.
  EXPECT_NEAR(uav["geometry"]["coordinates"][0], 7.3 + 6 / 76.2, 0.001);
  EXPECT_NEAR(uav["geometry"]["coordinates"][1], 46.85 + 1 / 111.2, 0.001);
}

/// A live page with a base map of one tile.
class ServedTiles : public ::testing::Test {
 protected:
  ServedTiles() {
    WriteMbtiles(file_, {{"format", "png"}, {"bounds", "7,46,8,47"}, {"attribution", "us"}},
                 {{{9, 266, 180}, "\x89PNG picture"}});
    feed_.emplace("run", OpenTiles(file_));
    server_.emplace(0);
    server_->Start(&*feed_);
  }
  TemporaryFolder folder_;
  const std::string file_ = folder_.File("tiles.mbtiles");
  std::optional<LiveFeed> feed_;
  std::optional<LiveServer> server_;
};

TEST_F(ServedTiles, ThePageIsToldOfItsBaseMapAndGetsItsTiles) {
  FakeLog log = MakeFakeMission();
  ForEach<scenario_t>(&log, [](scenario_t& scenario) {
    scenario.json.insert(scenario.json.find("\"seed\""),
                         R"("origin": {"latitude_deg": 46.85, "longitude_deg": 7.3}, )");
    scenario.sha256 = Sha256(scenario.json);
  });
  feed_->Add(Encoded(log));
  LiveFeed::Reader reader;
  const auto chunk = feed_->Next(&reader, kLong);
  ASSERT_TRUE(chunk);
  const auto map = nlohmann::json::parse(*chunk)["basemap"];
  EXPECT_EQ(map["source"], "us");
  EXPECT_EQ(map["zooms"], (nlohmann::json{9, 9}));
  EXPECT_FALSE(map.contains("tiles"));
  httplib::Client client(server_->url().substr(0, server_->url().size() - 1));
  client.set_read_timeout(60);
  const auto about = client.Get("/tiles.json");
  ASSERT_TRUE(about);
  EXPECT_EQ(nlohmann::json::parse(about->body)["source"], "us");
  EXPECT_EQ(nlohmann::json::parse(about->body)["zooms"], (nlohmann::json{9, 9}));
  const auto tile = client.Get("/tiles/9/266/180");
  ASSERT_TRUE(tile);
  EXPECT_EQ(tile->status, 200);
  EXPECT_EQ(tile->body, "\x89PNG picture");
  EXPECT_EQ(tile->get_header_value("Content-Type"), "image/png");
  for (const char* path :
       {"/tiles/9/266/181", "/tiles/9/266/180/1", "/tiles/9/-1/180", "/tiles/99/0/0",
        "/tiles/9/266", "/tiles/../../etc/passwd", "/tiles/9/999999999/0"}) {
    EXPECT_EQ(client.Get(path)->status, 404) << path;
  }
}

TEST_F(ServedTiles, OfAMissionElsewhereThereIsNone) {
  feed_->Add(Mission());  // it has no origin
  LiveFeed::Reader reader;
  const auto chunk = feed_->Next(&reader, kLong);
  ASSERT_TRUE(chunk);
  EXPECT_FALSE(nlohmann::json::parse(*chunk).contains("basemap"));
}

TEST_F(LiveServed, DispatchSystemsGetTasksAsAlertsThatOurOwnFeedReads) {
  EXPECT_EQ(client_.Get("/mission.cap")->status, 404);
  FakeLog log = MakeFakeMission();
  ForEach<scenario_t>(&log, [](scenario_t& scenario) {
    scenario.json.insert(scenario.json.find("\"seed\""),
                         R"("origin": {"latitude_deg": 46.85, "longitude_deg": 7.3},
                            "start": "2026-01-16T09:00:00Z", )");
    scenario.sha256 = Sha256(scenario.json);
  });
  const std::vector<Packet> packets = Encoded(log);
  Reports read;
  const auto reads = [&](auto is_so) {
    return Eventually([&] {
      const auto got = client_.Get("/mission.cap");
      if (!got || got->status != 200) return false;
      read = ReadCap(got->body, "mission.cap", "Exercise", std::nullopt);
      return is_so();
    });
  };
  const auto half = packets.begin() + static_cast<std::ptrdiff_t>(packets.size() / 2);
  feed_.Add({packets.begin(), half});
  ASSERT_TRUE(reads([&] { return read.reports.size() == 2 && read.reports[1].tasks.size() == 1; }));
  EXPECT_EQ(read.reports[1].key, "muster,muster.run.task.1,2026-01-16T09:00:00-00:00");
  EXPECT_EQ(read.reports[1].tasks[0]["priority"], 1);
  EXPECT_EQ(read.reports[1].tasks[0]["name"], "Task 1");
  feed_.Add({half, packets.end()});
  ASSERT_TRUE(
      reads([&] { return read.reports[0].tasks.empty() && read.reports[1].tasks.empty(); }));
  EXPECT_TRUE(read.refused.empty());
  EXPECT_EQ(read.reports[1].replaces,
            std::vector<std::string>{"muster,muster.run.task.1,2026-01-16T09:00:00-00:00"});
}

TEST_F(LiveServed, EventsCarryTheMissionAndSayGoodbye) {
  feed_.Add(Mission());
  std::string heard;
  const auto response = client_.Get("/events", [&](const char* data, std::size_t size) {
    heard.append(data, size);
    if (heard.find("\"ended\":true") != std::string::npos) feed_.Close();
    return true;
  });
  ASSERT_TRUE(response);
  EXPECT_EQ(response->get_header_value("Content-Type"), "text/event-stream");
  EXPECT_EQ(heard.rfind("event: chunk\ndata: {", 0), 0U);
  EXPECT_NE(heard.find("event: bye\n"), std::string::npos);
}

TEST_F(LiveServed, EndsWhileSomebodyListens) {
  feed_.Add(Mission());
  std::string heard;
  std::thread closes;
  client_.Get("/events", [&](const char* data, std::size_t size) {
    heard.append(data, size);
    if (!closes.joinable()) {
      closes = std::thread([this] { server_.reset(); });
    }
    return true;
  });
  closes.join();
  EXPECT_NE(heard.find("event: bye\n"), std::string::npos);
}

/// A connection to the server, as a client that knows no manners makes it.
class Raw {
 public:
  explicit Raw(const LiveServer& server) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    const std::string url = server.url();
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1))));
    EXPECT_EQ(connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Raw() { close(fd_); }
  Raw(const Raw&) = delete;
  Raw& operator=(const Raw&) = delete;

  bool Say(std::string_view text) {
    return send(fd_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  /// All until the server closes.
  std::string Hear() {
    std::string heard;
    char buffer[4096];
    for (ssize_t got; (got = recv(fd_, buffer, sizeof buffer, 0)) > 0;) {
      heard.append(buffer, static_cast<std::size_t>(got));
    }
    return heard;
  }
  /// A byte now and then until the server has enough of it.
  void Drip() {
    char byte;
    while (Say("a") && recv(fd_, &byte, 1, MSG_DONTWAIT) < 0 && errno == EAGAIN) {
      poll(nullptr, 0, 20);
    }
  }

 private:
  int fd_;
};

TEST_F(LiveServed, NobodyKeepsItWaiting) {
  std::vector<std::thread> drips;
  for (int i = 0; i < 6; ++i) drips.emplace_back([this] { Raw(*server_).Drip(); });
  for (std::thread& drip : drips) drip.join();  // each is given up after a while
  drips.clear();
  std::vector<std::unique_ptr<Raw>> clients;
  for (const char* begin : {"", "GET / HT", "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n",
                            "GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9999\r\n\r\n",
                            "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9999\r\n\r\n"}) {
    clients.push_back(std::make_unique<Raw>(*server_));
    clients.back()->Say(begin);
    drips.emplace_back([client = clients.back().get()] { client->Drip(); });
  }
  server_.reset();
  for (std::thread& drip : drips) drip.join();
}

TEST_F(LiveServed, ServesSoManyAtATime) {
  std::vector<std::unique_ptr<Raw>> clients;
  for (std::size_t i = 0; i < LiveServer::kMostClients; ++i) {
    clients.push_back(std::make_unique<Raw>(*server_));
  }
  Raw one_more(*server_);
  EXPECT_EQ(one_more.Hear().rfind("HTTP/1.1 503 ", 0), 0U);
  clients.clear();
  while (!client_.Get("/elsewhere") || client_.Get("/elsewhere")->status != 404) {
  }
}

TEST_F(LiveServed, RefusesWhatIsNoRequest) {
  const std::pair<std::string, std::string> cases[] = {
      {"hello\r\n\r\n", "400"},
      {"\r\n\r\n", "400"},
      {"GET / HTTP/1.1\r\n\r\n", "403"},
      {"PUT / HTTP/1.1\r\nhost: 127.0.0.1:1\r\n\r\n", "405"},
      {"GET /" + std::string(20'000, 'x'), "431"},
      {"GET /x?y HTTP/1.0\r\nHOST:localhost\r\n\r\n", "404"},
  };
  for (const auto& [request, status] : cases) {
    Raw raw(*server_);
    raw.Say(request);
    EXPECT_EQ(raw.Hear().rfind("HTTP/1.1 " + status, 0), 0U) << request.substr(0, 40);
  }
}

TEST(LiveServer, ATakenPortIsSaid) {
  const LiveServer first(0);
  const std::string url = first.url();
  const int port = std::stoi(url.substr(url.rfind(':') + 1));
  EXPECT_THROW(LiveServer second(port), SystemError);
}

TEST(FollowedRun, ReadsFilesAsTheyGrowAndAsTheyCome) {
  const TemporaryFolder folder;
  const std::vector<Packet> packets = Mission();
  const auto source = OpenPacketSource(folder.path().string());
  EXPECT_TRUE(source->is_log());
  EXPECT_TRUE(source->Read(0).empty());
  std::vector<Packet> read;
  const auto read_on = [&] {
    for (Packet& packet : source->Read(0)) read.push_back(std::move(packet));
  };
  {
    EventLogWriter log(folder.File("mission.lcm"));
    for (std::size_t i = 0; i < 40; ++i) {
      log.Write(0, packets[i]);
      log.Flush();
      read_on();
      EXPECT_EQ(read.size(), i + 1);
    }
  }
  EventLogWriter next(folder.File("mission.lcm.1"));
  for (std::size_t i = 40; i < packets.size(); ++i) next.Write(0, packets[i]);
  next.Flush();
  read_on();
  EXPECT_EQ(read, packets);
  EXPECT_THROW(OpenPacketSource(folder.File("nothing")), InputError);
}

TEST(ScenarioRequest, AsksWithOneMessageAgainAndAgainUntilAnswered) {
  ScenarioRequest request;
  EXPECT_FALSE(request.Due({}, false, 0));
  EXPECT_FALSE(request.Due(7, false, 0));  // it may come by itself
  const auto question = request.Due(7, false, 2'000'000);
  ASSERT_TRUE(question);
  const auto decoded = DecodeValid<request_t>(question->bytes);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->header.run_id, 7);
  EXPECT_EQ(decoded->header.seq, 0);
  EXPECT_EQ(decoded->channel, "MUSTER_SCENARIO");
  EXPECT_FALSE(request.Due(7, false, 2'000'001));
  EXPECT_EQ(request.Due(7, false, 4'000'000), question);
  EXPECT_FALSE(request.Due(7, true, 9'000'000));
}

process_status_t StatusOf(const char* name, std::int64_t wall_us, double cpu_s) {
  process_status_t status{};
  status.name = status.header.sender = name;
  status.header.run_id = 7;
  status.header.wall_us = wall_us;
  status.state = 2;
  status.received = 123'456;
  status.lost = 42;
  status.cpu_s = cpu_s;
  status.rss_bytes = 6'500'000;
  return status;
}

std::string TextOf(const TopView& view, std::int64_t now_us, std::size_t width = 0) {
  std::string text;
  for (const TopView::Line& line : view.Lines(now_us, width)) text += line.text + "\n";
  return text;
}

TEST(TopView, CountsAgentsTasksAndProcesses) {
  TopView view;
  EXPECT_EQ(TextOf(view, 0), "nothing heard yet\n");
  // Up to minute 8: UAV 0 and worker 0 sense task 0 (7.2 to 9.2), UAV 1 stands, the vehicle too.
  for (const FakeMessage& message : MakeFakeMission()) {
    FakeMessage copy = message;
    if (copy.header().sim_us <= 8 * 60'000'000) view.Add(copy.Encoded());
  }
  constexpr std::int64_t kWall = 1'000'000'000'000;
  for (int i = 0; i < 10; ++i) {
    process_status_t status = StatusOf("uav", kWall + i * 1'000'000, 0.25 * i);
    status.header.boot_id = 1;
    status.header.seq = i;
    view.Add({"MUSTER_PROCESS", Encode(status)});
  }
  const std::string text = TextOf(view, kWall + 9'500'000);
  EXPECT_NE(text.find("0:08:00 of"), std::string::npos) << text;
  EXPECT_NE(text.find("tasks: 0 of 2 done, 1 being sensed"), std::string::npos) << text;
  EXPECT_NE(text.find("uavs            2      1       0        0        1"), std::string::npos)
      << text;
  // One message a second, half a second old, a quarter of a processor, started twice.
  EXPECT_NE(text.find("uav           running           0.5s      1"), std::string::npos) << text;
  EXPECT_NE(text.find("123k     42        0       0      2    25   6.5 MB"), std::string::npos)
      << text;
  EXPECT_NE(TextOf(view, kWall + 60'000'000).find("uav           silent"), std::string::npos);
  for (const TopView::Line& line : view.Lines(kWall, 30)) EXPECT_LE(line.text.size(), 30U);
}

TEST(TopView, SaysForHowLongASchedulerHasBeenDeciding) {
  TopView view;
  for (FakeMessage message : MakeFakeMission()) {
    if (message.header().sim_us <= 8 * 60'000'000) view.Add(message.Encoded());
  }
  constexpr std::int64_t kWall = 1'000'000'000'000;
  const auto say = [&](std::int64_t seq, std::int64_t wall_us, ProcessState state) {
    process_status_t status = StatusOf("scheduler-2", wall_us, 0);
    status.header.seq = seq;
    status.state = NumberOf(state);
    view.Add({"MUSTER_PROCESS", Encode(status)});
  };
  say(0, kWall, ProcessState::kRunning);
  for (int i = 0; i < 20; ++i) say(1 + i, kWall + 1'000'000 + i * 150'000, ProcessState::kDeciding);
  std::string text = TextOf(view, kWall + 4'200'000);
  EXPECT_NE(text.find("scheduler-2   deciding 3.2 s"), std::string::npos) << text;
  EXPECT_NE(view.Json(kWall + 4'200'000).find("\"deciding_s\": 3."), std::string::npos);
  say(21, kWall + 4'300'000, ProcessState::kRunning);
  text = TextOf(view, kWall + 4'400'000);
  EXPECT_NE(text.find("scheduler-2   running"), std::string::npos) << text;
}

TEST(TopView, PrintsNothingThatATerminalWouldObey) {
  TopView view;
  for (const Packet& packet : Mission()) view.Add(packet);
  process_status_t status = StatusOf("\x1b[2Jx\n", 1, 0);
  view.Add({"MUSTER_PROCESS", Encode(status)});
  const std::string text = TextOf(view, 0);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
