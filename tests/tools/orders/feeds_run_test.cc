// Alerts and forms fed to missions of real processes.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/tools/faults/mission_test.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class FeedsRunTest : public MissionTest {
 protected:
  void SetUp() override {
    MissionTest::SetUp();
    if (IsSkipped()) return;
    Json scenario = Json::parse(TextOf(scenario_));
    scenario["origin"] = {{"latitude_deg", 46.8}, {"longitude_deg", 7.3}};
    here_ = folder_.File("here.json");
    std::ofstream(here_) << scenario;
    fs::create_directory(folder_.File("inbox"));
  }
  /// An hour. Slow enough for a task that a feed adds at once not to be done before the next one.
  void Start(const std::string& rate) {
    mission_.emplace(folder_, "mission",
                     std::vector<std::string>{"run", here_, "--quiet", "--take-orders", "--rate",
                                              rate, "--limit", "60", "--out", Run()});
    ASSERT_TRUE(Eventually([&] { return fs::exists(Run() + "/orders.sock"); }))
        << mission_->output();
  }
  std::string Run() const { return folder_.File("run"); }
  /// The last line of a feed's output.
  std::string Feed(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"feed", Run()});
    Muster feed(folder_, fmt::format("feed-{}", feeds_++), arguments);
    feed.Wait();
    return feed.output();
  }
  void Write(const std::string& name, const std::string& kind, const std::string& id,
             const std::string& references, const std::string& severity, double latitude = 46.9) {
    std::ofstream(folder_.File("inbox/" + name)) << fmt::format(
        "<alert><identifier>{}</identifier><sender>s</sender><sent>2026-01-01T00:00:0{}Z</sent>"
        "<status>Actual</status><msgType>{}</msgType><references>{}</references><info>"
        "<urgency>Unknown</urgency><severity>{}</severity><headline>Bridge</headline>"
        "<area><circle>{},7.4 1</circle></area></info></alert>",
        id, id, kind, references, severity, latitude);
  }

  std::string here_;
  std::optional<Muster> mission_;
  int feeds_ = 0;
};

TEST_F(FeedsRunTest, AlertsAreTakenOnceChangedAndCancelled) {
  Start("200");
  const std::vector<std::string> look = {folder_.File("inbox"), "--format", "cap"};
  Write("1.xml", "Alert", "1", "", "Extreme");
  EXPECT_EQ(Feed(look), "1 taken, 0 refused\n");
  EXPECT_EQ(Feed(look), "0 taken, 0 refused\n");
  // Without its memory it is the same order again.
  for (const auto& file : fs::directory_iterator(Run())) {
    if (file.path().filename().string().starts_with("cap-")) fs::remove(file.path());
  }
  EXPECT_EQ(Feed(look), "1 taken, 0 refused\n");
  // Nor is it another one from another source.
  EXPECT_EQ(Feed({folder_.File("inbox/1.xml"), "--format", "cap"}), "1 taken, 0 refused\n");
  // The same place: changed. Another one: in its stead. The order of the names is not theirs.
  Write("0.xml", "Update", "2", "s,1,2026-01-01T00:00:01Z", "Minor");
  EXPECT_EQ(Feed(look), "1 taken, 0 refused\n");
  Write("00.xml", "Update", "3", "s,2,2026-01-01T00:00:02Z", "Minor", 46.95);
  EXPECT_EQ(Feed(look), "2 taken, 0 refused\n");
  // What the server no longer has is cancelled all the same.
  fs::remove(folder_.File("inbox/00.xml"));
  Write("4.xml", "Cancel", "4", "s,3,2026-01-01T00:00:03Z", "Minor");
  Write("5.xml", "Alert", "5", "", "Extreme", 80);
  const std::string output = Feed(look);
  EXPECT_NE(output.find("1 taken, 1 refused"), std::string::npos) << output;
  ASSERT_EQ(mission_->Wait(), 0) << mission_->output();
  const Json report = Report();
  EXPECT_EQ(report["tasks_total"], 122);
  EXPECT_EQ(report["events"]["task_cancelled"], 2);
}

