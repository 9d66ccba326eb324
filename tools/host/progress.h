#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "base/units.h"

namespace muster::tools {

/// "1:23:30" of a duration.
std::string ClockText(TimeUs duration_us);

/// Shows a line of progress again and again: in place on a terminal (by carriage return and spaces
/// alone, no colour and no escape sequence), as plain lines at longer intervals elsewhere.
class ProgressPrinter {
 public:
  enum class Style { kNone, kInPlace, kLines };

  ProgressPrinter(std::FILE* out, Style style) : out_(out), style_(style) {}

  bool due(TimeUs now_us) const { return style_ != Style::kNone && now_us >= due_us_; }
  void Show(const std::string& line, TimeUs now_us);
  /// Ends the line in place, so that other text may follow.
  void Break();

 private:
  std::FILE* out_;
  Style style_;
  TimeUs due_us_ = 0;
  std::size_t shown_ = 0;  ///< width of the line in place
};

/// In place on a terminal that can, lines elsewhere.
ProgressPrinter::Style StyleFor(std::FILE* out, bool quiet);

}  // namespace muster::tools
