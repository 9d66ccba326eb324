#include "tools/record/run_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "protocol/convert.h"
#include "protocol/process.h"

namespace muster::tools {
namespace {

constexpr std::size_t kWindow = 64;
constexpr std::int64_t kLongestPauseUs = 60 * kMinuteUs;

auto Key(const event_t& event) {
  return std::tie(event.at_us, event.kind, event.uav_id, event.worker_id, event.vehicle_id,
                  event.task_id, event.charge_id, event.fault_id);
}

/// The start of the world that says the event; -1: another process does.
std::int64_t WorldOf(const event_t& event) {
  return event.header.sender == process_name::kWorld ? event.header.boot_id : -1;
}

bool IsBefore(const event_t& a, const event_t& b) {
  return std::tuple(Key(a), WorldOf(a), std::tie(a.detail)) <
         std::tuple(Key(b), WorldOf(b), std::tie(b.detail));
}

/// A world that started again says its last events again, as new messages. It may not know the
/// words of a process that was lost with it.
bool IsSaidAgain(const event_t& first, const event_t& event) {
  return Key(first) == Key(event) &&
         (first.detail == event.detail ||
          (first.header.sender == event.header.sender && WorldOf(first) != WorldOf(event)));
}

auto Rank(const header_t& header) { return std::tie(header.boot_id, header.seq, header.sender); }

}  // namespace

void Track::Add(std::int64_t tick, Point at, double range_left_m) {
  if ((base_ && tick <= base_->tick) || excluded_.contains(tick)) return;
  const auto place =
      std::lower_bound(pending_.begin(), pending_.end(), tick,
                       [](const Mark& mark, std::int64_t t) { return mark.tick < t; });
  const Mark mark{tick, at, range_left_m};
  if (place != pending_.end() && place->tick == tick) {
    *place = mark;
    return;
  }
  pending_.insert(place, mark);
  if (pending_.size() <= kWindow) return;
  // Half at a time, so that each position moves a bounded number of times.
  const auto end = pending_.begin() + kWindow / 2;
  for (auto it = pending_.begin(); it != end; ++it) {
    if (base_) length_m_ += WayM(*base_, *it);
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
  const Mark* before = base_ ? &*base_ : nullptr;
  for (const Mark& mark : pending_) {
    if (before != nullptr) length += WayM(*before, mark);
    before = &mark;
  }
  return length;
}

double Track::WayM(const Mark& from, const Mark& to) const {
  return scenario_->WaysAt(scenario_->rules.TimeOf(from.tick))
      .Gone(AgentKind::kUav, from.at, to.at);
}

std::int64_t RunRecord::last_tick() const {
  const Rules& rules = scenario()->rules;
  return (rules.limit_us + rules.tick_us - 1) / rules.tick_us;
}

void RunRecord::Add(const Packet& packet, const MissionReader::Visit& also) {
  reader_.Add(packet, [&](const Message& message, const Packet& its_packet) {
    Take(message);
    if (also) also(message, its_packet);
  });
}

void RunRecord::Take(const Message& message) {
  Handle(
      message, [&](const scenario_t& m) { TakeScenario(m); },
      [&](const clock_t& m) { TakeClock(m); }, [&](const world_state_t& m) { TakeWorld(m); },
      [&](const rulings_t& m) { TakeRulings(m); }, [&](const agent_states_t& m) { TakeAgents(m); },
      [&](const schedule_t& m) { TakeSchedule(m); },
      [&](const clearances_t& m) {
        if (scenario()) air_.Take(m, *scenario());
      },
      [&](const event_t& m) {
        events_.push_back(m);
        events_sorted_ = false;
      },
      [&](const fault_t& m) { TakeFault(m); }, [&](const process_status_t& m) { TakeProcess(m); });
}

void RunRecord::TakeScenario(const scenario_t& message) {
  if (!scenario_sha256_.empty()) return;
  scenario_sha256_ = message.sha256;
  tracks_.assign(scenario()->uavs.size(), Track(*scenario()));
  row_ = scenario()->row();
  said_.resize(row_.size());
}

void RunRecord::TakeRulings(const rulings_t& message) {
  TickCover* cover = Cover(message.tick);
  if (cover == nullptr) return;
  cover->rulings = true;
  Excuse(message, cover);
  Collapse(message.tick);
}

void RunRecord::TakeFault(const fault_t& message) {
  // The one with for_us 0 ends it.
  const auto [known, is_new] = faults_.try_emplace(message.fault_id, message);
  if (!is_new && known->second.for_us == 0) known->second = message;
}

void RunRecord::TakeProcess(const process_status_t& message) {
  process_status_t& newest = processes_[{message.name, message.header.boot_id}];
  if (newest.name.empty() || newest.header.seq < message.header.seq) newest = message;
}

RunRecord::TickCover* RunRecord::Cover(std::int64_t tick) {
  if (tick < 0 || tick > last_tick()) {
    reader_.Reject();
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
  const Rules& rules = scenario()->rules;
  const TimeUs before_us =
      message.tick == 0 ? -1 : std::min((message.tick - 1) * rules.tick_us, rules.limit_us);
  for (const ruling_t& ruling : message.rulings) {
    if (ruling.kind == RulingKind::kReleased) continue;
    const auto kind = static_cast<AgentKind>(ruling.agent_kind);
    const auto i = row_.Find(kind, ruling.agent_id);
    if (!i) continue;
    cover->excused.push_back(*i);
    if (kind == AgentKind::kUav && ruling.at_us > before_us) tracks_[*i].Exclude(message.tick);
  }
}

void RunRecord::TakeClock(const clock_t& message) {
  if (message.phase == ClockPhase::kReady) return;
  // Decisions before this tick that it does not require never were in force.
  for (std::int32_t d = scenario()->rules.LastDecisionBefore(message.tick_us);
       d > message.required_decision && !skipped_.contains(d); --d) {
    skipped_.insert(d);
    schedules_.erase(d);
  }
  const std::int64_t wall_us = message.header.wall_us;
  auto& walls = tick_walls_.try_emplace(message.tick, wall_us, wall_us).first->second;
  walls = {std::min(walls.first, wall_us), std::max(walls.second, wall_us)};
  if (message.phase == ClockPhase::kEnded) end_announced_ = true;
  if (TickCover* cover = Cover(message.tick)) {
    cover->clock = true;
    Collapse(message.tick);
  }
}

void RunRecord::TakeWorld(const world_state_t& message) {
  if (message.task_status.size() != scenario()->tasks.size()) {
    reader_.Reject();
    return;
  }
  if (TickCover* cover = Cover(message.tick)) {
    cover->world = true;
    Collapse(message.tick);
  }
  if (!final_world_ || final_world_->tick < message.tick) final_world_ = message;
}

void RunRecord::TakeAgents(const agent_states_t& message) {
  const auto kind = static_cast<AgentKind>(message.kind);
  const auto known = [&](const agent_t& agent) { return row_.Find(kind, agent.id).has_value(); };
  if (!std::all_of(message.agents.begin(), message.agents.end(), known)) {
    reader_.Reject();
    return;
  }
  air_.Take(message, *scenario());
  TickCover* cover = Cover(message.tick);
  if (cover != nullptr) cover->agents.resize(said_.size());
  for (const agent_t& agent : message.agents) {
    const std::size_t i = *row_.Find(kind, agent.id);
    // An agent that has not joined yet is nowhere.
    const bool is_vacant = agent.online_until_us == 0 && reader_.orders().takes_orders();
    if (kind == AgentKind::kUav && !is_vacant)
      tracks_[i].Add(message.tick, {agent.x_m, agent.y_m}, agent.range_left_m);
    measured_legs_.Take(*scenario(), kind, message.tick, agent);
    const bool heard = cover == nullptr ? covered_ticks_.Contains(message.tick) : cover->agents[i];
    // Another start of the same sender may say a tick again that an earlier start said.
    Said& said = said_[i];
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
      cover->agents[i] = true;
      ++cover->n_agents;
    }
  }
  Collapse(message.tick);
}

void RunRecord::TakeSchedule(const schedule_t& message) {
  if (!Possible(message, *scenario())) {
    reader_.Reject();
    return;
  }
  if (skipped_.contains(message.decision)) return;
  const auto [known, is_new] = schedules_.try_emplace(message.decision);
  if (is_new || Rank(message.header) < Rank(known->second.header)) {
    known->second = message;
  }
}

const std::vector<event_t>& RunRecord::events() const {
  if (!events_sorted_) {
    std::sort(events_.begin(), events_.end(), IsBefore);
    events_.erase(std::unique(events_.begin(), events_.end(), IsSaidAgain), events_.end());
    events_sorted_ = true;
  }
  return events_;
}

double RunRecord::wall_s() const {
  std::int64_t sum_us = 0;
  const auto add = [&](std::int64_t us) { sum_us += us < 0 || us > kLongestPauseUs ? 0 : us; };
  const std::pair<std::int64_t, std::int64_t>* before = nullptr;
  for (const auto& [tick, walls] : tick_walls_) {
    if (before != nullptr) add(walls.first - before->first);
    before = &walls;
  }
  if (before != nullptr) add(before->second - before->first);
  return ToSeconds(sum_us);
}

RunRecord::Completeness RunRecord::CheckComplete() const {
  Completeness result;
  ListGaps(&result);
  result.repeated = repeated_;
  result.damage = damage_;
  if (reader_.overflowed()) {
    result.damage.push_back(
        fmt::format("no scenario in the first {} messages", MissionReader::kMostHeldBack));
  }
  result.torn_tails = torn_tails_;
  const auto lacks = [&](const char* what, std::int64_t at) {
    ++result.n_missing;
    if (result.missing.size() < kMaxListed) result.missing.push_back({what, at, at});
  };
  if (!scenario()) {
    lacks("scenario", 0);
    return result;
  }
  const std::int64_t newest =
      std::max(covered_ticks_.max(), open_ticks_.empty() ? -1 : open_ticks_.rbegin()->first);
  result.ended = end_announced_;
  result.last_tick = end_announced_ || newest >= last_tick()
                         ? last_tick()
                         : std::max<std::int64_t>(-1, newest - 1);
  ListMissingTicks(&result);
  const Rules& rules = scenario()->rules;
  for (std::int32_t d = 0; d < scenario()->decisions(); ++d) {
    if (schedules_.contains(d) || skipped_.contains(d)) continue;
    if (rules.TimeOfDecision(d) > rules.TimeOf(result.last_tick)) break;
    lacks("schedule", d);
  }
  if (!end_announced_) lacks("end", last_tick());
  result.complete =
      result.gaps.empty() && result.n_missing == 0 && result.repeated == 0 && result.damage.empty();
  return result;
}

/// Numbers that no message of a process has: gaps, or the last words of one that started again.
void RunRecord::ListGaps(Completeness* result) const {
  for (const auto& [start, seqs] : reader_.seqs()) {
    const auto later = reader_.seqs().upper_bound(start);
    const bool superseded = later != reader_.seqs().end() && later->first.first == start.first;
    for (const IntervalSet::Range& range : seqs.Missing(0, seqs.max())) {
      (superseded ? result->lost_tails : result->gaps)
          .push_back({start.first, start.second, range.first, range.last});
    }
  }
}

/// Runs of ticks of which the clock, the world, its rulings or an agent said nothing, in the order
/// in which they end.
void RunRecord::ListMissingTicks(Completeness* result) const {
  const std::size_t n_uavs = scenario()->uavs.size();
  const std::size_t n_workers = scenario()->workers.size();
  // The first three, then the agents.
  const auto name_of = [&](std::size_t owner) -> std::string {
    constexpr std::array kNames = {"clock", "world", "rulings"};
    if (owner < kNames.size()) return kNames[owner];
    const std::size_t i = owner - kNames.size();
    return i < n_uavs               ? fmt::format("uav:{}", i)
           : i < n_uavs + n_workers ? fmt::format("worker:{}", i - n_uavs)
                                    : fmt::format("vehicle:{}", i - n_uavs - n_workers);
  };
  constexpr IntervalSet::Range kNone{-1, -2};
  std::vector<IntervalSet::Range> runs(said_.size() + 3, kNone);
  const auto finish = [&](std::size_t owner) {
    IntervalSet::Range& run = runs[owner];
    if (run.first >= 0 && result->missing.size() < kMaxListed) {
      result->missing.push_back({name_of(owner), run.first, run.last});
    }
    run = kNone;
  };
  const auto lacks = [&](std::size_t owner, std::int64_t tick) {
    ++result->n_missing;
    if (runs[owner].last + 1 != tick) finish(owner);
    if (runs[owner].first < 0) runs[owner].first = tick;
    runs[owner].last = tick;
  };
  for (const IntervalSet::Range& range : covered_ticks_.Missing(0, result->last_tick)) {
    for (std::int64_t tick = range.first; tick <= range.last; ++tick) {
      const auto open = open_ticks_.find(tick);
      const TickCover none;
      const TickCover& cover = open == open_ticks_.end() ? none : open->second;
      if (!cover.clock) lacks(0, tick);
      if (!cover.world) lacks(1, tick);
      if (!cover.rulings) lacks(2, tick);
      for (std::size_t i = 0; i < said_.size(); ++i) {
        const bool said = !cover.agents.empty() && cover.agents[i];
        const bool excused =
            std::find(cover.excused.begin(), cover.excused.end(), i) != cover.excused.end();
        if (!said && !excused) lacks(i + 3, tick);
      }
    }
  }
  for (std::size_t owner = 0; owner < runs.size(); ++owner) finish(owner);
}

}  // namespace muster::tools
