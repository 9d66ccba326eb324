#include "tools/log/mission_stream.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>

#include "base/check.h"

namespace muster::tools {

MissionHead ReadMissionHead(MessageSource* source) {
  source->Rewind();
  MissionReader reader;
  while (!reader.epoch_us()) {
    const auto event = source->NextEvent();
    if (!event) break;
    reader.Add(event->packet, [](const Message&, const Packet&) {});
  }
  if (!reader.scenario()) throw InputError(source->name() + ": the log has no scenario");
  return {*reader.run_id(), *reader.scenario(), reader.epoch_us().value_or(0)};
}

std::shared_ptr<const Scenario> ForEachMessage(
    MessageSource* source, std::int64_t run_id,
    const std::function<void(const Message&, const Packet&, const Scenario&)>& visit) {
  source->Rewind();
  MissionReader reader(run_id);
  while (const auto event = source->NextEvent()) {
    reader.Add(event->packet, [&](const Message& message, const Packet& packet) {
      visit(message, packet, *reader.scenario());
    });
  }
  return reader.scenario();
}

std::string IsoTime(std::int64_t unix_us) {
  const std::time_t seconds = static_cast<std::time_t>(unix_us / 1'000'000);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(seconds), unix_us / 1000 % 1000);
}

}  // namespace muster::tools
