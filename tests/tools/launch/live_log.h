#pragma once

#include <fmt/format.h>
#include <sys/types.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"

namespace muster::tools {

/// A running mission's log, followed over all its files, for the tick and the pids.
class LiveLog {
 public:
  explicit LiveLog(std::string run) : run_(std::move(run)) {}
  void Read() {
    while (true) {
      const std::string path =
          run_ + "/mission.lcm" + (files_ == 0 ? "" : fmt::format(".{}", files_));
      if (!reader_) {
        if (!std::filesystem::exists(path)) return;
        reader_.emplace(path, EventLogReader::Tail::kMayGrow);
      }
      while (const auto event = reader_->Next()) Take(event->packet);
      const std::string next = fmt::format("{}/mission.lcm.{}", run_, files_ + 1);
      if (!std::filesystem::exists(next)) return;
      reader_.reset();
      ++files_;
    }
  }
  std::int64_t tick() const { return tick_; }
  /// 0: not known yet.
  pid_t pid(const std::string& name) const {
    const auto found = pids_.find(name);
    return found == pids_.end() ? 0 : found->second;
  }

 private:
  void Take(const Packet& packet) {
    if (packet.channel == channel::kClock) {
      if (const auto clock = DecodeValid<clock_t>(packet.bytes))
        tick_ = std::max(tick_, clock->tick);
    } else if (packet.channel == channel::kProcess) {
      if (const auto status = DecodeValid<process_status_t>(packet.bytes)) {
        pids_[status->name] = status->pid;
      }
    }
  }
  std::string run_;
  std::optional<EventLogReader> reader_;
  int files_ = 0;
  std::int64_t tick_ = -1;
  std::map<std::string, pid_t> pids_;
};

/// The one child of that process whose program is `program`; 0: none.
inline pid_t ChildOf(pid_t parent, const std::string& program) {
  for (const std::filesystem::directory_entry& entry :
       std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream stat(entry.path() / "stat");
    std::string text;
    std::getline(stat, text);
    const std::size_t open = text.find('(');
    const std::size_t close = text.rfind(')');
    if (open == std::string::npos || close == std::string::npos) continue;
    if (text.substr(open + 1, close - open - 1) != program) continue;
    // "PID (NAME) STATE PARENT ..."
    if (std::stol(text.substr(close + 4)) == parent) return std::stoi(name);
  }
  return 0;
}

}  // namespace muster::tools
