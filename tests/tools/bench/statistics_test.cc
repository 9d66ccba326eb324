#include "tools/bench/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/check.h"
#include "tests/temporary_folder.h"
#include "tools/bench/bench_command.h"
#include "tools/bench/plot.h"
#include "tools/bench/sheet.h"
#include "tools/files/pending_file.h"

namespace muster::tools {
namespace {

TEST(Statistics, AQuantileIsTheValueOfTheNearestRank) {
  const std::vector<double> values = {5, kNotKnown, 1, 4, 2, 3};
  EXPECT_EQ(Quantile(values, 0), 1);
  EXPECT_EQ(Quantile(values, 0.5), 3);
  EXPECT_EQ(Quantile(values, 0.9), 5);
  EXPECT_EQ(Quantile({1, 2, 3, 4}, 0.5), 3) << "of the two in the middle the upper one";
  EXPECT_TRUE(std::isnan(Quantile({kNotKnown}, 0.5)));
}

TEST(Statistics, MomentsAndSharesLeaveOutWhatIsNotKnown) {
  const Moments moments = MomentsOf({2, kNotKnown, 4, 6});
  EXPECT_EQ(moments.n, 3);
  EXPECT_DOUBLE_EQ(moments.mean, 4);
  EXPECT_DOUBLE_EQ(moments.standard_deviation, 2);
  EXPECT_DOUBLE_EQ(moments.standard_error, 2 / std::sqrt(3));
  EXPECT_EQ(MomentsOf({3}).standard_error, 0);
  EXPECT_DOUBLE_EQ(PercentUpTo(2, {1, 2, kNotKnown, 3, 4}), 50);
  EXPECT_TRUE(std::isnan(PercentUpTo(2, {})));
}

TEST(Statistics, GrowthIsThePowerOfTheSize) {
  EXPECT_NEAR(GrowthOf({{1, 3}, {10, 300}, {100, 30'000}}), 2, 1e-12);
  EXPECT_NEAR(GrowthOf({{1, 3}, {0, 7}, {10, 30}}), 1, 1e-12) << "without what has no logarithm";
  EXPECT_TRUE(std::isnan(GrowthOf({{5, 1}, {5, 2}})));
}

TEST(Statistics, GroupsKeepTheOrderOfTheirRows) {
  const std::vector<std::string> rows = {"b1", "a1", "b2"};
  const auto groups = GroupsOf(rows, [](const std::string& row) { return row[0]; });
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].first, 'b');
  const auto digit = [](const std::string& row) { return row[1] - '0'; };
  EXPECT_EQ(ValuesOf(groups[0].second, digit), (std::vector<double>{1, 2}));
}

TEST(Sheet, IsPlainTextOrMarkdown) {
  Sheet sheet("name|ms");
  sheet.Add("a|12.5");
  sheet.Add("longer|");
  EXPECT_EQ(sheet.Text(), "name     ms\na      12.5\nlonger     \n");
  EXPECT_EQ(sheet.Markdown(), "| name | ms |\n| --- | --- |\n| a | 12.5 |\n| longer |  |\n");
}

TEST(RowFile, BeginsAnewWithAHeaderAndGoesOnWithoutOne) {
  const TemporaryFolder folder;
  const std::string file = folder.File("rows.csv");
  WriteFile(file, "old\n");
  RowFile(file, "header\n").Add("1\n");
  RowFile(file, "").Add("2\n");
  EXPECT_EQ(ReadFile(file), "header\n1\n2\n");
  EXPECT_THROW(RowFile(folder.File("no/rows.csv"), "h\n"), SystemError);
  RowFile("", "header\n").Add("1\n");
}

TEST(Plot, DrawsPointsOrTheCsvFileInItsColumns) {
  const Plot plot{800,
                  400,
                  "set grid\n",
                  {{"set title 'a'\n", {{"1 2\n", "with lines", "ours"}}},
                   {"set title 'b'\n", {{"", "using 1:2", "read"}}},
                   {"", {}}},
                  2};
  EXPECT_EQ(ScriptOf(plot, "p.svg", "rows.csv"),
            "reset\nset terminal svg size 800,400 noenhanced background 'white'\n"
            "set output 'p.svg'\nset datafile separator ','\nset grid\nset multiplot layout 2,2\n"
            "set title 'a'\n$of_0_0 << EOD\n1 2\nEOD\nplot $of_0_0 with lines title 'ours'\n"
            "set title 'b'\nplot 'rows.csv' using 1:2 title 'read'\n"
            "unset multiplot\nunset output\n");
}

std::string Refusal(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "muster bench");
  try {
    BenchCommand(static_cast<int>(arguments.size()), arguments.data());
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

/// From the usual table of Student's t.
TEST(Statistics, StudentsQuantileIsThatOfTheTable) {
  const std::pair<int, double> table[] = {{4, 2.776},  {5, 2.571},        {6, 2.447},
                                          {9, 2.262},  {19, 2.093},       {29, 2.045},
                                          {99, 1.984}, {1'000'000, 1.960}};
  for (const auto& [degrees, value] : table) {
    EXPECT_NEAR(StudentQuantile975(degrees), value, 0.002) << degrees;
  }
  EXPECT_TRUE(std::isnan(StudentQuantile975(3)));
}

TEST(Bench, ASuiteRefusesTheOptionsOfOthersByName) {
  const struct {
    std::vector<const char*> arguments;
    std::string option;
  } cases[] = {
      {{"--cbc", "nothing"}, "--cbc"},
      {{"--suite", "scale", "--instances", "Random_1"}, "--instances"},
      {{"--suite", "hard", "--methods", "mpq"}, "--methods"},
      {{"--suite", "random", "--plot", "p.gp", "--out", "o.csv"}, "--plot"},
      {{"--suite", "random-missions", "--threads", "2"}, "--threads"},
      {{"--suite", "small-missions", "--threads", "2"}, "--threads"},
      {{"--suite", "missions", "--seeds", "3"}, "--seeds"},
      {{"--suite", "missions", "--threads", "2"}, "--threads"},
      {{"--suite", "arrivals", "--limit", "30"}, "--limit"},
      {{"--suite", "arrivals", "--merge", "a"}, "--merge"},
      {{"--suite", "paper", "--loads", "1"}, "--loads"},
      {{"--suite", "paper-long", "--repetitions", "1"}, "--repetitions"},
  };
  for (const auto& c : cases) {
    const std::string said = Refusal(c.arguments);
    EXPECT_NE(said.find(c.option + ": found suite "), std::string::npos) << said;
  }
  EXPECT_NE(Refusal({"--plot", "p.gp"}).find("--out: found nothing"), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
