#include "tools/faults/fault_injector.h"

#include <gtest/gtest.h>

#include <csignal>

#include "lcmtypes/bus/codec.h"
#include "tests/lcmtypes/queue_bus.h"

namespace muster::tools {
namespace {

struct FakeMission : FaultActions {
  SentPacket Publish(const fault_t& fault) override {
    published.push_back(fault);
    return std::make_shared<const Packet>(Packet{fault.fault_id, {}});
  }
  void SendAgain(const SentPacket& packet) override { again.push_back(packet->channel); }
  void Confirm(EventKind kind, const std::string& id) override {
    confirmed.push_back({NumberOf(kind), id});
  }
  bool IsRunning(const std::string&) override { return !down; }
  bool SignalProcess(const std::string& name, int signal) override {
    if (down) return false;
    signals.push_back({name, signal});
    return true;
  }
  void HoldRestart(const std::string& name) override { held.insert(name); }
  void ReleaseRestart(const std::string& name) override { held.erase(name); }
  void SetDiskFull(bool full) override { disk_full = full; }
  bool IsStopped(const std::string&) const override { return stopped; }
  bool IsGone(const std::string& name) const override { return gone.count(name) > 0; }
  std::int64_t BootOf(const std::string& name) const override {
    return name == "uav" ? uav_boot : 0;
  }

