#include "tools/audit/intake.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <string_view>

#include "lcmtypes/channels.h"
#include "tools/audit/values.h"

namespace muster::tools::audit {
namespace {

/// Ticks that may wait for an earlier one. Lockstep and the logger's window keep this under ten.
constexpr std::size_t kMaxPending = 256;
/// A resend is looked for among this many messages.
constexpr std::size_t kRecent = 4096;

std::size_t HashOf(const std::vector<std::uint8_t>& bytes) {
  return std::hash<std::string_view>()({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

int ClassOf(std::string_view channel) {
  return channel == channel::kUavs || channel == channel::kUavChanges         ? kUav
         : channel == channel::kWorkers || channel == channel::kWorkerChanges ? kWorker
                                                                              : kVehicle;
}

bool SameAltitudes(const clearances_t& a, const clearances_t& b) {
  clearances_t x = a, y = b;
  x.header = y.header = header_t{};
  return Encode(x) == Encode(y);
}

bool SameActions(const schedule_t& a, const schedule_t& b) {
  schedule_t x = a, y = b;
  for (schedule_t* s : {&x, &y}) {
    s->header = header_t{};
    s->solve_us = 0;
  }
  return Encode(x) == Encode(y);
}

}  // namespace

std::size_t DecisionHash(schedule_t schedule, const clearances_t* clearances) {
  schedule.header = header_t{};
  schedule.solve_us = 0;
  std::vector<std::uint8_t> bytes = Encode(schedule);
  if (clearances != nullptr) {
    clearances_t altitudes = *clearances;
    altitudes.header = header_t{};
    const std::vector<std::uint8_t> more = Encode(altitudes);
    bytes.insert(bytes.end(), more.begin(), more.end());
  }
  return HashOf(bytes);
}

template <class Message>
std::optional<Message> Intake::Admit(const Packet& packet) {
  std::optional<Message> message = DecodeValid<Message>(packet.bytes);
  if (!message) {
    ++heard_.undecodable;
    return {};
  }
  const header_t& header = message->header;
  if (!run_id_) run_id_ = header.run_id;
  if (header.run_id != *run_id_) return {};
  Sender& sender = senders_[{header.sender, header.boot_id}];
  const std::tuple key(header.sender, header.boot_id, header.seq);
  const std::size_t hash = HashOf(packet.bytes);
  if (!sender.seqs.Add(header.seq)) {
    ++heard_.duplicates;
    const auto known = recent_.find(key);
    if (known != recent_.end() && known->second != hash) {
      findings_->Add(header.sim_us, "seq",
                     "{} (start {}) used seq {} for two different messages, the second on {}",
                     header.sender, header.boot_id, header.seq, packet.channel);
    }
    return {};
  }
  recent_.emplace(key, hash);
  recent_order_.push_back(key);
  if (recent_order_.size() > kRecent) {
    recent_.erase(recent_order_.front());
    recent_order_.pop_front();
  }
  sender.last_sim_us = std::max(sender.last_sim_us, header.sim_us);
  ++heard_.messages;
  return message;
}

void Intake::Take(const Packet& packet) {
  const std::string& name = packet.channel;
  const auto keep = [&]<class Message>(std::optional<Message> TickFacts::*part) {
    auto m = Admit<Message>(packet);
    TickFacts* facts = m ? FactsOf(m->tick) : nullptr;
    if (facts != nullptr && !(facts->*part)) facts->*part = std::move(*m);
  };
  if (name == channel::kScenario) {
    if (const auto m = Admit<scenario_t>(packet)) TakeScenario(*m);
  } else if (name == channel::kRoads) {
    if (const auto m = Admit<roads_t>(packet)) TakeRoads(*m);
  } else if (name == channel::kClock) {
    const auto m = Admit<clock_t>(packet);
    if (m && m->phase == ClockPhase::kEnded) ended_ = true;
    if (m) heard_.clock_sender = m->header.sender;
    if (m && m->phase == ClockPhase::kRunning) {
      if (TickFacts* facts = FactsOf(m->tick)) facts->clock = *m;
    }
  } else if (name == channel::kOrders) {
    if (auto m = Admit<orders_t>(packet)) TakeOrders(std::move(*m));
  } else if (name == channel::kUavs || name == channel::kWorkers || name == channel::kVehicles) {
    if (const auto m = Admit<agent_states_t>(packet)) TakeStates(*m, ClassOf(name));
  } else if (IsReports(name)) {
    if (const auto m = Admit<agent_changes_t>(packet)) TakeChanges(*m, ClassOf(name));
  } else if (name == channel::kSchedule) {
    if (const auto m = Admit<schedule_t>(packet)) TakeSchedule(*m);
  } else if (name == channel::kClearances) {
    if (const auto m = Admit<clearances_t>(packet)) TakeClearances(*m);
  } else if (name == channel::kProposal) {
    if (const auto m = Admit<proposal_t>(packet)) {
      heard_.proposals[m->schedule.decision][m->header.sender].insert(
          DecisionHash(m->schedule, m->clearances.empty() ? nullptr : &m->clearances.front()));
    }
  } else if (name == channel::kEvent) {
    if (auto m = Admit<event_t>(packet)) heard_.events.push_back(std::move(*m));
  }
  if (name == channel::kWorld) keep(&TickFacts::world);
  if (name == channel::kRulings) keep(&TickFacts::rulings);
  if (name == channel::kDriver) Admit<event_t>(packet);
  if (name == channel::kFault) Admit<fault_t>(packet);
  if (name == channel::kProcess) Admit<process_status_t>(packet);
  if (name == channel::kOrder) Admit<order_t>(packet);
  if (name == channel::kLog || name == channel::kCopy) Admit<log_status_t>(packet);
  if (name == channel::kRequest) Admit<request_t>(packet);
  if (name == channel::kRestore) Admit<restore_t>(packet);
  if (name == channel::kAnswer) Admit<answer_t>(packet);
}

void Intake::TakeScenario(const scenario_t& message) {
  if (heard_.scenario) {
    if (message.sha256 != heard_.sha256) {
      findings_->Add(message.header.sim_us, "scenario", "the log holds two different scenarios");
    }
    return;
  }
  try {
    if (NamesRoads(message.json) && !roads_) {
      waits_for_roads_ = message;
      return;
    }
    heard_.scenario = ParseScenario(message.json, roads_ ? roads_->roads : "");
  } catch (const std::exception& error) {
    findings_->Add(0, "scenario", "the log's scenario cannot be read: {}", error.what());
    return;
  }
  heard_.sha256 = message.sha256;
  if (Sha256Of(message.json) != heard_.sha256) {
    findings_->Add(0, "scenario", "sha256 is {}, the message says {}", Sha256Of(message.json),
                   heard_.sha256);
  }
}

void Intake::TakeRoads(const roads_t& message) {
  if (roads_) {
    if (message.sha256 != roads_->sha256) {
      findings_->Add(message.header.sim_us, "scenario",
                     "the log holds two different road networks");
    }
    return;
  }
  roads_ = message;
  if (waits_for_roads_) TakeScenario(*std::exchange(waits_for_roads_, std::nullopt));
}

TickFacts* Intake::FactsOf(std::int64_t tick) {
  if (tick < 0 || tick > heard_.scenario->last_tick()) {
    findings_->Add(now_us_, "lockstep", "a message names tick {}, the last is {}", tick,
                   heard_.scenario->last_tick());
    return nullptr;
  }
  if (tick < next_tick_ || stopped_) return nullptr;
  TickFacts& facts = pending_[tick];
  for (const int kind : kClasses) facts.reports[kind].resize(heard_.scenario->agents[kind].size());
  return &facts;
}

bool Intake::CanReport(int said, int kind, std::int64_t tick, TickFacts** facts) {
  if (said != kind) {
    findings_->Add(heard_.scenario->TimeOf(std::clamp<std::int64_t>(tick, 0, 1 << 30)), "lockstep",
                   "agents of class {} on the channel of {}s, tick {}", said,
                   ToString<AgentKind>(kind), tick);
    return false;
  }
  *facts = FactsOf(tick);
  const bool is_late = tick >= 0 && tick < next_tick_;
  return *facts != nullptr || is_late;
}

void Intake::TakeStates(const agent_states_t& message, int kind) {
  TickFacts* facts = nullptr;
  if (!CanReport(message.kind, kind, message.tick, &facts)) return;
  for (const agent_t& agent : message.agents) {
    TakeReport({message.tick, kind, agent, -1, message.applied_decision, message.header.sender,
                message.header.boot_id},
               facts);
  }
}

void Intake::TakeChanges(const agent_changes_t& message, int kind) {
  TickFacts* facts = nullptr;
  if (!CanReport(message.kind, kind, message.tick, &facts)) return;
  const header_t& header = message.header;
  if (heard_.scenario->DecisionAt(message.tick) >= 0) {
    findings_->Add(now_us_, "lockstep",
                   "{} says only what has changed at tick {}, where a decision rests on it",
                   header.sender, message.tick);
    return;
  }
  // A range that the scenario does not have is reported once.
  const auto last = std::min<std::int64_t>(
      message.last_id, static_cast<std::int64_t>(heard_.scenario->agents[kind].size()));
  auto listed = message.agents.begin();
  for (auto id = message.first_id; id <= last; ++id) {
    Report report{message.tick,  kind,          {}, message.base_tick, message.applied_decision,
                  header.sender, header.boot_id};
    report.agent.id = id;
    if (listed != message.agents.end() && listed->id == id) {
      report.agent = *listed++;
      report.base_tick = -1;
    }
    TakeReport(report, facts);
  }
}

void Intake::TakeReport(const Report& report, TickFacts* facts) {
  const int kind = report.kind;
  const std::int64_t t = heard_.scenario->TimeOf(report.tick);
  const std::int32_t id = report.agent.id;
  if (id < 0 || static_cast<std::size_t>(id) >= heard_.scenario->agents[kind].size()) {
    findings_->Add(t, "lockstep", "{} reports {}:{}, which the scenario does not have",
                   report.sender, ToString<AgentKind>(kind), id);
    return;
  }
  if (facts == nullptr) {
    if (!stopped_) late_.push_back(report);
    return;
  }
  auto& known = facts->reports[kind][static_cast<std::size_t>(id)];
  if (!known) {
    known = report;
    return;
  }
  // A restarted process may say its last tick again.
  if (known->sender == report.sender && known->boot_id != report.boot_id) {
    facts->again[{kind, id}].push_back(report);
    return;
  }
  findings_->Add(t, "lockstep",
                 "{}:{} is reported twice for tick {}, by {} (start {}) and {} (start {})",
                 ToString<AgentKind>(kind), id, report.tick, known->sender, known->boot_id,
                 report.sender, report.boot_id);
}

/// Orders may ask for a decision, so what is said of one waits for the orders up to its tick.
void Intake::TakeOrders(orders_t message) {
  TickFacts* facts = FactsOf(message.tick);
  if (facts == nullptr ||
      (facts->orders && facts->orders->header.boot_id >= message.header.boot_id)) {
    return;
  }
  std::set<std::int64_t>& extra = heard_.scenario->extra_ticks;
  extra.erase(message.tick);
  for (const taken_order_t& taken : message.taken) {
    const nlohmann::json order = nlohmann::json::parse(taken.json, nullptr, false);
    if (order.is_object() && order.value("order", "") == "decide_now") extra.insert(message.tick);
  }
  facts->orders = std::move(message);
  while (!early_.empty() && HasOrders(early_.begin()->first)) {
    const auto early = early_.extract(early_.begin());
    for (const schedule_t& schedule : early.mapped().first) TakeSchedule(schedule);
    for (const clearances_t& clearances : early.mapped().second) TakeClearances(clearances);
  }
}

bool Intake::HasOrders(std::int64_t tick) const {
  if (!heard_.scenario->takes_orders() || tick < next_tick_ || stopped_ ||
      tick > heard_.scenario->last_tick()) {
    return true;
  }
  // The number of a decision follows from those before it.
  for (std::int64_t at = next_tick_; at <= tick; ++at) {
    const auto facts = pending_.find(at);
    if (facts == pending_.end() || !facts->second.orders) return false;
  }
  return true;
}

bool Intake::IsDue(std::int32_t decision, std::int64_t tick) const {
  if (decision < 0) return false;
  // Where the audit has stopped, it no longer knows which decisions were asked for.
  return stopped_ || (tick >= 0 && tick <= heard_.scenario->last_tick() &&
                      heard_.scenario->DecisionAt(tick) == decision);
}

void Intake::TakeSchedule(const schedule_t& message) {
  if (!HasOrders(message.tick)) return early_[message.tick].first.push_back(message);
  const std::int32_t d = message.decision;
  const std::int64_t t =
      heard_.scenario->TimeOf(std::clamp<std::int64_t>(message.tick, 0, 1 << 30));
  if (!IsDue(d, message.tick)) {
    findings_->Add(t, "lockstep",
                   "a schedule names decision {} at tick {}, where none or another is due", d,
                   message.tick);
    return;
  }
  const auto [known, is_new] = heard_.schedules.try_emplace(d, message);
  if (!is_new && !SameActions(known->second, message)) {
    findings_->Add(t, "lockstep",
                   "decision {} was made twice and differently, by {} (start {}, seq {}) and "
                   "{} (start {}, seq {})",
                   d, known->second.header.sender, known->second.header.boot_id,
                   known->second.header.seq, message.header.sender, message.header.boot_id,
                   message.header.seq);
  }
}

void Intake::TakeClearances(const clearances_t& message) {
  if (!HasOrders(message.tick)) return early_[message.tick].second.push_back(message);
  const std::int64_t t =
      heard_.scenario->TimeOf(std::clamp<std::int64_t>(message.tick, 0, 1 << 30));
  if (!heard_.scenario->separation || !IsDue(message.decision, message.tick)) {
    findings_->Add(t, "separation", "altitudes of decision {} at tick {}, where none are due",
                   message.decision, message.tick);
    return;
  }
  const auto [known, is_new] = heard_.clearances.try_emplace(message.decision, message);
  if (!is_new && !SameAltitudes(known->second, message)) {
    findings_->Add(t, "separation", "decision {} gave altitudes twice and differently",
                   message.decision);
  }
}

bool Intake::Complete(const TickFacts& facts) const {
  if (!facts.clock || !facts.world || !facts.rulings) return false;
  if (heard_.scenario->takes_orders() &&
      (!facts.orders || facts.orders->header.boot_id < facts.world->header.boot_id)) {
    return false;
  }
  if (const std::int32_t due = heard_.scenario->DecisionAt(next_tick_); due >= 0) {
    const std::optional<bool> in_force = InForce();
    if (!in_force || (*in_force && !heard_.schedules.contains(due))) return false;
    if (*in_force && heard_.scenario->separation && !heard_.clearances.contains(due)) return false;
  }
  const bool is_long_ago = ended_ || pending_.contains(next_tick_ + 2);
  for (const int kind : kClasses) {
    for (std::size_t id = 0; id < facts.reports[kind].size(); ++id) {
      if (facts.reports[kind][id]) continue;
      // Only a lost process's agents have no report: the world rules that they failed. One that had
      // failed before its process was lost has none either; else its report may be on its way.
      const auto lost = [&](const ruling_t& r) {
        return r.agent_kind == kind && r.agent_id == static_cast<int>(id) &&
               (r.kind == RulingKind::kLost || (r.kind == RulingKind::kFailed && is_long_ago));
      };
      if (std::none_of(facts.rulings->rulings.begin(), facts.rulings->rulings.end(), lost)) {
        return false;
      }
    }
  }
  return true;
}

std::optional<bool> Intake::InForce() const {
  const auto next = pending_.find(next_tick_ + 1);
  if (next == pending_.end() || !next->second.clock) return {};
  // A world that starts again may pass over a decision that its earlier start had put into force,
  // when no agent has gone on with it. The clock before the first report is the one that holds.
  const auto is_told = [](const auto& reports) {
    return std::any_of(reports.begin(), reports.end(), [](const auto& one) { return bool(one); });
  };
  const TickFacts& facts = next->second;
  const bool holds = ended_ || pending_.contains(next_tick_ + 2) ||
                     std::any_of(std::begin(facts.reports), std::end(facts.reports), is_told);
  if (!holds) return {};
  return facts.clock->required_decision >= heard_.scenario->DecisionAt(next_tick_);
}

std::string Intake::WhatIsMissing() const {
  const auto found = pending_.find(next_tick_);
  const TickFacts none;
  const TickFacts& facts = found == pending_.end() ? none : found->second;
  std::string text;
  const auto add = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (!facts.clock) add("clock_t");
  if (!facts.world) add("world_state_t");
  if (!facts.rulings) add("rulings_t");
  if (heard_.scenario->takes_orders() && !facts.orders) add("orders_t");
  const std::int32_t due = heard_.scenario->DecisionAt(next_tick_);
  if (due >= 0 && !heard_.schedules.contains(due))
    add(fmt::format("schedule_t of decision {}", due));
  if (due >= 0 && heard_.scenario->separation && !heard_.clearances.contains(due))
    add(fmt::format("clearances_t of decision {}", due));
  if (due >= 0 && !InForce()) {
    const auto next = pending_.find(next_tick_ + 1);
    const bool has_clock = next != pending_.end() && next->second.clock;
    add(fmt::format("{} of tick {}", has_clock ? "a report" : "clock_t", next_tick_ + 1));
  }
  for (const int kind : kClasses) {
    for (std::size_t id = 0; id < heard_.scenario->agents[kind].size(); ++id) {
      if (facts.reports[kind].empty() || !facts.reports[kind][id]) {
        add(fmt::format("state of {}:{}", ToString<AgentKind>(kind), id));
        break;  // one of a class is enough to say
      }
    }
  }
  return fmt::format("tick {} lacks: {}", next_tick_, text);
}

const TickFacts* Intake::Next() {
  const auto next = pending_.find(next_tick_);
  if (next != pending_.end() && Complete(next->second)) {
    now_us_ = heard_.scenario->TimeOf(next_tick_);
    return &next->second;
  }
  if (pending_.size() > kMaxPending) {
    findings_->Add(heard_.scenario->TimeOf(next_tick_), "lockstep", "{}", WhatIsMissing());
    Stop();
  }
  return nullptr;
}

const schedule_t* Intake::ScheduleOfNext() const {
  const std::int32_t due = heard_.scenario->DecisionAt(next_tick_);
  return due >= 0 && *InForce() ? &heard_.schedules.at(due) : nullptr;
}

const clearances_t* Intake::ClearancesOfNext() const {
  const std::int32_t due = heard_.scenario->DecisionAt(next_tick_);
  const bool keeps_apart = heard_.scenario->separation.has_value();
  return due >= 0 && keeps_apart && *InForce() ? &heard_.clearances.at(due) : nullptr;
}

void Intake::Drop() { pending_.erase(next_tick_++); }

void Intake::Stop() {
  stopped_ = true;
  pending_.clear();
}

void Intake::Finish() {
  if (!stopped_ && next_tick_ <= heard_.scenario->last_tick()) {
    breaks_off_ = !ended_ && (pending_.empty() || pending_.rbegin()->first <= next_tick_ + 1);
    findings_->Add(heard_.scenario->TimeOf(next_tick_), "lockstep", "{}", WhatIsMissing());
    Stop();
  }
  if (!ended_) {
    findings_->Add(heard_.scenario->limit_us, "lockstep",
                   "no clock_t of phase 2 announces the end");
  }
  for (const auto& [start, sender] : senders_) {
    const auto missing = sender.seqs.Missing(0, sender.seqs.max());
    for (const IntervalSet::Range& gap : missing) {
      findings_->Add(sender.last_sim_us, "seq", "{} (start {}) lacks seq {} to {} of 0 to {}",
                     start.first, start.second, gap.first, gap.last, sender.seqs.max());
    }
  }
  // A later start of the world may say in other words what an earlier one has said.
  const auto world_of = [](const event_t& event) {
    return event.header.sender == kWorld ? event.header.boot_id : -1;
  };
  std::sort(heard_.events.begin(), heard_.events.end(), [&](const event_t& a, const event_t& b) {
    return std::tuple(KeyOf(a), a.fault_id, world_of(a), a.detail) <
           std::tuple(KeyOf(b), b.fault_id, world_of(b), b.detail);
  });
  heard_.events.erase(
      std::unique(heard_.events.begin(), heard_.events.end(),
                  [&](const event_t& a, const event_t& b) {
                    return KeyOf(a) == KeyOf(b) && a.fault_id == b.fault_id &&
                           (a.detail == b.detail ||
                            (a.header.sender == b.header.sender && world_of(a) != world_of(b)));
                  }),
      heard_.events.end());
}

}  // namespace muster::tools::audit
