#include "tools/report/mission_feed.h"

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::tools {
namespace {

/// What may come before the scenario; a sound log has a few packets there.
constexpr std::size_t kMaxHeldBack = 20'000;

}  // namespace

void MissionFeed::Add(const Packet& packet) {
  record_.Add(packet);
  if (const auto header = DecodeHeader(packet)) heard_run_id_ = header->run_id;
  if (timeline_) {
    Take(packet);
    return;
  }
  if (FindChannel(packet.channel) != nullptr && held_back_.size() < kMaxHeldBack) {
    held_back_.push_back(packet);
  }
  if (!record_.scenario()) return;
  timeline_.emplace(*record_.scenario());
  inbox_.emplace(record_.run_id(), "");
  for (const Packet& held : held_back_) Take(held);
  held_back_.clear();
  held_back_.shrink_to_fit();
}

void MissionFeed::Take(const Packet& packet) {
  const auto header = DecodeHeader(packet);
  if (!header || header->run_id != record_.run_id()) return;
  if (!seen_[{header->sender, header->boot_id}].Add(header->seq)) return;
  const auto message = inbox_->Open(packet);
  if (!message) return;
  timeline_->Add(*message);
  const auto* clock = std::get_if<clock_t>(&*message);
  if (clock == nullptr || clock->phase == ClockPhase::kReady || epoch_known_) return;
  epoch_known_ = true;
  epoch_us_ = header->wall_us == 0 ? 0 : header->wall_us - clock->tick_us;
}

void MissionFeed::Finish() {
  if (timeline_) timeline_->Finish();
}

}  // namespace muster::tools
