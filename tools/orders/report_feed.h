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
  DocumentSource(std::string from, std::vector<std::string> endings, std::string token);

  /// Name and content of each. Throws SystemError where the server does not answer, InputError
  /// where a file cannot be read or is larger than kMostBytes.
  std::vector<std::pair<std::string, std::string>> Read() const;

  static constexpr std::size_t kMostBytes = 64 << 20;

 private:
  const std::string from_;
  const std::vector<std::string> endings_;
  const std::string token_;
};

struct FeedSettings {
  std::string run;     ///< run directory
  std::string format;  ///< in the orders' ids
  std::string memory;  ///< file in the run directory: what was given from this source
  double every_s = 0;  ///< seconds between two looks; 0: one look
  std::function<Reports(const std::string& document, const std::string& file)> read;
};

struct FeedCounts {
  int taken = 0, refused = 0;
};

/// Gives a running mission what the documents report. The orders' ids follow from the reports
/// alone, and a file remembers their tasks: so what is given again, after a restart or from another
/// source too, is taken once. A report that replaces another changes its task where the place is
/// the same, and else cancels it and adds a new one. Ends with the mission, or when `stop` says so.
/// Where it looks again, a look that fails is said, and is no end; else it throws as
/// DocumentSource::Read, and SystemError where the mission ends before an answer.
FeedCounts FeedReports(const DocumentSource& source, const FeedSettings& settings,
                       const StopSignals& stop);

}  // namespace muster::tools
