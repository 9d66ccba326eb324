#include "tools/trials/campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>

#include "base/random.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "protocol/fault_kinds.h"
#include "tools/audit/auditor.h"
#include "tools/audit/report_check.h"
#include "tools/explain/redecide.h"
#include "tools/log/packet_source.h"
#include "tools/record/digest.h"
#include "tools/record/report_json.h"
#include "tools/trials/draws.h"
#include "tools/trials/truthful_drivers.h"

namespace muster::tools {
namespace {

/// Quick enough for thousands of missions, each another way to decide.
constexpr const char* kPolicies[] = {"certified", "mpq", "mpq-uniform", "kwta", "greedy-sum"};
constexpr TimeUs kLostAfterUs = kSecondUs / 2;

/// Small and crowded, so that much happens in little time.
GeneratorSettings DrawSettings(Random* random) {
  const auto between = [&](int low, int high) {
    return low + static_cast<int>(random->Below(static_cast<std::uint32_t>(high - low + 1)));
  };
  GeneratorSettings settings;
  settings.name = "soak";
  settings.width_km = between(5, 20);
  settings.height_km = between(5, 20);
  settings.uavs = between(1, 12);
  settings.workers = between(1, 15);
  settings.vehicles = between(1, 6);
  settings.tasks = between(1, 50);
  settings.charging_points = between(1, 6);
  settings.online_min = {static_cast<double>(between(20, 60)), kUpToLimit};
  settings.task_cost_km = {1, static_cast<double>(between(1, 6))};
  settings.start_fraction = {0.3, 1};
  if (random->Below(4) == 0) settings.capacity.reset();
  if (random->Below(2) == 0) settings.placement = Placement::kContinuous;
  if (random->Below(2) == 0) settings.uptime = Uptime::kAnyTime;
  Rules& rules = settings.rules;
  rules.limit_us = between(6, 18) * 10 * kMinuteUs;
  rules.interval_us = (random->Below(2) == 0 ? 5 : 10) * kMinuteUs;
  rules.tick_us = (random->Below(2) == 0 ? 30 : 15) * kSecondUs;
  if (random->Below(2) == 0) rules.availability = Availability::kStrict;
  Disturbances& disturbances = settings.disturbances;
  if (random->Below(3) == 0) disturbances.wind = {0.1, 0.4};
  if (random->Below(3) == 0) disturbances.communication_m = {100, 500};
  if (random->Below(3) == 0) disturbances.agent_failure = {0.01, 0.05};
  if (random->Below(3) == 0) disturbances.match_failure = {0.05, 0.1};
  return settings;
}

/// Some of the orders, in time or too late.
void DrawWithdrawals(std::uint64_t seed, std::vector<world::PlannedOrder>* orders) {
  Random random(seed, Stream::kSoak, 9);
  const std::vector<world::PlannedOrder> all = *orders;
  for (const world::PlannedOrder& one : all) {
    if (random.Below(10) > 0) continue;
    const int early_min = static_cast<int>(random.Below(6)) - 2;
    const auto at_min = std::max<TimeUs>(0, one.order.not_before_us / kMinuteUs - early_min);
    const std::string json = fmt::format(
        "{{\"at_min\": {}, \"order\": \"withdraw\", \"withdraws\": \"{}\"}}", at_min, one.order.id);
    world::PlannedOrder planned{ParseOrder(json, "order"), json};
    planned.order.id = "withdraw-" + one.order.id;
    planned.order.issuer = "drawn";
    orders->push_back(std::move(planned));
  }
}

void DrawOrders(std::uint64_t seed, VirtualMission* mission) {
  Random random(seed, Stream::kSoak, 5);
  AddRoom({random.Below(40), {3, 3, 3}}, &mission->scenario);
  for (auto* draw : {&DrawTaskOrders, &DrawDirectives}) {
    if (random.Below(3) == 0) continue;
    for (world::PlannedOrder& order : draw(mission->scenario, &random)) {
      mission->orders.push_back(std::move(order));
    }
  }
  DrawWithdrawals(seed, &mission->orders);
}

/// All agents of some classes are measured; every other one of them has a driver. In half of these
/// missions some are not ready at times, if `some_wait`.
void DrawDrivers(std::uint64_t seed, bool some_wait, VirtualMission* mission) {
  Scenario& scenario = mission->scenario;
  PerKind<std::size_t> measured = {};
  Random random(seed, Stream::kSoak, 6);
  for (const AgentKind kind : kAgentKinds) {
    if (random.Below(3) == 0) continue;
    measured[kind] = scenario.n_agents(kind);
    for (AgentSpec& agent : ByKind(kind, scenario.uavs, scenario.workers, scenario.vehicles)) {
      agent.measured = true;
    }
  }
  some_wait = some_wait && Random(seed, Stream::kSoak, 12).Below(2) == 0;
  mission->drivers = [seed, measured,
                      some_wait](AgentKind kind) -> std::unique_ptr<agents::DriverPort> {
    if (measured[kind] == 0) return nullptr;
    return std::make_unique<TruthfulDrivers>(seed, kind, measured[kind], nullptr, some_wait);
  };
}

/// With some of the processes that are killed, others die at the same moment, as all of a host do.
void DrawHosts(std::uint64_t seed, VirtualMission* mission) {
  Random random(seed, Stream::kSoak, 7);
  FaultPlan more;
  for (const PlannedFault& fault : mission->faults) {
    // Out of mission time all of them start again at once.
    if (fault.kind != FaultKind::kProcessKilled || fault.for_us > 0 ||
        fault.target == process_name::kLogger) {
      continue;
    }
    for (const std::string& name :
         simulation::ProcessNames(mission->schedulers, mission->per_class)) {
      if (name == fault.target || random.Below(3) > 0) continue;
      PlannedFault& other = more.emplace_back(fault);
      other.id = fmt::format("{}-{}", fault.id, name);
      other.target = name;
    }
  }
  mission->faults.insert(mission->faults.end(), more.begin(), more.end());
  std::stable_sort(mission->faults.begin(), mission->faults.end(),
                   [](const PlannedFault& a, const PlannedFault& b) { return a.at_us < b.at_us; });
}

/// In one mission in three, the clocks of some hosts are wrong by up to a day, or are set during
/// it.
void DrawClocks(std::uint64_t seed, VirtualMission* mission) {
  Random random(seed, Stream::kSoak, 8);
  if (random.Below(3) > 0) return;
  constexpr TimeUs kDayUs = 24 * 60 * kMinuteUs;
  // About as long as a mission takes.
  constexpr std::uint32_t kMissionMs = 500;
  mission->epoch_us = 10 * kDayUs;
  std::vector<std::string> names =
      simulation::ProcessNames(mission->schedulers, mission->per_class);
  names.emplace_back(process_name::kLauncher);
  for (const std::string& name : names) {
    for (std::uint32_t jumps = random.Below(3); jumps > 0; --jumps) {
      const bool before = random.Below(2) == 0;
      const TimeUs at_us = before ? 0 : 1000 * TimeUs{random.Below(kMissionMs)};
      mission->clock_jumps.push_back(
          {name, at_us, ToUs(ToSeconds(kDayUs) * random.Uniform(-1, 1))});
    }
  }
}

void DrawDecisions(std::uint64_t seed, VirtualMission* mission) {
  Random random(seed, Stream::kSoak, 10);
  if (random.Below(3) > 0) return;
  Scenario& scenario = mission->scenario;
  if (!scenario.takes_orders()) AddRoom({1, {}}, &scenario);
  const auto minutes = static_cast<std::uint32_t>(scenario.rules.limit_us / kMinuteUs);
  if (random.Below(2) == 0) {
    scenario.rules.emergencies_at_once = true;
    for (std::size_t i = 0; i < scenario.n_tasks(); ++i) {
      if (random.Below(4) > 0) continue;
      scenario.tasks[i].priority = Priority::kEmergency;
      if (random.Below(2) == 0) scenario.tasks[i].reported_us = random.Below(minutes) * kMinuteUs;
    }
  }
  for (std::uint32_t n = random.Below(8); n > 0; --n) {
    const std::string json =
        fmt::format(R"({{"at_min": {}, "order": "decide_now"}})", random.Below(4 * minutes) / 4.0);
    world::PlannedOrder planned{ParseOrder(json, "order"), json};
    planned.order.id = fmt::format("decision-{}", n);
    planned.order.issuer = "drawn";
    mission->orders.push_back(std::move(planned));
  }
}

void DrawExtras(const CampaignSettings& settings, std::uint64_t seed, VirtualMission* mission) {
  Random random(seed, Stream::kSoak, 4);
  const auto draws = [&](Extra extra) {
    const bool is_drawn = random.Below(3) == 0;
    return is_drawn && settings.extras.contains(extra);
  };
  const bool roads = draws(Extra::kRoads), zones = draws(Extra::kZones);
  const bool orders = draws(Extra::kOrders), measured = draws(Extra::kMeasured);
  const bool hosts = draws(Extra::kHosts);
  Scenario& scenario = mission->scenario;
  if (orders) DrawOrders(seed, mission);
  if (roads && !settings.scenario) DrawStreets(seed, &scenario);
  if (roads && scenario.roads) DrawClosures(&random, mission);
  if (zones && (!settings.scenario || scenario.air)) DrawZones(&random, mission);
  if (measured) DrawDrivers(seed, settings.extras.contains(Extra::kNotReady), mission);
  if (hosts) DrawHosts(seed, mission);
  if (settings.extras.contains(Extra::kClocks)) DrawClocks(seed, mission);
  if (settings.extras.contains(Extra::kDecisions)) DrawDecisions(seed, mission);
  if (settings.extras.contains(Extra::kLateZones)) DrawLateZones(seed, mission);
}

/// Bytes of repeats beside each byte that is said once. The more processes the world waits for, the
/// more often one of them is not heard, and all of them repeat themselves; so they do when a part
/// of all packets is lost.
double MostRepeats(const VirtualMission& mission) {
  const bool many = mission.per_class > 1 || mission.schedulers > 1;
  const bool loses =
      std::any_of(mission.faults.begin(), mission.faults.end(), [](const PlannedFault& fault) {
        return fault.kind == FaultKind::kLoss && fault.target == "*";
      });
  return 1.5 + (many ? 0.5 : 0) + (loses ? 0.5 : 0);
}

}  // namespace

VirtualMission DrawMission(const CampaignSettings& settings, std::uint64_t seed) {
  Random random(seed, Stream::kSoak);
  VirtualMission mission;
  mission.goes_on = settings.goes_on.value_or(seed % 2 == 0);
  mission.policy = settings.policy.empty()
                       ? kPolicies[random.Below(static_cast<std::uint32_t>(std::size(kPolicies)))]
                       : settings.policy;
  // Draws of their own: with more to draw, the other missions stay what they were.
  if (settings.policy.empty() && Random(seed, Stream::kSoak, 2).Below(8) == 0) {
    mission.policy = "neighbours:reach=4:loss=0.1";
  }
  if (settings.scenario) {
    mission.scenario = *settings.scenario;
  } else {
    mission.scenario = Generate(settings.preset ? *settings.preset : DrawSettings(&random), seed);
  }
  mission.lost_after_us = kLostAfterUs;
  mission.drop = settings.drop;
  mission.fault_seed = seed;
  mission.schedulers =
      settings.schedulers.value_or(1 + static_cast<int>(Random(seed, Stream::kSoak, 1).Below(3)));
  // Every third has two or three processes of each agent class.
  if (Random split(seed, Stream::kSoak, 3); split.Below(3) == 0) {
    const auto wanted = 2 + split.Below(2);
    const Scenario& of = mission.scenario;
    const std::size_t least = std::min({of.uavs.size(), of.workers.size(), of.vehicles.size()});
    mission.per_class = static_cast<int>(std::clamp<std::size_t>(least, 1, wanted));
  }
  RandomPlanSettings plan;
  plan.seed = seed;
  plan.per_class = mission.per_class;
  plan.schedulers = mission.schedulers;
  plan.rate_per_hour = settings.rate_per_hour;
  plan.kinds = settings.kinds;
  // An agent that has failed by chance, or whose range has ended, cannot fail by a fault.
  const Disturbances& chances = mission.scenario.disturbances;
  if (chances.agent_failure.on() || chances.wind.on() || chances.communication_m.on()) {
    std::erase_if(plan.kinds, [](FaultKind kind) { return RowOf(kind).of_agents(); });
  }
  plan.goes_on = mission.goes_on;
  mission.faults = DrawPlan(mission.scenario, plan);
  DrawExtras(settings, seed, &mission);
  return mission;
}

namespace {

/// Whether a fault is without effect because it is to make an agent fail that has failed before, as
/// its driver said.
bool IsOfAnAgentThatGaveUp(std::string_view line, const FaultPlan& faults,
                           const std::vector<Packet>& packets) {
  const auto fault = std::find_if(faults.begin(), faults.end(), [&](const PlannedFault& one) {
    return RowOf(one.kind).of_agents() && line.starts_with(fmt::format("fault {} (", one.id));
  });
  if (fault == faults.end()) return false;
  return std::any_of(packets.begin(), packets.end(), [&](const Packet& packet) {
    if (packet.channel != channel::kEvent) return false;
    const auto event = DecodeValid<event_t>(packet.bytes);
    if (!event || event->kind != EventKind::kAgentFailed ||
        !event->detail.starts_with("its driver"))
      return false;
    const PerKind<std::int32_t> ids = {event->uav_id, event->worker_id, event->vehicle_id};
    return std::any_of(std::begin(kAgentKinds), std::end(kAgentKinds), [&](AgentKind kind) {
      return ids[kind] >= 0 && fault->target == fmt::format("{}:{}", ToString(kind), ids[kind]);
    });
  });
}

}  // namespace

std::vector<std::string> FindingsOf(const VirtualMission& mission) {
  std::vector<Packet> packets;
  audit::Auditor auditor;
  VirtualMission watched = mission;
  watched.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t) {
    packets.push_back(*event.packet);
    auditor.Add(*event.packet);
  };
  const MissionResult result = RunVirtualMission(watched);

