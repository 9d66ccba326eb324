#include "tools/bench/paper_suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "base/check.h"
#include "scheduler/policies/registry.h"
#include "tests/temporary_folder.h"
#include "tools/bench/paper_page.h"
#include "tools/bench/paper_rows.h"
#include "tools/bench/paper_tables.h"
#include "tools/host/worker_pool.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

class PaperSuite : public ::testing::Test {
 protected:
  /// Two settings, both modes, two seeds: 24 runs of a few hundredths of a second.
  PaperOptions Small(const std::string& out, int jobs = 2) const {
    PaperOptions options;
    options.filter.settings = {"Random_4", "Random_10"};
    options.filter.policies = {std::string(kUpperBound), "kwta", "horizon"};
    options.filter.seeds = 2;
    options.out = (folder_ / out).string();
    options.jobs = jobs;
    options.quiet = true;
    return options;
  }
  std::string Read(const std::string& out, const char* file = "runs.csv") const {
    std::ifstream in(folder_ / out / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void Write(const std::string& out, const std::string& text) const {
    std::ofstream(folder_ / out / "runs.csv", std::ios::binary) << text;
  }
  /// Without the last four columns, which are times.
  static std::string WithoutTimes(const std::string& csv) {
    std::string text;
    std::size_t at = 0;
    while (at < csv.size()) {
      std::string line = csv.substr(at, csv.find('\n', at) - at);
      at += line.size() + 1;
      for (int i = 0; i < 4; ++i) line.resize(line.rfind(','));
      text += line + "\n";
    }
    return text;
  }

  const TemporaryFolder folder_;
};

TEST_F(PaperSuite, RowsDoNotDependOnJobsOrderOrInterruption) {
  ASSERT_TRUE(RunPaperSuite(Small("one", 1)));
  ASSERT_TRUE(RunPaperSuite(Small("three", 3)));
  const std::string all = Read("one");
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 1 + 2 * 2 * 2 * 3);
  EXPECT_EQ(WithoutTimes(all), WithoutTimes(Read("three")));

  // Killed in the middle of a row; what is there already is not flown again.
  fs::create_directory(folder_ / "torn");
  const std::size_t half = all.size() / 2;
  const std::string kept = all.substr(0, all.rfind('\n', half) + 1);
  ASSERT_LT(kept.size(), half) << "the cut is to be inside a row";
  Write("torn", all.substr(0, half));
  ASSERT_TRUE(RunPaperSuite(Small("torn")));
  EXPECT_EQ(WithoutTimes(Read("torn")), WithoutTimes(all));
  EXPECT_EQ(Read("torn").substr(0, kept.size()), kept) << "times and all";
}

TEST_F(PaperSuite, MoreSeedsGoOnWhereFewerEnded) {
  PaperOptions options = Small("grow");
  options.filter.seeds = 1;
  ASSERT_TRUE(RunPaperSuite(options));
  const PaperRows first = ReadPaperCsv((folder_ / "grow" / "runs.csv").string());
  options.filter.seeds = 2;
  ASSERT_TRUE(RunPaperSuite(options));
  const PaperRows second = ReadPaperCsv((folder_ / "grow" / "runs.csv").string());
  EXPECT_EQ(second.size(), 2 * first.size());
  for (const auto& [run, row] : first) EXPECT_EQ(second.at(run).cpu_s, row.cpu_s) << NameOf(run);
}

TEST_F(PaperSuite, RowsOfAnotherProgramAreRefused) {
  ASSERT_TRUE(RunPaperSuite(Small("mixed")));
  std::string csv = Read("mixed");
  const std::string build = BuildName();
  csv.replace(csv.rfind(build), build.size(), std::string(build.size(), '0'));
  Write("mixed", csv);
  try {
    RunPaperSuite(Small("mixed"));
    FAIL() << "taken as they are";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("runs.csv: build of Random_4"), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(Read("mixed"), csv) << "the rows stay as they were";
}

TEST_F(PaperSuite, JobsMergeToTheSameRows) {
  ASSERT_TRUE(RunPaperSuite(Small("whole")));
  std::vector<std::string> folders;
  for (const char* setting : {"Random_10", "Random_4"}) {
    PaperOptions part = Small(setting);
    part.filter.settings = {setting};
    ASSERT_TRUE(RunPaperSuite(part));
    folders.push_back(part.out);
  }
  MergePaperRuns(Small("merged"), folders);
  EXPECT_EQ(WithoutTimes(Read("merged")), WithoutTimes(Read("whole")));

  ::testing::internal::CaptureStdout();
  ListPaperJobs(Small("jobs"), "muster");
  const std::string jobs = ::testing::internal::GetCapturedStdout();
  EXPECT_EQ(std::count(jobs.begin(), jobs.end(), '\n'), 2 * 3);
  EXPECT_NE(jobs.find("muster bench --suite paper --instances Random_10 --methods kwta "),
            std::string::npos);
  EXPECT_EQ(jobs.find("--data"), std::string::npos);

  folders.push_back((folder_ / "empty").string());
  EXPECT_THROW(MergePaperRuns(Small("again"), folders), InputError);
}

TEST_F(PaperSuite, JobsOfTheLongSuiteAreOfThatSuite) {
  PaperOptions options = Small("jobs");
  options.filter = {};
  options.filter.longer = true;
  ::testing::internal::CaptureStdout();
  ListPaperJobs(options, "muster");
  const std::string jobs = ::testing::internal::GetCapturedStdout();
  EXPECT_NE(jobs.find("--suite paper-long "), std::string::npos);
  EXPECT_EQ(jobs.find("--suite paper "), std::string::npos);
}

TEST_F(PaperSuite, NothingIsMergedThatIsMissingDoubledOrOfAnotherBuild) {
  ASSERT_TRUE(RunPaperSuite(Small("whole")));
  const std::string all = Read("whole");
  const auto error_of = [&](const std::vector<std::string>& names) {
    std::vector<std::string> folders;
    for (const std::string& name : names) folders.push_back((folder_ / name).string());
    try {
      MergePaperRuns(Small("merged"), folders);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  // A job that was killed in its last row.
  fs::create_directory(folder_ / "torn");
  Write("torn", all.substr(0, all.size() - 20));
  const std::string missing = error_of({"torn"});
  EXPECT_NE(missing.find("1 of 24 runs missing, the first Random_4 "), std::string::npos)
      << missing;
  EXPECT_NE(missing.find("run these jobs again: Random_4."), std::string::npos) << missing;
  EXPECT_NE(error_of({"whole", "torn"}).find("each run once"), std::string::npos);
  fs::create_directory(folder_ / "other");
  std::string other = all;
  const std::string build = BuildName();
  other.replace(other.rfind(build), build.size(), std::string(build.size(), '0'));
  Write("other", other);
  EXPECT_NE(error_of({"other"}).find("build of Random_4"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "merged")) << "nothing is half-written";
  EXPECT_EQ(error_of({"whole"}), "");
}

TEST_F(PaperSuite, AFolderOfPlacesHasAllTheirTables) {
  PaperOptions options = Small("data");
  options.data = (folder_ / "").string();
  EXPECT_THROW(RunPaperSuite(options), InputError);
}

TEST(PublishedFigures, AreThoseOfThePaper) {
  const auto figure = PublishedFigures::OfThePaper().Of("Table 3", "Random_1", "mpq");
  EXPECT_DOUBLE_EQ(figure.completion.value(), 0.7283);
  EXPECT_DOUBLE_EQ(figure.decision_s.value(), 0.18);
}

TEST_F(PaperSuite, TablesHoldMeansErrorsAndThePapersFigures) {
  const std::string figures =
      "table_or_section,dataset_or_setting,algorithm,metric,value\n"
      "Table 3 (x),Random_1,HoCs-MPQ,task_completion_rate,0.7283\n"
      "Table 3 (x),Random_1,HoCs-MPQ,decision_time_s,0.18\n"
      "Sec 5.2.3 Fig 9,\"area scale: mean of Random_2(20x20)+Random_1(30x30)"
      "+Random_3(40x40); Interval 10min; LimitTime 3h\",HoCs-MPQ,"
      "task_completion_rate_pct,74.72\n";
  PaperRows rows;
  const auto add = [&](const char* setting, const char* policy, std::uint64_t seed,
                       std::int64_t done) {
    PaperRow row;
    row.build = "b";
    row.tasks = 100;
    row.done = done;
    row.decision_median_s = 0.002;
    PaperCase what;
    what.setting = setting;
    rows[{what, policy, seed}] = row;
  };
  add("Random_1", "mpq", 1, 60);
  add("Random_1", "mpq", 2, 70);
  add("Random_1", "horizon", 1, 58);
  add("Random_1", "horizon", 2, 69);
  add("Random_2", "mpq", 1, 90);
  add("Random_3", "mpq", 1, 30);
  const std::vector<PaperTable> tables =
      MakePaperTables(rows, PublishedFigures(figures, "figures.csv"));
  const auto cell = [&](const std::string& title, const std::string& label) {
    for (const PaperTable& table : tables) {
      for (std::size_t l = 0; l < table.labels.size(); ++l) {
        if (table.title.starts_with(title) && table.labels[l] == label) return table.cells[l][0];
      }
    }
    ADD_FAILURE() << "no " << title << " " << label;
    return PaperCell();
  };
  const PaperCell single = cell("Table 3", "Random_1");
  EXPECT_EQ(single.seeds, 2);
  EXPECT_DOUBLE_EQ(single.mean, 0.65);
  EXPECT_NEAR(single.standard_deviation, 0.05 * std::sqrt(2), 1e-12);
  EXPECT_NEAR(single.standard_error, 0.05, 1e-12);
  EXPECT_EQ(CompletionText(single), "0.650 ± 0.050 (0.728)");
  EXPECT_EQ(DecisionTimeText(single), "2 ms (180 ms)");
  // Only seed 1 has all three.
  const PaperCell mean = cell("Group (3)", "area, mean");
  EXPECT_EQ(mean.seeds, 1);
  EXPECT_DOUBLE_EQ(mean.mean, 0.6);
  EXPECT_DOUBLE_EQ(mean.published.completion.value(), 0.7472);

  const std::vector<PairedDifference> differences = PairedDifferences(rows, "horizon", "mpq");
  ASSERT_EQ(differences.size(), 1u);
  EXPECT_NEAR(differences[0].mean, -0.015, 1e-12);
  EXPECT_NEAR(differences[0].standard_error, 0.005, 1e-12);
  EXPECT_TRUE(differences[0].below());

  const std::string page = (folder_ / "page.html").string();
  WritePaperPage(rows, (folder_ / "page.md").string(), page);
  std::ifstream in(page);
  const std::string html(std::istreambuf_iterator<char>(in), {});
  EXPECT_NE(html.find("0.650 ± 0.050 (0.728)"), std::string::npos);
  if (std::system("command -v gnuplot > /dev/null 2>&1") == 0) {
    EXPECT_NE(html.find("<svg"), std::string::npos);
  }
  EXPECT_EQ(html.find("src="), std::string::npos) << "one file that needs no other";
}

TEST(PaperPlan, HoldsTheWholeTable2AndNoRunTwice) {
  const std::vector<PaperRun> main = PlanRuns({});
  const std::set<PaperRun> unique(main.begin(), main.end());
  EXPECT_EQ(unique.size(), main.size());
  std::set<std::string> settings, policies;
  for (const PaperRun& run : main) {
    settings.insert(run.what.setting);
    policies.insert(run.policy);
  }
  for (int n = 1; n <= 29; ++n) EXPECT_EQ(settings.count("Random_" + std::to_string(n)), 1u) << n;
  for (const std::string& policy : policies) {
    if (policy == kUpperBound) continue;
    EXPECT_NO_THROW(scheduler::MakePolicy(policy)) << policy;
  }
  PaperFilter longer;
  longer.longer = true;
  for (const PaperRun& run : PlanRuns(longer)) {
    EXPECT_EQ(unique.count(run), 0u) << NameOf(run);
    EXPECT_NO_THROW(scheduler::MakePolicy(run.policy));
  }
}

TEST(RunInProcesses, ACrashOrAnErrorTouchesNoOtherJob) {
  std::vector<std::string> results(6);
  RunInProcesses(
      6, 2,
      [](std::size_t i) -> std::string {
        if (i == 1) std::_Exit(7);
        if (i == 2) throw InputError("no good");
        if (i == 3) std::abort();
        return std::string(100000, static_cast<char>('a' + i));  // more than a pipe holds
      },
      [&](std::size_t i, const std::string& text) { results[i] = text; },
      [&](std::size_t i, const std::string& why) { results[i] = "failed: " + why; });
  EXPECT_EQ(results[0], std::string(100000, 'a'));
  EXPECT_EQ(results[1], "failed: exit code 7");
  EXPECT_EQ(results[2], "failed: no good");
  EXPECT_EQ(results[3], "failed: ended by signal 6");
  EXPECT_EQ(results[5], std::string(100000, 'f'));
}

}  // namespace
}  // namespace muster::tools
