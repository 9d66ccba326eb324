#include "protocol/fault_kinds.h"

#include <algorithm>
#include <array>
#include <csignal>

#include "base/units.h"

namespace muster {
namespace {

/// In the order of the wire's numbers.
constexpr std::array<FaultRow, kNames<FaultKind>.size()> kRows = {{
    {.kind = FaultKind::kAgentFails, .target = FaultTarget::kAgent, .effect = "agent failed"},
    {.kind = FaultKind::kAgentSilent,
     .target = FaultTarget::kAgent,
     .effect = "agent failed",
     .must_end = true},
    {.kind = FaultKind::kProcessKilled,
     .target = FaultTarget::kProcess,
     .effect = "killed",
     .holds_clock = true,
     .kills = true,
     .begin_signal = SIGKILL},
    {.kind = FaultKind::kProcessStopped,
     .target = FaultTarget::kProcess,
     .effect = "stopped",
     .holds_clock = true,
     .must_end = true,
     .begin_signal = SIGSTOP,
     .end_signal = SIGCONT},
    {.kind = FaultKind::kPartition,
     .target = FaultTarget::kSides,
     .holds_clock = true,
     .must_end = true,
     .hits = &PacketFaultCounters::unheard},
    {.kind = FaultKind::kLoss,
     .target = FaultTarget::kReceivers,
     .deafens = true,
     .value_key = "probability",
     .value_most = 1,
     .apply = [](double p, PacketFaults* faults) { faults->loss = std::max(faults->loss, p); },
     .hits = &PacketFaultCounters::lost},
    {.kind = FaultKind::kDuplication,
     .target = FaultTarget::kReceivers,
     .value_key = "probability",
     .value_most = 1,
     .apply = [](double p,
                 PacketFaults* faults) { faults->duplication = std::max(faults->duplication, p); },
     .hits = &PacketFaultCounters::duplicated},
    {.kind = FaultKind::kDelay,
     .target = FaultTarget::kReceivers,
     .value_key = "delay_ms",
     .value_most = 1000,
     .value_unit = 1e-3,
     .value_drawn = 1e-2,
     .apply = [](double s,
                 PacketFaults* faults) { faults->delay_us = std::max(faults->delay_us, ToUs(s)); },
     .hits = &PacketFaultCounters::delayed},
    {.kind = FaultKind::kReordering,
     .target = FaultTarget::kReceivers,
     .value_key = "probability",
     .value_most = 1,
     .apply = [](double p,
                 PacketFaults* faults) { faults->reorder = std::max(faults->reorder, p); },
     .hits = &PacketFaultCounters::reordered},
    // Where more packets are damaged, lies outlast the truth.
    {.kind = FaultKind::kCorruption,
     .target = FaultTarget::kReceivers,
     .damages = true,
     .value_key = "probability",
     .value_most = 0.2,
     .value_drawn = 0.5,
     .apply = [](double p,
                 PacketFaults* faults) { faults->corrupt = std::max(faults->corrupt, p); },
     .hits = &PacketFaultCounters::corrupted},
    {.kind = FaultKind::kDiskFull,
     .target = FaultTarget::kLog,
     .effect = "killed",
     .holds_clock = true,
     .must_end = true,
     .kills = true},
    {.kind = FaultKind::kForeign, .target = FaultTarget::kEverybody},
    {.kind = FaultKind::kRoadClosed, .target = FaultTarget::kRoads, .effect = "roads closed"},
    {.kind = FaultKind::kZoneUnknown, .target = FaultTarget::kAir, .effect = "zone in force"},
}};

static_assert([] {
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    if (static_cast<std::size_t>(kRows[i].kind) != i) return false;
  }
  return true;
}());

}  // namespace

const FaultRow& RowOf(FaultKind kind) { return kRows.at(static_cast<std::size_t>(kind)); }

}  // namespace muster