TEST_F(FeedsRunTest, AServerIsAskedAgainUntilTheMissionEnds) {
  httplib::Server server;
  int asked = 0;
  server.Get("/data.json", [&](const httplib::Request& request, httplib::Response& response) {
    ++asked;
    if (request.get_header_value("Authorization") != "Token secret" || asked == 1) {
      response.status = 503;
      return;
    }
    const char* second = R"(, {"_uuid": "v", "_geolocation": [46.92, 7.45], "what": "Dam"})";
    response.set_content(fmt::format(R"([{{"_uuid": "u", "_geolocation": [46.91, 7.45]}}{}])",
                                     asked > 2 ? second : ""),
                         "application/json");
  });
  const int port = server.bind_to_any_port("127.0.0.1");
  std::thread serving([&] { server.listen_after_bind(); });
  std::ofstream(folder_.File("token")) << "secret\n";
  Start("400");
  const std::string output =
      Feed({fmt::format("http://127.0.0.1:{}/data.json", port), "--format", "kobo", "--every",
            "0.3", "--token-file", folder_.File("token"), "--task-name", "what"});
  EXPECT_NE(output.find("it answers with status 503"), std::string::npos) << output;
  EXPECT_NE(output.find("2 taken, 0 refused"), std::string::npos) << output;
  server.stop();
  serving.join();
  ASSERT_EQ(mission_->Wait(), 0) << mission_->output();
  EXPECT_EQ(Report()["tasks_total"], 122);
}

TEST_F(FeedsRunTest, EveryPageOfAFormIsReadFromTheServerThatWasNamed) {
  httplib::Server server;
  std::string host;
  server.Get("/data.json", [&](const httplib::Request& request, httplib::Response& response) {
    const std::string from = request.get_param_value("start");
    const std::string next = from.empty()  ? "\"http://" + host + "/data.json?start=1\""
                             : from == "1" ? "\"/data.json?start=2\""
                                           : "null";
    response.set_content(
        fmt::format(
            R"({{"next": {}, "results": [{{"_uuid": "{}", "_geolocation": [46.9, 7.4]}}]}})", next,
            from.empty() ? "0" : from),
        "application/json");
  });
  server.Get("/elsewhere.json", [&](const httplib::Request&, httplib::Response& response) {
    response.set_content(R"({"next": "http://192.0.2.1/data.json", "results": []})",
                         "application/json");
  });
  server.Get("/circle.json", [&](const httplib::Request&, httplib::Response& response) {
    response.set_content(R"({"next": "/circle.json", "results": []})", "application/json");
  });
  const int port = server.bind_to_any_port("127.0.0.1");
  host = fmt::format("127.0.0.1:{}", port);
  std::thread serving([&] { server.listen_after_bind(); });
  Start("400");
  EXPECT_EQ(Feed({"http://" + host + "/data.json", "--format", "kobo"}), "3 taken, 0 refused\n");
  EXPECT_NE(Feed({"http://" + host + "/elsewhere.json", "--format", "kobo"})
                .find("it links to another server: http://192.0.2.1/data.json"),
            std::string::npos);
  EXPECT_NE(Feed({"http://" + host + "/circle.json", "--format", "kobo"})
                .find("its next page is one that was read"),
            std::string::npos);
  server.stop();
  serving.join();
  ASSERT_EQ(mission_->Wait(), 0) << mission_->output();
  EXPECT_EQ(Report()["tasks_total"], 123);
}

