#pragma once

#include <vector>

#include "tests/tools/fake_mission.h"
#include "tools/record/run_record.h"

namespace muster::tools {

inline RunRecord RecordOf(const std::vector<Packet>& packets) {
  RunRecord record;
  for (const Packet& packet : packets) record.Add(packet);
  return record;
}

inline RunRecord RecordOf(const FakeLog& log) { return RecordOf(Encoded(log)); }

}  // namespace muster::tools
