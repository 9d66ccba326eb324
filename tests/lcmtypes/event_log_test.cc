#include "lcmtypes/bus/event_log.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "base/check.h"
#include "base/random.h"
#include "tests/temporary_folder.h"

namespace muster {
namespace {

namespace fs = std::filesystem;
using Tail = EventLogReader::Tail;

class EventLog : public ::testing::Test {
 protected:
  std::string Path(const char* name = "log") const { return folder_.File(name); }

 private:
  const TemporaryFolder folder_;
};

std::vector<LogEvent> Events(int count) {
  std::vector<LogEvent> events;
  for (int i = 0; i < count; ++i) {
    LogEvent event;
    event.number = i;
    event.received_us = 1'700'000'000'000'000 + i;
    event.packet.channel = i % 2 == 0 ? "MUSTER_CLOCK" : "OTHER";
    for (int k = 0; k < i * 7; ++k) event.packet.bytes.push_back(static_cast<std::uint8_t>(k * i));
    events.push_back(event);
  }
  return events;
}

std::string Written(const std::vector<LogEvent>& events, const std::string& path) {
  {
    EventLogWriter writer(path);
    for (const LogEvent& event : events) writer.Write(event.received_us, event.packet);
    writer.Flush();
  }
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Store(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}
void Append(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary | std::ios::app) << bytes;
}

std::vector<LogEvent> ReadAll(EventLogReader& reader) {
  std::vector<LogEvent> events;
  while (auto event = reader.Next()) events.push_back(*event);
  return events;
}

TEST_F(EventLog, ReadsWhatIsWritten) {
  const std::vector<LogEvent> events = Events(50);
  Written(events, Path());
  EventLogReader reader(Path(), Tail::kFinal);
  EXPECT_EQ(ReadAll(reader), events);
  EXPECT_EQ(reader.garbage_bytes(), 0);
  EXPECT_EQ(reader.pending_bytes(), 0);
}

TEST_F(EventLog, TheFormatIsTheDocumentedOne) {
  LogEvent event;
  event.received_us = 0x0102030405060708;
  event.packet = {"AB", {0xff, 0x00}};
  const std::string bytes = Written({event}, Path());
  const std::string expected(
      "\xED\xA1\xDA\x01"
      "\0\0\0\0\0\0\0\0"
      "\x01\x02\x03\x04\x05\x06\x07\x08"
      "\0\0\0\x02"
      "\0\0\0\x02"
      "AB\xff\0",
      32);
  EXPECT_EQ(bytes, expected);
}

TEST_F(EventLog, EveryTornTailLosesOnlyTheTornEvent) {
  const std::vector<LogEvent> events = Events(6);
  const std::string bytes = Written(events, Path("whole"));
  std::vector<std::size_t> ends;
  for (const LogEvent& event : events) {
    ends.push_back((ends.empty() ? 0 : ends.back()) + 28 + event.packet.channel.size() +
                   event.packet.bytes.size());
  }
  ASSERT_EQ(ends.back(), bytes.size());
  for (std::size_t length = 0; length <= bytes.size(); ++length) {
    Store(Path(), std::string_view(bytes).substr(0, length));
    const auto whole = std::upper_bound(ends.begin(), ends.end(), length) - ends.begin();
    const std::size_t torn = length - (whole > 0 ? ends[static_cast<std::size_t>(whole) - 1] : 0);
    const std::vector<LogEvent> expected(events.begin(), events.begin() + whole);
    EventLogReader finished(Path(), Tail::kFinal);
    EXPECT_EQ(ReadAll(finished), expected) << length;
    EXPECT_EQ(finished.garbage_bytes(), static_cast<std::int64_t>(torn)) << length;
    EventLogReader growing(Path(), Tail::kMayGrow);
    EXPECT_EQ(ReadAll(growing), expected) << length;
    EXPECT_EQ(growing.garbage_bytes(), 0) << length;
    EXPECT_EQ(growing.pending_bytes(), static_cast<std::int64_t>(torn)) << length;
  }
}

TEST_F(EventLog, FollowsAGrowingFileByteByByte) {
  const std::vector<LogEvent> events = Events(8);
  const std::string bytes = Written(events, Path("whole"));
  Store(Path(), "");
  EventLogReader reader(Path(), Tail::kMayGrow);
  std::vector<LogEvent> got;
  for (const char byte : bytes) {
    EXPECT_EQ(reader.Next(), std::nullopt);
    Append(Path(), std::string_view(&byte, 1));
    while (auto event = reader.Next()) got.push_back(*event);
  }
  EXPECT_EQ(got, events);
  EXPECT_EQ(reader.garbage_bytes(), 0);
  EXPECT_EQ(reader.pending_bytes(), 0);
}

TEST_F(EventLog, FollowsItsWriterFromFlushToFlush) {
  const std::vector<LogEvent> events = Events(8);
  EventLogWriter writer(Path());
  EventLogReader reader(Path(), Tail::kMayGrow);
  for (const LogEvent& event : events) {
    writer.Write(event.received_us, event.packet);
    writer.Flush();
    EXPECT_EQ(ReadAll(reader), std::vector<LogEvent>{event});
  }
}

TEST_F(EventLog, FindsWhatFollowsATornEvent) {
  const std::vector<LogEvent> events = Events(12);
  const std::string bytes = Written(events, Path("whole"));
  const std::string last =
      Written({events[11]}, Path("one"));  // 28 + 5 + 77 bytes, longer than most
  for (std::size_t length = 1; length < last.size(); ++length) {
    Store(Path(), last.substr(0, length) + bytes);
    EventLogReader reader(Path(), Tail::kFinal);
    EXPECT_EQ(ReadAll(reader), events) << "torn after " << length;
    EXPECT_EQ(reader.garbage_bytes(), static_cast<std::int64_t>(length));
  }
}

TEST_F(EventLog, SkipsGarbageBetweenEvents) {
  constexpr std::uint64_t kSeed = 20240611;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const std::vector<LogEvent> events = Events(20);
  std::vector<std::string> pieces;
  for (const LogEvent& event : events) {
    pieces.push_back(Written({event}, Path()));
    pieces.back()[11] = static_cast<char>(event.number);  // low byte of the number
    fs::remove(Path());
  }
  for (std::uint32_t round = 0; round < 200; ++round) {
    Random random(kSeed, Stream::kTest, 0, round);
    std::string file;
    std::int64_t garbage = 0;
    for (const std::string& piece : pieces) {
      const std::uint32_t noise = random.Below(4) == 0 ? random.Below(100) : 0;
      for (std::uint32_t i = 0; i < noise; ++i) {
        // Every other one a piece of a sync word.
        file += static_cast<char>(random.Below(2) == 0 ? "\xED\xA1\xDA\x01"[random.Below(4)]
                                                       : static_cast<int>(random.Below(256)));
      }
      garbage += noise;
      file += piece;
    }
    Store(Path(), file);
    EventLogReader reader(Path(), Tail::kFinal);
    ASSERT_EQ(ReadAll(reader), events) << "round " << round;
    EXPECT_EQ(reader.garbage_bytes(), garbage) << "round " << round;
  }
}

TEST_F(EventLog, ADamagedLengthCostsOneEventAndNoMemory) {
  const std::vector<LogEvent> events = Events(10);
  std::string bytes = Written(events, Path("whole"));
  for (const char* length : {"\x7f\xff\xff\xff", "\xff\xff\xff\xff", "\x07\xff\xff\xff"}) {
    std::string damaged = bytes;
    damaged.replace(24, 4, length, 4);  // data length of the first
    Store(Path(), damaged);
    EventLogReader reader(Path(), Tail::kFinal);
    EXPECT_EQ(ReadAll(reader), std::vector<LogEvent>(events.begin() + 1, events.end()));
  }
}

TEST_F(EventLog, ReadsEventsLargerThanItsChunks) {
  std::vector<LogEvent> events = Events(3);
  for (LogEvent& event : events) event.packet.bytes.assign(3'000'000, 0xED);
  Written(events, Path());
  EventLogReader reader(Path(), Tail::kFinal);
  EXPECT_EQ(ReadAll(reader), events);
}

TEST_F(EventLog, WriterNeverTouchesAnExistingFile) {
  Store(Path(), "precious");
  EXPECT_THROW(EventLogWriter writer(Path()), SystemError);
  EXPECT_EQ(fs::file_size(Path()), 8u);
}

TEST_F(EventLog, NamesFilesThatItCannotUse) {
  EXPECT_THROW(EventLogReader(Path("absent"), Tail::kFinal), SystemError);
  EXPECT_THROW(EventLogWriter(Path("no/folder/log")), SystemError);
  const std::string bytes = Written(Events(3), Path());
  EventLogReader reader(Path(), Tail::kMayGrow);
  ReadAll(reader);
  Store(Path(), "");
  EXPECT_THROW(reader.Next(), SystemError);
}

TEST_F(EventLog, AFullDiskIsAnError) {
  // A limit on the file's size stands for a full disk. In a child: the limit stays.
  EXPECT_EXIT(
      {
        signal(SIGXFSZ, SIG_IGN);
        rlimit limit;
        limit.rlim_cur = limit.rlim_max = 1000;
        setrlimit(RLIMIT_FSIZE, &limit);
        int code = 0;
        try {
          EventLogWriter writer(Path());
          writer.Write(0, {"MUSTER_CLOCK", std::vector<std::uint8_t>(900)});
          writer.Flush();
          writer.Write(0, {"MUSTER_CLOCK", std::vector<std::uint8_t>(900)});
          writer.Flush();
        } catch (const SystemError& error) {
          std::fprintf(stderr, "%s\n", error.what());
          code = 3;
        }
        _exit(code);
      },
      ::testing::ExitedWithCode(3), "cannot write .*: File too large");
  EventLogReader reader(Path(), Tail::kFinal);
  EXPECT_EQ(ReadAll(reader).size(), 1u);
}

TEST_F(EventLog, ABatchIsWhatLcmWrites) {
  const std::vector<LogEvent> events = Events(50);
  const std::string expected = Written(events, Path("lcm"));
  BatchLogWriter writer(Path());
  for (const LogEvent& event : events) {
    writer.Add(event.received_us, event.packet);
    if (event.number % 8 == 0) writer.Flush();
  }
  EXPECT_LT(fs::file_size(Path()), expected.size());
  writer.Flush();
  std::ifstream file(Path(), std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), expected);
  EXPECT_THROW(BatchLogWriter again(Path()), SystemError);
}

TEST_F(EventLog, ABatchThatFindsNoRoomEndsInAWholeEvent) {
  EXPECT_EXIT(
      {
        signal(SIGXFSZ, SIG_IGN);
        rlimit limit;
        limit.rlim_cur = limit.rlim_max = 2500;
        setrlimit(RLIMIT_FSIZE, &limit);
        int code = 0;
        try {
          BatchLogWriter writer(Path());
          for (int i = 0; i < 4; ++i) {
            writer.Add(i, {"MUSTER_CLOCK", std::vector<std::uint8_t>(900)});
            if (i == 0) writer.Flush();
          }
          writer.Flush();
        } catch (const SystemError& error) {
          std::fprintf(stderr, "%s\n", error.what());
          code = 3;
        }
        _exit(code);
      },
      ::testing::ExitedWithCode(3), "cannot write .*: File too large");
  EventLogReader reader(Path(), Tail::kFinal);
  EXPECT_EQ(ReadAll(reader).size(), 2u);
  EXPECT_EQ(reader.garbage_bytes(), 0);
}

TEST_F(EventLog, ATornTailIsCutUnderAReader) {
  const std::string bytes = Written(Events(10), Path());
  Append(Path(), std::string_view(bytes).substr(0, 20));
  EventLogReader reader(Path(), Tail::kMayGrow);
  EXPECT_EQ(ReadAll(reader).size(), 10u);
  EXPECT_EQ(reader.pending_bytes(), 20);
  EXPECT_EQ(CutTornTail(Path()), 20);
  EXPECT_EQ(CutTornTail(Path()), 0);
  EXPECT_EQ(fs::file_size(Path()), bytes.size());
  EXPECT_FALSE(reader.Next());
  EXPECT_EQ(reader.pending_bytes(), 0);
  EXPECT_EQ(reader.garbage_bytes(), 0);
}

TEST_F(EventLog, ATornTailIsCutBeforeTheEventsAheadOfItAreRead) {
  const std::vector<LogEvent> events = Events(4);
  const std::string bytes = Written(events, Path("whole"));
  for (const Tail tail : {Tail::kFinal, Tail::kMayGrow}) {
    for (std::size_t torn = 1; torn < 40; ++torn) {
      for (std::size_t read = 1; read < events.size(); ++read) {
        Store(Path(), bytes + bytes.substr(0, torn));
        EventLogReader reader(Path(), tail);
        for (std::size_t i = 0; i < read; ++i) ASSERT_EQ(reader.Next(), events[i]);
        fs::resize_file(Path(), bytes.size());
        const auto rest = events.begin() + static_cast<std::ptrdiff_t>(read);
        ASSERT_EQ(ReadAll(reader), std::vector<LogEvent>(rest, events.end()))
            << torn << " " << read;
        Append(Path(), bytes);
        ASSERT_EQ(ReadAll(reader), events) << "written on";
        ASSERT_EQ(reader.garbage_bytes(), 0);
      }
    }
  }
}

/// A read at the moment at which a torn tail is cut off may find zeros in its place (Linux, ext4).
TEST_F(EventLog, ZerosOfATailThatIsCutOffAreForgotten) {
  const std::vector<LogEvent> events = Events(4);
  const std::string bytes = Written(events, Path("whole"));
  for (const Tail tail : {Tail::kFinal, Tail::kMayGrow}) {
    for (std::size_t torn = 1; torn < 40; ++torn) {
      for (std::size_t of_it = 0; of_it < torn; ++of_it) {
        Store(Path(), bytes + bytes.substr(0, of_it) + std::string(torn - of_it, '\0'));
        EventLogReader reader(Path(), tail);
        ASSERT_EQ(ReadAll(reader), events);
        fs::resize_file(Path(), bytes.size());
        ASSERT_EQ(ReadAll(reader), std::vector<LogEvent>()) << torn << " " << of_it;
        Append(Path(), bytes);
        ASSERT_EQ(ReadAll(reader), events) << "written on";
        ASSERT_EQ(reader.garbage_bytes(), 0);
        fs::resize_file(Path(), bytes.size());
        ASSERT_THROW(ReadAll(reader), SystemError) << "events that were handed out";
      }
    }
  }
}

}  // namespace
}  // namespace muster
