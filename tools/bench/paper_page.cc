#include "tools/bench/paper_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <set>
#include <utility>

#include "base/check.h"
#include "base/spawn.h"
#include "tools/bench/paper_tables.h"
#include "tools/bench/plot.h"
#include "tools/files/scratch_folder.h"
#include "tools/record/report_json.h"

namespace muster::tools {
namespace {

constexpr std::string_view kStyle =
    "body{font:14px sans-serif;margin:2em;max-width:110em}table{border-collapse:collapse;"
    "margin:1em 0}td,th{border:1px solid #bbb;padding:.2em .5em;text-align:right;white-space:"
    "nowrap}td:first-child,th:first-child{text-align:left}.t{color:#777}svg{max-width:100%;"
    "height:auto}";

std::string Escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '<') {
      result += "&lt;";
    } else if (c == '&') {
      result += "&amp;";
    } else {
      result += c;
    }
  }
  return result;
}

std::string HtmlTable(const PaperTable& table) {
  std::string text = "<table><tr><th>";
  for (const std::string& policy : table.policies) text += "<th>" + Escaped(policy);
  text += "\n";
  for (std::size_t l = 0; l < table.labels.size(); ++l) {
    text += "<tr><td>" + Escaped(table.labels[l]);
    for (std::size_t p = 0; p < table.policies.size(); ++p) {
      const PaperCell& cell = table.cells[l][p];
      text += "<td>" + CompletionText(cell);
      if (table.policies[p] != kUpperBound) {
        text += "<br><span class=t>" + DecisionTimeText(cell) + "</span>";
      }
    }
    text += "\n";
  }
  return text + "</table>\n";
}

constexpr const char* kColours[] = {"#999999", "#0072b2", "#56b4e9", "#332288", "#e69f00",
                                    "#ddcc77", "#999933", "#000000", "#cc3311", "#009e73",
                                    "#cc79a7", "#882255", "#44aa99", "#aa4499", "#661100"};

enum class Measure { kCompletion, kDecisionTime };

/// The policies side by side at each line of the table, with their standard deviation, the paper's
/// figures as crosses. No chart when there is nothing to draw.
Plot PlotOf(const PaperTable& table, Measure measure) {
  const bool completion = measure == Measure::kCompletion;
  std::vector<std::string> labels;
  for (const std::string& label : table.labels) {
    labels.push_back(fmt::format("'{}' {}", label, labels.size()));
  }
  Chart chart;
  Curve published{"", "using 1:2 with points pt 2 ps 0.8 lc 'black'", "the paper"};
  const double step = 0.8 / static_cast<double>(table.policies.size());
  for (std::size_t p = 0; p < table.policies.size(); ++p) {
    if (!completion && table.policies[p] == kUpperBound) continue;
    Curve curve{"",
                fmt::format("using 1:2:3 with yerrorbars pt 7 ps 0.5 lc '{}'",
                            kColours[p % std::size(kColours)]),
                table.policies[p]};
    for (std::size_t l = 0; l < table.labels.size(); ++l) {
      const PaperCell& cell = table.cells[l][p];
      const double x = static_cast<double>(l) - 0.4 + step * (static_cast<double>(p) + 0.5);
      const auto& theirs = completion ? cell.published.completion : cell.published.decision_s;
      if (theirs) published.points += fmt::format("{} {}\n", x, *theirs);
      if (cell.seeds == 0) continue;
      curve.points += fmt::format("{} {} {}\n", x, completion ? cell.mean : cell.decision_s,
                                  completion ? cell.standard_deviation : 0);
    }
    if (!curve.points.empty()) chart.curves.push_back(curve);
  }
  if (chart.curves.empty() && published.points.empty()) return {};
  if (!published.points.empty()) chart.curves.push_back(published);
  return {300 + 75 * static_cast<int>(table.labels.size()),
          440,
          fmt::format("set termoption font 'sans-serif,11'\nset xtics ({}) rotate by -35\n"
                      "set xrange [-0.6:{}]\nset key outside right\nset grid ytics\n"
                      "set ylabel '{}'\n{}\n",
                      fmt::join(labels, ","), static_cast<double>(table.labels.size()) - 0.4,
                      completion ? "completion rate" : "seconds a decision",
                      completion ? "set yrange [0:1.05]" : "set logscale y\nset format y '%.0e'"),
          {chart}};
}

/// The plots as SVG; none when gnuplot is not there or does not manage.
std::vector<std::string> Draw(const std::vector<std::pair<const PaperTable*, Plot>>& plots) {
  if (!FindProgram("gnuplot")) return {};
  const ScratchFolder folder("muster_plots");
  std::FILE* gnuplot = popen("gnuplot 2> /dev/null", "w");
  std::vector<std::string> files;
  for (std::size_t i = 0; gnuplot != nullptr && i < plots.size(); ++i) {
    files.push_back(folder.File(fmt::format("{}.svg", i)));
    const std::string script = ScriptOf(plots[i].second, files.back());
    std::fwrite(script.data(), 1, script.size(), gnuplot);
  }
  if (gnuplot != nullptr) pclose(gnuplot);
  std::vector<std::string> svgs;
  for (const std::string& file : files) {
    const std::string svg = ReadFile(file);
    const std::size_t start = svg.find("<svg");
    if (start == std::string::npos || svg.find("</svg>") == std::string::npos) {
      svgs.clear();
      break;
    }
    svgs.push_back(svg.substr(start));
  }
  return svgs;
}

}  // namespace

std::string WritePaperPage(const PaperRows& rows, const std::string& markdown_file,
                           const std::string& html_file) {
  const std::vector<PaperTable> tables = MakePaperTables(rows, PublishedFigures::OfThePaper());
  std::set<std::string> builds;
  std::set<std::uint64_t> seeds;
  for (const auto& [run, row] : rows) {
    builds.insert(row.build);
    seeds.insert(run.seed);
  }
  const std::string intro = fmt::format(
      "Each cell has the share of tasks done: the mean over the seeds ± its standard error, and in "
      "brackets the paper's figure. {} runs, {} seeds, commit {}.",
      rows.size(), seeds.size(), fmt::join(builds, ", "));
  WriteFile(markdown_file, intro + "\n\n" + PaperMarkdown(rows, tables));

  std::vector<std::pair<const PaperTable*, Plot>> plots;
  for (const PaperTable& table : tables) {
    for (const Measure measure : {Measure::kCompletion, Measure::kDecisionTime}) {
      Plot plot = PlotOf(table, measure);
      if (!plot.charts.empty()) plots.emplace_back(&table, std::move(plot));
    }
  }
  const std::vector<std::string> svgs = Draw(plots);
  std::string page = fmt::format(
      "<!doctype html><meta charset=utf-8><title>The paper's experiments</title><style>{}</style>"
      "<h1>The paper's experiments</h1><p>{} Plots: bars are one standard deviation over the "
      "seeds, "
      "crosses the paper's figures. Grey: time of a decision.\n",
      kStyle, Escaped(intro));
  for (std::size_t t = 0; t < tables.size(); ++t) {
    page += fmt::format("<h2>{}, {}</h2><p>{}\n", Escaped(tables[t].title),
                        NameOf(tables[t].availability), Escaped(tables[t].note));
    for (std::size_t i = 0; i < svgs.size(); ++i) {
      if (plots[i].first == &tables[t]) page += svgs[i];
    }
    page += HtmlTable(tables[t]);
  }
  WriteFile(html_file, page);
  return svgs.size() < plots.size()
             ? "gnuplot: not there or without its SVG terminal: the page lacks plots "
               "(Debian: gnuplot-nox)"
             : "";
}

}  // namespace muster::tools
