#include "tools/record/report_json.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "base/check.h"
#include "base/sha256.h"
#include "tests/tools/fake_mission.h"
#include "tests/tools/record/record_of.h"
#include "tools/record/digest.h"
#include "tools/record/service.h"
#include "tools/record/summary.h"

namespace muster::tools {
namespace {

nlohmann::json ReadBack(const RunRecord& record) {
  return nlohmann::json::parse(Report(record).dump(2));
}

std::uint64_t Bits(double value) { return std::bit_cast<std::uint64_t>(value); }

/// The docstring of Digest, read again: a second implementation, straight from the messages.
template <class T>
void Put(std::string* bytes, T value) {
  char raw[sizeof value];  // hosts of ours are little-endian
  std::memcpy(raw, &value, sizeof value);
  bytes->append(raw, sizeof value);
}

std::string DigestAgain(const FakeLog& log) {
  std::string bytes = "muster digest 1\n";
  std::string events, tasks, uavs;
  std::int64_t done_us[2] = {-1, -1};
  std::vector<event_t> sorted;
  world_state_t world{};
  agent_states_t states{};
  for (const FakeMessage& message : log) {
    if (const auto* s = std::get_if<schedule_t>(&message.body)) {
      Put(&bytes, 'D');
      Put(&bytes, s->decision);
      Put(&bytes, s->n);
      for (const action_t& a : s->actions) {
        Put(&bytes, a.kind);
        for (int id : {a.uav_id, a.worker_id, a.vehicle_id, a.task_id, a.charge_id}) {
          Put(&bytes, id);
        }
        for (double x : {a.x_m, a.y_m, a.weight}) Put(&bytes, x);
      }
    } else if (const auto* e = std::get_if<event_t>(&message.body)) {
      sorted.push_back(*e);
    } else if (const auto* w = std::get_if<world_state_t>(&message.body)) {
      world = *w;
    } else if (const auto* a = std::get_if<agent_states_t>(&message.body); a && a->kind == 0) {
      states = *a;
    }
  }
  std::stable_sort(sorted.begin(), sorted.end(), [](const event_t& a, const event_t& b) {
    return std::pair(a.at_us, a.kind) < std::pair(b.at_us, b.kind);
  });
  for (const event_t& e : sorted) {
    Put(&bytes, 'E');
    Put(&bytes, e.at_us);
    Put(&bytes, e.kind);
    for (int id : {e.uav_id, e.worker_id, e.vehicle_id, e.task_id, e.charge_id}) Put(&bytes, id);
    if (e.kind == 5) done_us[e.task_id] = e.at_us;
  }
  for (std::size_t task = 0; task < 2; ++task) {
    Put(&bytes, 'T');
    Put(&bytes, world.task_status[task]);
    Put(&bytes, done_us[task]);
  }
  for (const agent_t& uav : states.agents) {
    Put(&bytes, 'U');
    Put(&bytes, uav.range_left_m);
  }
  return Sha256(bytes);
}

TEST(Digest, IsWhatItsDescriptionSays) {
  FakeLog log = MakeFakeMission();
  // In the fake log the 5 "online" events of time 0 come as UAVs, workers, vehicle: ids ascend with
  // -1 first, so the sorted order is the reverse of the classes.
  std::vector<FakeMessage*> online;
  for (FakeMessage& m : log) {
    if (const auto* e = std::get_if<event_t>(&m.body); e && e->kind == 0) online.push_back(&m);
  }
  ASSERT_EQ(online.size(), 5u);
  FakeLog in_order = {*online[4], *online[2], *online[3], *online[0], *online[1]};
  for (std::size_t i = 0; i < 5; ++i) *online[i] = in_order[i];
  EXPECT_EQ(Digest(RecordOf(log)), DigestAgain(log));
}

TEST(Digest, DoesNotSeeTicksTimesNorProcesses) {
  const std::string expected = Digest(RecordOf(MakeFakeMission()));
  EXPECT_EQ(Digest(RecordOf(MakeFakeMission(10'000'000))), expected);
  EXPECT_EQ(Digest(RecordOf(MakeFakeMission(600'000'000))), expected);
  FakeLog log = MakeFakeMission();
  ForEach<schedule_t>(&log, [](schedule_t& s) {
    s.solve_us *= 7;
    s.header.wall_us += 12345;
    s.header.boot_id = 1;
    std::swap(s.actions[0], s.actions[1]);
  });
  ForEach<process_status_t>(&log, [](process_status_t& s) { s.cpu_s = 9; });
  Renumber(&log);
  EXPECT_EQ(Digest(RecordOf(log)), expected);
}

TEST(Digest, SeesEveryDecisionAndOutcome) {
  const std::string expected = Digest(RecordOf(MakeFakeMission()));
  const auto changed = [&](const std::function<void(FakeLog*)>& edit) {
    FakeLog log = MakeFakeMission();
    edit(&log);
    return Digest(RecordOf(log)) != expected;
  };
  EXPECT_TRUE(changed([](FakeLog* log) {
    ForEach<schedule_t>(log, [](schedule_t& s) {
      if (s.decision == 2) s.actions[1].weight = std::nextafter(s.actions[1].weight, 1.0);
    });
  }));
  EXPECT_TRUE(changed([](FakeLog* log) {
    ForEach<schedule_t>(log, [](schedule_t& s) {
      if (s.decision == 0) s.actions[3].worker_id = 1;
    });
  }));
  EXPECT_TRUE(changed([](FakeLog* log) {
    ForEach<event_t>(log, [](event_t& e) { e.at_us += e.kind == 8 ? 1 : 0; });
  }));
  EXPECT_TRUE(changed([](FakeLog* log) {
    ForEach<world_state_t>(log, [](world_state_t& w) {
      if (w.tick == 30) w.task_status[1] = 2;
    });
  }));
  EXPECT_TRUE(changed([](FakeLog* log) {
    ForEach<agent_states_t>(log, [](agent_states_t& s) {
      if (s.tick == 30 && s.kind == 0) s.agents[0].range_left_m -= 1e-9;
    });
  }));
}

TEST(Report, ListsTheRun) {
  const FakeLog log = MakeFakeMission();
  const nlohmann::json report = ReadBack(RecordOf(log));
  EXPECT_EQ(report["version"], 1);
  EXPECT_EQ(report["policy"], "by-hand");
  EXPECT_EQ(report["seed"], 5);
  EXPECT_EQ(report["scenario"]["interval_s"], 600);
  EXPECT_EQ(report["scenario"]["limit_s"], 1800);
  EXPECT_EQ(report["scenario"]["availability"], "strict");
  EXPECT_EQ(report["tasks_total"], 2);
  EXPECT_EQ(report["tasks_done"], 2);
  EXPECT_EQ(report["completion_rate"], 1.0);
  EXPECT_EQ(report["charges"], 1);
  EXPECT_EQ(report["events"]["sensing_done"], 2);
  EXPECT_EQ(report["events"]["agent_failed"], 0);
  EXPECT_DOUBLE_EQ(report["decision_time"]["median_s"].get<double>(), 0.002);
  EXPECT_DOUBLE_EQ(report["decision_time"]["max_s"].get<double>(), 0.003);
  EXPECT_EQ(report["tasks"][1]["status"], "done");
  EXPECT_DOUBLE_EQ(report["tasks"][1]["done_s"].get<double>(), 960);
  EXPECT_EQ(report["tasks"][1]["uav"], 1);
  EXPECT_EQ(report["tasks"][1]["worker"], 1);
  ASSERT_EQ(report["decisions"].size(), 3u);
  EXPECT_EQ(report["decisions"][1]["sim_s"], 600);
  EXPECT_TRUE(report["decisions"][1]["bound"].is_null());
  EXPECT_EQ(report["decisions"][2]["bound"], 12.0);
  EXPECT_EQ(report["decisions"][0]["candidates"], 20);
  ASSERT_EQ(report["processes"].size(), 5u);
  EXPECT_EQ(report["processes"][0]["name"], "scheduler");
  EXPECT_EQ(report["processes"][0]["received"], 50);
  EXPECT_EQ(report["processes"][0]["restarts"], 0);
  EXPECT_EQ(report["log"]["complete"], true);
  EXPECT_EQ(report["log"]["messages"], log.size());
  EXPECT_EQ(report["log"]["gaps"].size(), 0u);
  EXPECT_EQ(report["digest"].get<std::string>().size(), 64u);
}

TEST(Report, NumbersReadBackBitForBit) {
  FakeLog log = MakeFakeMission();
  const double odd = std::nextafter(0.1 + 0.2, 1.0);
  ForEach<schedule_t>(&log, [&](schedule_t& s) {
    s.actions[0].weight = odd;
    s.weight = 1e-310;  // subnormal
    s.bound = 123456789.000000015;
  });
  const nlohmann::json report = ReadBack(RecordOf(log));
  for (const auto& decision : report["decisions"]) {
    EXPECT_EQ(Bits(decision["actions"][0]["weight"].get<double>()), Bits(odd));
    EXPECT_EQ(Bits(decision["weight"].get<double>()), Bits(1e-310));
    EXPECT_EQ(Bits(decision["bound"].get<double>()), Bits(123456789.000000015));
  }
}

TEST(Report, SumsAProcessOverItsStarts) {
  FakeLog log = MakeFakeMission();
  for (const FakeMessage& message : FakeLog(log)) {
    const auto* status = std::get_if<process_status_t>(&message.body);
    if (status == nullptr || status->name != "uav" || status->state != 4) continue;
    log.push_back(message);
    log.back().header().boot_id = 2;
    std::get<process_status_t>(log.back().body).received = 11;
  }
  Renumber(&log);
  const nlohmann::json report = ReadBack(RecordOf(log));
  EXPECT_EQ(report["processes"][1]["name"], "uav");
  EXPECT_EQ(report["processes"][1]["received"], 61);
  EXPECT_EQ(report["processes"][1]["restarts"], 1);  // nothing is logged of start 1
}

TEST(Report, TellsFaultsWithWhatBecameOfThem) {
  FakeLog log = MakeFakeMission();
  FakeMessage message = log[0];
  fault_t fault{};
  fault.header = message.header();
  fault.header.sender = "injector";
  fault.fault_id = "f1";
  fault.kind = 5;
  fault.target = "uav";
  fault.at_us = 60'000'000;
  fault.for_us = 1'000'000;
  fault.probability = 0.25;
  log.push_back({"MUSTER_FAULT", fault});
  event_t event{};
  event.header = fault.header;
  event.kind = 13;
  event.at_us = 61'000'000;
  event.uav_id = event.worker_id = event.vehicle_id = event.task_id = event.charge_id = -1;
  event.fault_id = "f1";
  log.push_back({"MUSTER_EVENT", event});
  Renumber(&log);
  const nlohmann::json report = ReadBack(RecordOf(log));
  ASSERT_EQ(report["faults"].size(), 1u);
  EXPECT_EQ(report["faults"][0]["kind"], "loss");
  EXPECT_EQ(report["faults"][0]["applied_s"], 61.0);
  EXPECT_TRUE(report["faults"][0]["ended_s"].is_null());
}

TEST(Report, CountsAnswersOfAnOutsideSchedulerThatWereRefused) {
  FakeLog log = MakeFakeMission();
  event_t event{};
  event.header = log[0].header();
  event.header.sender = "scheduler";
  event.header.boot_id = 1;
  event.kind = NumberOf(EventKind::kAnswerRefused);
  event.at_us = 61'000'000;
  event.uav_id = event.worker_id = event.vehicle_id = event.task_id = event.charge_id = -1;
  event.detail = "decision 1: no answer within 3 s";
  log.push_back({"MUSTER_EVENT", event});
  Renumber(&log);
  const RunRecord record = RecordOf(log);
  const nlohmann::json report = ReadBack(record);
  EXPECT_EQ(report["events"]["answer_refused"], 1);
  ASSERT_EQ(report["refused_answers"].size(), 1u);
  EXPECT_EQ(report["refused_answers"][0]["sim_s"], 61.0);
  EXPECT_EQ(report["refused_answers"][0]["why"], event.detail);
  EXPECT_NE(Summary(record).find("1 answers of the outside scheduler, first: decision 1"),
            std::string::npos);
  EXPECT_EQ(report["digest"], ReadBack(RecordOf(MakeFakeMission()))["digest"]) << "no outcome";
}

TEST(Report, OfAnIncompleteLogNamesTheGaps) {
  FakeLog log = MakeFakeMission();
  std::erase_if(log, [](const FakeMessage& m) {
    const auto* s = std::get_if<schedule_t>(&m.body);
    return s != nullptr && s->decision == 1;
  });
  const RunRecord record = RecordOf(log);
  const nlohmann::json report = ReadBack(record);
  EXPECT_EQ(report["log"]["complete"], false);
  EXPECT_EQ(report["log"]["gaps"][0]["sender"], "scheduler");
  EXPECT_EQ(report["log"]["missing"][0]["owner"], "schedule");
  EXPECT_EQ(report["log"]["missing"][0]["first"], 1);
  EXPECT_NE(Summary(record).find("NOT COMPLETE"), std::string::npos);
  EXPECT_NE(Summary(record).find("scheduler (start 0) seq 2"), std::string::npos);
}

TEST(Summary, SaysWhatPeopleAskFirst) {
  const std::string text = Summary(RecordOf(MakeFakeMission()));
  for (const char* line :
       {"tasks done     2 of 2 (100.0 %)\n", "charges        1\n", "flown          14.5 km\n",
        "median 2.0 ms, max 3.0 ms\n", "log            complete, "}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << "in\n" << text;
  }
}

TEST(Service, CountsWorthResponseAndLateness) {
  const RunRecord record = RecordOf(MakeFakeMission());
  Scenario scenario = *record.scenario();
  EXPECT_FALSE(ReadBack(record).contains("service"));  // no task has times
  scenario.rules.priority_worth = {0.5, 1, 3, 4};
  scenario.rules.late_worth = 0.25;
  scenario.tasks[0].priority = Priority::kHigh;
  scenario.tasks[0].reported_us = kMinuteUs;
  scenario.tasks[0].due_us = 7 * kMinuteUs;  // sensing begins at 7.211 min
  scenario.tasks[1].priority = Priority::kEmergency;
  scenario.tasks[1].reported_us = 4 * kMinuteUs;
  scenario.tasks[1].due_us = 14 * kMinuteUs;  // and at 14 min
  Task never;
  never.reported_us = 9 * kMinuteUs;
  scenario.tasks.push_back(never);
  never.reported_us = scenario.rules.limit_us;  // nobody ever knew of it
  scenario.tasks.push_back(never);

  const Service service = ServiceOf(record, scenario);
  EXPECT_DOUBLE_EQ(service.worth_done, 3 * 0.25 + 4);
  EXPECT_DOUBLE_EQ(service.worth_all, 3 + 4 + 1);
  EXPECT_EQ(service.reported(), 3);
  EXPECT_EQ(service.done(), 2);
  EXPECT_EQ(service.on_time(), 1);
  EXPECT_EQ(service.by_priority[2].on_time, 0);
  EXPECT_EQ(service.by_priority[3].on_time, 1);
  ASSERT_EQ(service.response_s.size(), 2u);
  EXPECT_NEAR(service.response_s[0], 60 * 6.211, 0.1);
  EXPECT_NEAR(service.response_s[1], 600, 1e-6);
  EXPECT_EQ(service.response_quantile_s(0.5), service.response_s[0]);
  EXPECT_EQ(service.response_quantile_s(0.9), service.response_s[1]);
  EXPECT_NEAR(service.mean_response_s(), 30 * 16.211, 0.1);
  EXPECT_TRUE(ToJson(Service())["response_s"]["mean"].is_null());
}

}  // namespace
}  // namespace muster::tools
