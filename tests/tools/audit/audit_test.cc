#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "tests/temporary_folder.h"
#include "tests/tools/audit/mutations.h"
#include "tests/tools/fake_mission.h"
#include "tools/audit/audit_command.h"
#include "tools/audit/auditor.h"
#include "tools/audit/report_check.h"
#include "tools/record/report_json.h"
#include "tools/record/run_record.h"

namespace muster::tools {
namespace {

using audit::Auditor;
using audit::Violation;

std::vector<Violation> Audit(const FakeLog& log) {
  Auditor auditor;
  for (const Packet& packet : Encoded(log)) auditor.Add(packet);
  return auditor.Finish();
}

std::string Text(const std::vector<Violation>& violations) {
  std::string text;
  for (const Violation& v : violations) {
    text += std::to_string(v.at_us) + " " + v.invariant + ": " + v.text + "\n";
  }
  return text;
}

TEST(Audit, PassesAValidLog) {
  for (const std::int64_t tick_us : {10'000'000, 60'000'000, 200'000'000, 600'000'000}) {
    EXPECT_EQ(Text(Audit(MakeFakeMission(tick_us))), "") << tick_us;
  }
}

TEST(Audit, PassesWhenMessagesComeTwiceOrLate) {
  const std::vector<Packet> packets = Encoded(MakeFakeMission());
  std::vector<Packet> stirred;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const std::size_t block = i / 24 * 24;  // each block of three ticks or so backwards
    const std::size_t n = std::min<std::size_t>(24, packets.size() - block);
    stirred.push_back(packets[block + n - 1 - (i - block)]);
    if (i % 5 == 0) stirred.push_back(packets[i]);
  }
  Auditor auditor;
  for (const Packet& packet : stirred) auditor.Add(packet);
  EXPECT_EQ(Text(auditor.Finish()), "");
  EXPECT_GT(auditor.duplicates(), 0);
  EXPECT_EQ(auditor.messages(), static_cast<std::int64_t>(packets.size()));
}

TEST(Audit, CatchesEveryMutation) {
  for (const Mutation& mutation : Mutations()) {
    FakeLog log = MakeFakeMission();
    mutation.edit(&log);
    const std::vector<Violation> violations = Audit(log);
    ASSERT_FALSE(violations.empty()) << mutation.name;
    const Violation& first = violations[0];
    EXPECT_EQ(first.invariant, mutation.invariant) << mutation.name << "\n" << Text(violations);
    EXPECT_EQ(first.at_us, mutation.at_us) << mutation.name << "\n" << Text(violations);
    EXPECT_NE(first.text.find(mutation.mentions), std::string::npos) << mutation.name << "\n"
                                                                     << Text(violations);
  }
}

/// Rules that need a mission which this one is not; the tests that break them.
const std::map<std::string, const char*> kBrokenElsewhere = {
    {"directives", "DirectedMissions.DirectivesThatAreNotKeptAreFound"},
    {"meeting", "AuditMission.CatchesAMeetingThatLastsTooShort"},
    {"proposals", "SeveralSchedulers.TheAuditComparesProposalsAndDecision"},
    {"orders", "OrdersMission.TheAuditSeesWhatWasNotTaken"},
    {"report", "Audit.ComparesTheReportWithTheLog"},
    {"separation", "AuditMission.CatchesAltitudesThatDoNotKeepUavsApart"},
    {"seal", "SealRunTest.TheFirstMessageThatWasChangedIsNamed"}};

TEST(Audit, EveryRuleOfTheDocumentIsBrokenBySomeMutation) {
  std::ifstream document(MUSTER_SOURCE_DIR "/docs/reference/audit.md");
  ASSERT_TRUE(document);
  std::set<std::string> rules;
  for (std::string line; std::getline(document, line);) {
    // "| `sensing`, `charging` | begin when ..."
    if (line.rfind("| `", 0) != 0) continue;
    const std::string names = line.substr(0, line.find(" |", 2));
    for (std::size_t begin = names.find('`'); begin != std::string::npos;) {
      const std::size_t end = names.find('`', begin + 1);
      rules.insert(names.substr(begin + 1, end - begin - 1));
      begin = names.find('`', end + 1);
    }
  }
  std::set<std::string> broken;
  for (const Mutation& mutation : Mutations()) broken.insert(mutation.invariant);
  for (const auto& [rule, test] : kBrokenElsewhere) {
    EXPECT_FALSE(broken.contains(rule)) << rule;
    broken.insert(rule);
  }
  EXPECT_EQ(rules, broken);
}

class AuditCommandTest : public ::testing::Test {
 protected:
  /// Of the log's messages up to that time.
  int Run(const FakeLog& log, std::vector<const char*> more = {},
          std::int64_t until_us = std::numeric_limits<std::int64_t>::max()) {
    std::filesystem::remove(file_);
    {
      EventLogWriter writer(file_);
      for (const Packet& packet : Encoded(log)) {
        if (DecodeHeader(packet)->sim_us <= until_us) writer.Write(1, packet);
      }
      writer.Flush();
    }
    std::vector<const char*> arguments = {"muster audit", file_.c_str()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ::testing::internal::CaptureStdout();
    const int code = AuditCommand(static_cast<int>(arguments.size()), arguments.data());
    std::fflush(stdout);
    out_ = ::testing::internal::GetCapturedStdout();
    return code;
  }
  const TemporaryFolder folder_;
  const std::string file_ = folder_.File("mission.lcm");
  std::string out_;
};

TEST_F(AuditCommandTest, PrintsTheFirstViolationAndExitsWithFour) {
  EXPECT_EQ(Run(MakeFakeMission()), 0);
  EXPECT_NE(out_.find("passed: every rule holds"), std::string::npos) << out_;
  FakeLog log = MakeFakeMission();
  EditAgent(&log, 1, 0, 2, 2, [](agent_t& a) { a.x_m += 500; });
  EXPECT_EQ(Run(log), 4);
  EXPECT_NE(out_.find("  00:02:00.000000  speed: worker:0 moved "), std::string::npos) << out_;
  EXPECT_EQ(Run(log, {"--json"}), 4);
  const auto json = nlohmann::json::parse(out_);
  EXPECT_FALSE(json["passed"].get<bool>());
  EXPECT_EQ(json["violations"][0]["at_us"], 2 * kMin);
  EXPECT_EQ(json["violations"][0]["invariant"], "speed");
}

TEST_F(AuditCommandTest, OfAMissionThatStillRunsItSaysHowFarTheRulesHold) {
  FakeLog log = MakeFakeMission();
  EXPECT_EQ(Run(log, {}, 12 * kMin), 4);
  EXPECT_NE(out_.find("every rule holds up to 00:1"), std::string::npos) << out_;
  EXPECT_NE(out_.find("The mission ends at 00:30:00.000000: it still runs, or was broken off"),
            std::string::npos)
      << out_;
  EXPECT_EQ(Run(log, {"--json"}, 12 * kMin), 4);
  EXPECT_FALSE(nlohmann::json::parse(out_)["passed"].get<bool>());
  EXPECT_TRUE(nlohmann::json::parse(out_)["holds_so_far"].get<bool>());
  // Something else is wrong.
  EditAgent(&log, 1, 0, 2, 2, [](agent_t& a) { a.x_m += 500; });
  EXPECT_EQ(Run(log, {}, 12 * kMin), 4);
  EXPECT_NE(out_.find("FAILED, "), std::string::npos) << out_;
  // A tick in the middle is missing.
  FakeLog hole = MakeFakeMission();
  Remove<world_state_t>(&hole, [](const world_state_t& world) { return world.tick == 5; });
  Renumber(&hole);
  EXPECT_EQ(Run(hole, {}, 12 * kMin), 4);
  EXPECT_NE(out_.find("FAILED, "), std::string::npos) << out_;
}

TEST(Audit, AnEmptyLogFails) {
  Auditor auditor;
  const auto& violations = auditor.Finish();
  ASSERT_EQ(violations.size(), 1u);
  EXPECT_EQ(violations[0].invariant, "scenario");
}

TEST(Audit, ComparesTheReportWithTheLog) {
  const FakeLog log = MakeFakeMission();
  Auditor auditor;
  RunRecord record;
  for (const Packet& packet : Encoded(log)) {
    auditor.Add(packet);
    record.Add(packet);
  }
  ASSERT_EQ(Text(auditor.Finish()), "");
  ASSERT_TRUE(auditor.facts());
  const nlohmann::json report = nlohmann::json::parse(Report(record).dump());
  EXPECT_EQ(Text(audit::CheckReportFile(report, *auditor.facts())), "");

  const std::pair<const char*, nlohmann::json> edits[] = {
      {"/tasks_done", 1},
      {"/tasks_total", 3},
      {"/completion_rate", 0.5},
      {"/charges", 2},
      {"/seed", 6},
      {"/flown_m", 14545},
      {"/digest", std::string(64, '0')},
      {"/events/sensing_done", 3},
      {"/tasks/0/uav", 1},
      {"/tasks/1/done_s", 961},
      {"/uavs/1/range_left_m", 18455},
      {"/log/messages", 1},
      {"/log/complete", false},
      {"/decisions/1/weight", 3.374},
      {"/decisions/1/bound", 4},
      {"/decisions/2/bound", nullptr},
      {"/decisions/0/actions/3/worker", 1},
      {"/decisions/0/actions/1/weight", 0.3},  // the log says 0.1 + 0.2
      {"/decisions", nlohmann::json::array()},
  };
  for (const auto& [pointer, value] : edits) {
    nlohmann::json edited = report;
    ASSERT_NE(edited.at(nlohmann::json::json_pointer(pointer)), value) << pointer;
    edited[nlohmann::json::json_pointer(pointer)] = value;
    const auto violations = audit::CheckReportFile(edited, *auditor.facts());
    ASSERT_EQ(violations.size(), 1u) << pointer << "\n" << Text(violations);
    EXPECT_EQ(violations[0].invariant, "report");
    EXPECT_NE(violations[0].text.find(std::string(pointer).substr(1)), std::string::npos)
        << Text(violations);
  }
}

}  // namespace
}  // namespace muster::tools
