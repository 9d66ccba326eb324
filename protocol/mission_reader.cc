#include "protocol/mission_reader.h"

#include <algorithm>

#include "lcmtypes/channels.h"

namespace muster {

void MissionReader::Add(const Packet& packet, const Visit& visit) {
  const Channel* row = FindChannel(packet.channel);
  if (row == nullptr) {
    ++counts_.foreign;
    return;
  }
  std::optional<Message> message = DecodeMessage(packet);
  if (!message) return Reject();
  const std::int64_t run_id = HeaderOf(*message).run_id;
  heard_run_id_ = run_id;
  if (book_) return Take(*message, packet, visit);
  if (run_id_ && run_id != *run_id_) {
    ++counts_.strangers;
    return;
  }
  auto outcome = ScenarioReader::Outcome::kNothing;
  if (row->AcceptsFrom(HeaderOf(*message).sender)) outcome = scenario_reader_.Take(*message);
  if (outcome == ScenarioReader::Outcome::kRejected) Reject();
  if (outcome == ScenarioReader::Outcome::kWaits) run_id_ = run_id;
  if (outcome == ScenarioReader::Outcome::kWhole) {
    run_id_ = run_id;
    return Begin(std::move(*message), packet, visit);
  }
  if (held_back_.size() < kMostHeldBack) {
    held_back_.emplace_back(std::move(*message), packet);
  } else {
    overflowed_ = true;
  }
}

void MissionReader::Begin(Message message, const Packet& packet, const Visit& visit) {
  book_.emplace(scenario_reader_.scenario());
  scenario_reader_ = {};
  reports_.emplace(book_->scenario());
  held_back_.emplace_back(std::move(message), packet);
  // The scenario first: the newest, if it was told before its roads.
  const auto scenario = std::find_if(held_back_.rbegin(), held_back_.rend(), [](const auto& held) {
    return std::holds_alternative<scenario_t>(held.first);
  });
  std::rotate(held_back_.begin(), std::prev(scenario.base()), scenario.base());
  for (const auto& [held, held_packet] : std::exchange(held_back_, {})) {
    Take(held, held_packet, visit);
  }
}

void MissionReader::Take(const Message& message, const Packet& packet, const Visit& visit) {
  const header_t& header = HeaderOf(message);
  if (header.run_id != *run_id_) {
    ++counts_.strangers;
    return;
  }
  IntervalSet& seqs = seqs_[{header.sender, header.boot_id}];
  if (!seqs.Add(header.seq)) {
    ++counts_.duplicates;
    return;
  }
  ++counts_.messages;
  if (!FindChannel(packet.channel)->AcceptsFrom(header.sender)) return;
  if (const auto* orders = std::get_if<orders_t>(&message); orders != nullptr) {
    if (!book_->Take(*orders)) ++counts_.undecodable;
  }
  const auto* clock = std::get_if<clock_t>(&message);
  if (clock != nullptr && clock->phase != ClockPhase::kReady && !epoch_us_) {
    epoch_us_ = header.wall_us == 0 ? 0 : header.wall_us - clock->tick_us;
  }
  const bool is_report = std::holds_alternative<agent_states_t>(message) ||
                         std::holds_alternative<agent_changes_t>(message);
  if (!is_report) return visit(message, packet);
  const std::int64_t impossible = reports_->impossible();
  reports_->Add(message, packet, seqs, [&](const agent_states_t& states, const Packet& its_packet) {
    visit(Message(states), its_packet);
  });
  counts_.undecodable += reports_->impossible() - impossible;
}

}  // namespace muster
