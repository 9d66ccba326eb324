// What the live page's server does with orders; a mission's part is played by the test.
#include <gtest/gtest.h>
#include <httplib.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "base/check.h"
#include "tests/temporary_folder.h"
#include "tools/live/live_server.h"
#include "tools/orders/order_gate.h"
#include "tools/orders/order_socket.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

constexpr const char* kCancel = R"({"id": "c1", "order": "task_cancel", "task": 3})";

orders_t Taken(const order_t& order) {
  orders_t said{};
  said.tick = 7;
  said.header.sim_us = 210 * kSecondUs;
  said.taken = {{order.id, order.issuer, order.json, 3, 0, -1}};
  return said;
}

orders_t Refused(const order_t& order) {
  orders_t said{};
  said.refused = {{order.id, order.issuer, "task 3 is done"}};
  return said;
}

/// Answers every order as `answer` says, as a mission would, until it goes out of scope.
class FakeMissionAnswers {
 public:
  FakeMissionAnswers(OrderGate* gate, orders_t (*answer)(const order_t&))
      : thread_([this, gate, answer] {
          while (!end_) {
            for (const order_t& order : gate->Take(0)) {
              ++given_;
              gate->Answer(answer(order));
            }
            std::this_thread::yield();
          }
        }) {}
  ~FakeMissionAnswers() {
    end_ = true;
    thread_.join();
  }
  int given() const { return given_; }

 private:
  std::atomic<bool> end_ = false;
  std::atomic<int> given_ = 0;
  std::thread thread_;
};

class OrderServer : public ::testing::Test {
 protected:
  OrderServer() : server_(std::in_place, 0) {
    server_->Start(&feed_, &gate_);
    const std::string url = server_->url();
    const std::size_t hash = url.find("/#token=");
    token_ = url.substr(hash + 8);
    client_.emplace(url.substr(0, hash));
    client_->set_read_timeout(60);
  }
  httplib::Result Post(const std::string& body, const std::string& token) {
    return client_->Post("/orders", {{"Authorization", "Bearer " + token}}, body,
                         "application/json");
  }

  OrderGate gate_{std::nullopt};
  LiveFeed feed_{"run"};
  std::optional<LiveServer> server_;
  std::optional<httplib::Client> client_;
  std::string token_;
};

TEST_F(OrderServer, TellsWhatTheMissionTook) {
  const FakeMissionAnswers mission(&gate_, Taken);
  const auto answer = Post(kCancel, token_);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200);
  EXPECT_EQ(Json::parse(answer->body),
            Json::parse(R"({"id": "c1", "taken": {"tick": 7, "sim_s": 210.0, "task": 3}})"));
  // Given again it is the same order.
  EXPECT_EQ(Post(kCancel, token_)->body, answer->body);
  EXPECT_EQ(mission.given(), 1);
}

TEST_F(OrderServer, TellsWhyItWasRefused) {
  const FakeMissionAnswers mission(&gate_, Refused);
  const auto answer = Post(kCancel, token_);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 409);
  EXPECT_EQ(Json::parse(answer->body)["refused"], "task 3 is done");
}

TEST_F(OrderServer, WhoHasNotTheTokenGivesNone) {
  for (const std::string& token : {std::string(), std::string("x"), token_ + "0"}) {
    const auto answer = Post(kCancel, token);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 401) << token;
  }
  EXPECT_EQ(client_->Post("/orders", kCancel, "application/json")->status, 401);
  EXPECT_TRUE(gate_.Take(0).empty());
}

TEST_F(OrderServer, WhatIsNoOrderReachesNoMission) {
  for (const char* body : {"", "x", "[]", "{}", R"({"order": "task_cancel", "task": "a"})"}) {
    const auto answer = Post(body, token_);
    ASSERT_TRUE(answer) << body;
    EXPECT_GE(answer->status, 400) << body;
  }
  EXPECT_EQ(Post(std::string(100'000, ' '), token_)->status, 413);
  EXPECT_TRUE(gate_.Take(0).empty());
}

TEST_F(OrderServer, AnOrderWithoutAnAnswerIsAskedForAgain) {
  const auto pending = Post(kCancel, token_);
  ASSERT_TRUE(pending);
  EXPECT_EQ(pending->status, 202);
  for (const order_t& order : gate_.Take(0)) gate_.Answer(Taken(order));
  const httplib::Headers headers = {{"Authorization", "Bearer " + token_}};
  EXPECT_EQ(client_->Get("/orders/c1", headers)->status, 200);
  EXPECT_EQ(client_->Get("/orders/c2", headers)->status, 404);
}

TEST_F(OrderServer, ThePageAloneTakesNone) {
  LiveServer closed(0);
  LiveFeed feed("run");
  closed.Start(&feed);
  httplib::Client client(closed.url().substr(0, closed.url().size() - 1));
  EXPECT_EQ(client.Post("/orders", kCancel, "application/json")->status, 403);
}

TEST(OrderSocket, CarriesManyOrdersAndTheirAnswers) {
  const TemporaryFolder folder;
  OrderGate gate{std::nullopt};
  const FakeMissionAnswers mission(&gate, Taken);
  OrderSocket socket(folder.path(), &gate);
  OrderClient client(folder.path());
  for (int i = 0; i < 500; ++i) client.Send(R"({"order": "task_cancel", "task": 3})");
  client.Send("nonsense");
  int taken = 0, errors = 0;
  for (int i = 0; i < 501; ++i) {
    const Json answer = Json::parse(client.Receive(std::chrono::seconds(60)));
    taken += answer.contains("taken");
    errors += answer.contains("error");
  }
  EXPECT_EQ(taken, 500);
  EXPECT_EQ(errors, 1);
}

TEST(OrderSocket, TellsWhoWaitsThatTheMissionHasEnded) {
  const TemporaryFolder folder;
  OrderGate gate{std::nullopt};
  std::optional<OrderSocket> socket(std::in_place, folder.path(), &gate);
  OrderClient client(folder.path());
  client.Send(kCancel);
  while (gate.Take(0).empty()) std::this_thread::yield();
  gate.Close();
  EXPECT_EQ(Json::parse(client.Receive(std::chrono::seconds(60)))["error"],
            "the mission has ended");
  socket.reset();
  EXPECT_THROW(OrderClient{folder.path()}, InputError);
}

}  // namespace
}  // namespace muster::tools
