// Missions of real processes that take orders of known persons only.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "tests/tools/faults/mission_test.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class PersonsRunTest : public MissionTest {
 protected:
  std::string Run() const { return folder_.File("run"); }
  int Command(const std::vector<std::string>& arguments, std::string* output) {
    Muster muster(folder_, fmt::format("command-{}", commands_++), arguments);
    const int code = muster.Wait();
    *output = muster.output();
    return code;
  }
  /// The person's token, where it has one.
  std::string AddPerson(const std::vector<std::string>& more) {
    std::string output;
    std::vector<std::string> arguments = {"person", "add", persons_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(Command(arguments, &output), 0) << output;
    const std::size_t colon = output.rfind(": ");
    return colon == std::string::npos ? "" : output.substr(colon + 2, 64);
  }
  /// A log whose first order about that task was changed in that way; what its audit says.
  std::string AuditOfChanged(const std::string& name, void (*change)(taken_order_t*)) {
    const std::string folder = folder_.File(name);
    fs::create_directory(folder);
    for (const char* file : {"scenario.json", "manifest.json", "report.json"}) {
      fs::copy(Run() + "/" + file, folder + "/" + file);
    }
    {
      EventLogReader in(Run() + "/mission.lcm", EventLogReader::Tail::kFinal);
      EventLogWriter out(folder + "/mission.lcm");
      while (auto event = in.Next()) {
        if (event->packet.channel == channel::kOrders) {
          auto orders = Decode<orders_t>(event->packet.bytes);
          for (taken_order_t& order : orders->taken) {
            if (order.json.find("task_cancel") != std::string::npos) change(&order);
          }
          event->packet.bytes = Encode(*orders);
        }
        out.Write(event->received_us, event->packet);
      }
      out.Flush();
    }
    std::string output;
    EXPECT_EQ(Command({"audit", folder}, &output), 4) << output;
    return output;
  }

  const std::string persons_ = folder_.File("persons.json");
  int commands_ = 0;
};

