#include "world/driver_words.h"

#include <gtest/gtest.h>

#include <string>

#include "lcmtypes/words.h"

namespace muster::world {
namespace {

/// Two UAVs, of which the second is measured, and a measured vehicle.
Scenario Some() {
  Scenario scenario;
  scenario.uavs.resize(2);
  scenario.uavs[1].measured = true;
  scenario.vehicles.resize(1);
  scenario.vehicles[0].measured = true;
  return scenario;
}

event_t Word(EventKind kind, TimeUs at_us, const std::string& detail, int uav = 1,
             int vehicle = -1) {
  event_t event{};
  event.kind = static_cast<std::int8_t>(kind);
  event.at_us = at_us;
  event.uav_id = uav;
  event.worker_id = -1;
  event.vehicle_id = vehicle;
  event.detail = detail;
  return event;
}

TEST(DriverWords, AMessageIsPassedOnOnce) {
  const Scenario scenario = Some();
  DriverWords words(scenario);
  EXPECT_TRUE(words.Hear(Word(EventKind::kDriverSays, 10, "fog")));
  EXPECT_FALSE(words.Hear(Word(EventKind::kDriverSays, 10, "fog")));
  EXPECT_TRUE(words.Hear(Word(EventKind::kDriverSays, 10, "rain")));
  EXPECT_TRUE(words.Hear(Word(EventKind::kDriverSays, 9, "fog")));
  EXPECT_TRUE(words.Hear(Word(EventKind::kDriverCalls, 10, "fog"))) << "a call is another matter";
  EXPECT_FALSE(words.Hear(Word(EventKind::kDriverCalls, 10, "fog")));
  EXPECT_TRUE(words.Hear(Word(EventKind::kDriverSays, 10, "fog", -1, 0))) << "another agent";
}

TEST(DriverWords, OfAnAgentTheyAreLimitedByKind) {
  const Scenario scenario = Some();
  DriverWords words(scenario);
  for (TimeUs t = 0; t < 1000; ++t) {
    ASSERT_TRUE(words.Hear(Word(EventKind::kDriverSays, t, "again"))) << t;
  }
  EXPECT_FALSE(words.Hear(Word(EventKind::kDriverSays, 1000, "again")));
  EXPECT_TRUE(words.Hear(Word(EventKind::kDriverCalls, 1000, "help")));
  EXPECT_TRUE(words.Hear(Word(EventKind::kDriverSays, 1000, "again", -1, 0)));
}

TEST(DriverWords, WhatADriverWaitsForIsPassedOnWhenItIsNew) {
  const Scenario scenario = Some();
  DriverWords words(scenario);
  EXPECT_TRUE(words.Hear(Word(EventKind::kDriverWaits, 10, "a fix")));
  EXPECT_FALSE(words.Hear(Word(EventKind::kDriverWaits, 10, "a fix"))) << "said again";
  EXPECT_FALSE(words.Hear(Word(EventKind::kDriverWaits, 5, "a battery"))) << "it came late";
  EXPECT_TRUE(words.Hear(Word(EventKind::kDriverWaits, 11, "a battery")));
  EXPECT_TRUE(words.Hear(Word(EventKind::kDriverWaits, 5, "a fix", -1, 0)));
}

TEST(DriverWords, OnlyMeasuredAgentsHaveThem) {
  const Scenario scenario = Some();
  DriverWords words(scenario);
  for (const EventKind kind :
       {EventKind::kDriverSays, EventKind::kDriverCalls, EventKind::kDriverWaits}) {
    EXPECT_FALSE(words.Hear(Word(kind, 1, "x", 0)));
    EXPECT_FALSE(words.Hear(Word(kind, 1, "x", 2)));
    EXPECT_FALSE(words.Hear(Word(kind, 1, "x", -1)));
  }
}

TEST(DriverWords, AFailureKeepsItsFirstReasonAndIsAwaitedThreeTimes) {
  const Scenario scenario = Some();
  DriverWords words(scenario);
  AgentState uav;
  uav.kind = AgentKind::kUav;
  uav.id = 1;
  AgentState vehicle;
  vehicle.kind = AgentKind::kVehicle;
  vehicle.id = 0;
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(words.Awaits(uav)) << i;
  EXPECT_FALSE(words.Awaits(uav));
  EXPECT_EQ(words.WhyFailed(uav), "its driver has failed");
  EXPECT_FALSE(words.Hear(Word(EventKind::kDriverFailed, 10, "a motor", -1, 0)));
  EXPECT_FALSE(words.Hear(Word(EventKind::kDriverFailed, 11, "a propeller", -1, 0)));
  EXPECT_EQ(words.WhyFailed(vehicle), "a motor");
  EXPECT_FALSE(words.Awaits(vehicle)) << "its reason is known";
}

}  // namespace
}  // namespace muster::world
