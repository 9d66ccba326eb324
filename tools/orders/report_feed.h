#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/host/stop_signals.h"
#include "tools/orders/alert_feed.h"

namespace muster::tools {

/// Documents of another system: a file, the files of a folder with these endings, in order of their
/// names, stdin ("-"), or what a web server answers ("http://", "https://").
class DocumentSource {
 public:
  /// `token`: sent to the server as "Authorization: Token ...", as Kobo wants it; "": none. Throws
  /// InputError where there is no such file.
  /// `next_page`: the address of the page after this one, "" on the last; asked of the same server.
  DocumentSource(std::string from, std::vector<std::string> endings, std::string token,
                 std::function<std::string(const std::string&)> next_page = {});

  /// Name and content of each. Throws SystemError where the server does not answer, InputError
  /// where a file cannot be read, or all pages together are larger than kMostBytes.
  std::vector<std::pair<std::string, std::string>> Read() const;

  static constexpr std::size_t kMostBytes = 64 << 20;

 private:
  std::vector<std::pair<std::string, std::string>> ReadPages() const;

  const std::string from_;
  const std::vector<std::string> endings_;
  const std::string token_;
  const std::function<std::string(const std::string&)> next_page_;
};

struct FeedSettings {
  std::string run;       ///< run directory
  std::string format;    ///< in the orders' ids
  std::string key_file;  ///< the orders are signed with; "": they are not
  std::string memory;    ///< file in the run directory: what was given from this source
  double every_s = 0;    ///< seconds between two looks; 0: one look
  std::function<Reports(const std::string& document, const std::string& file)> read;
};

struct FeedCounts {
  int taken = 0, refused = 0;
};

/// Gives a running mission what the documents report. The orders' ids follow from the reports
/// alone, and a file remembers their tasks: so what is given again, after a restart or from another
/// source too, is taken once. A report that replaces another, or comes in a new version, changes
/// its task where the place is the same, and else cancels it and adds a new one. Ends with the
/// mission, or when `stop` says so. Where it looks again, a look that fails is said, and is no end;
/// else it throws as DocumentSource::Read, and SystemError where the mission ends before an answer.
FeedCounts FeedReports(const DocumentSource& source, const FeedSettings& settings,
                       const StopSignals& stop);

}  // namespace muster::tools
