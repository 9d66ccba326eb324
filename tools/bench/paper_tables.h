#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "tools/bench/paper_rows.h"

namespace muster::tools {

/// What a paper says of its methods: CSV with the columns table_or_section, dataset_or_setting,
/// algorithm, metric, value.
class PublishedFigures {
 public:
  /// Throws InputError, which names `file`.
  PublishedFigures(std::string_view csv, const std::string& file);
  /// The paper's own (published.csv).
  static PublishedFigures OfThePaper();

  struct Figure {
    std::optional<double> completion;  ///< 0 to 1
    std::optional<double> decision_s;
  };
  /// Of the paper's method that a policy of ours is a reading of, or of a method that we do not
  /// have, by its own name.
  Figure Of(const std::string& section, const std::string& setting,
            const std::string& policy) const;

 private:
  /// By table_or_section, dataset_or_setting, algorithm.
  std::map<std::tuple<std::string, std::string, std::string>, Figure> figures_;
};

/// Mean over seeds, of the mean over a line's cases.
struct PaperCell {
  int seeds = 0;  ///< for which every case of the line has a row
  double mean = 0;
  double standard_deviation = 0;  ///< over the seeds
  double standard_error = 0;      ///< of the mean
  double decision_s = 0;          ///< mean of the missions' median decision times
  PublishedFigures::Figure published;
};

struct PaperTable {
  std::string title;
  std::string note;
  Availability availability = Availability::kStrict;
  std::vector<std::string> policies;          ///< columns
  std::vector<std::string> labels;            ///< lines
  std::vector<std::vector<PaperCell>> cells;  ///< [lines][policies]
};

/// One table for each experiment and mode that has rows.
std::vector<PaperTable> MakePaperTables(const PaperRows& rows, const PublishedFigures& published);

/// `policy` less `base` in one case.
struct PairedDifference {
  PaperCase what;
  std::string policy;
  int seeds = 0;
  double mean = 0;
  double standard_error = 0;
  bool below() const { return mean < -standard_error - 1e-12; }
};
/// Of every case and seed that has both.
std::vector<PairedDifference> PairedDifferences(const PaperRows& rows, const std::string& policy,
                                                const std::string& base);

/// "0.659 ± 0.006 (0.728)": mean, standard error (not of one seed), the paper's figure; "" when
/// there is nothing.
std::string CompletionText(const PaperCell& cell);
/// "0.44 ms (180 ms)"
std::string DecisionTimeText(const PaperCell& cell);

/// All of it for a reader of Markdown.
std::string PaperMarkdown(const PaperRows& rows, const std::vector<PaperTable>& tables);

}  // namespace muster::tools
