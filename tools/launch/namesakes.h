#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "lcmtypes/bus/bus.h"

namespace muster::tools {

/// Notices two living processes under one name: what they say of themselves, about once a second,
/// bears the host and the pid of each.
class Namesakes {
 public:
  /// Takes a process_status_t of the mission. A line that names both, once for each name.
  std::optional<std::string> OnHeard(const Packet& packet);

 private:
  /// A few suffice: a mission has some tens of processes and starts.
  static constexpr std::size_t kMost = 1000;
  struct Self {
    std::string host;
    std::int32_t pid = 0;
    auto operator<=>(const Self&) const = default;
  };
  std::map<std::pair<std::string, std::int64_t>, Self> first_;  ///< by sender, boot_id
  std::set<std::string> said_;
};

}  // namespace muster::tools
