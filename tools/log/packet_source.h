#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "tools/log/log_source.h"

namespace muster::tools {

/// A log in memory; the packets must outlive it.
class PacketSource : public MessageSource {
 public:
  explicit PacketSource(const std::vector<Packet>& packets) : packets_(packets) {}
  std::optional<LogEvent> NextEvent() override {
    if (next_ == packets_.size()) return {};
    return LogEvent{0, 0, packets_[next_++]};
  }
  void Rewind() override { next_ = 0; }

 private:
  const std::vector<Packet>& packets_;
  std::size_t next_ = 0;
};

}  // namespace muster::tools
