#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::recorder {

/// A small message of that sender.
inline Packet MessageOf(const std::string& sender, std::int64_t seq, std::int64_t boot_id = 0,
                        std::int64_t run_id = 1) {
  request_t request;
  request.header.run_id = run_id;
  request.header.sender = sender;
  request.header.boot_id = boot_id;
  request.header.seq = seq;
  request.header.sim_us = 0;
  request.header.wall_us = 0;
  request.channel = std::string(channel::kScenario);
  return {std::string(channel::kRequest), Encode(request)};
}

}  // namespace muster::recorder
