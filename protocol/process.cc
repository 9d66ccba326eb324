#include "protocol/process.h"

#include <algorithm>
#include <utility>

#include "lcmtypes/channels.h"

namespace muster {

Process::Process(const Identity& identity, Window window)
    : sender_(identity, window), inbox_(identity.run_id, identity.name, identity.boot_id) {}

void Process::Step(const std::vector<Packet>& arrived, const Now& now, std::vector<Packet>* out) {
  for (const Packet& packet : arrived) {
    const std::optional<Message> message = inbox_.Open(packet);
    if (message) Take(*message, packet, now);
  }
  OnStep(now);
  sender_.Flush(now, out);
  SayUnlogged(now, out);
}

void Process::Step(const Packet& packet, const std::optional<Message>& message, const Now& now,
                   std::vector<Packet>* out) {
  if (inbox_.Admit(packet, message)) Take(*message, packet, now);
  OnStep(now);
  sender_.Flush(now, out);
  SayUnlogged(now, out);
}

void Process::Compute(const std::function<void()>& computation) {
  if (!run_long_) return computation();
  const ProcessState before = std::exchange(state_, ProcessState::kDeciding);
  run_long_(computation);
  state_ = before;
}

void Process::Beat(std::vector<Packet>* arrived, const Usage& usage, const Now& now,
                   std::vector<Packet>* out) {
  std::erase_if(*arrived, [&](const Packet& packet) {
    if (packet.channel != channel::kLog) return false;
    const std::optional<Message> message = inbox_.Open(packet);
    if (message) sender_.Acknowledge(std::get<log_status_t>(*message));
    return true;
  });
  ReportStatus(usage, now);
  sender_.Flush(now, out);
}

void Process::Take(const Message& message, const Packet& packet, const Now& now) {
  const auto* marks = std::get_if<log_status_t>(&message);
  if (marks != nullptr && packet.channel == channel::kLog) sender_.Acknowledge(*marks);
  OnMessage(message, packet, now);
}

void Process::Request(std::string_view channel, TimeUs sim_us, const Now& now) {
  questions_.try_emplace(std::string(channel), sender_.next_seq());
  request_t request{};
  request.channel = channel;
  sender_.Send(channel::kRequest, std::move(request), sim_us, now);
}

bool Process::Answers(const answer_t& answer) const {
  const auto question = questions_.find(answer.channel);
  return question != questions_.end() && answer.asker == identity().name &&
         answer.asker_boot_id == identity().boot_id && answer.asker_seq >= question->second &&
         answer.asker_seq < sender_.next_seq();
}

answer_t AnswerTo(const request_t& request, std::int64_t tick, std::vector<std::uint8_t> message) {
  answer_t answer{};
  answer.asker = request.header.sender;
  answer.asker_boot_id = request.header.boot_id;
  answer.asker_seq = request.header.seq;
  answer.channel = request.channel;
  answer.tick = tick;
  answer.data = std::move(message);
  answer.n = static_cast<std::int32_t>(answer.data.size());
  return answer;
}

void Process::Answer(const request_t& request, std::int64_t tick, std::vector<std::uint8_t> message,
                     TimeUs sim_us, const Now& now) {
  sender_.Send(channel::kAnswer, AnswerTo(request, tick, std::move(message)), sim_us, now);
}

TimeUs Process::wake_us() const { return std::min(OwnWakeUs(), sender_.wake_us()); }

void Process::Announce(event_t event, const Now& now) {
  sender_.Send(channel::kEvent, std::move(event), sim_us_, now);
}

void Process::ReportStatus(const Usage& usage, const Now& now) {
  process_status_t status{};
  status.name = identity().name;
  status.host = usage.host;
  status.pid = usage.pid;
  status.state = static_cast<std::int8_t>(state_);
  status.tick = tick();
  status.received = inbox_.counters().received;
  status.lost = lost();
  status.rejected = rejected();
  status.resent = sender_.resent();
  status.cpu_s = usage.cpu_s;
  status.rss_bytes = usage.rss_bytes;
  sender_.Send(channel::kProcess, std::move(status), sim_us_, now);
}

}  // namespace muster
