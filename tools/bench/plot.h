#pragma once

#include <string>
#include <vector>

namespace muster::tools {

struct Curve {
  std::string points;  ///< lines of numbers; "": the plot's CSV file
  std::string style;   ///< gnuplot: "using 1:2 with lines"
  std::string title;
};

struct Chart {
  std::string settings;  ///< gnuplot's, whole lines
  std::vector<Curve> curves;
};

/// Charts side by side in one SVG file.
struct Plot {
  int width = 0, height = 0;
  std::string settings;  ///< gnuplot's, whole lines, of all charts
  std::vector<Chart> charts;
  int columns = 1;
};

/// The gnuplot script that draws it. `csv_file`: what curves without points are drawn from.
std::string ScriptOf(const Plot& plot, const std::string& svg_file,
                     const std::string& csv_file = "");

}  // namespace muster::tools
