#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "model/scenario.h"

namespace muster::tools {

/// What is left of a mission whose launcher has gone.
struct EarlierRun {
  std::vector<std::string> log_files;
  std::map<std::string, std::int64_t> starts;  ///< how often each sender has started, by the log
  std::int64_t tick = -1;                      ///< the last one in the log
  TimeUs tick_us = -1;                         ///< its time; -1: no tick yet
  bool has_ended = false;                      ///< the mission's end is in the log
  bool was_stopped = false;                    ///< the launcher has ended in order
  std::int64_t first_boot = 0;  ///< of KeepApart: below it nothing is logged any more
  std::vector<Person> persons;  ///< who may order, as the mission was told last

  /// How often that sender has started.
  std::int64_t StartsOf(const std::string& sender) const;
  /// Processes of the earlier launcher may live on, on other hosts: gives all senders numbers that
  /// it does not reach. The first of them, first_boot, is that of no start: those who hear of it
  /// end.
  void KeepApart();
};

/// The scenario that the log of the run directory `run` has, without its orders. Throws InputError
/// when it has none.
Scenario ScenarioInLog(const std::string& run);

/// Reads the log of the run directory `run`, of the mission `run_id`. Throws InputError when there
/// is none.
EarlierRun ReadEarlierRun(const std::string& run, const Scenario& scenario, std::int64_t run_id);

}  // namespace muster::tools
