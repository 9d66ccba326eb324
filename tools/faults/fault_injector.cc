#include "tools/faults/fault_injector.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>

#include "protocol/fault_kinds.h"

namespace muster::tools {
FaultInjector::FaultInjector(FaultPlan plan, std::vector<std::string> names)
    : names_(std::move(names)) {
  for (PlannedFault& fault : plan) {
    Injection& injection = injections_.emplace_back();
    injection.fault = std::move(fault);
  }
}

void FaultInjector::Begin(Injection* injection, TimeUs monotonic_us, FaultActions* actions) {
  const PlannedFault& fault = injection->fault;
  const FaultRow& row = RowOf(fault.kind);
  // A process that does not run now is signalled when it runs again.
  if (row.begin_signal != 0 && !actions->SignalProcess(fault.target, row.begin_signal)) return;
  if (row.kills && (fault.for_real_us > 0 || fault.for_us > 0)) actions->HoldRestart(fault.target);
  if (row.target == FaultTarget::kLog) actions->SetDiskFull(true);
  injection->phase = Phase::kActive;
  injection->died = std::any_of(names_.begin(), names_.end(), [&](const std::string& name) {
    return Concerns(ToWire(fault), name) && !actions->IsRunning(name);
  });
  injection->begin = actions->Publish(ToWire(fault));
  injection->repeat.Start(monotonic_us);
  if (fault.for_real_us > 0) injection->until_real_us = monotonic_us + fault.for_real_us;
}

void FaultInjector::End(Injection* injection, TimeUs monotonic_us, FaultActions* actions) {
  const PlannedFault& fault = injection->fault;
  injection->phase = Phase::kOver;
  injection->until_real_us = kNever;
  const FaultRow& row = RowOf(fault.kind);
  if (row.by_world()) return;
  if (row.end_signal != 0) actions->SignalProcess(fault.target, row.end_signal);
  if (row.target == FaultTarget::kLog) actions->SetDiskFull(false);
  if (row.kills) actions->ReleaseRestart(fault.target);
  fault_t end = ToWire(fault);
  end.at_us = mission_us_;
  end.for_us = 0;
  injection->end = actions->Publish(end);
  injection->repeat.Start(monotonic_us);
  if (!row.of_packets()) actions->Confirm(EventKind::kFaultEnded, fault.id);
}

bool FaultInjector::Owed(const Injection& injection, const FaultActions& actions) const {
  if (injection.phase == Phase::kWaiting || !RowOf(injection.fault.kind).of_packets()) return false;
  const fault_t wire = ToWire(injection.fault);
  return std::any_of(names_.begin(), names_.end(), [&](const std::string& name) {
    if (!Concerns(wire, name) || actions.IsGone(name)) return false;
    const Start start(name, actions.BootOf(name));
    if (injection.phase == Phase::kActive) return injection.applied.count(start) == 0;
    return injection.applied.count(start) > 0 && injection.ended.count(start) == 0;
  });
}

void FaultInjector::Step(TimeUs mission_us, TimeUs monotonic_us, FaultActions* actions) {
  if (mission_us < 0) return;
  mission_us_ = mission_us;
  for (Injection& injection : injections_) {
    const PlannedFault& fault = injection.fault;
    if (injection.phase == Phase::kWaiting && mission_us >= fault.at_us) {
      Begin(&injection, monotonic_us, actions);
    } else if (injection.phase == Phase::kActive &&
               (monotonic_us >= injection.until_real_us ||
                (fault.for_us > 0 && mission_us >= fault.at_us + fault.for_us))) {
      End(&injection, monotonic_us, actions);
    }
    if (injection.phase == Phase::kActive && RowOf(fault.kind).begin_signal == SIGSTOP &&
        !injection.confirmed && actions->IsStopped(fault.target)) {
      injection.confirmed = true;
      actions->Confirm(EventKind::kFaultApplied, fault.id);
    }
    if (monotonic_us >= injection.repeat.due_us() && Owed(injection, *actions)) {
      injection.repeat.Fire(monotonic_us);
      actions->SendAgain(injection.phase == Phase::kActive ? injection.begin : injection.end);
    }
  }
}

bool FaultInjector::OnDeath(const std::string& name, FaultActions* actions) {
  bool planned = false;
  for (Injection& injection : injections_) {
    const PlannedFault& fault = injection.fault;
    injection.died |= injection.phase == Phase::kActive && Concerns(ToWire(fault), name);
    if (!RowOf(fault.kind).kills || fault.target != name || injection.confirmed) continue;
    if (injection.phase == Phase::kWaiting) continue;
    planned = injection.confirmed = true;
    actions->Confirm(EventKind::kFaultApplied, fault.id);
  }
  return planned;
}

void FaultInjector::OnEvent(const event_t& event) {
  if (event.kind != EventKind::kFaultApplied && event.kind != EventKind::kFaultEnded) return;
  for (Injection& injection : injections_) {
    if (injection.fault.id != event.fault_id) continue;
    const bool is_new =
        (event.kind == EventKind::kFaultApplied ? injection.applied : injection.ended)
            .insert({event.header.sender, event.header.boot_id})
            .second;
    if (is_new && event.kind == EventKind::kFaultEnded)
      injection.hits += HitsOf(event.detail).value_or(0);
  }
}

void FaultInjector::EndAll(TimeUs monotonic_us, FaultActions* actions) {
  for (Injection& injection : injections_) {
    if (injection.phase == Phase::kActive) End(&injection, monotonic_us, actions);
  }
}

bool FaultInjector::Settled(const FaultActions& actions) const {
  return std::none_of(injections_.begin(), injections_.end(), [&](const Injection& injection) {
    return injection.phase == Phase::kActive || Owed(injection, actions);
  });
}

std::vector<std::string> FaultInjector::WithoutEffect() const {
  std::vector<std::string> lines;
  for (const Injection& injection : injections_) {
    const PlannedFault& fault = injection.fault;
    const auto add = [&](std::string_view why) {
      lines.push_back(
          fmt::format("fault {} ({} {}): {}", fault.id, ToString(fault.kind), fault.target, why));
    };
    if (injection.phase == Phase::kWaiting) {
      add("its time did not come");
    } else if (injection.applied.empty()) {
      if (!injection.died) add("no process has confirmed it");
    } else if (RowOf(fault.kind).of_packets() && injection.hits == 0 &&
               injection.applied == injection.ended) {  // else a start died with its count
      add("it hit no packet");
    }
  }
  return lines;
}

bool FaultInjector::foreign() const {
  return std::any_of(injections_.begin(), injections_.end(), [](const Injection& injection) {
    return injection.fault.kind == FaultKind::kForeign && injection.phase == Phase::kActive;
  });
}

}  // namespace muster::tools
