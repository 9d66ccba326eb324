#include "tools/bench/paper_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "base/check.h"
#include "base/sha256.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tools/bench/general_solver.h"
#include "tools/bound/upper_bound.h"
#include "tools/files/pending_file.h"
#include "tools/host/build_info.h"
#include "tools/record/report_json.h"
#include "tools/scenario/table.h"

namespace muster::tools {
namespace {

constexpr std::string_view kHeader =
    "setting,interval_min,limit_min,disturbance,availability,policy,seed,build,places,tasks,done,"
    "completion,charges,flown_km,digest,decision_median_s,decision_mean_s,decision_max_s,cpu_s\n";

/// Fields of one line of the CSV by column.
class Fields {
 public:
  Fields(const Table& table, std::size_t row)
      : table_(table), row_(table.rows[row]), line_(row + 2) {}

  const std::string& Text(std::string_view column) const { return row_[table_.Column(column)]; }
  template <class T>
  T Number(std::string_view column) const {
    const std::string& text = Text(column);
    T value{};
    const auto end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || at != end) {
      throw InputError(fmt::format("{}:{}", table_.file, line_), column, "'" + text + "'",
                       "a number");
    }
    return value;
  }

 private:
  const Table& table_;
  const std::vector<std::string>& row_;
  std::size_t line_;
};

}  // namespace

PaperRow FlyPaperRun(const PaperRun& run, const Scenario& scenario) {
  const double started_s = CpuSeconds();
  PaperRow row;
  row.tasks = static_cast<std::int64_t>(scenario.tasks.size());
  if (run.policy == kUpperBound) {
    row.done = UpperBound(scenario);
    row.cpu_s = CpuSeconds() - started_s;
    return row;
  }
  RunRecord record;
  Simulate(TextOf(scenario), PolicyToRun(run), [&](const Packet& packet) { record.Add(packet); });
  const nlohmann::ordered_json report = Report(record);
  row.done = report["tasks_done"];
  row.charges = report["charges"];
  row.flown_km = report["flown_m"].get<double>() / 1000;
  row.digest = report["digest"];
  row.decision_median_s = report["decision_time"]["median_s"];
  row.decision_max_s = report["decision_time"]["max_s"];
  double solve_us = 0;
  for (const auto& [index, schedule] : record.schedules()) {
    solve_us += static_cast<double>(schedule.solve_us);
  }
  const auto n = std::max<std::size_t>(1, record.schedules().size());
  row.decision_mean_s = solve_us * 1e-6 / static_cast<double>(n);
  row.cpu_s = CpuSeconds() - started_s;
  return row;
}

std::string PaperCsvHeader() { return std::string(kHeader); }

std::string PaperCsvLine(const PaperRun& run, const PaperRow& row) {
  return fmt::format(
      "{},{},{},{},{},{},{},{},{},{},{},{:.6f},{},{:.3f},{},{:.6f},{:.6f},{:.6f},{:.3f}\n",
      run.what.setting, run.what.interval_min, run.what.limit_min, run.what.disturbance,
      NameOf(run.what.availability), run.policy, run.seed, row.build, row.places, row.tasks,
      row.done, row.completion(), row.charges, row.flown_km, row.digest, row.decision_median_s,
      row.decision_mean_s, row.decision_max_s, row.cpu_s);
}

std::string PaperCsv(const PaperRows& rows) {
  std::string text = PaperCsvHeader();
  for (const auto& [run, row] : rows) text += PaperCsvLine(run, row);
  return text;
}

PaperRows ReadPaperCsv(const std::string& file) {
  std::string text = ReadFile(file);
  text.resize(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);
  if (text.empty()) return {};
  if (!text.starts_with(kHeader)) {
    throw InputError(file, "line 1", "'" + text.substr(0, text.find('\n')) + "'",
                     "the columns of muster bench --suite paper");
  }
  const Table table = ParseCsv(text, file);
  PaperRows rows;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const Fields fields(table, i);
    PaperRun run;
    run.what = {
        fields.Text("setting"), fields.Number<int>("interval_min"), fields.Number<int>("limit_min"),
        fields.Text("disturbance"),
        fields.Text("availability") == "strict" ? Availability::kStrict : Availability::kOverrun};
    run.policy = fields.Text("policy");
    run.seed = fields.Number<std::uint64_t>("seed");
    PaperRow row;
    row.build = fields.Text("build");
    row.places = fields.Text("places");
    row.tasks = fields.Number<std::int64_t>("tasks");
    row.done = fields.Number<std::int64_t>("done");
    row.charges = fields.Number<std::int64_t>("charges");
    row.flown_km = fields.Number<double>("flown_km");
    row.digest = fields.Text("digest");
    row.decision_median_s = fields.Number<double>("decision_median_s");
    row.decision_mean_s = fields.Number<double>("decision_mean_s");
    row.decision_max_s = fields.Number<double>("decision_max_s");
    row.cpu_s = fields.Number<double>("cpu_s");
    rows.emplace(std::move(run), std::move(row));
  }
  return rows;
}

std::string NameOf(const PaperRun& run) {
  return fmt::format("{} {} min {} min {} {} {} seed {}", run.what.setting, run.what.interval_min,
                     run.what.limit_min, run.what.disturbance, NameOf(run.what.availability),
                     run.policy, run.seed);
}

std::string BuildName() {
  std::string commit = kCommit;
  if (commit != "unknown" && !commit.ends_with("-dirty")) return commit;
  return commit + "-" + Sha256(ReadFile("/proc/self/exe")).substr(0, 12);
}

}  // namespace muster::tools
