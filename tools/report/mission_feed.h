#pragma once

#include <cstdint>
#include <optional>

#include "tools/record/run_record.h"
#include "tools/report/timeline.h"

namespace muster::tools {

/// A mission's packets, from a log, the bus or the launcher alike, as record and timeline. It is
/// the mission of the first scenario.
class MissionFeed {
 public:
  /// Takes a packet: any, in any order, as often as it comes.
  void Add(const Packet& packet);
  /// Nothing more comes.
  void Finish();

  bool ready() const { return timeline_.has_value(); }  ///< the scenario is there
  const RunRecord& record() const { return record_; }
  RunRecord& record() { return record_; }
  const Timeline& timeline() const { return *timeline_; }
  /// Wall time of mission time 0, microseconds since the Unix epoch; 0 in a simulated mission or
  /// before its start.
  std::int64_t epoch_us() const { return record_.reader().epoch_us().value_or(0); }
  /// Run of the newest message, whether ready or not; none before the first.
  std::optional<std::int64_t> heard_run_id() const { return record_.reader().heard_run_id(); }

 private:
  RunRecord record_;
  std::optional<Timeline> timeline_;
};

}  // namespace muster::tools
