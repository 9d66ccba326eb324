#include "recorder/archive.h"

#include <algorithm>
#include <set>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "protocol/convert.h"
#include "protocol/process.h"
#include "world/restoring.h"

namespace muster::recorder {
namespace {

/// Ticks kept. The newest may have been told in part, and it takes the verdict on the one before.
constexpr std::size_t kTicks = 4;
/// A damaged name makes a sender that is none.
constexpr std::size_t kMostSources = 1000;
constexpr TimeUs kPatienceUs = 2 * kSecondUs;
constexpr TimeUs kAgainUs = kSecondUs / 2;

bool IsOfWorld(std::string_view name) {
  return name == channel::kWorld || name == channel::kRulings || name == channel::kClock;
}
bool IsStates(std::string_view name) {
  return name == channel::kUavs || name == channel::kWorkers || name == channel::kVehicles;
}

request_t QuestionFor(std::string_view channel) {
  request_t question{};
  question.channel = channel;
  return question;
}

}  // namespace

Archive::Archive(const Scenario& scenario, std::int64_t run_id, bool goes_on)
    : book_(scenario),
      scenario_(*book_.scenario()),
      run_id_(run_id),
      goes_on_(goes_on),
      reports_(book_.scenario()) {}

void Archive::Add(const Packet& packet) {
  if (IsReports(packet.channel)) return AddReport(packet);
  if (packet.channel == channel::kSchedule) {
    const auto schedule = DecodeValid<schedule_t>(packet.bytes);
    if (!schedule || schedule->header.run_id != run_id_ || schedule->decision < newest_decision_ ||
        !Possible(*schedule, scenario_)) {
      return;
    }
    newest_decision_ = schedule->decision;
    schedule_ = packet;
    return;
  }
  if (packet.channel == channel::kClearances) {
    const auto clearances = DecodeValid<clearances_t>(packet.bytes);
    if (!clearances || clearances->header.run_id != run_id_ || !Possible(*clearances, scenario_)) {
      return;
    }
    clearances_[clearances->decision] = packet;
    if (clearances_.size() > kTicks) clearances_.erase(clearances_.begin());
    return;
  }
  if (packet.channel == channel::kOrders && book_.takes_orders()) {
    const auto orders = DecodeValid<orders_t>(packet.bytes);
    // One that cannot be is nothing to keep.
    if (orders && orders->header.run_id == run_id_) static_cast<void>(book_.Take(*orders));
    return;
  }
  if (!IsOfWorld(packet.channel)) return;
  const std::optional<header_t> header = DecodeHeader(packet);
  if (header && header->run_id == run_id_) Keep(packet.channel, *header, {packet.bytes, {}});
}

void Archive::AddReport(const Packet& packet) {
  // Most come twice: from the bus, and from the log.
  const std::optional<header_t> said = DecodeHeader(packet);
  if (!said) return;
  const auto known = seqs_.find({said->sender, said->boot_id});
  if (known != seqs_.end() && known->second.Contains(said->seq)) return;
  const std::optional<Message> report = DecodeMessage(packet);
  if (!report) return;
  const header_t& header = HeaderOf(*report);
  const std::pair start(header.sender, header.boot_id);
  if (header.run_id != run_id_ || (seqs_.size() >= kMostSources && !seqs_.contains(start))) return;
  IntervalSet& seqs = seqs_[start];
  if (!seqs.Add(header.seq)) return;
  reports_.Add(*report, packet, seqs, [&](const agent_states_t& states, const Packet& as_said) {
    if (IsStates(as_said.channel)) {
      Keep(as_said.channel, states.header, {as_said.bytes, {}});
    } else {
      Keep(ChannelOf(static_cast<AgentKind>(states.kind)), states.header, {{}, states});
    }
  });
}

void Archive::Keep(std::string_view channel, const header_t& header, const Kept& kept) {
  if (header.sim_us < 0 || header.sim_us > scenario_.rules.limit_us) return;
  const Source source{std::string(channel), header.sender};
  if (told_.size() >= kMostSources && !told_.contains(source)) return;
  const TimeUs tick_us = scenario_.rules.tick_us;
  Told& told = told_[source];
  told[(header.sim_us + tick_us - 1) / tick_us].try_emplace({header.boot_id, header.seq}, kept);
  Forget(source, &told);
}

template <class Visit>
void Archive::ForEachMessage(const Messages& messages, Visit visit) {
  for (const auto& [id, kept] : messages) {
    if (!kept.states) {
      visit(kept.bytes);
      continue;
    }
    for (const agent_states_t& part : PartsOf(*kept.states)) visit(Encode(part));
  }
}

void Archive::Forget(const Source& source, Told* told) const {
  // What became of lost agents is in the verdicts about their last report. That may be in part one
  // tick newer than what counted.
  const auto is_of_lost = [&](std::int64_t tick) {
    return IsOfWorld(source.channel) &&
           std::any_of(told_.begin(), told_.end(), [&](const auto& other) {
             if (!IsStates(other.first.channel)) return false;
             const std::int64_t last = other.second.rbegin()->first;
             return last - 1 <= tick && tick <= last + 1;
           });
  };
  auto oldest = told->begin();
  for (std::size_t n = told->size(); n > kTicks; --n) {
    oldest = is_of_lost(oldest->first) ? std::next(oldest) : told->erase(oldest);
  }
}

template <class Visit>
void Archive::ForEachReport(const Told& told, std::int64_t tick, Visit visit) const {
  for (const auto& [t, messages] : told) {
    if (t == tick || (goes_on_ && t < tick)) visit(t, messages);
  }
}

std::optional<std::int64_t> Archive::Consistent() const {
  std::set<std::int64_t, std::greater<>> ticks;
  for (const auto& [source, told] : told_) {
    for (const auto& [tick, messages] : told) ticks.insert(tick + IsOfWorld(source.channel));
  }
  for (const std::int64_t tick : ticks) {
    world::Restoring restoring(scenario_, run_id_);
    for (const auto& [source, told] : told_) {
      const std::string& name = source.channel;
      const auto take = [&](std::int64_t t, const Messages& messages) {
        ForEachMessage(messages, [&](const std::vector<std::uint8_t>& bytes) {
          // An impossible one is missing below.
          static_cast<void>(restoring.Take(AnswerTo(QuestionFor(name), t, bytes)));
        });
      };
      if (IsOfWorld(source.channel)) {
        for (const auto& [t, messages] : told) take(t, messages);
      } else {
        ForEachReport(told, tick, take);
      }
    }
    const auto state = goes_on_ ? restoring.NewestWithoutLost() : restoring.Newest();
    if (state && state->tick == tick) return tick;
  }
  return {};
}

bool Archive::AnswersAtOnce(const request_t& request) const {
  return request.channel == channel::kSchedule || request.channel == channel::kClearances ||
         (goes_on_ && request.header.sender == process_name::kWorld);
}

std::vector<answer_t> Archive::Answer(const request_t& request, TimeUs now_us) {
  if (request.channel == channel::kSchedule && schedule_) {
    return {AnswerTo(request, 0, schedule_->bytes)};
  }
  if (request.channel == channel::kClearances) {
    std::vector<answer_t> answers;
    for (const auto& [decision, packet] : clearances_) {
      answers.push_back(AnswerTo(request, decision, packet.bytes));
    }
    return answers;
  }
  const bool of_orders = request.channel == channel::kOrders && book_.takes_orders();
  if (!IsStates(request.channel) && !IsOfWorld(request.channel) && !of_orders) return {};
  Question& question = questions_[{request.header.sender, request.header.boot_id, request.channel}];
  if (question.asked_us == kNever || now_us - question.asked_us > kPatienceUs) {
    question.since_us = now_us;
  }
  question.asked_us = now_us;
  const bool has_begun = std::any_of(told_.begin(), told_.end(), [](const auto& source) {
    return source.first.channel == channel::kWorld;
  });
  const bool at_once = has_begun && AnswersAtOnce(request);
  const TimeUs patience_us = at_once ? 0 : kPatienceUs;
  if (now_us - question.since_us < patience_us || now_us - question.answered_us < kAgainUs) {
    return {};
  }
  question.answered_us = now_us;
  if (of_orders) {
    const Identity us{run_id_, process_name::kLauncher, 0};
    return {AnswerTo(request, book_.tick(), BookBytes(book_, us))};
  }

  const std::optional<std::int64_t> consistent =
      at_once ? scenario_.rules.last_tick() : Consistent();
  if (!consistent && has_begun) return {};
  std::vector<answer_t> answers;
  if (!consistent) {  // the mission has not begun
    if (!IsStates(request.channel)) return {};
    answers.push_back(AnswerTo(request, -1, {}));
    return answers;
  }
  const auto answer = [&](std::int64_t tick, const Messages& messages) {
    ForEachMessage(messages, [&](const std::vector<std::uint8_t>& bytes) {
      answers.push_back(AnswerTo(request, tick, bytes));
    });
  };
  for (const auto& [source, told] : told_) {
    if (source.channel != request.channel) continue;
    if (IsOfWorld(source.channel)) {
      for (const auto& [tick, messages] : told) answer(tick, messages);
    } else if (told.contains(*consistent) || request.header.sender != source.sender) {
      // Where its agents stand now is for the world to tell a lost process itself.
      ForEachReport(told, *consistent, answer);
    }
  }
  return answers;
}

}  // namespace muster::recorder
