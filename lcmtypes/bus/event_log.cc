#include "lcmtypes/bus/event_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <lcm/eventlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "base/check.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

// An event: sync word, number (8), time (8), channel length (4), data length (4), channel, data;
// all big-endian. Source: LCM's eventlog.c.
constexpr std::array<std::uint8_t, 4> kSync = {0xED, 0xA1, 0xDA, 0x01};
constexpr std::size_t kHeaderBytes = 28;
/// LCM's own limit.
constexpr std::int64_t kMaxChannelBytes = 63;
/// Twice what the channel table allows; a damaged length must not hide the rest of a log.
constexpr std::int64_t kMaxDataBytes = 128 << 20;
constexpr std::size_t kChunkBytes = 256 * 1024;

constexpr std::size_t kNoEvent = 0;
constexpr std::size_t kIncomplete = static_cast<std::size_t>(-1);

std::uint64_t ReadBigEndian(const std::uint8_t* bytes, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | bytes[i];
  return value;
}
std::int64_t ReadInt64(const std::uint8_t* bytes) {
  return static_cast<std::int64_t>(ReadBigEndian(bytes, 8));
}
std::int64_t ReadInt32(const std::uint8_t* bytes) {
  return static_cast<std::int32_t>(ReadBigEndian(bytes, 4));
}

/// Whether what is there of the first four bytes is (the start of) a sync word.
bool StartsLikeEvent(const std::uint8_t* bytes, std::size_t available) {
  return std::equal(kSync.begin(),
                    kSync.begin() + static_cast<std::ptrdiff_t>(std::min(available, kSync.size())),
                    bytes);
}

}  // namespace

EventLogReader::EventLogReader(const std::string& path, Tail tail)
    : path_(path), tail_(tail), fd_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (fd_ < 0) throw SystemError(fmt::format("cannot read {}: {}", path, std::strerror(errno)));
}

EventLogReader::~EventLogReader() { close(fd_); }

/// Appends what the file holds next to the buffer; false at its end.
bool EventLogReader::ReadMore() {
  if (begin_ > kChunkBytes && begin_ > buffer_.size() / 2) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
  }
  const std::size_t old_size = buffer_.size();
  buffer_.resize(old_size + kChunkBytes);
  ssize_t got = 0;
  do {
    got = pread(fd_, buffer_.data() + old_size, kChunkBytes, offset_);
  } while (got < 0 && errno == EINTR);
  buffer_.resize(old_size + (got > 0 ? static_cast<std::size_t>(got) : 0));
  if (got < 0) throw SystemError(fmt::format("cannot read {}: {}", path_, std::strerror(errno)));
  offset_ += got;
  if (got > 0) return true;
  struct stat status {};
  if (fstat(fd_, &status) == 0 && status.st_size < offset_) {
    ForgetFrom(status.st_size);
  }
  return false;
}

/// The file was cut at `end`: a torn event, maybe behind whole ones that are not handed out yet.
/// A read at the same moment may have found zeros in its place, which were skipped as garbage.
void EventLogReader::ForgetFrom(std::int64_t end) {
  if (end < handed_out_) {
    throw SystemError(fmt::format("{} became shorter while it was read", path_));
  }
  const auto cut_off = static_cast<std::size_t>(offset_ - end);
  const std::size_t pending = std::min(cut_off, available());
  garbage_bytes_ -= static_cast<std::int64_t>(cut_off - pending);
  buffer_.resize(buffer_.size() - pending);
  offset_ = end;
}

bool EventLogReader::Ensure(std::size_t bytes) {
  while (available() < bytes) {
    if (!ReadMore()) return false;
  }
  return true;
}

