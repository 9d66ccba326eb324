// Who may order: the file, the launcher's desk, and what the server says to those who may not.
#include <gtest/gtest.h>
#include <httplib.h>
#include <sys/stat.h>

#include <atomic>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "base/check.h"
#include "base/sha256.h"
#include "model/generator.h"
#include "tests/temporary_folder.h"
#include "tools/live/live_server.h"
#include "tools/orders/order_gate.h"
#include "tools/orders/order_signer.h"
#include "tools/orders/persons_desk.h"
#include "world/order_desk.h"

namespace muster::tools {
namespace {

using Ordered = nlohmann::ordered_json;

constexpr std::int64_t kRun = 1796000000000000;
constexpr std::int64_t kNow = 1796000000000000;  // 2026-11-30, in microseconds
constexpr const char* kCancel3 = R"({"order": "task_cancel", "task": 3})";
constexpr const char* kPin = R"({"order": "pin", "task": 12, "agents": ["uav:3"]})";

/// A file of persons: token "t-NAME" or a key each.
class PersonsTest : public ::testing::Test {
 protected:
  void SetUp() override { Write(Everybody()); }

  Ordered Everybody() const {
    const auto person = [](const char* name, const char* role) {
      return Ordered{{"name", name}, {"role", role}, {"token_sha256", Sha256(TokenOf(name))}};
    };
    Ordered gone = person("Gone", "control");
    gone["until"] = "2026-11-29T00:00:00Z";
    return {person("Chief", "control"),
            person("Radio", "order"),
            person("Guest", "watch"),
            gone,
            {{"name", "Ada"}, {"role", "order"}, {"key", ada_.key.Public()}}};
  }
  static std::string TokenOf(const std::string& name) { return "t-" + name; }
  void Write(const Ordered& persons) {
    std::ofstream(file_) << Ordered{{"persons", persons}}.dump();
    // Two writes within one step of the file system's clock have to differ.
    times_[1].tv_sec += 1;
    utimensat(AT_FDCWD, file_.c_str(), times_, 0);
  }
  /// An order signed by that key in that name, for that run.
  static std::string Signed(const std::string& json, const std::string& by, const SigningKey& key,
                            std::int64_t run = kRun, const std::string& id = "s1") {
    const Ordered order = Ordered::parse(json);
    SignedOrder parts{order.dump(), by, by, ""};
    Ordered sent = order;
    sent["id"] = id;
    sent["issuer"] = by;
    sent["signed"] = {{"by", by}, {"signature", key.Sign(TextToSign(run, id, by, parts))}};
    return sent.dump();
  }

