#include "tools/bench/paper_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "base/check.h"
#include "base/text.h"
#include "tools/bench/sheet.h"
#include "tools/bench/statistics.h"
#include "tools/scenario/table.h"

namespace muster::tools {

extern const std::string_view kPublishedCsv;  // made by CMake of published.csv

namespace {

/// The paper's methods and our readings of them. The learned methods have no reading here.
constexpr std::pair<std::string_view, std::string_view> kReadings[] = {
    {"mpq", "HoCs-MPQ"},
    {"mpq", "HoCs-MPQ hierarchical weights"},
    {"mpq-uniform", "HoCs-MPQ uniform weights"},
    {"ils", "HoCs-ILS"},
    {"kwta", "HoCs-KWTA"},
    {"greedy-sum", "HoCs-GREEDY"},
    {"greedy-nearest", "HoCs-GREEDY"},
    {"HoCs-MADL", "HoCs-MADL"},
    {"HoCs-MARL", "HoCs-MARL"},
};

/// Columns: the policies in the order of the plan, then the paper's that we do not have.
const std::vector<std::string>& ColumnOrder() {
  static const std::vector<std::string> order = [] {
    std::vector<std::string> names = PaperPolicies();
    const std::vector<std::string> learned = LearnedColumns();
    names.insert(names.end(), learned.begin(), learned.end());
    names.insert(names.end(), {"HoCs-MADL", "HoCs-MARL"});
    return names;
  }();
  return order;
}

PaperCell CellOf(const PaperRows& rows, std::vector<PaperCase> cases, Availability availability,
                 const std::string& policy, const std::set<std::uint64_t>& seeds) {
  PaperCell cell;
  std::vector<double> values;
  double decision_s = 0;
  for (const std::uint64_t seed : seeds) {
    double sum = 0, time_s = 0;
    const bool all = std::all_of(cases.begin(), cases.end(), [&](PaperCase what) {
      what.availability = availability;
      const auto row = rows.find({what, policy, seed});
      if (row == rows.end()) return false;
      sum += row->second.completion();
      time_s += row->second.decision_median_s;
      return true;
    });
    if (!all) continue;
    values.push_back(sum / static_cast<double>(cases.size()));
    decision_s += time_s / static_cast<double>(cases.size());
  }
  cell.seeds = static_cast<int>(values.size());
  if (values.empty()) return cell;
  const Moments moments = MomentsOf(values);
  cell.mean = moments.mean;
  cell.standard_deviation = moments.standard_deviation;
  cell.standard_error = moments.standard_error;
  cell.decision_s = decision_s / static_cast<double>(values.size());
  return cell;
}

std::string Duration(double seconds) {
  if (seconds < 1) return fmt::format("{:.3g} ms", seconds * 1e3);
  return fmt::format("{:.3g} s", seconds);
}

/// Without the policies that no line has a run of, but with the paper's own that it has figures of.
PaperTable WithoutEmptyColumns(const PaperTable& all) {
  PaperTable table{all.title, all.note, all.availability, {}, all.labels, {}};
  table.cells.resize(all.labels.size());
  for (std::size_t p = 0; p < all.policies.size(); ++p) {
    const std::string& policy = all.policies[p];
    const bool used = std::any_of(all.cells.begin(), all.cells.end(), [&](const auto& line) {
      return line[p].seeds > 0 || (policy.starts_with("HoCs-") && line[p].published.completion);
    });
    if (!used) continue;
    table.policies.push_back(policy);
    for (std::size_t l = 0; l < all.labels.size(); ++l) table.cells[l].push_back(all.cells[l][p]);
  }
  return table;
}

/// A line for each of the table's, with `cell` of each policy.
std::string MarkdownOf(
    const PaperTable& table,
    const std::function<std::string(std::size_t line, std::size_t policy)>& cell) {
  Sheet sheet(fmt::format("|{}", fmt::join(table.policies, "|")));
  for (std::size_t l = 0; l < table.labels.size(); ++l) {
    std::string cells = table.labels[l];
    for (std::size_t p = 0; p < table.policies.size(); ++p) cells += "|" + cell(l, p);
    sheet.Add(cells);
  }
  return sheet.Markdown() + "\n";
}

std::string CaseName(const PaperCase& what) {
  return fmt::format("{} {} min {} h {} {}", what.setting, what.interval_min, what.limit_min / 60,
                     what.disturbance, NameOf(what.availability));
}

/// What the requirement asks of our policies, and where it fails.
std::string Differences(const PaperRows& rows) {
  Sheet sheet("policy|cases|above|equal|below|smallest difference");
  std::string failing;
  for (const std::string policy : {"horizon", "rollout", "certified"}) {
    std::vector<PairedDifference> all = PairedDifferences(rows, policy, "mpq");
    std::erase_if(all, [](const PairedDifference& d) { return d.seeds < 2; });  // no error known
    if (all.empty()) continue;
    int above = 0, below = 0;
    const PairedDifference* least = &all.front();
    for (const PairedDifference& d : all) {
      above += d.mean > d.standard_error;
      below += d.below();
      if (d.mean < least->mean) least = &d;
      if (d.below() && policy != "certified") {
        failing += fmt::format("- {}, {}: {:+.4f} ± {:.4f} ({} seeds)\n", policy, CaseName(d.what),
                               d.mean, d.standard_error, d.seeds);
      }
    }
    const auto n = static_cast<int>(all.size());
    sheet.Add(fmt::format("{}|{}|{}|{}|{}|{:+.4f} ± {:.4f}, {}", policy, n, above,
                          n - above - below, below, least->mean, least->standard_error,
                          CaseName(least->what)));
  }
  return "## Differences to mpq\n\n"
         "A case is a setting with an interval, a limit, a disturbance and a mode. Its difference "
         "is the mean of the differences to `mpq` with the same seed. Above and below mean by more "
         "than one standard error.\n\n" +
         sheet.Markdown() + (failing.empty() ? "" : "\nBelow:\n\n" + failing);
}

}  // namespace

PublishedFigures PublishedFigures::OfThePaper() { return {kPublishedCsv, "published.csv"}; }

PublishedFigures::PublishedFigures(std::string_view csv, const std::string& file) {
  const Table table = ParseCsv(csv, file);
  const std::size_t section = table.Column("table_or_section"),
                    setting = table.Column("dataset_or_setting"),
                    algorithm = table.Column("algorithm"), metric = table.Column("metric"),
                    value = table.Column("value");
  for (const std::vector<std::string>& row : table.rows) {
    const bool rate = row[metric].starts_with("task_completion_rate");
    const bool time = row[metric] == "decision_time_s";
    if (!rate && !time) continue;
    const auto found = ToNumber(row[value]);
    if (!found) throw InputError(file, "value", "'" + row[value] + "'", "a number");
    const double number = *found;
    Figure& figure = figures_[{row[section], row[setting], row[algorithm]}];
    if (time) {
      figure.decision_s = number;
    } else {
      const bool percent = row[metric].find("_pct") != std::string::npos;
      figure.completion = percent ? number / 100 : number;
    }
  }
}

PublishedFigures::Figure PublishedFigures::Of(const std::string& section,
                                              const std::string& setting,
                                              const std::string& policy) const {
  for (const auto& [ours, theirs] : kReadings) {
    if (ours != policy || setting.empty()) continue;
    for (auto at = figures_.lower_bound({section, "", ""});
         at != figures_.end() && std::get<0>(at->first).starts_with(section); ++at) {
      if (std::get<1>(at->first) == setting && std::get<2>(at->first) == theirs) return at->second;
    }
  }
  return {};
}

std::vector<PaperTable> MakePaperTables(const PaperRows& rows, const PublishedFigures& published) {
  std::set<std::uint64_t> seeds;
  for (const auto& [run, row] : rows) seeds.insert(run.seed);
  std::vector<PaperTable> tables;
  for (const PaperExperiment& experiment : PaperExperiments(true)) {
    for (const Availability availability : {Availability::kStrict, Availability::kOverrun}) {
      PaperTable all{experiment.title, experiment.note, availability, ColumnOrder(), {}, {}};
      for (const PaperLine& line : experiment.lines) {
        std::vector<PaperCell> cells;
        bool ours = false;
        for (const std::string& policy : all.policies) {
          PaperCell& cell =
              cells.emplace_back(CellOf(rows, line.cases, availability, policy, seeds));
          cell.published = published.Of(experiment.section, line.published, policy);
          ours = ours || cell.seeds > 0;
        }
        if (!ours) continue;
        all.labels.push_back(line.label);
        all.cells.push_back(std::move(cells));
      }
      if (!all.labels.empty()) tables.push_back(WithoutEmptyColumns(all));
    }
  }
  return tables;
}

std::vector<PairedDifference> PairedDifferences(const PaperRows& rows, const std::string& policy,
                                                const std::string& base) {
  std::map<PaperCase, std::vector<double>> differences;
  for (const auto& [run, row] : rows) {
    if (run.policy != policy) continue;
    const auto other = rows.find({run.what, base, run.seed});
    if (other == rows.end()) continue;
    differences[run.what].push_back(row.completion() - other->second.completion());
  }
  std::vector<PairedDifference> result;
  for (const auto& [what, values] : differences) {
    const Moments moments = MomentsOf(values);
    result.push_back(
        {what, policy, static_cast<int>(values.size()), moments.mean, moments.standard_error});
  }
  return result;
}

std::string CompletionText(const PaperCell& cell) {
  std::string text;
  if (cell.seeds == 1) text = fmt::format("{:.3f}", cell.mean);
  if (cell.seeds > 1) text = fmt::format("{:.3f} ± {:.3f}", cell.mean, cell.standard_error);
  if (cell.published.completion) {
    text += fmt::format("{}({:.3f})", text.empty() ? "" : " ", *cell.published.completion);
  }
  return text;
}

std::string DecisionTimeText(const PaperCell& cell) {
  std::string text;
  if (cell.seeds > 0) text = Duration(cell.decision_s);
  if (cell.published.decision_s) {
    text += fmt::format("{}({})", text.empty() ? "" : " ", Duration(*cell.published.decision_s));
  }
  return text;
}

std::string PaperMarkdown(const PaperRows& rows, const std::vector<PaperTable>& tables) {
  std::string text;
  for (const PaperTable& table : tables) {
    text += fmt::format("## {}, {}\n\n{}\n\n", table.title, NameOf(table.availability), table.note);
    text += MarkdownOf(
        table, [&](std::size_t l, std::size_t p) { return CompletionText(table.cells[l][p]); });
    const bool timed = std::any_of(table.cells.begin(), table.cells.end(), [](const auto& line) {
      return std::any_of(line.begin(), line.end(), [](const PaperCell& cell) {
        return cell.published.decision_s.has_value();
      });
    });
    if (!timed) continue;
    text += "Time of a decision (median of a mission, mean over the seeds):\n\n";
    text += MarkdownOf(table, [&](std::size_t l, std::size_t p) {
      return table.policies[p] == kUpperBound ? "" : DecisionTimeText(table.cells[l][p]);
    });
  }
  return text + Differences(rows);
}

}  // namespace muster::tools
