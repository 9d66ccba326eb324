#include "tools/log/mission_stream.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <map>
#include <utility>

#include "base/check.h"
#include "base/interval_set.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"

namespace muster::tools {

MissionHead ReadMissionHead(LogSource* source) {
  source->Rewind();
  MissionHead head;
  bool found = false;
  while (const auto message = source->Next()) {
    if (!message->header) continue;
    if (!found && message->packet.channel == channel::kScenario) {
      const auto scenario = DecodeValid<scenario_t>(message->packet.bytes);
      if (!scenario) continue;
      head.run_id = scenario->header.run_id;
      head.scenario = ParseScenario(scenario->json, "MUSTER_SCENARIO");
      found = true;
    }
    if (!found || message->packet.channel != channel::kClock) continue;
    const auto clock = DecodeValid<clock_t>(message->packet.bytes);
    if (!clock || clock->header.run_id != head.run_id || clock->phase == ClockPhase::kReady)
      continue;
    head.epoch_us = clock->header.wall_us == 0 ? 0 : clock->header.wall_us - clock->tick_us;
    return head;
  }
  if (!found) throw InputError(source->files()[0] + ": the log has no scenario");
  return head;
}

void ForEachMessage(MessageSource* source, std::int64_t run_id,
                    const std::function<void(const Message&, const Packet&)>& visit) {
  source->Rewind();
  Inbox inbox(run_id, "");
  std::map<std::pair<std::string, std::int64_t>, IntervalSet> seen;
  while (const auto logged = source->Next()) {
    if (!logged->header || logged->header->run_id != run_id) continue;
    const header_t& h = *logged->header;
    if (!seen[{h.sender, h.boot_id}].Add(h.seq)) continue;
    if (const auto message = inbox.Open(logged->packet)) visit(*message, logged->packet);
  }
}

std::string IsoTime(std::int64_t unix_us) {
  const std::time_t seconds = static_cast<std::time_t>(unix_us / 1'000'000);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(seconds), unix_us / 1000 % 1000);
}

}  // namespace muster::tools
