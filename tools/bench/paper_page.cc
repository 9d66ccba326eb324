#include "tools/bench/paper_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <set>

#include "base/check.h"
#include "tools/bench/paper_tables.h"
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

enum class Plot { kCompletion, kDecisionTime };

/// A gnuplot script: the policies side by side at each line of the table, with their standard
/// deviation, the paper's figures as crosses. "" when there is nothing to draw.
std::string PlotScript(const PaperTable& table, Plot plot, const std::string& svg_file) {
  const bool completion = plot == Plot::kCompletion;
  std::string data, curves, labels;
  const double step = 0.8 / static_cast<double>(table.policies.size());
  for (std::size_t l = 0; l < table.labels.size(); ++l) {
    labels += fmt::format("{}'{}' {}", l == 0 ? "" : ",", table.labels[l], l);
  }
  std::string published;
  for (std::size_t p = 0; p < table.policies.size(); ++p) {
    if (!completion && table.policies[p] == kUpperBound) continue;
    std::string points;
    for (std::size_t l = 0; l < table.labels.size(); ++l) {
      const PaperCell& cell = table.cells[l][p];
      const double x = static_cast<double>(l) - 0.4 + step * (static_cast<double>(p) + 0.5);
      const auto& theirs = completion ? cell.published.completion : cell.published.decision_s;
      if (theirs) published += fmt::format("{} {}\n", x, *theirs);
      if (cell.seeds == 0) continue;
      points += fmt::format("{} {} {}\n", x, completion ? cell.mean : cell.decision_s,
                            completion ? cell.standard_deviation : 0);
    }
    if (points.empty()) continue;
    data += fmt::format("$p{} << EOD\n{}EOD\n", p, points);
    curves += fmt::format("{}$p{} using 1:2:3 with yerrorbars pt 7 ps 0.5 lc '{}' title '{}'",
                          curves.empty() ? "plot " : ", ", p, kColours[p % std::size(kColours)],
                          table.policies[p]);
  }
  if (!published.empty()) {
    data += fmt::format("$published << EOD\n{}EOD\n", published);
    curves += ", $published using 1:2 with points pt 2 ps 0.8 lc 'black' title 'the paper'";
  }
  if (curves.empty()) return "";
  return fmt::format(
      "reset\nset terminal svg size {},440 noenhanced font 'sans-serif,11' background 'white'\n"
      "set output '{}'\nset xtics ({}) rotate by -35\nset xrange [-0.6:{}]\n"
      "set key outside right\nset grid ytics\nset ylabel '{}'\n{}\n{}{}\nset output\n",
      300 + 75 * table.labels.size(), svg_file, labels,
      static_cast<double>(table.labels.size()) - 0.4,
      completion ? "completion rate" : "seconds a decision",
      completion ? "set yrange [0:1.05]" : "set logscale y\nset format y '%.0e'", data, curves);
}

/// SVG texts of the scripts' plots; none when gnuplot is not there or does not manage.
std::vector<std::string> Draw(const std::vector<std::pair<const PaperTable*, Plot>>& plots) {
  if (std::system("command -v gnuplot > /dev/null 2>&1") != 0) return {};
  const ScratchFolder folder("muster_plots");
  std::FILE* gnuplot = popen("gnuplot 2> /dev/null", "w");
  std::vector<std::string> files;
  for (std::size_t i = 0; gnuplot != nullptr && i < plots.size(); ++i) {
    files.push_back(folder.File(fmt::format("{}.svg", i)));
    const std::string script = PlotScript(*plots[i].first, plots[i].second, files.back());
    std::fwrite(script.data(), 1, script.size(), gnuplot);
  }
  if (gnuplot != nullptr) pclose(gnuplot);
  std::vector<std::string> svgs;
  for (const std::string& file : files) {
    std::ifstream in(file, std::ios::binary);
    const std::string svg(std::istreambuf_iterator<char>(in), {});
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
      "Share of tasks done: mean over the seeds and its standard error; in brackets what the paper "
      "gives. {} runs, {} seeds, commit {}.",
      rows.size(), seeds.size(), fmt::join(builds, ", "));
  WriteFile(markdown_file, intro + "\n\n" + PaperMarkdown(rows, tables));

  std::vector<std::pair<const PaperTable*, Plot>> plots;
  for (const PaperTable& table : tables) {
    for (const Plot plot : {Plot::kCompletion, Plot::kDecisionTime}) {
      if (!PlotScript(table, plot, "").empty()) plots.emplace_back(&table, plot);
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