TEST_F(PersonsRunTest, OrdersAreTakenOfThoseWhoMayAndProvenInTheLog) {
  const std::string chief = AddPerson({"Chief", "--role", "control"});
  const std::string guest = AddPerson({"Guest", "--role", "watch"});
  const std::string key = folder_.File("radio.key"), other_key = folder_.File("eve.key");
  AddPerson({"Radio", "--role", "order", "--key-file", key});
  std::string output;
  EXPECT_EQ(Command({"person", "add", folder_.File("others.json"), "Radio", "--role", "order",
                     "--key-file", other_key},
                    &output),
            0)
      << output;
  EXPECT_EQ(Command({"person", "add", persons_, "Chief", "--role", "watch"}, &output), 2);
  EXPECT_NE(output.find("remove it first"), std::string::npos) << output;
  EXPECT_EQ(Command({"person", "list", persons_}, &output), 0);
  EXPECT_NE(output.find("Radio"), std::string::npos) << output;

  const std::string planned = folder_.File("planned.jsonl");
  std::ofstream(planned) << R"({"order": "task_cancel", "task": 7, "issuer": "eve of the day"})"
                         << "\n";
  Muster mission(
      folder_, "mission",
      {"run", scenario_, "--persons", persons_, "--orders", planned, "--live=0", "--control",
       "--rate", "360", "--out", Run(), "--fault", "process_killed:world@30"});
  ASSERT_TRUE(Eventually([&] {
    return mission.output().find("#token=TOKEN") != std::string::npos;
  })) << mission.output();
  const std::size_t at = mission.output().find("http://");
  httplib::Client page(mission.output().substr(at, mission.output().find("/#token") - at));
  page.set_read_timeout(60);
  const auto post = [&](const char* body, const std::string& token) {
    const auto answer =
        page.Post("/orders", {{"Authorization", "Bearer " + token}}, body, "application/json");
    return answer ? answer->status : 0;
  };
  EXPECT_EQ(post(R"({"order": "task_cancel", "task": 5})", guest), 403);
  EXPECT_EQ(post(R"({"order": "task_cancel", "task": 5})", "x"), 401);
  EXPECT_EQ(post(R"({"order": "pin", "task": 60, "agents": ["uav:3", "worker:7"]})", chief), 200);
  const std::vector<std::string> cancel = {"task", "cancel", Run(), "5"};
  const auto signed_with = [&](std::vector<std::string> command, const std::string& file) {
    command.insert(command.end(), {"--sign", file});
    return Command(command, &output);
  };
  EXPECT_EQ(Command(cancel, &output), 4);
  EXPECT_NE(output.find("signed orders only (--sign FILE)"), std::string::npos) << output;
  EXPECT_EQ(signed_with(cancel, other_key), 4);
  EXPECT_NE(output.find("the signature is not Radio's"), std::string::npos) << output;
  EXPECT_EQ(signed_with({"agent", "recall", Run(), "worker:3"}, key), 4);
  EXPECT_NE(output.find("agent_recall needs control"), std::string::npos) << output;
  EXPECT_EQ(signed_with(cancel, key), 0) << output;
  std::ofstream(folder_.File("rows.jsonl"))
      << R"({"order": "task_add", "task": {"x_km": 1, "y_km": 1}})"
      << "\n";
  EXPECT_EQ(signed_with({"feed", Run(), folder_.File("rows.jsonl")}, key), 0) << output;
  EXPECT_EQ(Command({"person", "remove", persons_, "Radio"}, &output), 0) << output;
  EXPECT_TRUE(Eventually([&] {
    signed_with({"task", "change", Run(), "90", "--priority", "2"}, key);
    return output.find("Radio may not order any more: removed") != std::string::npos;
  })) << output;
  ASSERT_TRUE(Eventually([&] { return mission.output().find("stays at") != std::string::npos; }))
      << mission.output();
  mission.child().Signal(SIGINT);
  EXPECT_EQ(mission.Wait(), 0) << mission.output();
  EXPECT_NE(mission.output().find("is refused: Guest has the role watch"), std::string::npos)
      << mission.output();

  std::string lines;
  const std::string before = folder_.File("before.json"), captured = folder_.File("c.jsonl");
  EXPECT_EQ(Command({"log", "orders", Run(), "--scenario", before}, &lines), 0) << lines;
  EXPECT_EQ(lines.find("signed"), std::string::npos) << lines;
  std::ofstream(captured) << lines;
  EXPECT_EQ(
      Command({"simulate", before, "--orders", captured, "--quiet", "--out", folder_.File("again")},
              &output),
      0)
      << output;
  EXPECT_EQ(Report("again")["digest"], Report()["digest"]);

  // The log proves who gave an order: what was changed afterwards is seen.
  EXPECT_NE(AuditOfChanged("digit",
                           [](taken_order_t* order) {
                             char& digit = order->json[order->json.size() - 5];
                             digit = digit == '0' ? '1' : '0';
                           })
                .find("has a signature that is not"),
            std::string::npos);
  EXPECT_NE(AuditOfChanged("bare",
                           [](taken_order_t* order) {
                             order->json.resize(order->json.rfind(",\"signed\":"));
                             order->json += "}";
                           })
                .find("is not signed"),
            std::string::npos);
  EXPECT_NE(AuditOfChanged("world",
                           [](taken_order_t* order) {
                             order->issuer = "world";
                             order->json.resize(order->json.rfind(",\"signed\":"));
                             order->json += "}";
                           })
                .find("is not signed"),
            std::string::npos);
  EXPECT_NE(AuditOfChanged("another", [](taken_order_t* order) { order->issuer = "Chief"; })
                .find("has a signature that is not"),
            std::string::npos);
}

}  // namespace
}  // namespace muster::tools
