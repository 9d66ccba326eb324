// Real missions by the real `muster bench`.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/lcmtypes/test_network.h"
#include "tests/tools/launch/muster_process.h"
#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

using Row = std::map<std::string, std::string>;

std::vector<std::string> FieldsOf(const std::string& line) {
  std::vector<std::string> fields;
  std::stringstream in(line + ",");
  for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
  return fields;
}

std::vector<Row> RowsOf(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> names = FieldsOf(line);
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> fields = FieldsOf(line);
    EXPECT_EQ(fields.size(), names.size()) << line;
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < names.size(); ++i) row[names[i]] = fields.at(i);
  }
  return rows;
}

TEST(MissionRuns, EachIsMeasuredAndDecidesTheSame) {
  MUSTER_NEEDS_MULTICAST();
  if (TestNetwork().kind != Network::Kind::kPrivate) GTEST_SKIP() << "no network of its own";
  const TemporaryFolder folder;
  const std::string csv = folder.File("rows.csv"), plot = folder.File("rows.gp");
  Muster muster(folder, "bench",
                {"bench", "--suite", "missions", "--instances", "Random_1", "--scales", "0.25",
                 "--limit", "30", "--processes", "1,2", "--runs", "simulate,muster,lcm,none",
                 "--out", csv, "--plot", plot});
  ASSERT_EQ(muster.Wait(std::chrono::minutes(3)), 0) << muster.output();
  const std::vector<Row> rows = RowsOf(csv);
  ASSERT_EQ(rows.size(), 2u * (1 + 2 * 3));
  std::map<std::string, std::string> digests;
  for (const Row& row : rows) {
    const std::string run = row.at("run");
    SCOPED_TRACE(row.at("instance") + " " + run + " " + row.at("processes"));
    EXPECT_EQ(row.at("end"), "complete");
    EXPECT_EQ(row.at("limit_min"), "30");
    EXPECT_GT(std::stod(row.at("wall_s")), 0);
    EXPECT_GT(std::stod(row.at("cpu_s")), 0);
    const bool over_lcm = run != "simulate", logged = run == "muster" || run == "lcm";
    EXPECT_EQ(std::stoll(row.at("sent_bytes")) > 0, over_lcm);
    EXPECT_EQ(std::stoll(row.at("received_datagrams")) > 0, over_lcm);
    EXPECT_EQ(std::stoll(row.at("log_bytes")) > 0, logged);
    EXPECT_EQ(std::stoll(row.at("log_messages")) > 0, logged);
    for (const std::string kind : {"world", "uav", "scheduler"}) {
      EXPECT_EQ(!row.at(kind + "_cpu_s").empty(), over_lcm) << kind;
      EXPECT_EQ(!row.at(kind + "_peak_bytes").empty(), over_lcm) << kind;
    }
    EXPECT_EQ(!row.at("recorder_cpu_s").empty(), run == "muster");
    EXPECT_EQ(!row.at("launcher_cpu_s").empty(), logged);
    EXPECT_EQ(!row.at("simulate_cpu_s").empty(), !over_lcm);
    if (run == "none") continue;
    EXPECT_EQ(digests.emplace(row.at("instance"), row.at("digest")).first->second,
              row.at("digest"));
  }
  EXPECT_EQ(digests.size(), 2u);
  EXPECT_NE(TextOf(plot).find(csv), std::string::npos);
}

TEST(MissionRuns, WhatCannotBeIsRefused) {
  const TemporaryFolder folder;
  const std::vector<std::vector<std::string>> requests = {{"--methods", "mpq,ils"},
                                                          {"--instances", "Random_77"},
                                                          {"--processes", "0"},
                                                          {"--runs", "tape"},
                                                          {"--plot", "x.gp"}};
  for (std::vector<std::string> request : requests) {
    request.insert(request.begin(), {"bench", "--suite", "missions"});
    Muster muster(folder, "bench", request);
    EXPECT_EQ(muster.Wait(), 2) << muster.output();
  }
}

}  // namespace
}  // namespace muster::tools
