// Arbitrary packets as what a run left: its report, digest, summary, page and audit. Whatever was
// heard, the report is JSON and the audit comes to an end.

#include <nlohmann/json.hpp>

#include "base/check.h"
#include "tests/fuzz/fuzz_mission.h"
#include "tools/audit/auditor.h"
#include "tools/record/digest.h"
#include "tools/record/report_json.h"
#include "tools/record/summary.h"
#include "tools/report/mission_feed.h"
#include "tools/report/page_chunk.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  tools::MissionFeed feed;
  tools::audit::Auditor auditor;
  for (const Packet& packet : fuzz::ParsePackets(data, size)) {
    feed.Add(packet);
    auditor.Add(packet);
  }
  feed.Finish();
  auditor.Finish();
  if (!feed.ready()) return 0;
  tools::Digest(feed.record());
  tools::Summary(feed.record());
  tools::PageCursor cursor;
  for (const std::string& text :
       {tools::Report(feed.record()).dump(), tools::PageChunk(feed, "run", &cursor, true).dump()}) {
    MUSTER_CHECK(nlohmann::json::accept(text), "{}", text);
  }
  return 0;
}
