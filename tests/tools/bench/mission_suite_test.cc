#include "tools/bench/mission_suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace muster::tools {
namespace {

MissionRow Row(double size, const std::string& run, int processes, double wall_s) {
  MissionRow row;
  row.instance = size == 1 ? "Random_29" : "Random_29 x" + std::to_string(static_cast<int>(size));
  row.size = size;
  row.agents = static_cast<std::int64_t>(400 * size);
  row.policy = "certified";
  row.run = run;
  row.processes = processes;
  row.figures.wall_s = wall_s;
  row.figures.log_bytes = static_cast<std::int64_t>(1e6 * size);
  row.figures.received_datagrams = 99;
  row.figures.buffer_errors = 1;
  row.figures.digest = "d";
  row.figures.kinds["uav"] = {0.25, 3 << 20};
  return row;
}

TEST(MissionSuite, KernelCountersAreFoundByProtocolAndName) {
  const std::string table =
      "Ip: Forwarding InReceives\nIp: 1 7\nUdp: InDatagrams NoPorts RcvbufErrors\nUdp: 12 0 345\n";
  EXPECT_EQ(KernelCounter(table, "Udp", "RcvbufErrors"), 345);
  EXPECT_EQ(KernelCounter(table, "Ip", "InReceives"), 7);
  EXPECT_EQ(KernelCounter(table, "Udp", "InReceives"), -1);
  EXPECT_EQ(KernelCounter("", "Udp", "RcvbufErrors"), -1);
  EXPECT_EQ(KernelCounter("Udp: A\n", "Udp", "A"), -1);
}

TEST(MissionSuite, ProcessesOfAClassAreOfOneKind) {
  EXPECT_EQ(KindOf("uav"), "uav");
  EXPECT_EQ(KindOf("uav-12"), "uav");
  EXPECT_EQ(KindOf("uav-"), "uav-");
  EXPECT_EQ(KindOf("my-uav"), "my-uav");
}

TEST(MissionSuite, ARowHasAllColumns) {
  MissionRow row = Row(1, "muster", 2, 1.5);
  row.figures.end = "exited with code 3, \"no\"\n";
  const std::string header = MissionCsvHeader(), line = ToCsv(row);
  EXPECT_EQ(std::count(line.begin(), line.end(), ','),
            std::count(header.begin(), header.end(), ','));
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  EXPECT_NE(line.find(",0.25,"), std::string::npos) << line;
  EXPECT_NE(line.find(",3145728,"), std::string::npos) << line;
}

TEST(MissionSuite, TheSummaryHasMediansRatiosAndGrowth) {
  std::vector<MissionRow> rows = {Row(1, "simulate", 1, 0.5), Row(10, "simulate", 1, 5)};
  for (const double wall_s : {3.0, 1.0, 2.0}) rows.push_back(Row(1, "muster", 1, wall_s));
  rows.push_back(Row(10, "muster", 1, 2 * std::pow(10, 1.25)));
  const std::string text = SummaryOf(rows);
  EXPECT_NE(text.find("Random_29        400   muster     1    3   2.00  4.00"), std::string::npos)
      << text;
  EXPECT_NE(text.find("Random_29, muster, 1 a class: wall time grows with agents^1.25, the log "
                      "with agents^1.00\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(SummaryOf(std::vector<MissionRow>{}).find("grows"), std::string::npos);
}

TEST(MissionSuite, WhoEndsOtherwiseOrDecidesOtherwiseIsNamed) {
  std::vector<MissionRow> rows = {Row(1, "simulate", 1, 1), Row(1, "muster", 1, 1),
                                  Row(1, "muster", 12, 1), Row(1, "none", 1, 1)};
  rows[3].figures.digest = "";
  EXPECT_TRUE(ProblemsOf(rows).empty());
  rows[1].figures.digest = "e";
  rows[2].figures.end = "exited with code 3";
  EXPECT_EQ(ProblemsOf(rows),
            (std::vector<std::string>{
                "Random_29, 1 a class, muster, repetition 0: decided otherwise than the first of "
                "its instance",
                "Random_29, 12 a class, muster, repetition 0: exited with code 3"}));
}

TEST(MissionSuite, ThePlotReadsItsCsvFile) {
  const std::string script = MissionPlotScript("rows.csv", "plot.svg", 12);
  EXPECT_NE(script.find("set output 'plot.svg'"), std::string::npos);
  EXPECT_NE(script.find("'rows.csv' using"), std::string::npos);
  EXPECT_NE(script.find("of('muster', 12, 'wall_s')"), std::string::npos);
  EXPECT_EQ(script.find("every"), std::string::npos) << "it would leave out the first row";
  EXPECT_EQ(MissionPlotScript("rows.csv", "plot.svg", 1).find("12"), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
