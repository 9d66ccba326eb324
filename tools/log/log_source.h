#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/event_log.h"
#include "muster/header_t.hpp"
#include "tools/files/log_progress.h"

namespace muster::tools {

/// One message of a run's log.
struct LoggedMessage {
  std::int64_t received_us = 0;  ///< wall time at the logger, microseconds since the Unix epoch
  Packet packet;
  Tag tag;                         ///< of a sealed mission's message; empty: none
  std::optional<header_t> header;  ///< none: no valid message of a channel of ours
};

/// Where messages come from, in order, again and again.
class MessageSource {
 public:
  virtual ~MessageSource() = default;
  virtual std::optional<LogEvent> NextEvent() = 0;
  virtual void Rewind() = 0;
  /// For messages to people.
  virtual std::string name() const { return "log"; }
  /// NextEvent() with the message's header.
  std::optional<LoggedMessage> Next();
};

/// The messages of all log files of a run, one file after the other. Memory stays within a few of
/// the largest messages.
class LogSource : public MessageSource {
 public:
  /// Run directory or log file. Throws InputError when there is none, SystemError when reading
  /// fails.
  explicit LogSource(const std::string& run);

  std::optional<LogEvent> NextEvent() override;
  void Rewind() override;
  std::string name() const override { return files_[0]; }

  /// From now on stderr tells how much of the log has been read (LogProgress); `what` names the
  /// work.
  void ShowProgress(const std::string& what) { progress_.emplace(what, files_); }

  const std::vector<std::string>& files() const { return files_; }
  /// Index in files() of the last message's file.
  std::size_t file() const { return file_; }
  /// Bytes so far that belong to no event.
  std::int64_t garbage_bytes() const;
  /// Messages so far that have not the tag that the key beside the log makes.
  std::int64_t refused() const;

 private:
  std::vector<std::string> files_;
  std::size_t file_ = 0;
  std::unique_ptr<EventLogReader> reader_;
  std::optional<LogProgress> progress_;
  std::int64_t garbage_before_ = 0, refused_before_ = 0;  ///< in files read to their end
};

}  // namespace muster::tools
