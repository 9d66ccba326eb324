// Logs that earlier versions wrote (tests/logs) are read, audited, decided again and shown.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"
#include "tools/audit/audit_command.h"
#include "tools/explain/redecide_command.h"
#include "tools/log/log_source.h"
#include "tools/record/digest.h"
#include "tools/record/run_record.h"
#include "tools/report/page.h"
#include "tools/report/report_command.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

class OldLogs : public ::testing::TestWithParam<std::string> {
 protected:
  std::string run() const { return (fs::path(MUSTER_OLD_LOGS) / GetParam()).string(); }

  template <class Command>
  int Run(Command command, std::vector<const char*> arguments) {
    ::testing::internal::CaptureStdout();
    const int code = command(static_cast<int>(arguments.size()), arguments.data());
    std::fflush(stdout);
    said_ = ::testing::internal::GetCapturedStdout();
    return code;
  }

  std::string said_;
};

std::vector<std::string> Versions() {
  std::vector<std::string> versions;
  for (const auto& entry : fs::directory_iterator(MUSTER_OLD_LOGS)) {
    if (entry.is_directory()) versions.push_back(entry.path().filename());
  }
  return versions;
}

std::string Text(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_P(OldLogs, SayWhatTheirReportSays) {
  RunRecord record;
  LogSource log(run());
  while (const auto message = log.Next()) record.Add(message->packet);
  const auto report = nlohmann::json::parse(Text(run() + "/report.json"));
  EXPECT_TRUE(record.CheckComplete().complete);
  EXPECT_EQ(Digest(record), report.at("digest"));
  EXPECT_EQ(record.counts().messages, report.at("log").at("messages"));
  EXPECT_EQ(record.faults().size(), report.at("faults").size());
}

TEST_P(OldLogs, PassTheAudit) {
  EXPECT_EQ(Run(AuditCommand, {"muster audit", run().c_str()}), 0) << said_;
}

TEST_P(OldLogs, AreDecidedAgainBitForBit) {
  EXPECT_EQ(Run(RedecideCommand, {"muster redecide", run().c_str()}), 0) << said_;
  EXPECT_NE(said_.find("bit for bit"), std::string::npos) << said_;
}

TEST_P(OldLogs, AreShown) {
  if (PageTemplate().empty()) GTEST_SKIP() << "this build has no report page";
  const TemporaryFolder folder;
  const std::string page = folder.File("page.html");
  EXPECT_EQ(Run(ReportCommand, {"muster report", run().c_str(), "--out", page.c_str()}), 0);
  EXPECT_GT(fs::file_size(page), PageTemplate().size());
}

class SealedLog : public OldLogs {
 protected:
  /// The key, changed in its first digit or not, where its owner alone may read it.
  std::string Key(bool changed) const {
    std::string text = Text(run() + "/seal.key");
    if (changed) text[0] = text[0] == '0' ? '1' : '0';
    const std::string file = folder_.File(changed ? "other.key" : "seal.key");
    std::ofstream(file) << text;
    fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
    return file;
  }
  const TemporaryFolder folder_;
};

TEST_P(SealedLog, IsProvenByItsKeyAlone) {
  const std::string log = folder_.File("mission.lcm");
  fs::copy_file(run() + "/mission.lcm", log);
  EXPECT_EQ(Run(AuditCommand, {"muster audit", log.c_str()}), 0) << "read without: " << said_;
  const std::string key = Key(false);
  EXPECT_EQ(Run(AuditCommand, {"muster audit", run().c_str(), "--key", key.c_str()}), 0) << said_;
  EXPECT_NE(said_.find(" messages have the right tag\n"), std::string::npos) << said_;
  EXPECT_EQ(said_.find("left out"), std::string::npos) << said_;
  const std::string other = Key(true);
  EXPECT_EQ(Run(AuditCommand, {"muster audit", run().c_str(), "--key", other.c_str()}), 4) << said_;
}

INSTANTIATE_TEST_SUITE_P(OfVersion0_1_0, SealedLog, ::testing::Values("0.1.0_sealed"));

INSTANTIATE_TEST_SUITE_P(EveryVersion, OldLogs, ::testing::ValuesIn(Versions()),
                         [](const auto& version) {
                           std::string name = "Version" + version.param;
                           for (char& c : name) {
                             if (c == '.') c = '_';
                           }
                           return name;
                         });

}  // namespace
}  // namespace muster::tools
