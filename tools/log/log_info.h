#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/interval_set.h"
#include "tools/log/log_source.h"

namespace muster::tools {

/// What a log holds, per channel and per start of a sender. Memory grows with their number and the
/// gaps.
struct LogInfo {
  struct Channel {
    std::int64_t messages = 0;
    std::int64_t bytes = 0;
    std::int64_t undecodable = 0;  ///< on a channel of ours
    std::int64_t first_sim_us = -1, last_sim_us = -1;
  };
  struct Sender {
    std::int64_t messages = 0;  ///< distinct
    std::int64_t repeats = 0;
    IntervalSet seqs;
    std::vector<IntervalSet::Range> Gaps() const { return seqs.Missing(0, seqs.max()); }
  };
  std::map<std::string, Channel> channels;
  std::map<std::tuple<std::int64_t, std::string, std::int64_t>, Sender>
      senders;  ///< run, name, start
  std::vector<std::string> files;
  std::int64_t messages = 0;
  std::int64_t ours = 0;     ///< of them: on channels of the table
  std::int64_t sealed = 0;   ///< of these: with a tag
  std::int64_t refused = 0;  ///< not counted above: without the tag that the key beside it makes
  std::int64_t garbage_bytes = 0;
  std::int64_t first_received_us = 0, last_received_us = 0;

  void Add(const LoggedMessage& message);
};

LogInfo ReadLogInfo(const std::string& run);
std::string ToText(const LogInfo& info);
nlohmann::ordered_json ToJson(const LogInfo& info);

}  // namespace muster::tools
