#include "agents/core/agent_process.h"

#include <algorithm>
#include <muster/agent_states_t.hpp>

#include "lcmtypes/channels.h"
#include "world/model/check.h"
#include "world/model/scenario_json.h"

namespace muster::agents {
namespace {

/// Agents a message: keeps it near one datagram's 64 kB, so that little is lost with a fragment.
constexpr std::size_t kAgentsPerMessage = 256;

std::string_view ChannelOf(AgentKind kind) {
  return kind == AgentKind::kUav      ? channel::kUavs
         : kind == AgentKind::kWorker ? channel::kWorkers
                                      : channel::kVehicles;
}

std::int32_t MemberOf(const Action& action, AgentKind kind) {
  return kind == AgentKind::kUav      ? action.uav.value
         : kind == AgentKind::kWorker ? action.worker.value
                                      : action.vehicle.value;
}

/// Converts all or nothing.
template <class Wire, class Model>
bool FromWireAll(const std::vector<Wire>& wires, const WireLimits& limits,
                 std::vector<Model>* out) {
  for (const Wire& wire : wires) {
    const std::optional<Model> model = FromWire(wire, limits);
    if (!model) return false;
    out->push_back(*model);
  }
  return true;
}

}  // namespace

AgentProcess::AgentProcess(Identity identity, int window, AgentKind kind, IdRange ids)
    : Process(std::move(identity), window), kind_(kind), ids_(ids) {}

void AgentProcess::OnMessage(const Message& message, const Packet&, const Now&) {
  if (!scenario_) {
    if (const auto* scenario = std::get_if<scenario_t>(&message)) Take(*scenario);
    return;
  }
  Handle(
      message, [&](const clock_t& clock) { Take(clock); },
      [&](const world_state_t& world) { Take(world); },
      [&](const rulings_t& rulings) { Take(rulings); },
      [&](const schedule_t& schedule) { Take(schedule); });
}

void AgentProcess::Take(const scenario_t& message) {
  try {
    scenario_ = ParseScenario(message.json, "scenario");
  } catch (const InputError&) {
    inbox().Reject();
    return;
  }
  const auto& specs = scenario_->agents(kind_);
  const auto n = static_cast<std::int32_t>(specs.size());
  const auto [first, last] = ids_.value_or(std::pair(0, n - 1));
  if (first < 0 || last >= n || first > last) {
    throw InputError("command line", "--ids", fmt::format("{}-{}", first, last),
                     fmt::format("ids of the scenario's {}s, 0-{}", ToString(kind_), n - 1));
  }
  for (std::int32_t id = first; id <= last; ++id) {
    agents_.push_back(StartOf(kind_, id, specs[static_cast<std::size_t>(id)]));
  }
  set_state(ProcessState::kReady);
}

void AgentProcess::Take(const clock_t& clock) {
  if (clock.phase == 2) set_state(ProcessState::kEnded);
  if (clock.phase == 1 && state() == ProcessState::kReady) set_state(ProcessState::kRunning);
  if (clock.tick == tick_) clock_repeated_ = clock.phase < 2;
  if (clock.tick == tick_ + 1) clock_ = clock;
}

void AgentProcess::Take(const world_state_t& world) {
  if (world.tick != tick_ || activities_) return;
  std::vector<Activity> activities;
  if (FromWireAll(world.activities, WireLimits(*scenario_), &activities)) {
    activities_ = std::move(activities);
  } else {
    inbox().Reject();
  }
}

void AgentProcess::Take(const rulings_t& rulings) {
  if (rulings.tick != tick_ || rulings_) return;
  std::vector<Ruling> list;
  if (FromWireAll(rulings.rulings, WireLimits(*scenario_), &list)) {
    rulings_ = std::move(list);
  } else {
    inbox().Reject();
  }
}

void AgentProcess::Take(const schedule_t& schedule) {
  if (schedule.tick != tick_ || schedule.decision != applied_decision_ + 1 || schedule_) return;
  std::vector<Action> actions;
  if (FromWireAll(schedule.actions, WireLimits(*scenario_), &actions)) {
    schedule_ = std::move(actions);
    schedule_decision_ = schedule.decision;
  } else {
    inbox().Reject();
  }
}

bool AgentProcess::CanAdvance() const {
  if (!clock_ || clock_->tick != tick_ + 1) return false;
  if (tick_ < 0) return true;
  return activities_ && rulings_ &&
         (clock_->required_decision <= applied_decision_ ||
          (schedule_ && schedule_decision_ == clock_->required_decision));
}

void AgentProcess::OnStep(const Now& now) {
  if (!scenario_) {
    if (request_.due_us() == kNever) request_.Start(now.monotonic_us);
    if (request_.Fire(now.monotonic_us)) {
      request_t request{};
      request.channel = channel::kScenario;
      sender().Send(channel::kRequest, std::move(request), 0, now);
    }
    return;
  }
  request_.Stop();
  if (CanAdvance()) {
    Advance(now);
  } else if (clock_repeated_) {
    for (const SentPacket& packet : states_packets_) sender().Resend(packet);
  }
  clock_repeated_ = false;
}

void AgentProcess::Advance(const Now& now) {
  if (tick_ >= 0) {
    const Verdict verdict(std::move(*activities_), std::move(*rulings_));
    for (AgentState& agent : agents_) Settle(&agent, verdict, tick_us_, scenario_->tasks);
    if (clock_->required_decision > applied_decision_) {
      Apply(*schedule_, schedule_decision_, tick_us_);
      applied_decision_ = schedule_decision_;
    }
  }
  tick_ = clock_->tick;
  tick_us_ = clock_->tick_us;
  clock_.reset();
  activities_.reset();
  rulings_.reset();
  schedule_.reset();
  set_sim_us(tick_us_);
  PublishStates(now);
}

void AgentProcess::Apply(const std::vector<Action>& actions, std::int32_t decision, TimeUs t) {
  for (const Action& action : actions) {
    const std::int32_t id = MemberOf(action, kind_);
    if (id < agents_.front().id || id > agents_.back().id) continue;
    AgentState& agent = agents_[static_cast<std::size_t>(id - agents_.front().id)];
    if (!agent.idle(t)) continue;  // a command for a busy agent is refused: its partner is released
    if (IsPair(action.kind) &&
        MatchFails(action, decision, scenario_->disturbances, scenario_->seed)) {
      continue;
    }
    Begin(&agent, action, decision, t, scenario_->disturbances, scenario_->seed);
  }
}

void AgentProcess::PublishStates(const Now& now) {
  states_packets_.clear();
  for (std::size_t first = 0; first < agents_.size(); first += kAgentsPerMessage) {
    const std::size_t last = std::min(agents_.size(), first + kAgentsPerMessage);
    agent_states_t states{};
    states.kind = static_cast<std::int8_t>(kind_);
    states.tick = tick_;
    states.applied_decision = applied_decision_;
    states.n = static_cast<std::int32_t>(last - first);
    for (std::size_t i = first; i < last; ++i) {
      states.agents.push_back(ToWire(agents_[i], tick_us_, scenario_->tasks));
    }
    states_packets_.push_back(sender().Send(ChannelOf(kind_), std::move(states), tick_us_, now));
  }
}

}  // namespace muster::agents