  TemporaryFolder folder_;
  const std::string file_ = folder_.File("persons.json");
  timespec times_[2] = {{0, 0}, {1'000'000, 0}};
  const PersonKey ada_{"Ada", SigningKey::Fresh()};
};

TEST_F(PersonsTest, BadFilesAreNamedWithTheirKey) {
  const auto error = [&](const std::string& text) -> std::string {
    std::ofstream(file_) << text;
    try {
      ReadPersons(file_);
    } catch (const InputError& refusal) {
      return refusal.what();
    }
    return "";
  };
  const auto of = [&](const Ordered& person) {
    return error(Ordered{{"persons", {person}}}.dump());
  };
  EXPECT_NE(error("x").find("persons.json"), std::string::npos);
  EXPECT_NE(error("{}").find("persons"), std::string::npos);
  EXPECT_NE(of({{"name", ""}, {"role", "watch"}}).find("name"), std::string::npos);
  EXPECT_NE(of({{"name", "launcher"}, {"role", "watch"}}).find("launcher"), std::string::npos);
  EXPECT_NE(of({{"name", "world"}, {"role", "watch"}}).find("name"), std::string::npos);
  EXPECT_NE(of({{"name", "a\nb"}, {"role", "watch"}}).find("name"), std::string::npos);
  EXPECT_NE(of({{"name", "A"}, {"role", "boss"}}).find("watch, order or control"),
            std::string::npos);
  EXPECT_NE(of({{"name", "A"}, {"role", "none"}}).find("role"), std::string::npos);
  EXPECT_NE(of({{"name", "A"}, {"role", "watch"}, {"key", "12"}}).find("64"), std::string::npos);
  EXPECT_NE(of({{"name", "A"}, {"role", "watch"}, {"token", "x"}}).find("token"),
            std::string::npos);
  EXPECT_NE(of({{"name", "A"}, {"role", "watch"}, {"until", "noon"}}).find("ISO 8601"),
            std::string::npos);
  const Ordered a = {{"name", "A"}, {"role", "watch"}};
  EXPECT_NE(error(Ordered{{"persons", {a, a}}}.dump()).find("each name once"), std::string::npos);
  EXPECT_EQ(of(a), "");
}

TEST_F(PersonsTest, AKeyFileIsItsOwnersAlone) {
  const std::string file = folder_.File("ada.key");
  WritePersonKey(ada_, file);
  EXPECT_EQ(LoadPersonKey(file).name, "Ada");
  EXPECT_EQ(LoadPersonKey(file).key.Public(), ada_.key.Public());
  chmod(file.c_str(), 0644);
  try {
    LoadPersonKey(file);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("chmod 600"), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find(ada_.key.Secret()), std::string::npos);
  }
}

/// What is taken, and what is refused, with the reason.
TEST_F(PersonsTest, EachMisuseIsRefusedAndNamed) {
  PersonsDesk desk(file_, kRun, kNow, SigningKey::Fresh());
  desk.Planned();
  OrderGate gate(std::nullopt, &desk);
  const auto why = [&](const std::string& json, const std::string& token) -> std::string {
    try {
      gate.Give(json, "page", token);
    } catch (const NotAllowed& refusal) {
      return refusal.what();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  // Theirs.
  EXPECT_EQ(why(kCancel3, "t-Radio"), "");
  EXPECT_EQ(why(kPin, "t-Chief"), "");
  EXPECT_EQ(why(Signed(kCancel3, "Ada", ada_.key), ""), "");
  EXPECT_EQ(gate.Take(kNow).size(), 3U);
  // Given again it is the same order, and nothing more happens.
  EXPECT_EQ(why(Signed(kCancel3, "Ada", ada_.key), ""), "");
  EXPECT_TRUE(gate.Take(kNow).empty());

  EXPECT_EQ(why(kCancel3, ""), "this mission takes signed orders only (--sign FILE)");
  EXPECT_EQ(why(kCancel3, "t-Nobody"), "nobody has that token, or not any more");
  EXPECT_EQ(why(kCancel3, Sha256("t-Chief")), "nobody has that token, or not any more");
  EXPECT_EQ(why(kCancel3, "t-Gone"), "nobody has that token, or not any more");
  EXPECT_EQ(why(kCancel3, "t-Guest"), "Guest has the role watch; task_cancel needs order");
  EXPECT_EQ(why(kPin, "t-Radio"), "Radio has the role order; pin needs control");
  EXPECT_EQ(why(Signed(kPin, "Ada", ada_.key), ""), "Ada has the role order; pin needs control");
  const std::string not_hers = "the signature is not Ada's for this order of this run";
  EXPECT_EQ(why(Signed(kCancel3, "Ada", SigningKey::Fresh()), ""), not_hers);
  EXPECT_EQ(why(Signed(kCancel3, "Ada", ada_.key, kRun + 1), ""), not_hers);
  Ordered changed = Ordered::parse(Signed(kCancel3, "Ada", ada_.key));
  changed["task"] = 4;
  EXPECT_EQ(why(changed.dump(), ""), not_hers);
  changed = Ordered::parse(Signed(kCancel3, "Ada", ada_.key));
  changed["id"] = "s2";
  EXPECT_EQ(why(changed.dump(), ""), not_hers);
  changed = Ordered::parse(Signed(kCancel3, "Ada", ada_.key));
  changed["issuer"] = "Chief";
  EXPECT_EQ(why(changed.dump(), ""), not_hers);
  changed = Ordered::parse(Signed(kCancel3, "Ada", ada_.key));
  changed["signed"]["by"] = "Chief";  // who has a token, and no key
  EXPECT_EQ(why(changed.dump(), ""), "the signature is not Chief's for this order of this run");
  EXPECT_EQ(why(Signed(kCancel3, "Eve", ada_.key), ""), "this mission knows nobody named Eve");
  EXPECT_EQ(why(Signed(kCancel3, "Gone", ada_.key), ""), "Gone may not order any more: expired");
  EXPECT_EQ(why(Signed(kCancel3, "launcher", ada_.key), ""),
            "this mission knows nobody named launcher");
  changed["signed"] = "x";
  EXPECT_NE(why(changed.dump(), "").find("signed.by"), std::string::npos);
  const char* const person = R"({"order": "person", "name": "Eve", "role": "control"})";
  EXPECT_NE(why(person, "t-Chief").find("the launcher gives it"), std::string::npos);
  EXPECT_TRUE(gate.Take(kNow).empty());
}

TEST_F(PersonsTest, WhoIsTakenOutOfTheFileMayOrderNothingMore) {
  PersonsDesk desk(file_, kRun, kNow, SigningKey::Fresh());
  EXPECT_EQ(desk.Planned().size(), 6U);
  EXPECT_TRUE(desk.Changes(kNow + 2'000'000).empty());
  Ordered persons = Everybody();
  persons.erase(0);
  persons[0]["role"] = "control";
  persons.push_back({{"name", "New"}, {"role", "watch"}});
  Write(persons);
  std::map<std::string, std::string> roles;
  for (const order_t& order : desk.Changes(kNow + 4'000'000)) {
    const Ordered json = Ordered::parse(order.json);
    roles[json["name"]] = json["role"].get<std::string>() + json.value("why", "");
  }
  EXPECT_EQ(roles, (std::map<std::string, std::string>{
                       {"Chief", "noneremoved"}, {"New", "watch"}, {"Radio", "control"}}));
  EXPECT_EQ(desk.OfToken("t-Chief"), nullptr);
  EXPECT_NE(desk.OfToken("t-Radio"), nullptr);
  // A file that is wrong changes nothing.
  std::ofstream(file_) << "{";
  EXPECT_TRUE(desk.Changes(kNow + 6'000'000).empty());
  EXPECT_NE(desk.OfToken("t-Radio"), nullptr);
  // Time passes.
  persons[0]["until"] = "2026-12-01T00:00:00Z";
  Write(persons);
  EXPECT_TRUE(desk.Changes(kNow + 8'000'000).empty());
  EXPECT_EQ(desk.Changes(kNow + 86'400'000'000 * 3).size(), 1U);
  EXPECT_EQ(desk.OfToken("t-Radio"), nullptr);
}

/// The world looks at each order once more, because any program on the mission's network can send
/// one.
TEST_F(PersonsTest, TheWorldTakesWhatIsSignedAndNothingElse) {
  PersonsDesk persons(file_, kRun, kNow, SigningKey::Fresh());
  const std::string lines = folder_.File("orders.jsonl");
  std::ofstream(lines) << persons.SignedLines(persons.Planned());
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  AddRoom({5, {}}, &scenario);
  world::OrderDesk desk(scenario, world::ReadPlannedOrders(lines));
  world::Agents agents;
  for (const AgentKind kind : kAgentKinds) {
    for (const AgentSpec& spec : scenario.agents(kind)) {
      const auto id = static_cast<std::int32_t>(agents[kind].size());
      agents[kind].push_back(StartOf(kind, id, spec, StraightWays()));
    }
  }
  const std::vector<TaskStatus> status(scenario.tasks.size(), TaskStatus::kOpen);
  std::int64_t tick = 0;
  const auto decide = [&] {
    orders_t said = desk.Decide(tick++, status, agents);
    desk.Take(said);
    return said;
  };
  OrderGate gate(std::nullopt, &persons);
  const auto given = [&](const std::string& json, const std::string& token) {
    gate.Give(json, "page", token);
    return gate.Take(kNow).back();
  };
  const order_t early = given(kCancel3, "t-Radio");
  EXPECT_FALSE(desk.Admits(early, kRun)) << "nobody is known yet";
  EXPECT_EQ(decide().n_taken, 6);

  ASSERT_TRUE(desk.Admits(early, kRun));
  EXPECT_FALSE(desk.Admits(early, kRun + 1));
  const auto with = [&](auto change) {
    order_t order = early;
    change(&order);
    return desk.Admits(order, kRun);
  };
  EXPECT_FALSE(with([](order_t* o) { o->json = kCancel3; }));
  EXPECT_FALSE(with([](order_t* o) { o->id = "other"; }));
  EXPECT_FALSE(with([](order_t* o) { o->issuer = "Chief"; }));
  EXPECT_FALSE(with([](order_t* o) { o->issuer = "world"; }));
  EXPECT_FALSE(with([](order_t* o) { o->json[20] ^= 1; }));
  EXPECT_FALSE(with([](order_t* o) { o->json.replace(o->json.find("Radio"), 5, "Chief"); }));
  EXPECT_FALSE(with([](order_t* o) { o->json.replace(o->json.find("launcher"), 8, "Ada"); }));
  EXPECT_FALSE(with([](order_t* o) { o->json += " "; }));
  const std::string own = Signed(kCancel3, "Ada", ada_.key, kRun, "s9");
  EXPECT_TRUE(desk.Admits(given(own, ""), kRun));

  // What the launcher would not pass on: the role counts here too.
  SignedOrder pin{Ordered::parse(kPin).dump(), "Ada", "Ada", ""};
  pin.signature = ada_.key.Sign(TextToSign(kRun, "p", "Ada", pin));
  order_t forged{};
  forged.id = "p";
  forged.issuer = "Ada";
  forged.json = ToJson(pin);
  ASSERT_TRUE(desk.Admits(forged, kRun));
  desk.Hear(forged);
  desk.Hear(early);
  // Another one of that id: it is not looked at, and the first is kept.
  order_t second = early;
  second.json = kCancel3;
  EXPECT_TRUE(desk.Admits(second, kRun));
  EXPECT_TRUE(desk.Hear(second));
  const orders_t said = decide();
  ASSERT_EQ(said.n_refused, 1);
  EXPECT_EQ(said.refused[0].reason, "Ada has the role order; pin needs control");
  ASSERT_EQ(said.n_taken, 1);
  EXPECT_EQ(said.taken[0].issuer, "Radio");
  EXPECT_EQ(said.taken[0].json, early.json);

  // Signed in time, and its giver is removed before the tick.
  const order_t late = given(R"({"order": "task_cancel", "task": 9})", "t-Radio");
  Ordered rest = Everybody();
  rest.erase(1);
  Write(rest);
  for (const order_t& order : persons.Changes(kNow + 2'000'000)) {
    ASSERT_TRUE(desk.Admits(order, kRun));
    desk.Hear(order);
  }
  desk.Hear(late);
  const orders_t then = decide();
  ASSERT_EQ(then.n_refused, 1);
  EXPECT_EQ(then.refused[0].reason, "Radio may not order any more: removed");
}

TEST_F(PersonsTest, TheServerSaysWhoMayNot) {
  PersonsDesk desk(file_, kRun, kNow, SigningKey::Fresh());
  OrderGate gate(std::nullopt, &desk);
  LiveFeed feed("run");
  LiveServer server(0);
  server.Start(&feed, &gate);
  const std::string url = server.url();
  ASSERT_TRUE(url.ends_with("/#token=TOKEN")) << url;
  httplib::Client client(url.substr(0, url.find("/#")));
  client.set_read_timeout(60);
  const auto post = [&](const char* body, const std::string& token) {
    httplib::Headers headers;
    if (!token.empty()) headers.emplace("Authorization", "Bearer " + token);
    return client.Post("/orders", headers, body, "application/json");
  };
  // A mission that takes all that reaches it.
  std::atomic<int> taken = 0;
  const std::jthread mission([&](const std::stop_token& end) {
    while (!end.stop_requested()) {
      for (const order_t& order : gate.Take(kNow)) {
        ++taken;
        orders_t said{};
        said.taken = {{order.id, order.issuer, order.json, 3, 0, -1}};
        gate.Answer(said);
      }
      std::this_thread::yield();
    }
  });
  EXPECT_EQ(post(kCancel3, "")->status, 401);
  EXPECT_EQ(post(kCancel3, "t-Nobody")->status, 401);
  const auto watcher = post(kCancel3, "t-Guest");
  EXPECT_EQ(watcher->status, 403);
  EXPECT_EQ(Ordered::parse(watcher->body)["refused"],
            "Guest has the role watch; task_cancel needs order");
  EXPECT_EQ(post(kCancel3, "t-Radio")->status, 200);
  EXPECT_EQ(post(Signed(kCancel3, "Ada", ada_.key).c_str(), "")->status, 200);
  EXPECT_EQ(client.Get("/orders/s1")->status, 401);
  EXPECT_EQ(client.Get("/orders/s1", {{"Authorization", "Bearer t-Guest"}})->status, 200);
  EXPECT_EQ(client.Post("/what-if", kPin, "application/json")->status, 401);
  EXPECT_EQ(taken, 2);
}

}  // namespace
}  // namespace muster::tools
