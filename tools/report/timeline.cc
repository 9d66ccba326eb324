#include "tools/report/timeline.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "model/separation.h"
#include "protocol/convert.h"
#include "protocol/process.h"

namespace muster::tools {
namespace {

/// How far a stop may lie off the straight line through its neighbours and still be left out.
constexpr double kStraightM = 0.5;

/// Whether `mid` lies on the straight way in time from `a` to `b`.
bool Straight(const Timeline::Stop& a, const Timeline::Stop& mid, const Timeline::Stop& b) {
  if (b.t_ms <= a.t_ms) return true;
  const double share =
      static_cast<double>(mid.t_ms - a.t_ms) / static_cast<double>(b.t_ms - a.t_ms);
  const auto off = [&](double from, double at, double to) {
    return std::abs(from + share * (to - from) - at) > kStraightM;
  };
  return !off(a.x_m, mid.x_m, b.x_m) && !off(a.y_m, mid.y_m, b.y_m) &&
         !off(a.range_m, mid.range_m, b.range_m);
}

void Append(Growing<Timeline::Stop>* stops, const Timeline::Stop& stop) {
  auto& rows = stops->rows;
  if (!rows.empty() && stop.t_ms < rows.back().t_ms) return;
  const bool again = !rows.empty() && stop.t_ms == rows.back().t_ms;
  if (again || (rows.size() >= 2 && Straight(rows[rows.size() - 2], rows.back(), stop))) {
    stops->ReplaceLast(stop);
  } else {
    stops->Push(stop);
  }
}

void Append(Growing<Timeline::Span>* spans, std::int64_t us, AgentStatus status) {
  const Timeline::Span span{Ms(us), static_cast<int>(status)};
  if (!spans->rows.empty() && spans->rows.back().status == span.status) return;
  if (!spans->rows.empty() && span.t_ms < spans->rows.back().t_ms) return;
  if (!spans->rows.empty() && span.t_ms == spans->rows.back().t_ms) {
    spans->ReplaceLast(span);
  } else {
    spans->Push(span);
  }
}

/// The first of the times that lies in [from, until]; `until` when none does. A decision takes
/// effect at the very time of the tick at which its agents still said that they were idle.
std::int64_t FirstWithin(std::int64_t from, std::int64_t until,
                         std::initializer_list<std::int64_t> times) {
  for (const std::int64_t time : times) {
    if (time >= from && time <= until) return time;
  }
  return until;
}

bool Active(AgentStatus status) {
  return status == AgentStatus::kSensing || status == AgentStatus::kCharging;
}

}  // namespace

Timeline::Timeline(std::shared_ptr<const Scenario> scenario)
    : shared_(std::move(scenario)), scenario_(*shared_), row_(scenario_.row()) {
  agents_.resize(row_.size());
  agent_order_.resize(row_.size());
  tasks_.resize(scenario_.tasks.size());
}

void Timeline::Add(const Message& message) {
  Handle(
      message, [&](const agent_states_t& m) { TakeAgents(m); },
      [&](const world_state_t& m) {
        world_order_.Add(m.tick, m.header, m, [&](std::int64_t, const world_state_t& world) {
          TakeWorld(world, world.header.sim_us);
        });
      },
      [&](const rulings_t& m) {
        for (const ruling_t& ruling : m.rulings) {
          if (ruling.kind == RulingKind::kReleased) continue;
          const auto kind = static_cast<AgentKind>(ruling.agent_kind);
          const auto i = row_.Find(kind, ruling.agent_id);
          if (!i) continue;
          agents_[*i].failed_us = ruling.at_us;
          if (ruling.kind == RulingKind::kLost) Lose(&agents_[*i], ruling.at_us, m.header.sim_us);
        }
      },
      [&](const schedule_t& m) {
        if (decided_.insert(m.decision).second) schedules_.Push(m);
      },
      [&](const event_t& m) {
        if (known_events_
                .insert({m.at_us, m.kind, m.uav_id, m.worker_id, m.vehicle_id, m.task_id,
                         m.charge_id, m.fault_id, m.detail})
                .second) {
          events_.Push(m);
        }
      },
      [&](const clearances_t& m) {
        const auto list = FromWire(m, WireLimits(scenario_));
        if (!list || scenario_.separation() == nullptr) return;
        auto& of_decision = clearances_[m.decision];
        for (const Clearance& clearance : *list) {
          if (clearance.decision == m.decision) of_decision[clearance.uav] = clearance;
        }
      },
      [&](const fault_t& m) { faults_.try_emplace(m.fault_id, m); },
      [&](const process_status_t& m) { TakeProcess(m); },
      [&](const clock_t& m) {
        if (m.phase != ClockPhase::kReady) now_ms_ = std::max(now_ms_, Ms(m.tick_us));
        ended_ = ended_ || m.phase == ClockPhase::kEnded;
      });
}

void Timeline::Finish() {
  for (const AgentKind kind : kAgentKinds) {
    for (std::size_t id = 0; id < scenario_.agents(kind).size(); ++id) {
      const std::size_t index = IndexOf(kind, id);
      agent_order_[index].Finish([&](std::int64_t tick, const agent_t& agent) {
        TakeAgent(kind, index, agent, scenario_.rules.TimeOf(tick));
      });
    }
  }
  world_order_.Finish(
      [&](std::int64_t, const world_state_t& world) { TakeWorld(world, world.header.sim_us); });
}

void Timeline::TakeAgents(const agent_states_t& message) {
  if (message.tick > scenario_.rules.last_tick()) return;
  const auto kind = static_cast<AgentKind>(message.kind);
  if (kind == AgentKind::kUav) TakeHeights(message);
  for (const agent_t& agent : message.agents) {
    const auto i = row_.Find(kind, agent.id);
    if (!i) continue;
    agent_order_[*i].Add(message.tick, message.header, agent,
                         [&](std::int64_t tick, const agent_t& state) {
                           TakeAgent(kind, *i, state, scenario_.rules.TimeOf(tick));
                         });
  }
}

void Timeline::TakeHeights(const agent_states_t& message) {
  if (message.tick < 1) return;
  const auto planned = clearances_.find(scenario_.rules.DecisionAt(message.tick - 1));
  if (planned == clearances_.end()) return;
  const LandingPlaces landing(scenario_.charging_points);
  const TimeUs at_us = scenario_.rules.TimeOf(message.tick - 1);
  for (const agent_t& report : message.agents) {
    const auto clearance = planned->second.find(report.id);
    if (clearance == planned->second.end()) continue;
    const auto uav = FromWire(report, AgentKind::kUav, scenario_.rules.TimeOf(message.tick),
                              WireLimits(scenario_));
    if (!uav || uav->failed) continue;
    Height height{report.id, {}};
    for (const Trajectory::Knot& knot :
         TrajectoryOf(*uav, clearance->second, at_us, landing).knots) {
      height.knots.emplace_back(Ms(at_us + ToUs(knot.t_s)), knot.up_m);
    }
    if (!height.knots.empty()) heights_.Push(std::move(height));
    planned->second.erase(clearance);
  }
}

void Timeline::Lose(Agent* agent, std::int64_t at_us, std::int64_t now_us) {
  if (!agent->last || agent->last_us >= now_us) return;
  if (static_cast<AgentStatus>(agent->last->status) == AgentStatus::kFailed) return;
  Append(&agent->spans, at_us, AgentStatus::kFailed);
  agent->last->status = static_cast<std::int8_t>(AgentStatus::kFailed);
  agent->last->arrive_us = std::min(agent->last->arrive_us, at_us);
  agent->last_us = std::max(agent->last_us, at_us);
}

void Timeline::TakeAgent(AgentKind kind, std::size_t index, const agent_t& now,
                         std::int64_t now_us) {
  if (now.online_until_us == 0) return;  // never online: nobody, or nobody yet
  Agent& agent = agents_[index];
  Move(kind, &agent, now, now_us);
  Change(kind, &agent, now, now_us);
  agent.last = now;
  agent.last_us = now_us;
}

void Timeline::PassCorners(AgentKind kind, const Agent& agent, std::int64_t until_us,
                           Growing<Stop>* stops) const {
  if (scenario_.ways->straight(kind) || agent.last->arrive_us <= agent.last_us) return;
  const auto leg = FromWire(*agent.last, kind, agent.last_us, WireLimits(scenario_));
  if (!leg) return;
  const TimeUs set_out_us = leg->depart_us + HoldUs(*leg);
  const auto duration_us = static_cast<double>(leg->arrive_us - set_out_us);
  for (const Ways::Corner& corner : leg->leg_ways->Corners(kind, leg->from, leg->to)) {
    const std::int64_t at_us = set_out_us + std::llround(corner.share * duration_us);
    if (at_us > agent.last_us && at_us < until_us) {
      Append(stops, {Ms(at_us), corner.at.x_m, corner.at.y_m, 0});
    }
  }
}

void Timeline::Move(AgentKind kind, Agent* agent, const agent_t& now, std::int64_t now_us) {
  if (agent->last) {
    const agent_t& last = *agent->last;
    PassCorners(
        kind, *agent,
        std::min({now_us, last.arrive_us, now.depart_us > agent->last_us ? now.depart_us : now_us}),
        &agent->stops);
    // The previous leg's end and the next one's start are known exactly.
    if (last.arrive_us > agent->last_us && last.arrive_us < now_us &&
        now.depart_us == last.depart_us) {
      // Where it stands now is where that leg led; its range falls on the way only.
      const double on_way =
          scenario_.ways->Length(AgentKind::kUav, {last.x_m, last.y_m}, {now.x_m, now.y_m});
      const double range =
          now.status == AgentStatus::kWaiting
              ? now.range_left_m
              : std::max(0.0, last.range_left_m - (last.range_full_m > 0 ? on_way : 0));
      Append(&agent->stops, {Ms(last.arrive_us), now.x_m, now.y_m, range});
    }
    if (now.depart_us > agent->last_us && now.depart_us < now_us &&
        now.depart_us != last.depart_us) {
      Append(&agent->stops,
             {Ms(now.depart_us), now.from_x_m, now.from_y_m, now.range_at_departure_m});
    }
  }
  Append(&agent->stops, {Ms(now_us), now.x_m, now.y_m, now.range_left_m});
}

const activity_t* Timeline::ActivityOf(AgentKind kind, std::int32_t id) const {
  const auto found = latest_activity_.find({kind, id});
  return found == latest_activity_.end() ? nullptr : &activities_.rows[found->second];
}

void Timeline::Change(AgentKind kind, Agent* agent, const agent_t& now, std::int64_t now_us) {
  const auto status = static_cast<AgentStatus>(now.status);
  if (!agent->last) {
    Append(&agent->spans, now_us, status);
    return;
  }
  const agent_t& last = *agent->last;
  const auto before = static_cast<AgentStatus>(last.status);
  if (before == status) return;
  const std::int64_t since = agent->last_us;
  const activity_t* activity = ActivityOf(kind, now.id);
  const std::int64_t start_us = activity == nullptr ? -1 : activity->start_us;
  const std::int64_t end_us = activity == nullptr ? -1 : activity->end_us;

  // What came between the two ticks, where it is known exactly.
  if (before == AgentStatus::kMoving && Active(status) && last.arrive_us > since &&
      last.arrive_us < start_us) {
    Append(&agent->spans, last.arrive_us, AgentStatus::kWaiting);
  }
  if (Active(before) && status != AgentStatus::kFailed && end_us > since && end_us < now_us) {
    Append(&agent->spans, end_us, AgentStatus::kIdle);
  }
  switch (status) {
    case AgentStatus::kOffline:
      Append(&agent->spans, FirstWithin(since, now_us, {now.online_until_us}), status);
      break;
    case AgentStatus::kFailed:
      Append(&agent->spans, FirstWithin(since, now_us, {agent->failed_us}), status);
      break;
    case AgentStatus::kIdle:
      Append(&agent->spans,
             FirstWithin(since, now_us,
                         {last.busy_until_us, last.arrive_us, end_us, now.online_from_us}),
             status);
      break;
    case AgentStatus::kMoving:
      Append(&agent->spans, FirstWithin(since, now_us, {now.depart_us}), status);
      break;
    case AgentStatus::kNotReady:
      Append(&agent->spans, now_us, status);
      break;
    case AgentStatus::kWaiting:
      Append(&agent->spans, FirstWithin(since, now_us, {now.arrive_us}), status);
      break;
    case AgentStatus::kSensing:
    case AgentStatus::kCharging:
      Append(&agent->spans, FirstWithin(since, now_us, {start_us}), status);
      break;
  }
}

void Timeline::TakeWorld(const world_state_t& world, std::int64_t now_us) {
  const std::int64_t t_ms = Ms(now_us);
  if (world.task_status.size() != tasks_.size()) return;
  for (std::size_t x = 0; x < tasks_.size(); ++x) {
    const std::int8_t status = world.task_status[x];
    const auto& rows = tasks_[x].rows;
    const int before = rows.empty() ? 0 : rows.back().status;
    if (status != before) tasks_[x].Push({t_ms, status});
  }
  if (done_.rows.empty() || done_.rows.back().tasks != world.done) {
    done_.Push({t_ms, world.done});
  }
  for (const activity_t& a : world.activities) {
    if (!known_activities_.insert({a.kind, a.uav_id, a.partner_id, a.site_id, a.start_us}).second) {
      continue;
    }
    const auto partner = PartnerKind(static_cast<Activity::Kind>(a.kind));
    latest_activity_[{AgentKind::kUav, a.uav_id}] = activities_.rows.size();
    latest_activity_[{partner, a.partner_id}] = activities_.rows.size();
    activities_.Push(a);
  }
}

void Timeline::TakeProcess(const process_status_t& status) {
  Growing<ProcessSample>& samples = processes_[status.name];
  ProcessSample sample{Ms(status.header.sim_us),
                       status.header.wall_us,
                       status.header.boot_id,
                       status.received,
                       status.lost,
                       status.rejected,
                       status.resent,
                       status.cpu_s,
                       status.rss_bytes,
                       status.state,
                       status.header.wall_us};
  auto& rows = samples.rows;
  if (!rows.empty() && std::tie(sample.boot_id, sample.wall_us, sample.t_ms) <
                           std::tie(rows.back().boot_id, rows.back().wall_us, rows.back().t_ms)) {
    return;  // said again, late
  }
  if (!rows.empty() && rows.back().boot_id == sample.boot_id && rows.back().state == sample.state) {
    sample.since_wall_us = rows.back().since_wall_us;
  }
  // The newest always stays; of the rest, every so many-th.
  std::size_t& every = sample_every_.try_emplace(status.name, 1).first->second;
  std::size_t& skipped = samples_skipped_[status.name];
  if (rows.size() >= 2 && ++skipped < every && rows.back().state == sample.state) {
    samples.ReplaceLast(sample);
    return;
  }
  skipped = 0;
  if (rows.size() >= kSamples) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < rows.size(); i += 2) rows[kept++] = rows[i];
    rows.resize(kept);
    ++samples.rebuilt;
    every *= 2;
  }
  samples.Push(sample);
}

}  // namespace muster::tools
