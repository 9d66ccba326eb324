#include "tools/host/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "base/say.h"

namespace muster::tools {
namespace {

constexpr TimeUs kInPlaceUs = 100 * 1000;
constexpr TimeUs kLinesUs = kSecondUs;

}  // namespace

std::string ClockText(TimeUs duration_us) {
  const TimeUs s = duration_us / kSecondUs;
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

void ProgressPrinter::Show(const std::string& line, TimeUs now_us) {
  if (style_ == Style::kNone) return;
  if (style_ == Style::kInPlace) {
    SayTo(out_, fmt::format("\r{:<{}}", line, std::max(shown_, line.size())));
    shown_ = line.size();
  } else {
    SayTo(out_, line + "\n");
  }
  due_us_ = now_us + (style_ == Style::kInPlace ? kInPlaceUs : kLinesUs);
}

void ProgressPrinter::Break() {
  if (shown_ == 0) return;
  SayTo(out_, "\n");
  shown_ = 0;
}

ProgressPrinter::Style StyleFor(std::FILE* out, bool quiet) {
  if (quiet) return ProgressPrinter::Style::kNone;
  const char* terminal = std::getenv("TERM");
  const bool capable = terminal != nullptr && std::string_view(terminal) != "dumb";
  return isatty(fileno(out)) != 0 && capable ? ProgressPrinter::Style::kInPlace
                                             : ProgressPrinter::Style::kLines;
}

}  // namespace muster::tools
