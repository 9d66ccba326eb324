#include "tests/tools/fake_mission.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "base/sha256.h"
#include "lcmtypes/channels.h"

namespace muster::tools {
namespace {

constexpr std::int64_t kMinute = 60'000'000;
constexpr std::int64_t kInterval = 10 * kMinute;
constexpr std::int64_t kLimit = 30 * kMinute;
constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();

struct Place {
  double x_m, y_m;
};

constexpr Place kTasks[] = {{4000, 1000}, {9000, 9000}};
constexpr Place kCharge = {6000, 1000};
constexpr double kUavSpeed = 1000.0 / 60, kWorkerSpeed = 500.0 / 60, kVehicleSpeed = 750.0 / 60;
constexpr double kFull_m = 30000;
constexpr double kChargeRate = 6000.0 / 60;

double Way(Place a, Place b) {
  const double dx = a.x_m - b.x_m, dy = a.y_m - b.y_m;
  return std::sqrt(dx * dx + dy * dy);
}

std::int64_t Us(double seconds) { return std::llround(seconds * 1e6); }

struct Agent {
  int kind, id;
  double speed;
  Place from, to;
  std::int64_t depart = 0, arrive = 0, busy_until = 0;
  double range_at_departure = 0;
  int action = -1, target = -1, partner = -1, decision = -1;
  std::int64_t start = -1, end = -1;  // of its activity
  double cost = 0;

  Place At(std::int64_t t) const {
    if (t >= arrive) return to;
    if (t <= depart) return from;
    const double f = static_cast<double>(t - depart) / static_cast<double>(arrive - depart);
    return {from.x_m + (to.x_m - from.x_m) * f, from.y_m + (to.y_m - from.y_m) * f};
  }
  double RangeAt(std::int64_t t) const {
    if (kind != 0) return 0;
    if (t < arrive) return range_at_departure - Way(from, At(t));
    const double arrived = range_at_departure - Way(from, to);
    if (start < 0 || t <= start) return arrived;
    const double f =
        std::min(1.0, static_cast<double>(t - start) / static_cast<double>(end - start));
    return action == 7 ? arrived - cost * f : arrived + (kFull_m - arrived) * f;
  }
  int StatusAt(std::int64_t t) const {
    if (busy_until <= t) return 1;
    if (t < arrive) return 2;
    if (start < 0 || t < start) return 3;
    return action == 7 ? 4 : 5;
  }
  void SettleAt(std::int64_t t) {
    if (action < 0 || busy_until > t) return;
    range_at_departure = RangeAt(busy_until);
    from = to;
    depart = arrive = busy_until;
    action = target = partner = -1;
    start = end = -1;
  }
  void Go(int kind_of_action, Place where, std::int64_t now) {
    from = to;
    to = where;
    depart = now;
    arrive = now + Us(Way(from, to) / speed);
    busy_until = arrive;
    action = kind_of_action;
    start = end = -1;
  }
};

std::string ScenarioJson(std::int64_t tick_us, double task0_cost_m) {
  const auto agent = [](int id, Place at, double km_per_min) {
    return nlohmann::json{{"id", id},
                          {"x_km", at.x_m / 1000},
                          {"y_km", at.y_m / 1000},
                          {"speed_km_per_min", km_per_min},
                          {"online_from_min", 0},
                          {"online_until_min", 60}};
  };
  const auto uav = [&](int id, Place at) {
    nlohmann::json json = agent(id, at, 1);
    json["full_range_km"] = json["range_km"] = 30;
    return json;
  };
  nlohmann::json vehicle = agent(0, {8000, 1000}, 0.75);
  vehicle["charge_km_per_min"] = 6;
  const nlohmann::json scenario = {
      {"version", 1},
      {"name", "by hand"},
      {"seed", 5},
      {"area_km", {10, 10}},
      {"interval_min", 10},
      {"limit_min", 30},
      {"rules", {{"tick_s", tick_us / 1'000'000}}},
      {"uavs", {uav(0, {1000, 1000}), uav(1, {9000, 8000})}},
      {"workers", {agent(0, {1000, 3000}, 0.5), agent(1, {9000, 7000}, 0.5)}},
      {"vehicles", {vehicle}},
      {"tasks",
       {{{"id", 0}, {"x_km", 4}, {"y_km", 1}, {"cost_km", task0_cost_m / 1000}},
        {{"id", 1}, {"x_km", 9}, {"y_km", 9}, {"cost_km", 2}}}},
      {"charging_points", {{{"id", 0}, {"x_km", 6}, {"y_km", 1}}}},
  };
  return scenario.dump();
}

class Mission {
 public:
  Mission(std::int64_t tick_us, double task0_cost_m)
      : tick_us_(tick_us), costs_{task0_cost_m, 2000} {
    agents_ = {
        {0, 0, kUavSpeed, {1000, 1000}, {1000, 1000}},
        {0, 1, kUavSpeed, {9000, 8000}, {9000, 8000}},
        {1, 0, kWorkerSpeed, {1000, 3000}, {1000, 3000}},
        {1, 1, kWorkerSpeed, {9000, 7000}, {9000, 7000}},
        {2, 0, kVehicleSpeed, {8000, 1000}, {8000, 1000}},
    };
    agents_[0].range_at_departure = agents_[1].range_at_departure = kFull_m;
  }

