#include "tools/report/mission_feed.h"

namespace muster::tools {

void MissionFeed::Add(const Packet& packet) {
  record_.Add(packet, [&](const Message& message, const Packet&) {
    if (!timeline_) timeline_.emplace(record_.scenario());
    timeline_->Add(message);
  });
}

void MissionFeed::Finish() {
  if (timeline_) timeline_->Finish();
}

}  // namespace muster::tools
