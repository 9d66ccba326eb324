#pragma once

#include <string>
#include <vector>

#include "tools/bench/paper_rows.h"

namespace muster::tools {

/// Writes the tables as Markdown, and with plots as one HTML page that needs no other file.
/// `published_file`: the paper's figures. Returns what a user should know: that file or gnuplot is
/// not there. Throws SystemError.
std::vector<std::string> WritePaperPage(const PaperRows& rows, const std::string& published_file,
                                        const std::string& markdown_file,
                                        const std::string& html_file);

}  // namespace muster::tools
