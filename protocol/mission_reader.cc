#include "protocol/mission_reader.h"

#include "base/check.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"

namespace muster {
namespace {

std::optional<Scenario> ScenarioOf(const scenario_t& message) {
  try {
    return ParseScenario(message.json, "MUSTER_SCENARIO");
  } catch (const InputError&) {
    return {};
  }
}

}  // namespace

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
  const auto* scenario = std::get_if<scenario_t>(&*message);
  if (scenario != nullptr && row->AcceptsFrom(scenario->header.sender)) {
    if (const std::optional<Scenario> base = ScenarioOf(*scenario)) {
      book_.emplace(*base);
      reports_.emplace(book_->scenario());
      run_id_ = run_id;
      Take(*message, packet, visit);
      for (const auto& [held, held_packet] : std::exchange(held_back_, {})) {
        Take(held, held_packet, visit);
      }
      return;
    }
    Reject();
  }
  if (held_back_.size() < kMostHeldBack) {
    held_back_.emplace_back(std::move(*message), packet);
  } else {
    overflowed_ = true;
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
