#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace muster::tools {

/// A number of a CSV file; nothing where it is not known.
std::string Number(double value);
/// A number for a person, as fmt's `format` says; "-" where it is not known.
std::string Shown(const char* format, double value);

/// A CSV file that each row is on disk before the next one is taken.
class RowFile {
 public:
  /// "" as `file`: there is none, and rows are dropped. `header` begins the file; "": the rows go
  /// behind what is there. Throws SystemError.
  RowFile(const std::string& file, const std::string& header);
  ~RowFile();
  RowFile(const RowFile&) = delete;
  RowFile& operator=(const RowFile&) = delete;

  /// Whole lines. Throws SystemError.
  void Add(const std::string& lines);

 private:
  const std::string name_;
  std::FILE* file_ = nullptr;
};

/// A table for a person, line by line: its cells with "|" between them.
class Sheet {
 public:
  explicit Sheet(const std::string& columns) { Add(columns); }

  void Add(const std::string& cells);

  /// The first column to the left, the others to the right.
  std::string Text() const;
  std::string Markdown() const;

 private:
  std::vector<std::vector<std::string>> lines_;  ///< columns first
  std::vector<std::size_t> widths_;
};

}  // namespace muster::tools
