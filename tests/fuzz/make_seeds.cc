// make_seeds DIR: writes the fuzzers' first inputs, one message of each type into DIR/codec and a
// log of them into DIR/event_log.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>

#include "lcmtypes/bus/event_log.h"
#include "tests/lcmtypes/sample_messages.h"

int main(int argc, char** argv) try {
  using namespace muster;
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_seeds DIR\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder / "codec");
  std::filesystem::create_directories(folder / "event_log");
  std::filesystem::remove(folder / "event_log" / "all");
  EventLogWriter log((folder / "event_log" / "all").string());
  const auto write = [&](const auto& message) {
    const std::vector<std::uint8_t> bytes = Encode(message);
    std::ofstream(folder / "codec" / message.getTypeName(), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    log.Write(1, {"MUSTER_CLOCK", bytes});
  };
  std::apply([&](const auto&... messages) { (write(messages), ...); }, SampleMessages());
  log.Flush();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "make_seeds: %s\n", error.what());
  return 1;
}
