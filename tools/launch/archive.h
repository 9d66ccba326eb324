#pragma once

#include <cstdint>
#include <map>
#include <muster/request_t.hpp>
#include <muster/restore_t.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "world/model/scenario.h"

namespace muster::tools {

/// The state of a mission as its processes have last told it. World and agent processes keep each
/// other's; when several have died at once, nobody is left to tell those that start again but who
/// has listened.
class Archive {
 public:
  /// `scenario` must outlive this object.
  Archive(const Scenario& scenario, std::int64_t run_id);

  /// A packet of the mission, from the bus or the log.
  void Add(const Packet& packet);

  /// What to answer, headers not filled. Nothing until the same start of the same process has asked
  /// for two seconds: whoever is alive knows better.
  std::vector<restore_t> Answer(const request_t& request, TimeUs now_us);

 private:
  using Message = std::tuple<std::string, std::int64_t, std::int64_t>;  // sender, boot_id, seq
  using Told = std::map<TimeUs, std::map<Message, Packet>>;             ///< by mission time

  /// The newest time from which the mission can go on: everybody's states, the verdict before.
  std::optional<TimeUs> Consistent() const;

  const Scenario& scenario_;
  const std::int64_t run_id_;
  std::map<std::string, Told, std::less<>> told_;  ///< by channel
  struct Question {
    TimeUs since_us = 0, asked_us = kNever, answered_us = 0;
  };
  std::map<std::tuple<std::string, std::int64_t, std::string>, Question> questions_;
};

}  // namespace muster::tools
