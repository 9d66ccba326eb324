// Missions that are sealed per process: what the thief of one process's key can say.
#include "lcmtypes/bus/member_keys.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/lossy_bus.h"
#include "lcmtypes/bus/seal.h"
#include "lcmtypes/channels.h"
#include "tests/lcmtypes/queue_bus.h"
#include "tests/temporary_folder.h"

namespace muster {
namespace {

using Json = nlohmann::json;

const SealKey kRunKey =
    SealKey::Parse("000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f", "here")
        .Of(7, "here");

MemberKeys AllKeys() {
  const auto block = [](AgentKind kind, std::int32_t first, std::int32_t last) {
    return std::optional<AgentBlock>({kind, first, last});
  };
  return MemberKeys::Of(kRunKey.bytes, 7, "launcher",
                        {{"world", {}},
                         {"scheduler-1", {}},
                         {"scheduler-2", {}},
                         {"recorder", {}},
                         {"launcher", {}},
                         {"uav-1", block(AgentKind::kUav, 0, 4)},
                         {"uav-2", block(AgentKind::kUav, 5, 9)},
                         {"worker", block(AgentKind::kWorker, 0, 9)}});
}

/// What the owner of that process's key file has.
MemberKeys KeysOf(const std::string& process) {
  return MemberKeys::Parse(AllKeys().Text({process}), process);
}

/// A message of `sender` on that channel, told by `fill`.
template <class T>
Packet Of(
    std::string_view channel, const std::string& sender, void (*fill)(T*) = [](T*) {}) {
  T message{};
  message.header.run_id = 7;
  message.header.sender = sender;
  fill(&message);
  EXPECT_TRUE(Valid(message)) << channel;
  return {std::string(channel), Encode(message)};
}

template <int first, int last>
void Report(agent_states_t* m) {
  for (int id = first; id <= last; ++id) m->agents.emplace_back().id = id;
  m->n = last - first + 1;
}
template <int first, int last>
void Change(agent_changes_t* m) {
  m->tick = 1;
  m->first_id = first;
  m->last_id = last;
}
template <EventKind kind, int uav>
void Tell(event_t* m) {
  m->kind = NumberOf(kind);
  m->uav_id = uav;
  m->worker_id = m->vehicle_id = m->task_id = m->charge_id = -1;
}

void Order(order_t* m) {
  m->id = "o";
  m->issuer = "thief";
  m->json = R"({"order": "task_cancel", "task": 1})";
}

/// An answer of `sender` that repeats that message.
Packet Repeating(const std::string& sender, const Packet& repeated) {
  answer_t answer{};
  answer.header.run_id = 7;
  answer.header.sender = sender;
  answer.asker = "world";
  answer.channel = repeated.channel;
  answer.data = repeated.bytes;
  answer.n = static_cast<std::int32_t>(answer.data.size());
  return {std::string(channel::kAnswer), Encode(answer)};
}

/// The thief's signature under any name: as if all senders had the stolen key.
Tag SignedByThief(const std::string& stolen, const Packet& packet) {
  Json keys = Json::parse(AllKeys().Text({stolen}));
  Json& members = keys["members"];
  const Json key = members[stolen];
  for (Json& member : members) member = key;
  return MemberKeys::Parse(keys.dump(), "thief").Sign(packet);
}

TEST(MemberKeys, AreDerivedFromTheRunsKeyAndTheName) {
  // Of an implementation of RFC 8032 in Python, with the seed
  // blake2b(b"muster process world", key=run, digest_size=32), and run as in seal_test.cc.
  const Json text = Json::parse(AllKeys().Text());
  EXPECT_EQ(text["members"]["world"]["public"],
            "86528992230743662bddb0093b17aa870019e4eeab5e05820cf1e0562fea8905");
  EXPECT_TRUE(AllKeys().AreOf(kRunKey.bytes));
  EXPECT_FALSE(AllKeys().AreOf(SealKey::Fresh(7).bytes));
}

TEST(MemberKeys, AProcessesKeyFileHasItsOwnSecretAlone) {
  const Json text = Json::parse(AllKeys().Text({"uav-1"}));
  for (const auto& [name, member] : text["members"].items()) {
    EXPECT_EQ(member.contains("secret"), name == "uav-1") << name;
  }
  EXPECT_EQ(text["members"]["uav-2"]["agents"], "uav:5-9");
  EXPECT_EQ(AllKeys().Text().find("secret"), std::string::npos);
  EXPECT_EQ(KeysOf("uav-1").Text({"uav-1"}), AllKeys().Text({"uav-1"}));
}

TEST(MemberKeys, AProcessSpeaksForItself) {
  const MemberKeys all = AllKeys();
  const std::string uav = "uav-1";
  const Packet states = Of<agent_states_t>(channel::kUavs, uav, Report<0, 4>);
  for (const Packet& packet :
       {states, Of<agent_changes_t>(channel::kUavChanges, uav, Change<0, 4>),
        Of<event_t>(channel::kDriver, uav, Tell<EventKind::kDriverFailed, 3>),
        Of<event_t>(channel::kEvent, uav, Tell<EventKind::kFaultApplied, -1>),
        Of<process_status_t>(channel::kProcess, uav,
                             [](process_status_t* m) { m->name = "uav-1"; }),
        Of<request_t>(channel::kRequest, uav, [](request_t* m) { m->channel = channel::kWorld; }),
        Repeating(uav, states)}) {
    const Tag signature = KeysOf(uav).Sign(packet);
    EXPECT_EQ(signature.size(), kSignatureBytes) << packet.channel;
    EXPECT_TRUE(all.Proves(packet, signature)) << packet.channel;
    EXPECT_FALSE(all.Proves(packet, Tag(kSignatureBytes, 0x55))) << packet.channel;
    EXPECT_FALSE(all.Proves(packet, {})) << packet.channel;
  }
}

TEST(MemberKeys, AStolenKeySpeaksForNobodyElse) {
  const MemberKeys all = AllKeys();
  const std::string uav = "uav-1";
  std::map<std::string, Packet> misuses = {
      {"the world's clock", Of<clock_t>(channel::kClock, "world")},
      {"the world's verdict", Of<world_state_t>(channel::kWorld, "world")},
      {"a clock of its own", Of<clock_t>(channel::kClock, uav)},
      {"a scheduler's schedule", Of<schedule_t>(channel::kSchedule, "scheduler")},
      {"a schedule of its own", Of<schedule_t>(channel::kSchedule, uav)},
      {"the recorder's marks", Of<log_status_t>(channel::kLog, "recorder")},
      {"marks of its own", Of<log_status_t>(channel::kLog, uav)},
      {"another process's agents, as itself",
       Of<agent_states_t>(channel::kUavs, uav, Report<4, 5>)},
      {"another process's agents, as that",
       Of<agent_states_t>(channel::kUavs, "uav-2", Report<5, 9>)},
      {"changes of another process's agents",
       Of<agent_changes_t>(channel::kUavChanges, uav, Change<4, 5>)},
      {"agents of another class", Of<agent_states_t>(channel::kWorkers, uav,
                                                     [](agent_states_t* m) {
                                                       Report<0, 0>(m);
                                                       m->kind = NumberOf(AgentKind::kWorker);
                                                     })},
      {"another process's driver",
       Of<event_t>(channel::kDriver, uav, Tell<EventKind::kDriverFailed, 5>)},
      {"a fault, as itself", Of<fault_t>(channel::kFault, uav)},
      {"a fault, as the launcher", Of<fault_t>(channel::kFault, "launcher")},
      {"an order, as itself", Of<order_t>(channel::kOrder, uav, Order)},
      {"an order, as the launcher", Of<order_t>(channel::kOrder, "launcher", Order)},
      {"that a task is done", Of<event_t>(channel::kEvent, uav, Tell<EventKind::kSensingDone, 0>)},
      {"the end of another process", Of<process_status_t>(channel::kProcess, "world",
                                                          [](process_status_t* m) {
                                                            m->name = "world";
                                                            m->state =
                                                                NumberOf(ProcessState::kEnded);
                                                          })},
      {"what the world said, repeated",
       Repeating(uav, Of<world_state_t>(channel::kWorld, "world"))},
      {"what it says the world said", Repeating(uav, Of<world_state_t>(channel::kWorld, uav))},
      {"another's agents, repeated",
       Repeating(uav, Of<agent_states_t>(channel::kUavs, "uav-2", Report<5, 9>))},
      {"the orders so far",
       Repeating(uav, {std::string(channel::kOrders), Encode(order_book_t{})})},
      {"that nothing has begun", Repeating(uav, {std::string(channel::kUavs), {}})},
      {"a sender that nobody knows", Of<process_status_t>(channel::kProcess, "uav-3")},
      {"no message", {std::string(channel::kClock), {1, 2, 3}}},
      {"another channel", {"SOMETHING", {1, 2, 3}}}};
  for (const auto& [what, packet] : misuses) {
    EXPECT_FALSE(all.Proves(packet, SignedByThief(uav, packet))) << what;
  }
  // Those whose words these are may say them.
  for (const auto& [sender, what] :
       std::map<std::string, std::string>{{"world", "the world's clock"},
                                          {"launcher", "a fault, as the launcher"},
                                          {"recorder", "the recorder's marks"},
                                          {"uav-2", "another process's agents, as that"}}) {
    EXPECT_TRUE(all.Proves(misuses[what], KeysOf(sender).Sign(misuses[what]))) << what;
  }
}

TEST(MemberKeys, TheLauncherAndTheWorldRepeatWhatOthersHaveSaid) {
  const MemberKeys all = AllKeys();
  for (const char* const sender : {"launcher", "world"}) {
    const Packet packet =
        Repeating(sender, Of<agent_states_t>(channel::kUavs, "uav-1", Report<0, 4>));
    EXPECT_TRUE(all.Proves(packet, KeysOf(sender).Sign(packet))) << sender;
  }
  const Packet packet =
      Repeating("scheduler-1", Of<agent_states_t>(channel::kUavs, "uav-1", Report<0, 4>));
  EXPECT_FALSE(all.Proves(packet, KeysOf("scheduler-1").Sign(packet)));
}

TEST(MemberKeys, OneOfSeveralSchedulersProposesAlone) {
  const MemberKeys all = AllKeys();
  const auto proposal = [](const std::string& sender) {
    return Of<proposal_t>(channel::kProposal, sender, [](proposal_t* m) {
      m->schedule.header = m->header;
      m->schedule.header.sender = "scheduler";
    });
  };
  EXPECT_TRUE(
      all.Proves(proposal("scheduler-1"), KeysOf("scheduler-1").Sign(proposal("scheduler-1"))));
  EXPECT_FALSE(
      all.Proves(proposal("scheduler-2"), SignedByThief("scheduler-1", proposal("scheduler-2"))));
  EXPECT_FALSE(all.Proves(proposal("uav-1"), KeysOf("uav-1").Sign(proposal("uav-1"))));
}

TEST(MemberKeys, WhatIsSentOnKeepsItsSignature) {
  auto* const queue = new testing::QueueBus;  // the bus's own
  LossyBus world(std::unique_ptr<Bus>(queue), 1, "world", [] { return 0; });
  const MemberKeys all =
      MemberKeys::Of(kRunKey.bytes, 7, "world", {{"world", {}}, {"scheduler", {}}});
  const Packet heard = Of<schedule_t>(channel::kSchedule, "scheduler");
  world.SetSeal(Seal(MemberKeys::Parse(all.Text({"world"}), "world")));
  world.Publish(heard);
  EXPECT_EQ(queue->sent.back(), heard) << "nothing to sign it with";
  queue->arriving.push_back(Seal(all).Closed(heard));
  ASSERT_EQ(world.Receive(0).size(), 1U);
  world.Publish(heard);
  EXPECT_EQ(queue->sent.back(), Seal(all).Closed(heard));
}

TEST(MemberKeys, BadFilesAreNamedAndNoSecretIsShown) {
  const std::string good = AllKeys().Text({"uav-1"});
  const std::string secret = Json::parse(good)["members"]["uav-1"]["secret"];
  const auto error = [&](const Json& json) -> std::string {
    try {
      MemberKeys::Parse(json.dump(), "uav-1.key");
    } catch (const InputError& found) {
      return found.what();
    }
    return "none";
  };
  const auto with = [&](const auto& change) {
    Json json = Json::parse(good);
    change(&json);
    return error(json);
  };
  EXPECT_EQ(with([](Json*) {}), "none");
  std::vector<std::string> errors = {
      with([](Json* j) { (*j)["version"] = 2; }),
      with([](Json* j) { (*j)["launcher"] = "nobody"; }),
      with([](Json* j) { (*j)["more"] = 1; }),
      with([](Json* j) { j->erase("members"); }),
      with([](Json* j) { (*j)["members"]["world"]["public"] = "00"; }),
      with([&](Json* j) { (*j)["members"]["uav-1"]["secret"] = secret.substr(1); }),
      with([&](Json* j) { (*j)["members"]["world"]["secret"] = secret; }),
      with([](Json* j) { (*j)["members"]["uav-1"]["agents"] = "uav:4-0"; }),
      with([](Json* j) { (*j)["members"]["uav-1"]["agents"] = "uav"; }),
      with([](Json* j) { (*j)["members"]["uav-1"]["agents"] = "plane:0-4"; })};
  for (const std::string& text : errors) {
    EXPECT_EQ(text.rfind("uav-1.key: ", 0), 0U) << text;
    EXPECT_NE(text.find("expected"), std::string::npos) << text;
    EXPECT_EQ(text.find(secret.substr(1)), std::string::npos) << text;
  }
}

TEST(MemberKeys, AProcessLoadsItsOwnKeyAndNotTheMissions) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder.File(name)) << text;
    EXPECT_EQ(chmod(folder.File(name).c_str(), 0600), 0);
    return folder.File(name);
  };
  const Seal seal = Seal::Load(write("uav-1.key", AllKeys().Text({"uav-1"})), 7);
  EXPECT_EQ(seal.tag_bytes(), kSignatureBytes);
  const Packet states = Of<agent_states_t>(channel::kUavs, "uav-1", Report<0, 4>);
  Packet closed = seal.Closed(states);
  EXPECT_TRUE(Seal(AllKeys()).Open(&closed));
  EXPECT_EQ(closed, states);
  EXPECT_EQ(CutTag(&(closed = seal.Closed(states))).size(), kSignatureBytes);
  EXPECT_THROW(Seal::Load(folder.File("uav-1.key"), 8), InputError) << "another run's";
  SealKey mission = kRunKey;
  mission.per_process = true;
  EXPECT_TRUE(SealKey::Parse(mission.Text(), "here").per_process);
  EXPECT_THROW(Seal::Load(write("seal.key", mission.Text()), 7), InputError);
}

}  // namespace
}  // namespace muster
