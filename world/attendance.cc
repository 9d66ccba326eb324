#include "world/attendance.h"

#include <fmt/format.h>

#include "base/check.h"
#include "model/agent.h"

namespace muster::world {

Attendance::Attendance(const Scenario& scenario, Peers peers) : peers_(std::move(peers)) {
  for (const AgentKind kind : kAgentKinds) {
    seats_[kind].resize(scenario.agents(kind).size());
    missing_ += seats_[kind].size();
  }
}

bool Attendance::MayReport(AgentKind kind, std::int32_t id, const std::string& process) const {
  const std::string& owner = OwnerOf(kind, id);
  if (owner.empty() || owner == process) return true;
  if (!peers_.introduced(process)) return false;
  if (!peers_.introduced(owner)) return true;
  throw InputError(fmt::format("{} {} is reported by two processes, {} and {}: give each its --ids",
                               ToString(kind), id, owner, process));
}

bool Attendance::Report(AgentKind kind, std::int32_t id, const std::string& process) {
  Seat& seat = SeatOf(kind, id);
  if (!seat.owner.empty() && seat.owner != process) Leave(seat.owner);
  if (seat.owner != process) seat.owner = process;
  if (newest_member_ != process) Join(process);
  if (seat.heard != Heard::kNot) return false;
  seat.heard = Heard::kYes;
  --missing_;
  return true;
}

void Attendance::StartTick() {
  missing_ = 0;
  for (const AgentKind kind : kAgentKinds) {
    for (Seat& seat : seats_[kind]) seat.heard = Heard::kNot;
    missing_ += seats_[kind].size();
  }
  for (const std::string& process : peers_.NamesOf(Peers::Presence::kLost)) {
    ForEachAgentOf(process, [&](AgentKind kind, std::int32_t id) { Excuse(kind, id); });
  }
}

std::set<std::string> Attendance::Owing() const {
  std::set<std::string> owing;
  for (const AgentKind kind : kAgentKinds) {
    for (const Seat& seat : seats_[kind]) {
      if (seat.heard == Heard::kNot) owing.insert(seat.owner);
    }
  }
  return owing;
}

void Attendance::Excuse(AgentKind kind, std::int32_t id) {
  Seat& seat = SeatOf(kind, id);
  if (seat.heard == Heard::kNot) --missing_;
  seat.heard = Heard::kNotAwaited;
}

bool Attendance::Lose(const std::string& process) {
  const bool was_there = peers_.presence(process) == Peers::Presence::kThere;
  peers_.set_presence(process, Peers::Presence::kLost);
  // Agents that have reported for this tick need no excuse.
  ForEachAgentOf(process, [&](AgentKind kind, std::int32_t id) {
    if (!reported(kind, id)) Excuse(kind, id);
  });
  return was_there;
}

std::vector<std::string> Attendance::TakeBack() {
  std::vector<std::string> back;
  for (const std::string& process : peers_.NamesOf(Peers::Presence::kReturning)) {
    std::size_t agents = 0, heard = 0;
    ForEachAgentOf(process, [&](AgentKind kind, std::int32_t id) {
      ++agents;
      heard += reported(kind, id);
    });
    if (agents == 0 || heard < agents) continue;
    peers_.set_presence(process, Peers::Presence::kThere);
    back.push_back(process);
  }
  return back;
}

}  // namespace muster::world
