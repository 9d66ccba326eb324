#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "model/scenario.h"
#include "tools/record/run_record.h"

namespace muster::tools {

/// How a mission served its tasks, if they are reported while it runs, are due, or differ in
/// priority. It counts the tasks that were reported before the limit; done are only those whose
/// sensing ended.
struct Service {
  struct Of {
    int reported = 0;
    int done = 0;
    int on_time = 0;  ///< of those done: sensing began by the due time
  };
  std::array<Of, kPriorities> by_priority;
  int expired = 0;
  std::vector<double> response_s;  ///< from the report to the begin of sensing, ascending
  double worth_done = 0;           ///< WorthOf each task that is done
  double worth_all = 0;            ///< had sensing of all begun in time

  int reported() const;
  int done() const;
  int on_time() const;
  double mean_response_s() const;            ///< NaN: none is done
  double response_quantile_s(double) const;  ///< nearest rank; NaN: none is done
};

/// What became of the tasks, by the due times and priorities of `scenario`, which may be another
/// one than the mission knew.
Service ServiceOf(const RunRecord& record, const Scenario& scenario);

/// As report.json has it (docs/reference/report-format.md).
nlohmann::ordered_json ToJson(const Service& service);

}  // namespace muster::tools