/// Size of the event at buffer index `at`; kNoEvent when there is none, kIncomplete when its rest
/// is not in the buffer.
std::size_t EventLogReader::EventSize(std::size_t at) const {
  const std::uint8_t* bytes = buffer_.data() + at;
  const std::size_t there = buffer_.size() - at;
  if (!StartsLikeEvent(bytes, there)) return kNoEvent;
  if (there < kHeaderBytes) return kIncomplete;
  const std::int64_t channel_bytes = ReadInt32(bytes + 20);
  const std::int64_t data_bytes = ReadInt32(bytes + 24);
  if (ReadInt64(bytes + 4) < 0 || ReadInt64(bytes + 12) < 0 || channel_bytes < 1 ||
      channel_bytes > kMaxChannelBytes || data_bytes < 0 || data_bytes > kMaxDataBytes) {
    return kNoEvent;
  }
  const auto channel_end = kHeaderBytes + static_cast<std::size_t>(channel_bytes);
  for (std::size_t i = kHeaderBytes; i < std::min(channel_end, there); ++i) {
    if (bytes[i] <= ' ' || bytes[i] > '~') return kNoEvent;
  }
  const std::size_t size = channel_end + static_cast<std::size_t>(data_bytes);
  return size <= there ? size : kIncomplete;
}

/// Where, from begin_, within its first `size` bytes, a whole event starts that is followed by
/// another or by the end of what is known; 0 when there is none.
std::size_t EventLogReader::EventWithin(std::size_t size) const {
  // A sync word may begin within and end behind.
  const std::size_t last = std::min(begin_ + size + kSync.size() - 1, buffer_.size());
  const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(last);
  auto at = buffer_.begin() + static_cast<std::ptrdiff_t>(begin_ + 1);
  while ((at = std::search(at, end, kSync.begin(), kSync.end())) != end) {
    const auto index = static_cast<std::size_t>(at - buffer_.begin());
    const std::size_t inner = EventSize(index);
    if (inner != kNoEvent && inner != kIncomplete) {
      const std::size_t next = index + inner;
      if (StartsLikeEvent(buffer_.data() + next, buffer_.size() - next)) return index - begin_;
    }
    ++at;
  }
  return 0;
}

/// Moves to the next byte that may start an event.
void EventLogReader::SkipGarbage() {
  const auto from = buffer_.begin() + static_cast<std::ptrdiff_t>(begin_ + 1);
  const auto next = std::find(from, buffer_.end(), kSync[0]);
  const auto skipped = static_cast<std::size_t>(next - from) + 1;
  begin_ += skipped;
  garbage_bytes_ += static_cast<std::int64_t>(skipped);
}

std::optional<LogEvent> EventLogReader::Next() {
  while (std::optional<LogEvent> event = NextOfAll()) {
    event->tag = CutTag(&event->packet);
    const bool ours = FindChannel(event->packet.channel) != nullptr;
    if (!seal_ || !ours || seal_->Holds(event->packet, event->tag)) return event;
    ++refused_;
  }
  return std::nullopt;
}

std::optional<LogEvent> EventLogReader::NextOfAll() {
  for (;;) {
    if (available() == 0 && !ReadMore()) return std::nullopt;
    std::size_t size = EventSize(begin_);
    if (size == kIncomplete) {
      if (ReadMore()) continue;
      if (tail_ == Tail::kMayGrow) return std::nullopt;
      if (available() == 0) continue;  // cut off
      size = kNoEvent;
    }
    if (size == kNoEvent) {
      SkipGarbage();
      continue;
    }
    // A torn event, by the length it gives, reaches into what was written behind it.
    Ensure(size + kHeaderBytes);
    if (available() < size) continue;  // cut off
    if (const std::size_t torn = EventWithin(size); torn > 0) {
      begin_ += torn;
      garbage_bytes_ += static_cast<std::int64_t>(torn);
      continue;
    }
    const std::uint8_t* bytes = buffer_.data() + begin_;
    const std::uint8_t* data = bytes + kHeaderBytes + ReadInt32(bytes + 20);
    LogEvent event;
    event.number = ReadInt64(bytes + 4);
    event.received_us = ReadInt64(bytes + 12);
    event.packet.channel.assign(bytes + kHeaderBytes, data);
    event.packet.bytes.assign(data, bytes + size);
    begin_ += size;
    handed_out_ = offset_ - pending_bytes();
    return event;
  }
}

