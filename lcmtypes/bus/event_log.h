#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/seal.h"

struct _lcm_eventlog_t;

namespace muster {

/// One entry of a log in lcm-logger's format.
struct LogEvent {
  std::int64_t number = 0;       ///< as counted by the writer, from 0
  std::int64_t received_us = 0;  ///< wall time, microseconds since the Unix epoch
  Packet packet;                 ///< without the tag
  Tag tag = {};                  ///< of a sealed mission's message (seal.h); empty: none
  bool operator==(const LogEvent&) const = default;
};

/// Reads a log from its start, also a damaged one: a torn tail, or garbage between events, is
/// skipped and counted. LCM's own reader stops at the first damage and allocates what a damaged
/// length says, so this one reads the format itself. Memory stays within a few of the largest
/// events.
class EventLogReader {
 public:
  enum class Tail {
    kFinal,    ///< no longer written: an incomplete event is damage
    kMayGrow,  ///< a logger writes on: an incomplete event is waited for
  };

  /// Throws SystemError when the file cannot be opened.
  EventLogReader(const std::string& path, Tail tail);
  ~EventLogReader();
  EventLogReader(const EventLogReader&) = delete;
  EventLogReader& operator=(const EventLogReader&) = delete;

  /// The next whole event. None: there is no further one; with kMayGrow, ask again when the file
  /// may have grown. Throws SystemError when reading fails or the file became shorter than the
  /// events that were handed out; an incomplete one may be cut off.
  std::optional<LogEvent> Next();

  /// From now on what is on channels of ours without the right tag is left out, and counted.
  void OnlyWith(std::optional<Seal> seal) { seal_ = std::move(seal); }
  std::int64_t refused() const { return refused_; }

  /// Bytes that belonged to no event.
  std::int64_t garbage_bytes() const { return garbage_bytes_; }
  /// Bytes read behind the last event: the start of one that is not complete yet. 0 with kFinal
  /// after the last event.
  std::int64_t pending_bytes() const { return static_cast<std::int64_t>(buffer_.size() - begin_); }

 private:
  std::optional<LogEvent> NextOfAll();
  std::size_t available() const { return buffer_.size() - begin_; }
  bool ReadMore();
  void ForgetFrom(std::int64_t end);
  bool Ensure(std::size_t bytes);
  std::size_t EventSize(std::size_t at) const;
  std::size_t EventWithin(std::size_t size) const;
  void SkipGarbage();

  std::string path_;
  Tail tail_;
  int fd_ = -1;
  std::int64_t offset_ = 0;      ///< bytes of the file that are or were in the buffer
  std::int64_t handed_out_ = 0;  ///< bytes of the file up to the end of the last event handed out
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;  ///< of what is not handed out yet
  std::int64_t garbage_bytes_ = 0;
  std::optional<Seal> seal_;
  std::int64_t refused_ = 0;
};

/// Writes a log that lcm-logplayer and other tools of LCM read.
class EventLogWriter {
 public:
  /// Makes the file. Throws SystemError when it exists, as appending behind a torn tail would hide
  /// what follows, or cannot be made.
  explicit EventLogWriter(const std::string& path);
  ~EventLogWriter();
  EventLogWriter(const EventLogWriter&) = delete;
  EventLogWriter& operator=(const EventLogWriter&) = delete;

  /// Throws SystemError when the file system refuses; the log may then end in a torn event, go on
  /// in a new file.
  void Write(std::int64_t received_us, const Packet& packet);
  /// Returns when all that was written is on the disk. Throws as Write.
  void Flush();

  std::int64_t events() const { return events_; }

 private:
  struct Destroy {
    void operator()(_lcm_eventlog_t* log) const;
  };

  std::string path_;
  std::unique_ptr<_lcm_eventlog_t, Destroy> log_;
  std::int64_t events_ = 0;
};

/// Writes such a log as a mission's recorder does: a batch of events by one call of the system. A
/// reader sees all that Flush() has written, and a writer that is killed loses nothing of it.
class BatchLogWriter {
 public:
  /// Makes the file. Throws SystemError when it exists or cannot be made.
  explicit BatchLogWriter(const std::string& path);
  ~BatchLogWriter();
  BatchLogWriter(const BatchLogWriter&) = delete;
  BatchLogWriter& operator=(const BatchLogWriter&) = delete;

  /// Adds it to the batch.
  void Add(std::int64_t received_us, const Packet& packet);
  /// Hands the batch to the kernel. Throws SystemError when that does not take all of it; the file
  /// then ends in the last whole event that it took, and nothing more can be written.
  void Flush();

 private:
  std::string path_;
  int fd_ = -1;
  std::int64_t events_ = 0;
  std::int64_t written_bytes_ = 0;
  std::vector<std::uint8_t> batch_;
  std::vector<std::size_t> ends_;  ///< of its events
};

/// Cuts off the bytes behind the last whole event of a log that is no longer written. Returns how
/// many. Throws SystemError.
std::int64_t CutTornTail(const std::string& path);

}  // namespace muster
