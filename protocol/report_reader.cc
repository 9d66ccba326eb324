#include "protocol/report_reader.h"

#include <algorithm>

namespace muster {

ReportReader::ReportReader(const std::shared_ptr<const Scenario>& scenario)
    : told_{ToldAgents(scenario, AgentKind::kUav), ToldAgents(scenario, AgentKind::kWorker),
            ToldAgents(scenario, AgentKind::kVehicle)} {}

void ReportReader::Add(const Message& report, const Packet& packet, const IntervalSet& seqs,
                       const Visit& visit) {
  const header_t& header = HeaderOf(report);
  Start& start = starts_[{header.sender, header.boot_id}];
  start.newest = std::max(start.newest, header.seq);
  start.next = std::max(start.next, start.newest - kMostBack);
  while (seqs.Contains(start.next)) ++start.next;
  if (const auto* whole = std::get_if<agent_states_t>(&report)) visit(*whole, packet);
  if (!Read(&start, report, packet, visit)) start.held.emplace(header.seq, Held{report, packet});
  if (!start.held.empty()) ReadHeld(&start, visit);
  if (start.next >= start.before_seq) start.before.reset();
}

void ReportReader::ReadHeld(Start* start, const Visit& visit) {
  std::erase_if(start->held, [&](const auto& held) {
    return held.first < start->newest - kMostBack ||
           Read(start, held.second.report, held.second.packet, visit);
  });
}

bool ReportReader::Read(Start* start, const Message& report, const Packet& packet,
                        const Visit& visit) {
  const std::int64_t seq = HeaderOf(report).seq;
  const bool is_before = start->before && seq < start->before_seq;
  const auto told_of = [&](std::int8_t kind) -> ToldAgents& {
    return is_before ? *start->before : told_[static_cast<AgentKind>(kind)];
  };
  if (const auto* whole = std::get_if<agent_states_t>(&report)) {
    ToldAgents& told = told_of(whole->kind);
    if (!start->before && start->next < seq) {
      start->before = told;
      start->before_seq = seq;
    }
    told.Take(*whole);
    return true;
  }
  const auto& changes = std::get<agent_changes_t>(report);
  ToldAgents& told = told_of(changes.kind);
  if (const auto states = told.Expand(changes)) {
    visit(*states, packet);
    return true;
  }
  if (told.Possible(changes)) return false;
  ++impossible_;
  return true;
}

}  // namespace muster
