#include "protocol/fault_switch.h"

#include <algorithm>
#include <string_view>

#include "base/text.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "protocol/fault_kinds.h"

namespace muster {
namespace {

/// A fault plan has some tens; who floods a process with ended ones gets no more memory than this.
constexpr std::size_t kMostOver = 1000;

std::set<std::string> Names(std::string_view list) {
  std::set<std::string> names;
  while (!list.empty()) {
    const std::size_t size = std::min(list.find('+'), list.size());
    if (size > 0) names.emplace(list.substr(0, size));
    list.remove_prefix(std::min(size + 1, list.size()));
  }
  return names;
}

/// The processes that `name` does not hear.
std::set<std::string> OtherSide(const std::string& target, const std::string& name) {
  const auto sides = SidesOf(target);
  if (!sides) return {};
  if (sides->first.count(name) > 0) return sides->second;
  return sides->second.count(name) > 0 ? sides->first : std::set<std::string>();
}

constexpr std::string_view kPackets = " packets";

}  // namespace

std::optional<std::pair<std::set<std::string>, std::set<std::string>>> SidesOf(
    const std::string& target) {
  const std::size_t bar = target.find('|');
  if (bar == std::string::npos) return {};
  return std::pair(Names(std::string_view(target).substr(0, bar)),
                   Names(std::string_view(target).substr(bar + 1)));
}

bool Concerns(const fault_t& fault, const std::string& name) {
  const FaultRow& row = RowOf(static_cast<FaultKind>(fault.kind));
  if (row.target == FaultTarget::kSides) return !OtherSide(fault.target, name).empty();
  return row.of_packets() && (fault.target == "*" || fault.target == name);
}

std::string HitsText(const std::string& name, std::int64_t packets) {
  return name + ": " + std::to_string(packets) + std::string(kPackets);
}

std::optional<std::int64_t> HitsOf(const std::string& text) {
  const std::size_t colon = text.rfind(": ");
  if (colon == std::string::npos || !text.ends_with(kPackets)) return {};
  return ToInteger(
      std::string_view(text).substr(colon + 2, text.size() - colon - 2 - kPackets.size()));
}

FaultSwitch::FaultSwitch(std::int64_t run_id, std::string name, LossyBus* bus,
                         std::function<std::int64_t()> rejected)
    : run_id_(run_id),
      name_(std::move(name)),
      bus_(bus),
      always_(bus->faults()),
      rejected_(std::move(rejected)) {}

std::optional<event_t> FaultSwitch::Take(const Packet& packet) {
  if (packet.channel != channel::kFault) return {};
  const auto fault = DecodeValid<fault_t>(packet.bytes);
  if (!fault || fault->header.run_id != run_id_) return {};
  return Take(*fault);
}

std::optional<event_t> FaultSwitch::Take(const fault_t& fault) {
  if (!Concerns(fault, name_)) return {};
  const bool ends = fault.for_us == 0;
  const auto active = active_.find(fault.fault_id);
  if (ends == (active == active_.end()) || (!ends && over_.contains(fault.fault_id))) return {};
  const std::int64_t hits = Hits(static_cast<FaultKind>(fault.kind));
  event_t event{};
  event.kind = NumberOf(ends ? EventKind::kFaultEnded : EventKind::kFaultApplied);
  event.at_us = fault.at_us;
  event.uav_id = event.worker_id = event.vehicle_id = event.task_id = event.charge_id = -1;
  event.fault_id = fault.fault_id;
  event.detail = ends ? HitsText(name_, hits - active->second.hits_before) : name_;
  if (ends) {
    active_.erase(active);
    if (over_.size() < kMostOver) over_.insert(fault.fault_id);
  } else {
    active_.emplace(fault.fault_id, Active{fault, hits});
  }
  SetBus();
  return event;
}

std::int64_t FaultSwitch::Hits(FaultKind kind) const {
  const FaultRow& row = RowOf(kind);
  return row.hits != nullptr ? bus_->counters().*row.hits : rejected_();
}

void FaultSwitch::SetBus() {
  PacketFaults faults = always_;
  for (const auto& [id, active] : active_) {
    const fault_t& fault = active.fault;
    const FaultRow& row = RowOf(static_cast<FaultKind>(fault.kind));
    if (row.apply != nullptr) row.apply(fault.probability, &faults);
    if (row.target == FaultTarget::kSides) faults.unheard.merge(OtherSide(fault.target, name_));
  }
  bus_->SetFaults(faults);
}

}  // namespace muster
