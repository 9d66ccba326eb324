#include "tools/bench/plot.h"

#include <fmt/format.h>

namespace muster::tools {

std::string ScriptOf(const Plot& plot, const std::string& svg_file, const std::string& csv_file) {
  std::string text = fmt::format(
      "reset\nset terminal svg size {},{} noenhanced background 'white'\nset output '{}'\n{}{}",
      plot.width, plot.height, svg_file, csv_file.empty() ? "" : "set datafile separator ','\n",
      plot.settings);
  const std::size_t charts = plot.charts.size();
  if (charts > 1) {
    const auto columns = static_cast<std::size_t>(plot.columns);
    text += fmt::format("set multiplot layout {},{}\n", (charts + columns - 1) / columns, columns);
  }
  for (std::size_t c = 0; c < charts; ++c) {
    text += plot.charts[c].settings;
    std::vector<std::string> curves;
    for (const Curve& curve : plot.charts[c].curves) {
      std::string from = fmt::format("'{}'", csv_file);
      if (!curve.points.empty()) {
        from = fmt::format("$of_{}_{}", c, curves.size());
        text += fmt::format("{} << EOD\n{}EOD\n", from, curve.points);
      }
      curves.push_back(fmt::format("{} {} title '{}'", from, curve.style, curve.title));
    }
    if (!curves.empty()) text += fmt::format("plot {}\n", fmt::join(curves, ", \\\n     "));
  }
  return text + (charts > 1 ? "unset multiplot\n" : "") + "unset output\n";
}

}  // namespace muster::tools