  FakeLog Run() {
    scenario_t scenario{};
    scenario.json = ScenarioJson(tick_us_, costs_[0]);
    scenario.sha256 = Sha256(scenario.json);
    Say("world", channel::kScenario, scenario, 0);
    for (const char* name : {"world", "uav", "worker", "vehicle", "scheduler"}) {
      SayStatus(name, 1, -1, 0);
    }
    for (const Agent& agent : agents_) {
      SayEvent(0, 0, agent.kind == 0 ? agent.id : -1, agent.kind == 1 ? agent.id : -1,
               agent.kind == 2 ? agent.id : -1, -1, -1);
    }
    const std::int64_t last_tick = kLimit / tick_us_;
    for (std::int64_t tick = 0; tick <= last_tick; ++tick) Tick(tick, last_tick);
    clock_t clock = Clock(last_tick);
    clock.phase = 2;
    Say("world", channel::kClock, clock, kLimit);
    for (const char* name : {"world", "uav", "worker", "vehicle", "scheduler"}) {
      SayStatus(name, 4, last_tick, kLimit);
    }
    return std::move(log_);
  }

 private:
  template <class Message>
  void Say(const char* sender, std::string_view on, Message message, std::int64_t t) {
    message.header.run_id = 7;
    message.header.sender = sender;
    message.header.boot_id = 0;
    message.header.seq = next_seq_[sender]++;
    message.header.sim_us = t;
    message.header.wall_us = 1'000'000 + t / 1000;
    log_.push_back({std::string(on), std::move(message)});
  }

  void SayStatus(const char* name, std::int8_t state, std::int64_t tick, std::int64_t t) {
    process_status_t status{};
    status.name = name;
    status.host = "host";
    status.pid = 100;
    status.state = state;
    status.tick = tick;
    status.received = state == 4 ? 50 : 0;
    status.lost = state == 4 ? 2 : 0;
    status.rejected = 0;
    status.resent = state == 4 ? 1 : 0;
    status.cpu_s = 0.25;
    status.rss_bytes = 1 << 20;
    Say(name, channel::kProcess, status, t);
  }

  void SayEvent(std::int8_t kind, std::int64_t at, int uav, int worker, int vehicle, int task,
                int charge) {
    event_t event{};
    event.kind = kind;
    event.at_us = at;
    event.uav_id = uav;
    event.worker_id = worker;
    event.vehicle_id = vehicle;
    event.task_id = task;
    event.charge_id = charge;
    Say("world", channel::kEvent, event, now_us_);
  }

  clock_t Clock(std::int64_t tick) const {
    const std::int64_t t = tick * tick_us_;
    clock_t clock{};
    clock.tick = tick;
    clock.tick_us = t;
    clock.limit_us = kLimit;
    clock.decision =
        t % kInterval == 0 && t < kLimit ? static_cast<std::int32_t>(t / kInterval) : -1;
    clock.required_decision =
        t == 0 ? -1 : static_cast<std::int32_t>((std::min(t, kLimit) - 1) / kInterval);
    clock.phase = 1;
    return clock;
  }