  std::vector<fault_t> published;
  std::vector<std::string> again;
  std::vector<std::pair<int, std::string>> confirmed;
  std::vector<std::pair<std::string, int>> signals;
  std::set<std::string> held;
  std::set<std::string> gone;
  bool disk_full = false;
  bool down = false;
  bool stopped = false;
  std::int64_t uav_boot = 0;
};

event_t Said(std::int8_t kind, const std::string& id, const std::string& sender,
             std::int64_t boot_id = 0) {
  event_t event{};
  event.kind = kind;
  event.fault_id = id;
  event.header.sender = sender;
  event.header.boot_id = boot_id;
  return event;
}

TEST(FaultInjector, RepeatsUntilEveryStartThatItConcernsHasConfirmed) {
  FakeMission mission;
  FaultInjector injector({ParseFaultFlag("loss:*@1+1=0.3", 0)}, {"world", "uav"});
  TimeUs now_us = 0;
  const auto step = [&](TimeUs mission_us) {
    now_us += kSecondUs;
    mission.again.clear();
    injector.Step(mission_us, now_us, &mission);
    return mission.again.size();
  };
  step(kMinuteUs - 1);
  EXPECT_TRUE(mission.published.empty()) << "not due";
  step(kMinuteUs);
  ASSERT_EQ(mission.published.size(), 1u);
  EXPECT_EQ(mission.published[0].for_us, kMinuteUs);
  EXPECT_EQ(step(kMinuteUs), 1u);
  injector.OnEvent(Said(13, "flag0", "world"));
  EXPECT_EQ(step(kMinuteUs), 1u);
  injector.OnEvent(Said(13, "flag0", "uav"));
  EXPECT_EQ(step(kMinuteUs), 0u);
  mission.uav_boot = 1;  // it knows nothing of what its previous start was told
  EXPECT_EQ(step(kMinuteUs), 1u);
  injector.OnEvent(Said(13, "flag0", "uav", 1));
  EXPECT_EQ(step(kMinuteUs), 0u);

  step(2 * kMinuteUs);
  ASSERT_EQ(mission.published.size(), 2u);
  EXPECT_EQ(mission.published[1].for_us, 0) << "the end";
  EXPECT_EQ(step(2 * kMinuteUs), 1u);
  injector.OnEvent(Said(14, "flag0", "world"));
  EXPECT_FALSE(injector.Settled(mission));
  EXPECT_TRUE(injector.WithoutEffect().empty()) << "the start that died may have lost packets";
  event_t last = Said(14, "flag0", "uav", 1);
  last.detail = HitsText("uav", 7);
  injector.OnEvent(last);
  EXPECT_EQ(step(2 * kMinuteUs), 0u);
  EXPECT_TRUE(injector.Settled(mission));
  EXPECT_TRUE(injector.WithoutEffect().empty());
}

TEST(FaultInjector, AFaultThatHitNoPacketHadNoEffect) {
  FakeMission mission;
  FaultInjector injector({ParseFaultFlag("loss:uav@1+1=0.3", 0)}, {"world", "uav"});
  injector.Step(kMinuteUs, 0, &mission);
  injector.OnEvent(Said(13, "flag0", "uav"));
  injector.Step(2 * kMinuteUs, kSecondUs, &mission);
  event_t end = Said(14, "flag0", "uav");
  end.detail = HitsText("uav", 0);
  injector.OnEvent(end);
  EXPECT_EQ(injector.WithoutEffect(),
            std::vector<std::string>{"fault flag0 (loss uav): it hit no packet"});
}

TEST(FaultInjector, WhoDiesWithItsConfirmationMayHaveBeenHit) {
  const std::vector<std::string> unconfirmed = {
      "fault flag0 (reordering uav): no process has confirmed it"};
  for (const char* dead : {"uav", "world"}) {
    FakeMission mission;
    FaultInjector injector({ParseFaultFlag("reordering:uav@1+1=0.3", 0)}, {"world", "uav"});
    injector.Step(kMinuteUs, 0, &mission);
    EXPECT_EQ(injector.WithoutEffect(), unconfirmed);
    EXPECT_FALSE(injector.OnDeath(dead, &mission)) << "not of the plan's making";
    injector.Step(2 * kMinuteUs, kSecondUs, &mission);
    EXPECT_EQ(injector.WithoutEffect().empty(), dead == std::string("uav"));
  }
  // One that is dead as the fault begins may be started again after it.
  FakeMission mission;
  mission.down = true;
  FaultInjector injector({ParseFaultFlag("reordering:uav@1+1=0.3", 0)}, {"world", "uav"});
  injector.Step(kMinuteUs, 0, &mission);
  injector.Step(2 * kMinuteUs, kSecondUs, &mission);
  EXPECT_TRUE(injector.WithoutEffect().empty());
}

TEST(FaultInjector, StopsForRealSecondsWhileTheMissionStandsStill) {
  FakeMission mission;
  FaultInjector injector({ParseFaultFlag("process_stopped:uav@1+2s", 0)}, {"uav"});
  injector.Step(kMinuteUs, 0, &mission);
  EXPECT_TRUE(mission.confirmed.empty()) << "the signal is out, the process not seen to stand";
  mission.stopped = true;
  injector.Step(kMinuteUs, 2 * kSecondUs - 1, &mission);
  EXPECT_EQ(mission.confirmed.size(), 1u);
  ASSERT_EQ(mission.signals.size(), 1u);
  EXPECT_EQ(mission.signals[0], std::pair(std::string("uav"), SIGSTOP));
  injector.Step(kMinuteUs, 2 * kSecondUs, &mission);
  ASSERT_EQ(mission.signals.size(), 2u);
  EXPECT_EQ(mission.signals[1].second, SIGCONT);
  EXPECT_EQ(mission.confirmed.size(), 2u);
}

TEST(FaultInjector, KillsWhenThereIsSomethingToKillAndHoldsItsRestart) {
  FakeMission mission;
  mission.down = true;
  FaultInjector injector({ParseFaultFlag("process_killed:uav@1+3s", 0)}, {"uav"});
  injector.Step(kMinuteUs, 0, &mission);
  EXPECT_TRUE(mission.published.empty());
  EXPECT_FALSE(injector.OnDeath("uav", &mission)) << "not of the plan's making";
  EXPECT_EQ(injector.WithoutEffect(),
            std::vector<std::string>{"fault flag0 (process_killed uav): its time did not come"});
  mission.down = false;
  injector.Step(kMinuteUs, kSecondUs, &mission);
  EXPECT_TRUE(mission.confirmed.empty());
  EXPECT_TRUE(injector.OnDeath("uav", &mission));
  EXPECT_EQ(mission.confirmed, (std::vector<std::pair<int, std::string>>{{13, "flag0"}}));
  EXPECT_FALSE(injector.OnDeath("uav", &mission)) << "once";
  EXPECT_EQ(mission.held, std::set<std::string>{"uav"});
  injector.Step(kMinuteUs, 4 * kSecondUs, &mission);
  EXPECT_TRUE(mission.held.empty());
}

TEST(FaultInjector, NothingIsLeftUnderWay) {
  FakeMission mission;
  FaultInjector injector({ParseFaultFlag("process_stopped:uav@1+60s", 0),
                          ParseFaultFlag("disk_full:lcm-logger@1+60s", 1)},
                         {"uav"});
  injector.Step(kMinuteUs, 0, &mission);
  EXPECT_TRUE(mission.disk_full);
  injector.EndAll(1, &mission);
  EXPECT_FALSE(mission.disk_full);
  EXPECT_TRUE(mission.held.empty());
  EXPECT_EQ(mission.signals.back().second, SIGCONT);
}

TEST(FaultSwitch, LargestShareHoldsAndTheEndRestores) {
  auto* const queue = new muster::testing::QueueBus;
  LossyBus bus(std::unique_ptr<Bus>(queue), 1, "uav", [] { return std::int64_t{0}; });
  bus.SetFaults({.loss = 0.1});
  FaultSwitch faults(1, "uav", &bus, [] { return std::int64_t{0}; });
  fault_t some = ToWire(ParseFaultFlag("loss:*@1=0.3", 1));
  fault_t more = ToWire(ParseFaultFlag("loss:uav@1=0.5", 2));
  const fault_t other = ToWire(ParseFaultFlag("loss:world@1=0.9", 3));
  fault_t cut = ToWire(ParseFaultFlag("partition:world|uav@1+1s", 4));
  EXPECT_EQ(faults.Take(some)->kind, 13);
  EXPECT_FALSE(faults.Take(some)) << "said twice, done once";
  EXPECT_EQ(faults.Take(more)->detail, "uav");
  EXPECT_FALSE(faults.Take(other));
  EXPECT_DOUBLE_EQ(bus.faults().loss, 0.5);
  EXPECT_TRUE(faults.Take(cut));
  EXPECT_EQ(bus.faults().unheard, std::set<std::string>{"world"});
  clock_t clock{};
  clock.header.sender = "world";
  bus.SetFaults({.unheard = {"world"}});
  for (int i = 0; i < 3; ++i) queue->arriving.push_back({"MUSTER_CLOCK", Encode(clock)});
  EXPECT_TRUE(bus.Receive(0).empty());
  cut.for_us = 0;
  EXPECT_EQ(faults.Take(cut)->detail, "uav: 3 packets");
  more.for_us = 0;
  EXPECT_EQ(faults.Take(more)->kind, 14);
  EXPECT_DOUBLE_EQ(bus.faults().loss, 0.3);
  some.for_us = 0;
  EXPECT_TRUE(faults.Take(some));
  EXPECT_DOUBLE_EQ(bus.faults().loss, 0.1) << "as it was before";
  some.for_us = 1;
  EXPECT_FALSE(faults.Take(some)) << "an order that somebody has kept and says again";
  EXPECT_DOUBLE_EQ(bus.faults().loss, 0.1);
}

TEST(FaultSwitch, EachKindHasItsOwnShareAndCount) {
  auto* const queue = new muster::testing::QueueBus;
  LossyBus bus(std::unique_ptr<Bus>(queue), 1, "uav", [] { return std::int64_t{0}; });
  std::int64_t rejected = 5;
  FaultSwitch faults(1, "uav", &bus, [&] { return rejected; });
  fault_t fault{};
  fault.target = "uav";
  fault.probability = 0.25;
  fault.for_us = 1;
  for (const FaultKind kind : {FaultKind::kLoss, FaultKind::kDuplication, FaultKind::kDelay,
                               FaultKind::kReordering, FaultKind::kCorruption}) {
    fault.kind = static_cast<std::int8_t>(kind);
    fault.fault_id = std::to_string(fault.kind);
    ASSERT_TRUE(faults.Take(fault)) << fault.fault_id;
  }
  const PacketFaults all{
      .loss = 0.25, .duplication = 0.25, .reorder = 0.25, .corrupt = 0.25, .delay_us = 250'000};
  EXPECT_EQ(bus.faults(), all);
  fault.kind = static_cast<std::int8_t>(FaultKind::kForeign);
  fault.fault_id = "foreign";
  ASSERT_TRUE(faults.Take(fault));
  EXPECT_EQ(bus.faults(), all);
  rejected = 12;
  fault.for_us = 0;
  EXPECT_EQ(faults.Take(fault)->detail, "uav: 7 packets");
  EXPECT_FALSE(faults.Take(fault)) << "it has ended";
  for (const FaultKind kind :
       {FaultKind::kAgentFails, FaultKind::kAgentSilent, FaultKind::kProcessKilled,
        FaultKind::kProcessStopped, FaultKind::kDiskFull}) {
    fault.kind = static_cast<std::int8_t>(kind);
    fault.for_us = 1;
    EXPECT_FALSE(faults.Take(fault)) << int{fault.kind};
  }
}

TEST(FaultSwitch, OnlyFaultsOfItsRunCount) {
  LossyBus bus(std::make_unique<muster::testing::QueueBus>(), 1, "uav",
               [] { return std::int64_t{0}; });
  FaultSwitch faults(1, "uav", &bus, [] { return std::int64_t{0}; });
  fault_t fault{};
  fault.header.sender = "launcher";
  fault.fault_id = "a";
  fault.kind = static_cast<std::int8_t>(FaultKind::kLoss);
  fault.target = "*";
  fault.probability = 0.5;
  fault.for_us = 1;
  for (const std::int64_t run : {2, 1}) {
    fault.header.run_id = run;
    EXPECT_FALSE(faults.Take(Packet{"MUSTER_CLOCK", Encode(fault)}));
    EXPECT_EQ(faults.Take(Packet{"MUSTER_FAULT", Encode(fault)}).has_value(), run == 1);
  }
}

TEST(FaultSwitch, SidesOfAPartition) {
  using Names = std::set<std::string>;
  EXPECT_FALSE(SidesOf("uav"));
  EXPECT_EQ(SidesOf("uav|world"), std::pair(Names{"uav"}, Names{"world"}));
  EXPECT_EQ(SidesOf("a+b+c|d"), std::pair(Names({"a", "b", "c"}), Names{"d"}));
  EXPECT_EQ(SidesOf("++a++|"), std::pair(Names{"a"}, Names{}));
  fault_t cut{};
  cut.kind = static_cast<std::int8_t>(FaultKind::kPartition);
  cut.target = "a+b|c";
  for (const char* name : {"a", "b", "c"}) EXPECT_TRUE(Concerns(cut, name)) << name;
  EXPECT_FALSE(Concerns(cut, "d"));
  EXPECT_FALSE(Concerns(cut, "*"));
}

TEST(FaultSwitch, HitsComeBackFromTheirText) {
  EXPECT_EQ(HitsOf(HitsText("uav-1", 12)), 12);
  for (const char* text : {"uav", "uav: packets", "uav: x packets", "uav: -1 packets", ""}) {
    EXPECT_FALSE(HitsOf(text)) << text;
  }
}

}  // namespace
}  // namespace muster::tools