void EventLogWriter::Destroy::operator()(_lcm_eventlog_t* log) const { lcm_eventlog_destroy(log); }

EventLogWriter::EventLogWriter(const std::string& path) : path_(path) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (fd >= 0) {
    close(fd);
    log_.reset(lcm_eventlog_create(path.c_str(), "w"));
  }
  if (log_ == nullptr) {
    throw SystemError(fmt::format("cannot make {}: {}", path, std::strerror(errno)));
  }
}

EventLogWriter::~EventLogWriter() = default;

void EventLogWriter::Write(std::int64_t received_us, const Packet& packet) {
  lcm_eventlog_event_t event{};
  event.eventnum = events_;
  event.timestamp = received_us;
  event.channellen = static_cast<std::int32_t>(packet.channel.size());
  event.datalen = static_cast<std::int32_t>(packet.bytes.size());
  // LCM's write takes them without const and does not change them.
  event.channel = const_cast<char*>(packet.channel.data());
  event.data = const_cast<std::uint8_t*>(packet.bytes.data());
  errno = 0;
  if (lcm_eventlog_write_event(log_.get(), &event) != 0) {
    throw SystemError(fmt::format("cannot write {}: {}", path_, std::strerror(errno)));
  }
  ++events_;
}

void EventLogWriter::Flush() {
  errno = 0;
  if (std::fflush(log_->f) != 0 || fdatasync(fileno(log_->f)) != 0) {
    throw SystemError(fmt::format("cannot write {}: {}", path_, std::strerror(errno)));
  }
}

BatchLogWriter::BatchLogWriter(const std::string& path)
    : path_(path), fd_(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)) {
  if (fd_ < 0) throw SystemError(fmt::format("cannot make {}: {}", path, std::strerror(errno)));
}

BatchLogWriter::~BatchLogWriter() { close(fd_); }

void BatchLogWriter::Add(std::int64_t received_us, const Packet& packet) {
  const auto add = [this](std::int64_t value, int bytes) {
    for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) {
      batch_.push_back(static_cast<std::uint8_t>(value >> shift));
    }
  };
  batch_.insert(batch_.end(), kSync.begin(), kSync.end());
  add(events_++, 8);
  add(received_us, 8);
  add(static_cast<std::int64_t>(packet.channel.size()), 4);
  add(static_cast<std::int64_t>(packet.bytes.size()), 4);
  batch_.insert(batch_.end(), packet.channel.begin(), packet.channel.end());
  batch_.insert(batch_.end(), packet.bytes.begin(), packet.bytes.end());
  ends_.push_back(batch_.size());
}

void BatchLogWriter::Flush() {
  std::size_t done = 0;
  while (done < batch_.size()) {
    const ssize_t wrote = write(fd_, batch_.data() + done, batch_.size() - done);
    if (wrote >= 0) {
      done += static_cast<std::size_t>(wrote);
    } else if (errno != EINTR) {
      const int error = errno;
      const auto torn = std::upper_bound(ends_.begin(), ends_.end(), done);
      const std::size_t whole = torn == ends_.begin() ? 0 : *(torn - 1);
      // What cannot be cut off is a torn tail, which readers know.
      static_cast<void>(!ftruncate(fd_, written_bytes_ + static_cast<std::int64_t>(whole)));
      throw SystemError(fmt::format("cannot write {}: {}", path_, std::strerror(error)));
    }
  }
  written_bytes_ += static_cast<std::int64_t>(done);
  batch_.clear();
  ends_.clear();
}

std::int64_t CutTornTail(const std::string& path) {
  EventLogReader reader(path, EventLogReader::Tail::kMayGrow);
  while (reader.Next()) {
  }
  const std::int64_t torn = reader.pending_bytes();
  struct stat status {};
  if (torn > 0 &&
      (stat(path.c_str(), &status) != 0 || truncate(path.c_str(), status.st_size - torn) != 0)) {
    throw SystemError(fmt::format("cannot cut {}: {}", path, std::strerror(errno)));
  }
  return torn;
}

}  // namespace muster
