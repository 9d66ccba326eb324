#pragma once

#include <string>

#include "tools/bench/paper_rows.h"

namespace muster::tools {

/// Writes the tables as Markdown, and with plots as one HTML page that needs no other file.
/// Returns what a user should know, that gnuplot is not there; else "". Throws SystemError.
std::string WritePaperPage(const PaperRows& rows, const std::string& markdown_file,
                           const std::string& html_file);

}  // namespace muster::tools