TEST_F(FeedsRunTest, RowsAreTakenOnceAndFollowTheirTable) {
  Start("200");
  const auto table = [&](const std::string& rows) {
    std::ofstream(folder_.File("cases.csv")) << "case,lat,lon,what,priority\n" << rows;
  };
  const std::vector<std::string> look = {folder_.File("cases.csv"),
                                         "--external-id",
                                         "case",
                                         "--task-name",
                                         "what",
                                         "--priority",
                                         "priority"};
  table("7,46.90,7.40,School,low\n8,46.91,7.41,Dam,low\n7,46.92,7.42,School,low\n");
  EXPECT_EQ(Feed(look), "3 taken, 0 refused\n");
  EXPECT_EQ(Feed(look), "0 taken, 0 refused\n");
  // Without its memory: the same orders again.
  for (const auto& file : fs::directory_iterator(Run())) {
    if (file.path().filename().string().starts_with("csv-")) fs::remove(file.path());
  }
  EXPECT_EQ(Feed(look), "3 taken, 0 refused\n");
  // A task changes, and changes back; another one moves.
  table("7,46.90,7.40,School,high\n8,46.91,7.41,Dam,low\n7,46.92,7.42,School,low\n");
  EXPECT_EQ(Feed(look), "1 taken, 0 refused\n");
  table("7,46.90,7.40,School,low\n8,46.94,7.44,Dam,low\n7,46.92,7.42,School,low\n");
  EXPECT_EQ(Feed(look), "3 taken, 0 refused\n");
  table("7,46.90,7.40,School,high\n8,46.94,7.44,Dam,low\n");
  EXPECT_EQ(Feed(look), "1 taken, 0 refused\n");
  EXPECT_EQ(Feed(look), "0 taken, 0 refused\n");
  // Rows without an id: the second of two that are the same is another task.
  std::ofstream(folder_.File("rows.geojson"))
      << R"({"type": "FeatureCollection", "features": [)"
      << R"({"type": "Feature", "properties": {}, "geometry": {"type": "Point", "coordinates": [7.4, 46.95]}},)"
      << R"({"type": "Feature", "properties": {}, "geometry": {"type": "Point", "coordinates": [7.4, 46.95]}}]})";
  EXPECT_EQ(Feed({folder_.File("rows.geojson")}), "2 taken, 0 refused\n");
  EXPECT_EQ(Feed({folder_.File("rows.geojson")}), "0 taken, 0 refused\n");
  std::ofstream(folder_.File("lines.jsonl")) << R"({"lat": 46.96, "lon": 7.4})"
                                             << "\n";
  EXPECT_EQ(Feed({folder_.File("lines.jsonl")}), "1 taken, 0 refused\n");
  EXPECT_EQ(Feed({folder_.File("lines.jsonl")}), "1 taken, 0 refused\n");
  ASSERT_EQ(mission_->Wait(), 0) << mission_->output();
  const Json report = Report();
  EXPECT_EQ(report["tasks_total"], 120 + 3 + 1 + 2 + 1);
  EXPECT_EQ(report["events"]["task_changed"], 3);
  EXPECT_EQ(report["events"]["task_cancelled"], 1);
}

TEST_F(FeedsRunTest, WhatCannotBeIsRefusedBeforeAnythingIsGiven) {
  std::ofstream(folder_.File("a.jsonl")) << "{}\n";
  Muster every(folder_, "every", {"feed", Run(), folder_.File("a.jsonl"), "--every", "3"});
  EXPECT_EQ(every.Wait(), 2);
  EXPECT_NE(every.output().find("it only with a whole document"), std::string::npos)
      << every.output();
  std::ofstream(folder_.File("a.csv")) << "lat,lon\n";
  Muster exercise(folder_, "exercise", {"feed", Run(), folder_.File("a.csv"), "--exercise"});
  EXPECT_EQ(exercise.Wait(), 2);
  EXPECT_NE(exercise.output().find("--format cap with it"), std::string::npos) << exercise.output();
  Muster out(
      folder_, "out",
      {"feed", here_, folder_.File("inbox"), "--format", "cap", "--out", folder_.File("o.jsonl")});
  EXPECT_EQ(out.Wait(), 2);
  Muster gone(folder_, "gone", {"feed", Run(), folder_.File("nowhere"), "--format", "cap"});
  EXPECT_EQ(gone.Wait(), 2);
  EXPECT_NE(gone.output().find("no such file or folder"), std::string::npos) << gone.output();
  std::ofstream(folder_.File("token")) << "secret\n";
  Muster token(folder_, "token",
               {"feed", Run(), folder_.File("a.csv"), "--token-file", folder_.File("token")});
  EXPECT_EQ(token.Wait(), 2);
  EXPECT_NE(token.output().find("a web address as FILE"), std::string::npos) << token.output();
}

}  // namespace
}  // namespace muster::tools
