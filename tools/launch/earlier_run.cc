#include "tools/launch/earlier_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "protocol/inbox.h"
#include "protocol/order_book.h"
#include "protocol/scenario_reader.h"
#include "protocol/sender.h"
#include "tools/files/log_files.h"

namespace muster::tools {
namespace {

void AddClock(const clock_t& clock, EarlierRun* earlier) {
  if (clock.phase == ClockPhase::kReady) return;
  earlier->has_ended |= clock.phase == ClockPhase::kEnded;
  earlier->tick = std::max(earlier->tick, clock.tick);
  earlier->tick_us = std::max(earlier->tick_us, clock.tick_us);
}

void AddStatus(const process_status_t& status, EarlierRun* earlier) {
  if (status.header.sender != process_name::kLauncher) return;
  const bool is_newest = status.header.boot_id + 1 == earlier->starts[status.header.sender];
  earlier->was_stopped = is_newest && status.state == ProcessState::kEnded;
}

}  // namespace

std::int64_t EarlierRun::StartsOf(const std::string& sender) const {
  const auto found = starts.find(sender);
  return found == starts.end() ? 0 : found->second;
}

Scenario ScenarioInLog(const std::string& run) {
  ScenarioReader scenario;
  for (const std::string& file : LogFilesOf(run)) {
    const auto reader = OpenLog(file, EventLogReader::Tail::kFinal);
    while (const auto event = reader->Next()) {
      const bool is_of_it =
          event->packet.channel == channel::kScenario || event->packet.channel == channel::kRoads;
      const std::optional<Message> message = is_of_it ? DecodeMessage(event->packet) : std::nullopt;
      if (message && scenario.Take(*message) == ScenarioReader::Outcome::kWhole) {
        return scenario.scenario();
      }
    }
  }
  throw InputError(fmt::format("{}: no scenario in its log", run));
}

void EarlierRun::KeepApart() {
  for (const auto& [sender, count] : starts) first_boot = std::max(first_boot, count);
  first_boot = (first_boot / kLauncherApart + 1) * kLauncherApart;
  for (auto& [sender, count] : starts) count = first_boot + 1;
}

EarlierRun ReadEarlierRun(const std::string& run, const Scenario& scenario, std::int64_t run_id) {
  EarlierRun earlier;
  earlier.log_files = LogFilesOf(run);
  OrderBook book(scenario);
  for (const std::string& file : earlier.log_files) {
    const auto reader = OpenLog(file, EventLogReader::Tail::kFinal);
    while (const auto event = reader->Next()) {
      const std::optional<header_t> header = DecodeHeader(event->packet);
      if (!header || header->run_id != run_id) continue;
      std::int64_t& starts = earlier.starts[header->sender];
      starts = std::max(starts, header->boot_id + 1);
      if (event->packet.channel == channel::kClock) {
        if (const auto clock = DecodeValid<clock_t>(event->packet.bytes))
          AddClock(*clock, &earlier);
      } else if (event->packet.channel == channel::kProcess) {
        if (const auto status = DecodeValid<process_status_t>(event->packet.bytes)) {
          AddStatus(*status, &earlier);
        }
      } else if (event->packet.channel == channel::kOrders && book.takes_orders()) {
        // Impossible ones are nothing to keep.
        if (const auto orders = DecodeValid<orders_t>(event->packet.bytes)) {
          static_cast<void>(book.Take(*orders));
        }
      }
    }
  }
  earlier.persons = book.scenario()->persons;
  return earlier;
}

}  // namespace muster::tools
