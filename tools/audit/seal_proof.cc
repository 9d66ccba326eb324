#include "tools/audit/seal_proof.h"

#include <fmt/format.h>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::tools::audit {

bool SealProof::Takes(const LogEvent& event, const std::string& file) {
  if (FindChannel(event.packet.channel) == nullptr) return true;
  const std::optional<header_t> header = DecodeHeader(event.packet);
  if (key_ && header && header->run_id != run_id_) {
    run_id_ = header->run_id;
    const bool is_ours = !key_->run_id || key_->run_id == run_id_;
    seal_.reset();
    if (is_ours) seal_.emplace(key_->Of(*run_id_, from_));
  }
  if (header && seal_ && seal_->Holds(event.packet, event.tag)) {
    ++proven_;
    return true;
  }
  if (refused_++ > 0) return false;
  first_refused_ = fmt::format("{}, event {} on {}", file, event.number, event.packet.channel);
  if (header) {
    first_refused_us_ = header->sim_us;
    first_refused_ += fmt::format(", which says that it is of {} (start {}, seq {})",
                                  header->sender, header->boot_id, header->seq);
  }
  first_refused_ += event.tag.empty() ? ": no tag" : ": another tag";
  return false;
}

}  // namespace muster::tools::audit
