#include "tools/audit/auditor.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <string_view>

#include "lcmtypes/channels.h"

namespace muster::tools::audit {
namespace {

/// Ticks that may wait for an earlier one. Lockstep and the logger's window keep this under ten.
constexpr std::size_t kMaxPending = 256;
constexpr std::size_t kMaxHeldBack = 20'000;
constexpr std::size_t kMaxViolations = 1000;
/// A resend is looked for among this many messages.
constexpr std::size_t kRecent = 4096;

std::size_t HashOf(const Packet& packet) {
  const std::string_view bytes(reinterpret_cast<const char*>(packet.bytes.data()),
                               packet.bytes.size());
  return std::hash<std::string_view>()(bytes);
}

int ClassOf(std::string_view channel) {
  return channel == channel::kUavs || channel == channel::kUavChanges         ? kUav
         : channel == channel::kWorkers || channel == channel::kWorkerChanges ? kWorker
                                                                              : kVehicle;
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

EventKey KeyOf(const event_t& e) {
  return {e.at_us, e.kind, e.uav_id, e.worker_id, e.vehicle_id, e.task_id, e.charge_id};
}

std::string Name(const EventKey& key) {
  const auto& [at, kind, uav, worker, vehicle, task, charge] = key;
  std::string text = Spaced(ToString<EventKind>(kind));
  const auto add = [&text](const char* name, int id) {
    if (id >= 0) text += fmt::format(" {}:{}", name, id);
  };
  add("uav", uav);
  add("worker", worker);
  add("vehicle", vehicle);
  add("task", task);
  add("charge", charge);
  return text + fmt::format(" at {} us", at);
}

void Auditor::Violate(std::int64_t at_us, std::string invariant, std::string text) {
  ++n_violations_;
  if (violations_.size() < kMaxViolations) {
    violations_.push_back({at_us, std::move(invariant), std::move(text)});
  }
}

void Auditor::Add(const Packet& packet) {
  if (FindChannel(packet.channel) == nullptr) return;
  if (scenario_ || packet.channel == channel::kScenario) {
    Take(packet);
  } else if (held_back_.size() < kMaxHeldBack) {
    held_back_.push_back(packet);
  }
}

template <class Message>
std::optional<Message> Auditor::Admit(const Packet& packet) {
  std::optional<Message> message = DecodeValid<Message>(packet.bytes);
  if (!message) {
    ++undecodable_;
    return {};
  }
  const header_t& header = message->header;
  if (!run_id_) run_id_ = header.run_id;
  if (header.run_id != *run_id_) return {};
  Sender& sender = senders_[{header.sender, header.boot_id}];
  const std::tuple key(header.sender, header.boot_id, header.seq);
  const std::size_t hash = HashOf(packet);
  if (!sender.seqs.Add(header.seq)) {
    ++duplicates_;
    const auto known = recent_.find(key);
    if (known != recent_.end() && known->second != hash) {
      Violate(header.sim_us, "seq",
              fmt::format("{} (start {}) used seq {} for two different messages, the second on {}",
                          header.sender, header.boot_id, header.seq, packet.channel));
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
  ++messages_;
  return message;
}

void Auditor::Take(const Packet& packet) {
  const std::string& name = packet.channel;
  if (name == channel::kScenario) {
    if (const auto m = Admit<scenario_t>(packet)) TakeScenario(*m);
    return;
  }
  if (name == channel::kClock) {
    const auto m = Admit<clock_t>(packet);
    if (m && m->phase == ClockPhase::kEnded) ended_ = true;
    if (m) clock_sender_ = m->header.sender;
    if (m && m->phase == ClockPhase::kRunning) {
      if (TickData* data = DataOf(m->tick)) data->clock = *m;
    }
  } else if (name == channel::kWorld) {
    auto m = Admit<world_state_t>(packet);
    TickData* data = m ? DataOf(m->tick) : nullptr;
    if (data != nullptr && !data->world) data->world = std::move(*m);
  } else if (name == channel::kRulings) {
    auto m = Admit<rulings_t>(packet);
    TickData* data = m ? DataOf(m->tick) : nullptr;
    if (data != nullptr && !data->rulings) data->rulings = std::move(*m);
  } else if (name == channel::kOrders) {
    if (auto m = Admit<orders_t>(packet)) TakeOrders(std::move(*m));
  } else if (name == channel::kOrder) {
    Admit<order_t>(packet);
  } else if (name == channel::kUavs || name == channel::kWorkers || name == channel::kVehicles) {
    if (const auto m = Admit<agent_states_t>(packet)) TakeStates(*m, ClassOf(name));
  } else if (IsReports(name)) {
    if (const auto m = Admit<agent_changes_t>(packet)) TakeChanges(*m, ClassOf(name));
  } else if (name == channel::kSchedule) {
    if (const auto m = Admit<schedule_t>(packet)) TakeSchedule(*m);
  } else if (name == channel::kEvent) {
    if (auto m = Admit<event_t>(packet)) events_.push_back(std::move(*m));
  } else if (name == channel::kDriver) {
    Admit<event_t>(packet);
  } else if (name == channel::kFault) {
    Admit<fault_t>(packet);
  } else if (name == channel::kProcess) {
    Admit<process_status_t>(packet);
  } else if (name == channel::kLog) {
    Admit<log_status_t>(packet);
  } else if (name == channel::kRequest) {
    Admit<request_t>(packet);
  } else if (name == channel::kRestore) {
    Admit<restore_t>(packet);
  } else if (name == channel::kAnswer) {
    Admit<answer_t>(packet);
  }
  Advance();
}

void Auditor::TakeScenario(const scenario_t& message) {
  if (scenario_) {
    if (message.sha256 != sha256_) {
      Violate(message.header.sim_us, "scenario", "the log holds two different scenarios");
    }
    return;
  }
  try {
    scenario_ = ParseScenario(message.json);
  } catch (const std::exception& error) {
    Violate(0, "scenario", fmt::format("the log's scenario cannot be read: {}", error.what()));
    return;
  }
  sha256_ = message.sha256;
  if (Sha256Of(message.json) != sha256_) {
    Violate(0, "scenario",
            fmt::format("sha256 is {}, the message says {}", Sha256Of(message.json), sha256_));
  }
  for (const int kind : {kUav, kWorker, kVehicle}) {
    for (const Scenario::Agent& spec : scenario_->agents[kind]) {
      AgentModel model;
      model.kind = kind;
      model.id = static_cast<int>(models_[kind].size());
      model.spec = &spec;
      model.ways = scenario_->ways.get();
      model.from = model.to = spec.at;
      model.range_at_departure_m = spec.range_m;
      model.Anchor(spec.at, 0, spec.range_m);
      models_[kind].push_back(model);
      ExpectPresence(model);
    }
    n_agents_[kind] = static_cast<int>(models_[kind].size()) - scenario_->room_agents[kind];
    last_seen_[kind].resize(models_[kind].size());
    told_[kind].resize(models_[kind].size());
    for (const AgentModel& model : models_[kind]) was_[kind].emplace_back(model.from, 0);
  }
  n_tasks_ = static_cast<int>(scenario_->tasks.size()) - scenario_->room_tasks;
  task_status_.assign(scenario_->tasks.size(), 0);
  flown_m_.assign(models_[kUav].size(), 0);
  final_range_m_.assign(models_[kUav].size(), 0);
  final_range_tick_.assign(models_[kUav].size(), -1);
  for (const Packet& packet : std::exchange(held_back_, {})) Take(packet);
}

void Auditor::ExpectPresence(const AgentModel& model) {
  const Scenario::Agent& spec = *model.spec;
  if (spec.online_from_us >= spec.online_until_us) return;
  if (spec.online_from_us <= scenario_->limit_us) {
    Expect(spec.online_from_us, EventKind::kAgentOnline, AgentKey{model.kind, model.id});
  }
  if (spec.online_until_us <= scenario_->limit_us) {
    Expect(spec.online_until_us, EventKind::kAgentOffline, AgentKey{model.kind, model.id});
  }
}

Auditor::TickData* Auditor::DataOf(std::int64_t tick) {
  if (tick < 0 || tick > scenario_->last_tick()) {
    Violate(now_us_, "lockstep",
            fmt::format("a message names tick {}, the last is {}", tick, scenario_->last_tick()));
    return nullptr;
  }
  if (tick < next_tick_ || stopped_) return nullptr;
  TickData& data = pending_[tick];
  for (const int kind : {kUav, kWorker, kVehicle}) data.reports[kind].resize(models_[kind].size());
  return &data;
}

void Auditor::TakeSchedule(const schedule_t& message) {
  const std::int32_t d = message.decision;
  const std::int64_t t = scenario_->TimeOf(std::clamp<std::int64_t>(message.tick, 0, 1 << 30));
  if (d < 0 || message.tick < 0 || message.tick > scenario_->last_tick() ||
      scenario_->DecisionAt(message.tick) != d) {
    Violate(t, "lockstep",
            fmt::format("a schedule names decision {} at tick {}, where none or another is due", d,
                        message.tick));
    return;
  }
  const auto [known, is_new] = schedules_.try_emplace(d, message);
  if (!is_new && !SameActions(known->second, message)) {
    Violate(t, "lockstep",
            fmt::format("decision {} was made twice and differently, by {} (start {}, seq {}) and "
                        "{} (start {}, seq {})",
                        d, known->second.header.sender, known->second.header.boot_id,
                        known->second.header.seq, message.header.sender, message.header.boot_id,
                        message.header.seq));
  }
}

bool Auditor::Complete(std::int64_t tick, const TickData& data) const {
  if (!data.clock || !data.world || !data.rulings) return false;
  if (scenario_->takes_orders() &&
      (!data.orders || data.orders->header.boot_id < data.world->header.boot_id)) {
    return false;
  }
  if (const std::int32_t due = scenario_->DecisionAt(tick); due >= 0) {
    const std::optional<bool> in_force = InForce(tick);
    if (!in_force || (*in_force && !schedules_.contains(due))) return false;
  }
  for (const int kind : {kUav, kWorker, kVehicle}) {
    for (std::size_t id = 0; id < data.reports[kind].size(); ++id) {
      if (data.reports[kind][id]) continue;
      // Only a lost process's agents have no report: the world rules that they failed.
      const auto lost = [&](const ruling_t& r) {
        return r.agent_kind == kind && r.agent_id == static_cast<int>(id) &&
               r.kind != RulingKind::kReleased;
      };
      if (std::none_of(data.rulings->rulings.begin(), data.rulings->rulings.end(), lost)) {
        return false;
      }
    }
  }
  return true;
}

std::optional<bool> Auditor::InForce(std::int64_t tick) const {
  const auto next = pending_.find(tick + 1);
  if (next == pending_.end() || !next->second.clock) return {};
  return next->second.clock->required_decision >= scenario_->DecisionAt(tick);
}

void Auditor::CheckSkipped() {
  for (const std::int32_t decision : skipped_) {
    const std::int64_t t = decision * scenario_->interval_us;
    // The world must have said that it misses somebody, and not yet that it is back.
    std::set<std::string> lost;
    for (const event_t& event : events_) {
      if (event.at_us > t || event.header.sender != clock_sender_) continue;
      if (event.kind == EventKind::kProcessLost) lost.insert(event.detail);
      if (event.kind == EventKind::kProcessBack) lost.erase(event.detail);
    }
    if (lost.empty()) {
      Violate(t, "lockstep",
              fmt::format("the clock does not require decision {}, and nobody was lost", decision));
    }
  }
}

std::string Auditor::WhatIsMissing(std::int64_t tick) const {
  const auto found = pending_.find(tick);
  const TickData none;
  const TickData& data = found == pending_.end() ? none : found->second;
  std::string text;
  const auto add = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (!data.clock) add("clock_t");
  if (!data.world) add("world_state_t");
  if (!data.rulings) add("rulings_t");
  if (scenario_->takes_orders() && !data.orders) add("orders_t");
  const std::int32_t due = scenario_->DecisionAt(tick);
  if (due >= 0 && !schedules_.contains(due)) add(fmt::format("schedule_t of decision {}", due));
  if (due >= 0 && !InForce(tick)) add(fmt::format("clock_t of tick {}", tick + 1));
  for (const int kind : {kUav, kWorker, kVehicle}) {
    for (std::size_t id = 0; id < models_[kind].size(); ++id) {
      if (data.reports[kind].empty() || !data.reports[kind][id]) {
        add(fmt::format("state of {}:{}", ToString<AgentKind>(kind), id));
        break;  // one of a class is enough to say
      }
    }
  }
  return fmt::format("tick {} lacks: {}", tick, text);
}

void Auditor::Advance() {
  while (!stopped_) {
    const auto data = pending_.find(next_tick_);
    if (data == pending_.end() || !Complete(next_tick_, data->second)) break;
    n_before_tick_ = n_violations_;
    CheckTick(next_tick_, data->second);
    pending_.erase(data);
    if (TickHolds()) {
      ++next_tick_;
    } else {
      stopped_ = true;
    }
  }
  if (!stopped_ && pending_.size() > kMaxPending) {
    Violate(scenario_->TimeOf(next_tick_), "lockstep", WhatIsMissing(next_tick_));
    stopped_ = true;
  }
  if (stopped_) pending_.clear();
}

void Auditor::CheckTick(std::int64_t tick, const TickData& data) {
  before_us_ = tick == 0 ? -1 : now_us_;
  now_us_ = scenario_->TimeOf(tick);
  due_ = scenario_->DecisionAt(tick);
  CheckClock(*data.clock);
  CheckReports(data);
  if (data.orders) CheckOrders(*data.orders);
  if (!TickHolds()) return;
  ReadRulings(*data.rulings);
  CheckSaidFailed();
  CheckActivities(*data.world);
  if (!TickHolds()) return;
  AbortActivities();
  SettleAgents();
  for (const Tracked& tracked : activities_) {
    if (tracked.is_new && tracked.meeting) CheckMeeting(tracked.activity);
  }
  CheckTasks(*data.world);
  ExpectEvents();
  if (due_ < 0) return;
  if (!*InForce(tick)) {
    skipped_.insert(due_);
    return;
  }
  if (TickHolds()) CheckDecision(schedules_.at(due_));
  in_force_ = due_;
}

void Auditor::CheckClock(const clock_t& clock) {
  const auto expect = [&](const char* field, std::int64_t found, std::int64_t expected) {
    if (found == expected) return;
    Violate(now_us_, "clock",
            fmt::format("clock_t of tick {}: {} is {}, expected {}", clock.tick, field, found,
                        expected));
  };
  expect("tick_us", clock.tick_us, now_us_);
  expect("limit_us", clock.limit_us, scenario_->limit_us);
  expect("decision", clock.decision, due_);
  expect("required_decision", clock.required_decision, in_force_);
}

const std::vector<Violation>& Auditor::Finish() {
  if (!scenario_) {
    if (violations_.empty()) Violate(0, "scenario", "the log has no scenario_t");
    return violations_;
  }
  if (!stopped_ && next_tick_ <= scenario_->last_tick()) {
    Violate(scenario_->TimeOf(next_tick_), "lockstep", WhatIsMissing(next_tick_));
    stopped_ = true;
  }
  if (!ended_) {
    Violate(scenario_->limit_us, "lockstep", "no clock_t of phase 2 announces the end");
  }
  for (const auto& [start, sender] : senders_) {
    const auto missing = sender.seqs.Missing(0, sender.seqs.max());
    for (const IntervalSet::Range& gap : missing) {
      Violate(sender.last_sim_us, "seq",
              fmt::format("{} (start {}) lacks seq {} to {} of 0 to {}", start.first, start.second,
                          gap.first, gap.last, sender.seqs.max()));
    }
  }
  std::sort(events_.begin(), events_.end(), [](const event_t& a, const event_t& b) {
    return std::tuple(KeyOf(a), a.fault_id, a.detail) < std::tuple(KeyOf(b), b.fault_id, b.detail);
  });
  events_.erase(std::unique(events_.begin(), events_.end(),
                            [](const event_t& a, const event_t& b) {
                              return KeyOf(a) == KeyOf(b) && a.fault_id == b.fault_id &&
                                     a.detail == b.detail;
                            }),
                events_.end());
  CompareEvents();
  CheckSkipped();
  if (!stopped_) {
    Facts facts;
    facts.sha256 = sha256_;
    facts.seed = scenario_->seed;
    facts.schedules = schedules_;
    for (const std::int32_t decision : skipped_) facts.schedules.erase(decision);
    facts.events = events_;
    facts.task_status = task_status_;
    facts.task_status.resize(static_cast<std::size_t>(n_tasks_));
    facts.flown_m = flown_m_;
    facts.flown_m.resize(static_cast<std::size_t>(n_agents_[kUav]));
    facts.final_range_m = final_range_m_;
    facts.final_range_m.resize(static_cast<std::size_t>(n_agents_[kUav]));
    facts.messages = messages_;
    facts.interval_us = scenario_->interval_us;
    facts_ = std::move(facts);
  }
  std::stable_sort(violations_.begin(), violations_.end(),
                   [](const Violation& a, const Violation& b) { return a.at_us < b.at_us; });
  return violations_;
}

void Auditor::CompareEvents() {
  // Where checking stopped, nothing is expected of what came later.
  const std::int64_t until = stopped_ ? before_us_ : scenario_->limit_us;
  std::set<EventKey> seen;
  for (const event_t& event : events_) {
    if (!IsOutcome(static_cast<EventKind>(event.kind))) continue;
    const EventKey key = KeyOf(event);
    const std::int64_t at = event.at_us;
    if (!seen.insert(key).second) {
      Violate(at, "events", fmt::format("said twice: {}", Name(key)));
    }
    if (at > until || event.kind == EventKind::kAgentBack) continue;
    if (!expected_.contains(key)) {
      Violate(at, "events", fmt::format("said but not so: {}", Name(key)));
    }
  }
  for (const EventKey& key : expected_) {
    if (std::get<0>(key) <= until && !seen.contains(key)) {
      Violate(std::get<0>(key), "events", fmt::format("not said: {}", Name(key)));
    }
  }
  // When an agent comes back is the fault injector's word; it must lie in the tick that shows it.
  std::size_t n_back = 0;
  for (const auto& [agent, after, at] : expected_back_) {
    const auto [kind, id] = agent;
    const auto fits = [kind = kind, id = id, from = after, to = at](const EventKey& key) {
      const int ids[] = {std::get<2>(key), std::get<3>(key), std::get<4>(key)};
      return std::get<1>(key) == EventKind::kAgentBack && ids[kind] == id &&
             std::get<0>(key) > from && std::get<0>(key) <= to;
    };
    if (std::any_of(seen.begin(), seen.end(), fits)) {
      ++n_back;
    } else {
      Violate(at, "events",
              fmt::format("not said: agent back {}:{} in ({}, {}] us", ToString<AgentKind>(kind),
                          id, after, at));
    }
  }
  const auto n_said =
      static_cast<std::size_t>(std::count_if(seen.begin(), seen.end(), [&](const EventKey& key) {
        return std::get<1>(key) == EventKind::kAgentBack && std::get<0>(key) <= until;
      }));
  if (n_said > n_back) {
    Violate(until, "events",
            fmt::format("{} agents said to be back, {} came back", n_said, n_back));
  }
}

}  // namespace muster::tools::audit
