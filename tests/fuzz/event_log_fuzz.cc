// Arbitrary bytes as a log: the reader ends, and every byte is part of an event or garbage.

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/check.h"
#include "lcmtypes/bus/event_log.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  const int fd = memfd_create("log", MFD_CLOEXEC);
  MUSTER_CHECK(fd >= 0 && write(fd, data, size) == static_cast<ssize_t>(size));
  const std::string path = fmt::format("/proc/self/fd/{}", fd);
  std::size_t explained = 0;
  EventLogReader reader(path, EventLogReader::Tail::kFinal);
  while (const auto event = reader.Next()) {
    explained += 28 + event->packet.channel.size() + event->packet.bytes.size();
  }
  MUSTER_CHECK(reader.pending_bytes() == 0);
  MUSTER_CHECK(explained + static_cast<std::size_t>(reader.garbage_bytes()) == size,
               "{} in events, {} garbage, of {}", explained, reader.garbage_bytes(), size);
  close(fd);
  return 0;
}
