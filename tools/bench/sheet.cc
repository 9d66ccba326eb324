#include "tools/bench/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

#include "base/text.h"
#include "tools/files/pending_file.h"

namespace muster::tools {

std::string Number(double value) { return std::isnan(value) ? "" : fmt::format("{:.9g}", value); }

std::string Shown(const char* format, double value) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

RowFile::RowFile(const std::string& file, const std::string& header) : name_(file) {
  if (file.empty()) return;
  file_ = std::fopen(file.c_str(), header.empty() ? "ab" : "wb");
  if (file_ == nullptr) FailToWrite(name_, errno);
  Add(header);
}

RowFile::~RowFile() {
  if (file_ != nullptr) std::fclose(file_);
}

void RowFile::Add(const std::string& lines) {
  if (file_ == nullptr) return;
  if (std::fwrite(lines.data(), 1, lines.size(), file_) != lines.size() ||
      std::fflush(file_) != 0) {
    FailToWrite(name_, errno);
  }
}

void Sheet::Add(const std::string& cells) {
  lines_.push_back(Split(cells, '|'));
  widths_.resize(lines_.front().size());
  for (std::size_t c = 0; c < widths_.size(); ++c) {
    widths_[c] = std::max(widths_[c], lines_.back()[c].size());
  }
}

std::string Sheet::Text() const {
  std::string text;
  for (const auto& cells : lines_) {
    text += fmt::format("{:<{}}", cells[0], widths_[0]);
    for (std::size_t c = 1; c < cells.size(); ++c) {
      text += fmt::format(" {:>{}}", cells[c], widths_[c]);
    }
    text += "\n";
  }
  return text;
}

std::string Sheet::Markdown() const {
  std::string text;
  const std::vector<std::string> rule(widths_.size(), "---");
  for (const auto& cells : lines_) {
    text += fmt::format("| {} |\n", fmt::join(cells, " | "));
    if (&cells == &lines_.front()) text += fmt::format("| {} |\n", fmt::join(rule, " | "));
  }
  return text;
}

}  // namespace muster::tools