  void Tick(std::int64_t tick, std::int64_t last_tick) {
    now_us_ = tick * tick_us_;
    const std::int64_t t = tick * tick_us_;
    const clock_t clock = Clock(tick);
    Say("world", channel::kClock, clock, t);
    SayAgents(0, "uav", channel::kUavs, tick);
    SayAgents(1, "worker", channel::kWorkers, tick);
    SayAgents(2, "vehicle", channel::kVehicles, tick);
    SayWorld(tick);
    rulings_t rulings{};
    rulings.tick = tick;
    rulings.n = 0;
    Say("world", channel::kRulings, rulings, t);
    for (Agent& agent : agents_) agent.SettleAt(t);
    if (clock.decision >= 0 && tick < last_tick) Decide(clock.decision, tick);
  }

  void SayAgents(int kind, const char* sender, std::string_view on, std::int64_t tick) {
    const std::int64_t t = tick * tick_us_;
    agent_states_t states{};
    states.kind = static_cast<std::int8_t>(kind);
    states.tick = tick;
    states.applied_decision = Clock(tick).required_decision;
    for (Agent agent : agents_) {
      if (agent.kind != kind) continue;
      // An agent learns of its activity from the world's word on its first tick.
      if (agent.start >= 0 && agent.depart == t - tick_us_) {
        agent.start = agent.end = -1;
        agent.busy_until = kForever;
      }
      agent_t a{};
      a.id = agent.id;
      a.x_m = agent.At(t).x_m;
      a.y_m = agent.At(t).y_m;
      a.speed_m_s = agent.speed;
      a.range_left_m = agent.RangeAt(t);
      a.range_full_m = kind == 0 ? kFull_m : 0;
      a.charge_rate_m_s = kind == 2 ? kChargeRate : 0;
      a.from_x_m = agent.from.x_m;
      a.from_y_m = agent.from.y_m;
      a.range_at_departure_m = agent.range_at_departure;
      a.depart_us = agent.depart;
      a.arrive_us = agent.arrive;
      a.online_from_us = 0;
      a.online_until_us = 2 * kLimit;
      a.busy_until_us = agent.busy_until;
      a.status = static_cast<std::int8_t>(agent.StatusAt(t));
      a.action = static_cast<std::int8_t>(agent.action);
      a.target_id = agent.target;
      a.partner_id = agent.partner;
      a.decision = agent.decision;
      states.agents.push_back(a);
    }
    states.n = static_cast<std::int32_t>(states.agents.size());
    Say(sender, on, states, t);
  }

  void SayWorld(std::int64_t tick) {
    const std::int64_t t = tick * tick_us_;
    const std::int64_t before = t - tick_us_;
    world_state_t world{};
    world.tick = tick;
    world.n_tasks = 2;
    world.task_status = {0, 0};
    world.done = 0;
    for (const activity_t& a : activities_) {
      if (a.kind == 0) {
        const int status = a.end_us <= t ? 3 : a.start_us <= t ? 2 : 1;
        world.task_status[static_cast<std::size_t>(a.site_id)] = static_cast<std::int8_t>(status);
        if (status == 3) ++world.done;
      }
      const auto due = [&](std::int64_t at) { return before < at && at <= t; };
      const bool sensing = a.kind == 0;
      const auto say = [&](int kind, std::int64_t at) {
        SayEvent(static_cast<std::int8_t>(kind), at, a.uav_id, sensing ? a.partner_id : -1,
                 sensing ? -1 : a.partner_id, sensing ? a.site_id : -1, sensing ? -1 : a.site_id);
      };
      if (due(a.start_us)) say(sensing ? 4 : 7, a.start_us);
      if (due(a.end_us)) say(sensing ? 5 : 8, a.end_us);
      if (a.end_us > before) world.activities.push_back(a);
    }
    world.n_activities = static_cast<std::int32_t>(world.activities.size());
    Say("world", channel::kWorld, world, t);
  }

  Agent& Find(int kind, int id) {
    return *std::find_if(agents_.begin(), agents_.end(),
                         [&](const Agent& a) { return a.kind == kind && a.id == id; });
  }

