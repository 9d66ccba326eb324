#include "world/attendance.h"

#include <gtest/gtest.h>

#include "base/check.h"

namespace muster::world {
namespace {

using Presence = Peers::Presence;
constexpr AgentKind kUav = AgentKind::kUav, kWorker = AgentKind::kWorker;

/// Two UAVs, one by each of two processes, and one worker.
class AttendanceTest : public ::testing::Test {
 protected:
  AttendanceTest() {
    ReportAll();
    attendance_.StartTick();
  }
  static Scenario Small() {
    Scenario scenario;
    scenario.uavs.resize(2);
    scenario.workers.resize(1);
    return scenario;
  }
  void ReportAll() {
    EXPECT_TRUE(attendance_.Report(kUav, 0, "uav-0"));
    EXPECT_TRUE(attendance_.Report(kUav, 1, "uav-1"));
    EXPECT_FALSE(attendance_.complete());
    EXPECT_TRUE(attendance_.Report(kWorker, 0, "worker"));
  }
  const std::vector<std::string> none_;
  Attendance attendance_{Small(), Peers(kSecondUs, true)};
};

TEST_F(AttendanceTest, IsCompleteWithEveryAgentsReport) {
  EXPECT_FALSE(attendance_.complete());
  EXPECT_FALSE(attendance_.reported(kUav, 1));
  EXPECT_EQ(attendance_.Owing(), (std::set<std::string>{"uav-0", "uav-1", "worker"}));
  ReportAll();
  EXPECT_TRUE(attendance_.complete());
  EXPECT_TRUE(attendance_.reported(kUav, 1));
  EXPECT_TRUE(attendance_.Owing().empty());
  EXPECT_FALSE(attendance_.Report(kUav, 1, "uav-1"));  // no news
  EXPECT_TRUE(attendance_.complete());
}

TEST_F(AttendanceTest, AnAgentHasOneProcess) {
  EXPECT_TRUE(attendance_.MayReport(kUav, 0, "uav-0"));
  // Nobody has heard who that is: a damaged name.
  EXPECT_FALSE(attendance_.MayReport(kUav, 0, "uav-2"));
  attendance_.peers().Introduce("uav-2");
  EXPECT_TRUE(attendance_.MayReport(kUav, 0, "uav-2"));  // then the first name was damaged
  attendance_.peers().Introduce("uav-0");
  EXPECT_THROW(static_cast<void>(attendance_.MayReport(kUav, 0, "uav-2")), InputError);
}

TEST_F(AttendanceTest, WhoIsLostIsNotAwaited) {
  EXPECT_TRUE(attendance_.Lose("uav-0"));
  EXPECT_FALSE(attendance_.Lose("uav-0"));  // it was not there
  EXPECT_EQ(attendance_.Owing(), (std::set<std::string>{"uav-1", "worker"}));
  EXPECT_FALSE(attendance_.Report(kUav, 0, "uav-0"));  // too late for this tick
  EXPECT_FALSE(attendance_.reported(kUav, 0));
  EXPECT_TRUE(attendance_.Report(kUav, 1, "uav-1"));
  EXPECT_TRUE(attendance_.Report(kWorker, 0, "worker"));
  EXPECT_TRUE(attendance_.complete());
  attendance_.StartTick();
  EXPECT_EQ(attendance_.Owing(), (std::set<std::string>{"uav-1", "worker"}));
}

TEST_F(AttendanceTest, AReportBeforeTheLossCounts) {
  EXPECT_TRUE(attendance_.Report(kUav, 0, "uav-0"));
  EXPECT_TRUE(attendance_.Lose("uav-0"));
  EXPECT_TRUE(attendance_.reported(kUav, 0));
}

TEST_F(AttendanceTest, WhoSpeaksAgainIsAwaitedFromTheNextTickAndThenBack) {
  EXPECT_TRUE(attendance_.Lose("uav-0"));
  attendance_.peers().Hear("uav-0", 0);
  EXPECT_EQ(attendance_.TakeBack(), none_);
  attendance_.StartTick();
  EXPECT_EQ(attendance_.Owing(), (std::set<std::string>{"uav-0", "uav-1", "worker"}));
  EXPECT_EQ(attendance_.TakeBack(), none_);
  ReportAll();
  EXPECT_EQ(attendance_.TakeBack(), std::vector<std::string>{"uav-0"});
  EXPECT_EQ(attendance_.peers().presence("uav-0"), Presence::kThere);
  EXPECT_EQ(attendance_.TakeBack(), none_);
}

TEST_F(AttendanceTest, AProcessWithoutAgentsComesBackByOtherMeans) {
  EXPECT_TRUE(attendance_.Lose("scheduler"));
  attendance_.peers().Hear("scheduler", 0);
  EXPECT_EQ(attendance_.TakeBack(), none_);
  EXPECT_EQ(attendance_.peers().presence("scheduler"), Presence::kReturning);
}

TEST_F(AttendanceTest, AnExcusedAgentIsNotAwaitedInThisTickOnly) {
  attendance_.Excuse(kUav, 1);
  attendance_.Excuse(kUav, 1);
  EXPECT_TRUE(attendance_.Report(kUav, 0, "uav-0"));
  EXPECT_FALSE(attendance_.complete());
  EXPECT_TRUE(attendance_.Report(kWorker, 0, "worker"));
  EXPECT_TRUE(attendance_.complete());
  attendance_.StartTick();
  EXPECT_TRUE(attendance_.Owing().contains("uav-1"));
}

TEST_F(AttendanceTest, IsDesertedWhenAllWhoTookPartHaveLeft) {
  attendance_.Join("scheduler");
  for (const char* name : {"uav-0", "uav-1", "worker"}) attendance_.Leave(name);
  EXPECT_FALSE(attendance_.deserted());
  attendance_.Leave("scheduler");
  EXPECT_TRUE(attendance_.deserted());
}

}  // namespace
}  // namespace muster::world
