#include "tools/record/run_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/agent.h"
#include "model/scenario_json.h"

namespace muster::tools {
namespace {

constexpr std::size_t kWindow = 64;
/// What may come before the scenario; a sound log has a few packets there.
constexpr std::size_t kMaxHeldBack = 20'000;

auto Key(const event_t& event) {
  return std::tie(event.at_us, event.kind, event.uav_id, event.worker_id, event.vehicle_id,
                  event.task_id, event.charge_id, event.fault_id, event.detail);
}

auto Rank(const header_t& header) { return std::tie(header.boot_id, header.seq, header.sender); }

}  // namespace

void Track::Add(std::int64_t tick, Point at, double range_left_m) {
  if ((base_ && tick <= base_->tick) || excluded_.contains(tick)) return;
  const auto place =
      std::lower_bound(pending_.begin(), pending_.end(), tick,
                       [](const Mark& mark, std::int64_t t) { return mark.tick < t; });
  if (place != pending_.end() && place->tick == tick) return;
  pending_.insert(place, {tick, at, range_left_m});
  if (pending_.size() <= kWindow) return;
  // Half at a time, so that each position moves a bounded number of times.
  const auto end = pending_.begin() + kWindow / 2;
  for (auto it = pending_.begin(); it != end; ++it) {
    if (base_) length_m_ += Distance(base_->at, it->at);
    base_ = *it;
  }
  pending_.erase(pending_.begin(), end);
}

void Track::Exclude(std::int64_t tick) {
  excluded_.insert(tick);
  std::erase_if(pending_, [&](const Mark& mark) { return mark.tick == tick; });
}

double Track::length_m() const {
  double length = length_m_;
  std::optional<Point> at;
  if (base_) at = base_->at;
  for (const Mark& mark : pending_) {
    if (at) length += Distance(*at, mark.at);
    at = mark.at;
  }
  return length;
}

std::int64_t RunRecord::last_tick() const {
  const Rules& rules = scenario_->rules;
  return (rules.limit_us + rules.tick_us - 1) / rules.tick_us;
}

void RunRecord::Add(const Packet& packet) {
  if (FindChannel(packet.channel) == nullptr) {
    ++counts_.foreign;
    return;
  }
  if (scenario_ || packet.channel == channel::kScenario) {
    Take(packet);
  } else if (held_back_.size() < kMaxHeldBack) {
    held_back_.push_back(packet);
  } else if (held_back_.size() == kMaxHeldBack) {
    held_back_.push_back(packet);
    NoteDamage(fmt::format("no scenario in the first {} messages", kMaxHeldBack));
  }
}

template <class Message>
std::optional<Message> RunRecord::Admit(const Packet& packet) {
  std::optional<Message> message = DecodeValid<Message>(packet.bytes);
  if (!message) {
    ++counts_.undecodable;
    return {};
  }
  const header_t& header = message->header;
  if (!run_id_) run_id_ = header.run_id;
  if (header.run_id != *run_id_) {
    ++counts_.strangers;
    return {};
  }
  if (!seqs_[{header.sender, header.boot_id}].Add(header.seq)) {
    ++counts_.duplicates;
    return {};
  }
  ++counts_.messages;
  return message;
}

void RunRecord::Take(const Packet& packet) {
  const std::string& name = packet.channel;
  if (name == channel::kScenario) {
    if (const auto message = Admit<scenario_t>(packet)) TakeScenario(*message);
  } else if (name == channel::kClock) {
    if (const auto message = Admit<clock_t>(packet)) TakeClock(*message);
  } else if (name == channel::kWorld) {
    if (auto message = Admit<world_state_t>(packet)) TakeWorld(std::move(*message));
  } else if (name == channel::kRulings) {
    const auto message = Admit<rulings_t>(packet);
    TickCover* cover = message ? Cover(message->tick) : nullptr;
    if (cover != nullptr) {
      cover->rulings = true;
      Excuse(*message, cover);
      Collapse(message->tick);
    }
  } else if (name == channel::kUavs || name == channel::kWorkers || name == channel::kVehicles) {
    if (const auto message = Admit<agent_states_t>(packet)) TakeAgents(*message);
  } else if (name == channel::kSchedule) {
    if (auto message = Admit<schedule_t>(packet)) TakeSchedule(std::move(*message));
  } else if (name == channel::kEvent) {
    if (auto message = Admit<event_t>(packet)) {
      events_.push_back(std::move(*message));
      events_sorted_ = false;
    }
  } else if (name == channel::kFault) {
    if (auto message = Admit<fault_t>(packet)) {
      // The one with for_us 0 ends it.
      const auto [known, is_new] = faults_.try_emplace(message->fault_id, *message);
      if (!is_new && known->second.for_us == 0) known->second = std::move(*message);
    }
  } else if (name == channel::kProcess) {
    if (auto message = Admit<process_status_t>(packet)) {
      process_status_t& newest = processes_[{message->name, message->header.boot_id}];
      if (newest.name.empty() || newest.header.seq < message->header.seq) {
        newest = std::move(*message);
      }
    }
  } else if (name == channel::kLog) {
    Admit<log_status_t>(packet);
  } else if (name == channel::kRequest) {
    Admit<request_t>(packet);
  } else if (name == channel::kRestore) {
    Admit<restore_t>(packet);
  }
}

void RunRecord::TakeScenario(const scenario_t& message) {
  if (scenario_) return;
  try {
    scenario_ = ParseScenario(message.json, "MUSTER_SCENARIO");
  } catch (const InputError&) {
    ++counts_.undecodable;
    return;
  }
  scenario_sha256_ = message.sha256;
  tracks_.resize(scenario_->uavs.size());
  said_.resize(scenario_->uavs.size() + scenario_->workers.size() + scenario_->vehicles.size());
  for (const Packet& packet : std::exchange(held_back_, {})) Take(packet);
}

RunRecord::TickCover* RunRecord::Cover(std::int64_t tick) {
  if (tick < 0 || tick > last_tick()) {
    ++counts_.undecodable;
    return nullptr;
  }
  if (covered_ticks_.Contains(tick)) return nullptr;
  return &open_ticks_[tick];
}

void RunRecord::Collapse(std::int64_t tick) {
  const auto cover = open_ticks_.find(tick);
  if (cover == open_ticks_.end()) return;
  const TickCover& c = cover->second;
  if (!c.clock || !c.world || !c.rulings || c.n_agents != said_.size()) return;
  covered_ticks_.Add(tick);
  open_ticks_.erase(cover);
}

void RunRecord::Excuse(const rulings_t& message, TickCover* cover) {
  const Rules& rules = scenario_->rules;
  const TimeUs before_us =
      message.tick == 0 ? -1 : std::min((message.tick - 1) * rules.tick_us, rules.limit_us);
  const std::size_t n_uavs = scenario_->uavs.size();
  const std::size_t offsets[] = {0, n_uavs, n_uavs + scenario_->workers.size(), said_.size()};
  for (const ruling_t& ruling : message.rulings) {
    if (ruling.kind != RulingKind::kFailed) continue;
    const std::size_t i = offsets[ruling.agent_kind] + static_cast<std::size_t>(ruling.agent_id);
    if (i >= offsets[ruling.agent_kind + 1]) continue;
    cover->excused.push_back(i);
    if (ruling.agent_kind == AgentKind::kUav && ruling.at_us > before_us)
      tracks_[i].Exclude(message.tick);
  }
}

void RunRecord::TakeClock(const clock_t& message) {
  if (message.phase == ClockPhase::kReady) return;
  // Decisions before this tick that it does not require never were in force.
  const Rules& rules = scenario_->rules;
  const std::int32_t before =
      message.tick_us <= 0
          ? -1
          : static_cast<std::int32_t>((std::min(message.tick_us, rules.limit_us) - 1) /
                                      rules.interval_us);
  for (std::int32_t d = before; d > message.required_decision && !skipped_.contains(d); --d) {
    skipped_.insert(d);
    schedules_.erase(d);
  }
  const std::pair<std::int64_t, std::int64_t> when(message.tick, message.header.wall_us);
  if (!first_clock_ || when < *first_clock_) first_clock_ = when;
  if (!last_clock_ || when > *last_clock_) last_clock_ = when;
  if (message.phase == ClockPhase::kEnded) end_announced_ = true;
  if (TickCover* cover = Cover(message.tick)) {
    cover->clock = true;
    Collapse(message.tick);
  }
}

void RunRecord::TakeWorld(world_state_t message) {
  if (message.task_status.size() != scenario_->tasks.size()) {
    ++counts_.undecodable;
    return;
  }
  if (TickCover* cover = Cover(message.tick)) {
    cover->world = true;
    Collapse(message.tick);
  }
  if (!final_world_ || final_world_->tick < message.tick) final_world_ = std::move(message);
}

void RunRecord::TakeAgents(const agent_states_t& message) {
  const std::size_t sizes[] = {scenario_->uavs.size(), scenario_->workers.size(),
                               scenario_->vehicles.size()};
  const auto kind = static_cast<std::size_t>(message.kind);
  const auto known = [&](const agent_t& agent) {
    return agent.id >= 0 && static_cast<std::size_t>(agent.id) < sizes[kind];
  };
  if (kind > 2 || !std::all_of(message.agents.begin(), message.agents.end(), known)) {
    ++counts_.undecodable;
    return;
  }
  const std::size_t offset = kind == 0 ? 0 : kind == 1 ? sizes[0] : sizes[0] + sizes[1];
  TickCover* cover = Cover(message.tick);
  if (cover != nullptr) cover->agents.resize(said_.size());
  for (const agent_t& agent : message.agents) {
    const auto id = static_cast<std::size_t>(agent.id);
    if (kind == 0) tracks_[id].Add(message.tick, {agent.x_m, agent.y_m}, agent.range_left_m);
    const bool heard =
        cover == nullptr ? covered_ticks_.Contains(message.tick) : cover->agents[offset + id];
    // Another start of the same sender may say a tick again that an earlier start said.
    Said& said = said_[offset + id];
    const bool same_start =
        said.sender == message.header.sender && said.boot_id == message.header.boot_id;
    const bool other_sender = !said.sender.empty() && said.sender != message.header.sender;
    if (heard &&
        (other_sender || (same_start && said.first <= message.tick && message.tick <= said.last))) {
      ++repeated_;
    }
    if (same_start) {
      said.first = std::min(said.first, message.tick);
      said.last = std::max(said.last, message.tick);
    } else if (message.header.boot_id > said.boot_id) {
      said = {message.header.sender, message.header.boot_id, message.tick, message.tick};
    }
    if (cover != nullptr && !heard) {
      cover->agents[offset + id] = true;
      ++cover->n_agents;
    }
  }
  Collapse(message.tick);
}

void RunRecord::TakeSchedule(schedule_t message) {
  if (message.decision < 0 || message.decision >= scenario_->decisions()) {
    ++counts_.undecodable;
    return;
  }
  if (skipped_.contains(message.decision)) return;
  const auto [known, is_new] = schedules_.try_emplace(message.decision);
  if (is_new || Rank(message.header) < Rank(known->second.header)) {
    known->second = std::move(message);
  }
}

const std::vector<event_t>& RunRecord::events() const {
  if (!events_sorted_) {
    std::sort(events_.begin(), events_.end(),
              [](const event_t& a, const event_t& b) { return Key(a) < Key(b); });
    // A world that started again says its last events again, as new messages.
    events_.erase(std::unique(events_.begin(), events_.end(),
                              [](const event_t& a, const event_t& b) { return Key(a) == Key(b); }),
                  events_.end());
    events_sorted_ = true;
  }
  return events_;
}

double RunRecord::wall_s() const {
  return first_clock_ ? static_cast<double>(last_clock_->second - first_clock_->second) * 1e-6 : 0;
}

RunRecord::Completeness RunRecord::CheckComplete() const {
  Completeness result;
  for (const auto& [start, seqs] : seqs_) {
    const auto later = seqs_.upper_bound(start);
    const bool superseded = later != seqs_.end() && later->first.first == start.first;
    for (const IntervalSet::Range& range : seqs.Missing(0, seqs.max())) {
      (superseded ? result.lost_tails : result.gaps)
          .push_back({start.first, start.second, range.first, range.last});
    }
  }
  result.repeated = repeated_;
  result.damage = damage_;
  result.torn_tails = torn_tails_;
  if (!scenario_) {
    result.missing.push_back({"scenario", 0, 0});
    result.n_missing = 1;
    return result;
  }

  const std::size_t n_uavs = scenario_->uavs.size();
  const std::size_t n_workers = scenario_->workers.size();
  const auto agent_name = [&](std::size_t i) {
    return i < n_uavs               ? fmt::format("uav:{}", i)
           : i < n_uavs + n_workers ? fmt::format("worker:{}", i - n_uavs)
                                    : fmt::format("vehicle:{}", i - n_uavs - n_workers);
  };
  // Owner 0 clock, 1 world, 2 rulings, then the agents: each one's run of missing ticks.
  const std::size_t n_owners = said_.size() + 3;
  std::vector<IntervalSet::Range> runs(n_owners, {-1, -2});
  const auto owner_name = [&](std::size_t owner) -> std::string {
    constexpr const char* kNames[] = {"clock", "world", "rulings"};
    return owner < 3 ? kNames[owner] : agent_name(owner - 3);
  };
  const auto finish = [&](std::size_t owner) {
    IntervalSet::Range& run = runs[owner];
    if (run.first >= 0 && result.missing.size() < kMaxListed) {
      result.missing.push_back({owner_name(owner), run.first, run.last});
    }
    run = {-1, -2};
  };
  const auto lacks = [&](std::size_t owner, std::int64_t first, std::int64_t last) {
    result.n_missing += last - first + 1;
    if (runs[owner].last + 1 != first) finish(owner);
    if (runs[owner].first < 0) runs[owner].first = first;
    runs[owner].last = last;
  };
  const std::int64_t newest =
      std::max(covered_ticks_.max(), open_ticks_.empty() ? -1 : open_ticks_.rbegin()->first);
  result.ended = end_announced_;
  result.last_tick = end_announced_ || newest >= last_tick()
                         ? last_tick()
                         : std::max<std::int64_t>(-1, newest - 1);
  for (const IntervalSet::Range& range : covered_ticks_.Missing(0, result.last_tick)) {
    for (std::int64_t tick = range.first; tick <= range.last; ++tick) {
      const auto open = open_ticks_.find(tick);
      const TickCover none;
      const TickCover& cover = open == open_ticks_.end() ? none : open->second;
      if (!cover.clock) lacks(0, tick, tick);
      if (!cover.world) lacks(1, tick, tick);
      if (!cover.rulings) lacks(2, tick, tick);
      for (std::size_t i = 0; i < said_.size(); ++i) {
        if (!cover.agents.empty() && cover.agents[i]) continue;
        if (std::find(cover.excused.begin(), cover.excused.end(), i) != cover.excused.end())
          continue;
        lacks(i + 3, tick, tick);
      }
    }
  }
  for (std::size_t owner = 0; owner < n_owners; ++owner) finish(owner);
  for (std::int32_t d = 0; d < scenario_->decisions(); ++d) {
    if (schedules_.contains(d) || skipped_.contains(d)) continue;
    if (d * scenario_->rules.interval_us > scenario_->rules.TimeOf(result.last_tick)) break;
    ++result.n_missing;
    if (result.missing.size() < kMaxListed) result.missing.push_back({"schedule", d, d});
  }
  if (!end_announced_) {
    ++result.n_missing;
    if (result.missing.size() < kMaxListed) {
      result.missing.push_back({"end", last_tick(), last_tick()});
    }
  }
  result.complete =
      result.gaps.empty() && result.n_missing == 0 && result.repeated == 0 && result.damage.empty();
  return result;
}

}  // namespace muster::tools