  action_t Command(int kind, int uav, int worker, int vehicle, int task, int charge, double weight,
                   std::int64_t now, std::int32_t decision) {
    const Place to = task >= 0     ? kTasks[task]
                     : charge >= 0 ? kCharge
                     : uav >= 0    ? Find(0, uav).to
                     : worker >= 0 ? Find(1, worker).to
                                   : Find(2, vehicle).to;
    Agent* members[] = {uav >= 0 ? &Find(0, uav) : nullptr,
                        worker >= 0 ? &Find(1, worker) : nullptr,
                        vehicle >= 0 ? &Find(2, vehicle) : nullptr};
    for (Agent* agent : members) {
      if (agent == nullptr) continue;
      agent->decision = decision;
      if (kind <= 2) continue;
      agent->Go(kind, to, now);
      agent->target = task >= 0 ? task : charge;
      if (kind == 7) agent->partner = agent->kind == 0 ? worker : uav;
      if (kind == 8) agent->partner = agent->kind == 0 ? vehicle : uav;
    }
    if (kind == 7 || kind == 8) {
      Agent& u = *members[0];
      Agent& p = kind == 7 ? *members[1] : *members[2];
      activity_t a{};
      a.kind = kind == 7 ? 0 : 1;
      a.uav_id = uav;
      a.partner_id = p.id;
      a.site_id = kind == 7 ? task : charge;
      a.start_us = std::max(u.arrive, p.arrive);
      const double seconds =
          kind == 7 ? costs_[task] / kUavSpeed
                    : (kFull_m - (u.range_at_departure - Way(u.from, u.to))) / kChargeRate;
      a.end_us = a.start_us + Us(seconds);
      if (kind == 7) u.cost = costs_[task];
      u.start = p.start = a.start_us;
      u.end = p.end = u.busy_until = p.busy_until = a.end_us;
      activities_.push_back(a);
    }
    return {
        static_cast<std::int8_t>(kind), uav, worker, vehicle, task, charge, to.x_m, to.y_m, weight};
  }

  void Decide(std::int32_t d, std::int64_t tick) {
    const std::int64_t t = tick * tick_us_;
    schedule_t schedule{};
    schedule.decision = d;
    schedule.tick = tick;
    schedule.policy = "by-hand";
    schedule.candidates = 20 + d;
    schedule.solve_us = 1000 * (d + 1);
    schedule.bound = d == 1 ? std::numeric_limits<double>::quiet_NaN() : 10.0 + d;
    auto& actions = schedule.actions;
    if (d == 0) {
      actions.push_back(Command(1, -1, 1, -1, -1, -1, 0.693, t, d));
      actions.push_back(Command(3, 1, -1, -1, 1, -1, 0.1 + 0.2, t, d));
      actions.push_back(Command(6, -1, -1, 0, -1, 0, 1.0 / 3, t, d));
      actions.push_back(Command(7, 0, 0, -1, 0, -1, 2.5, t, d));
    } else if (d == 1) {
      actions.push_back(Command(7, 1, 1, -1, 1, -1, 2.25, t, d));
      actions.push_back(Command(8, 0, -1, 0, -1, 0, 1.125, t, d));
    } else {
      actions.push_back(Command(0, 0, -1, -1, -1, -1, 0.693, t, d));
      actions.push_back(Command(5, 1, -1, -1, -1, 0, 0.75, t, d));
    }
    schedule.n = static_cast<std::int32_t>(actions.size());
    schedule.weight = 0;
    for (const action_t& action : actions) schedule.weight += action.weight;
    Say("scheduler", channel::kSchedule, schedule, t);
  }

  std::int64_t tick_us_;
  std::int64_t now_us_ = 0;  ///< of the tick under way
  double costs_[2];
  std::vector<Agent> agents_;
  std::vector<activity_t> activities_;
  std::map<std::string, std::int64_t> next_seq_;
  FakeLog log_;
};

}  // namespace

header_t& FakeMessage::header() {
  return std::visit([](auto& message) -> header_t& { return message.header; }, body);
}

Packet FakeMessage::Encoded() const {
  return std::visit([&](const auto& message) { return Packet{channel, Encode(message)}; }, body);
}

FakeLog MakeFakeMission(std::int64_t tick_us, double task0_cost_m) {
  return Mission(tick_us, task0_cost_m).Run();
}

void Renumber(FakeLog* log) {
  std::map<std::pair<std::string, std::int64_t>, std::int64_t> next;
  for (FakeMessage& message : *log) {
    header_t& header = message.header();
    header.seq = next[{header.sender, header.boot_id}]++;
  }
}

std::vector<Packet> Encoded(const FakeLog& log) {
  std::vector<Packet> packets;
  packets.reserve(log.size());
  for (const FakeMessage& message : log) packets.push_back(message.Encoded());
  return packets;
}

}  // namespace muster::tools
