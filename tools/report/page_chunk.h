#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/report/mission_feed.h"

namespace muster::tools {

/// What one reader of a page has been told already.
struct PageCursor {
  struct Place {
    std::size_t rows = 0;
    std::int64_t version = 0;
    std::int64_t rebuilt = 0;
  };
  bool begun = false;
  std::vector<Place> stops, spans, tasks;  ///< by agent or task
  Place done, schedules, activities, events, heights;
  std::map<std::string, Place> processes;
  std::size_t faults = 0, road_changes = 0;
  std::int64_t orders = 0;
  std::vector<Task> told_tasks;  ///< of missions that are open, which orders may change
  PerKind<std::vector<AgentSpec>> told_agents;
};

/// What the page is to learn: everything at first, later what is new or changed
/// (docs/guide/report.md describes it; tools/report/page/src/run.js reads it). `with_report`:
/// report.json's numbers too, without its long lists, which the chunk has in another form. The feed
/// must be ready.
nlohmann::ordered_json PageChunk(const MissionFeed& feed, const std::string& name,
                                 PageCursor* cursor, bool with_report);

}  // namespace muster::tools
