#pragma once

#include <string>
#include <vector>

#include "tools/report/timeline.h"

namespace muster::tools {

enum class Figure { kCompletion, kTimeline, kMap, kSpaceTime };

/// The names of --figure, in the order of Figure.
inline constexpr const char* kFigures[] = {"completion", "timeline", "map", "space-time"};

struct FigureRun {
  std::string name;
  const Timeline* timeline;
};

/// How a figure is written.
struct FigureFormat {
  std::string format;     ///< pdf, svg or png
  double width_cm = 8.8;  ///< one column of a usual paper
};

/// The gnuplot script that draws the figure into `file`. Of several runs there is only kCompletion.
std::string FigureScript(Figure figure, const std::vector<FigureRun>& runs,
                         const FigureFormat& format, const std::string& file);

/// Has gnuplot draw it; `file` appears whole or not at all. Throws SystemError where there is no
/// gnuplot, or it fails.
void WriteFigure(Figure figure, const std::vector<FigureRun>& runs, const FigureFormat& format,
                 const std::string& file);

}  // namespace muster::tools