  std::vector<std::string> findings = result.problems;
  for (const std::string& line : result.without_effect) {
    if (!IsOfAnAgentThatGaveUp(line, mission.faults, packets)) findings.push_back(line);
  }
  const auto log = result.record.CheckComplete();
  if (!log.complete) {
    findings.push_back(fmt::format("the log is not complete: {} gaps, {} missing, {} said twice",
                                   log.gaps.size(), log.n_missing, log.repeated));
  }
  if (static_cast<double>(result.repeated_bytes) >
      MostRepeats(mission) * static_cast<double>(result.message_bytes)) {
    findings.push_back(fmt::format("too much of the log is repeats: {} bytes beside {}",
                                   result.repeated_bytes, result.message_bytes));
  }
  for (const audit::Violation& v : auditor.Finish()) {
    findings.push_back(
        fmt::format("audit, {:.1f} min: {}: {}", ToMinutes(v.at_us), v.invariant, v.text));
  }
  if (auditor.facts()) {
    for (const audit::Violation& v :
         audit::CheckReportFile(Report(result.record), *auditor.facts())) {
      findings.push_back(fmt::format("report: {}: {}", v.invariant, v.text));
    }
  }
  PacketSource source(packets);
  for (const Divergence& d : DivergencesOf(Redecide(ReadDecisionLog(&source), ""))) {
    findings.push_back(fmt::format("decision {} made again: {}", d.decision, d.what));
  }
  if (!mission.goes_on && !mission.drivers && Digest(result.record) != UndisturbedDigest(mission)) {
    findings.push_back("decisions or outcomes are not those without faults");
  }
  return findings;
}

}  // namespace muster::tools
