#include "tools/faults/random_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "base/check.h"
#include "base/random.h"
#include "model/agent.h"
#include "protocol/fault_kinds.h"

namespace muster::tools {
namespace {

constexpr std::array<std::string_view, 6> kMembers = {
    ToString(AgentKind::kUav), ToString(AgentKind::kWorker), ToString(AgentKind::kVehicle),
    process_name::kScheduler,  process_name::kWorld,         process_name::kLogger};
constexpr std::uint32_t kReplaceable = 4;  ///< of those: without these a mission may go on
constexpr TimeUs kBetweenHoldsUs = 3 * kMinuteUs;
/// Apart from the draws for packets, which count from 0.
constexpr std::uint64_t kPlanEntity = std::uint64_t{1} << 40;

double Rounded(double value, double unit) { return std::round(value / unit) * unit; }

/// What is drawn for each fault, whether its kind has a use for it or not.
struct Draws {
  TimeUs minutes = 0;            ///< how long it lasts in mission time,
  TimeUs real_us = 0;            ///< or in real time
  bool in_mission_time = false;  ///< which of the two, for one that holds a process
  std::uint32_t member = 0;      ///< of kMembers
  double share = 0;              ///< of packets
};

/// Gives the fault a target and a duration. False where it has no target: there is no such agent,
/// or it is down already.
bool DrawTarget(const Draws& draws, const Scenario& scenario, const RandomPlanSettings& settings,
                bool is_held, Random* random, std::set<std::string>* felled, PlannedFault* fault) {
  const auto member = [&](std::uint32_t i) {
    std::string name(kMembers[i]);
    const int n = name == process_name::kScheduler ? settings.schedulers
                  : FromString<AgentKind>(name)    ? settings.per_class
                                                   : 1;
    if (n == 1) return name;
    return fmt::format("{}-{}", name, 1 + random->Below(static_cast<std::uint32_t>(n)));
  };
  const auto hold = [&] {
    (draws.in_mission_time ? fault->for_us : fault->for_real_us) =
        draws.in_mission_time ? draws.minutes : draws.real_us;
  };
  const FaultRow& row = RowOf(fault->kind);
  switch (row.target) {
    case FaultTarget::kAgent: {
      const AgentKind kind = kAgentKinds[random->Below(3)];
      const std::size_t n = scenario.agents(kind).size();
      if (n == 0) return false;
      fault->target =
          fmt::format("{}:{}", ToString(kind), random->Below(static_cast<std::uint32_t>(n)));
      // An agent that has failed, or is lost with its process, cannot fail again.
      if (!felled->insert(fault->target).second || is_held) return false;
      if (row.must_end) fault->for_us = draws.minutes;
      return true;
    }
    case FaultTarget::kRoads: {
      if (scenario.roads == nullptr) return false;
      const std::vector<RoadPoint>& points = scenario.roads->network->points;
      const RoadPoint at = points[random->Below(static_cast<std::uint32_t>(points.size()))];
      fault->target = fmt::format("{}/{}/{}", at.x_mm * 1e-6, at.y_mm * 1e-6, draws.share);
      fault->for_us = draws.minutes;
      return true;
    }
    case FaultTarget::kAir:
      if (scenario.air == nullptr) return false;
      fault->target = fmt::format("{:.6f}/{:.6f}/{}", random->Uniform() * scenario.width_m / 1000,
                                  random->Uniform() * scenario.height_m / 1000, draws.share);
      fault->for_us = draws.minutes;
      return true;
    case FaultTarget::kProcess:
      fault->target = member(draws.member);
      hold();
      return true;
    case FaultTarget::kSides:
      fault->target =
          fmt::format("{}|{}", member(random->Below(kReplaceable)), process_name::kWorld);
      hold();
      return true;
    case FaultTarget::kLog:
      fault->target = process_name::kLogger;
      fault->for_real_us = draws.real_us;
      return true;
    case FaultTarget::kEverybody:
      fault->target = "*";
      fault->for_us = draws.minutes;
      return true;
    case FaultTarget::kReceivers:
      // A process that is held may hear nothing that could be hit.
      fault->target = random->Below(2) == 0 || is_held ? "*" : member(random->Below(5));
      fault->for_us = draws.minutes;
      fault->probability = draws.share * row.value_drawn;
      return true;
  }
  return false;
}

}  // namespace

std::vector<FaultKind> AllSurvivableKinds() {
  std::vector<FaultKind> kinds;
  for (std::size_t i = 0; i < kNames<FaultKind>.size(); ++i) {
    const auto kind = static_cast<FaultKind>(i);
    if (!RowOf(kind).damages && !RowOf(kind).of_ways()) kinds.push_back(kind);
  }
  return kinds;
}

FaultPlan DrawPlan(const Scenario& scenario, const RandomPlanSettings& settings) {
  MUSTER_CHECK(!settings.kinds.empty() && settings.rate_per_hour > 0, "rate {}",
               settings.rate_per_hour);
  FaultPlan plan;
  Random random(settings.seed, Stream::kPacketFault, kPlanEntity);
  const double mean_gap_us = 3600e6 / settings.rate_per_hour;
  TimeUs hold_over_us = 0;
  std::set<std::string> felled;
  double at_us = 0;
  while (true) {
    at_us += -std::log(1 - random.Uniform()) * mean_gap_us;
    // The last tenth is left for everybody to come back.
    if (at_us >= 0.9 * static_cast<double>(scenario.rules.limit_us)) break;
    PlannedFault fault;
    fault.id = fmt::format("r{}", plan.size());
    fault.kind = settings.kinds[random.Below(static_cast<std::uint32_t>(settings.kinds.size()))];
    fault.at_us = ToUs(Rounded(at_us * 1e-6, 6));  // a tenth of a minute
    const FaultRow& row = RowOf(fault.kind);
    Draws draws;
    draws.minutes = static_cast<TimeUs>(5 + random.Below(26)) * kMinuteUs;
    draws.in_mission_time = settings.goes_on && random.Below(2) == 0;
    draws.member = random.Below(draws.in_mission_time ? kReplaceable : kMembers.size());
    draws.share = Rounded(random.Uniform(0.1, 0.4), 0.01);
    draws.real_us = ToUs(Rounded(random.Uniform(0.05, 0.5), 0.01));
    if (row.holds_clock) {
      if (fault.at_us < hold_over_us) continue;
      hold_over_us = fault.at_us + (draws.in_mission_time ? draws.minutes : 0) + kBetweenHoldsUs;
    }
    if (!DrawTarget(draws, scenario, settings, fault.at_us < hold_over_us, &random, &felled,
                    &fault)) {
      continue;
    }
    // A process that is held just when its packets begin to suffer cannot confirm it.
    const bool has_just_begun =
        std::any_of(plan.begin(), plan.end(), [&](const PlannedFault& other) {
          return RowOf(other.kind).of_packets() && other.at_us + kBetweenHoldsUs > fault.at_us &&
                 fault.target.find(other.target) != std::string::npos;
        });
    if (row.holds_clock && has_just_begun) continue;
    // The mission does not wait for one of several schedulers: a fault of its packets may be over
    // before it is back.
    const bool may_be_away =
        row.of_packets() && std::any_of(plan.begin(), plan.end(), [&](const PlannedFault& other) {
          const auto first = [](const PlannedFault& of) {
            return of.target.substr(0, of.target.find('|'));
          };
          return RowOf(other.kind).holds_clock && first(other) == first(fault) &&
                 process_name::IsOneOfSchedulers(fault.target);
        });
    if (may_be_away) continue;
    // A mission waits for the scheduler only at decisions: a hold in real time lasts till the next.
    if (row.holds_clock && fault.for_us == 0 &&
        fault.target.starts_with(process_name::kScheduler)) {
      const TimeUs interval_us = scenario.rules.interval_us;
      hold_over_us = (fault.at_us / interval_us + 1) * interval_us + kBetweenHoldsUs;
    }
    plan.push_back(std::move(fault));
  }
  return plan;
}

FaultPlan DropPlan(const Scenario& scenario, double share, TimeUs at_us, std::uint64_t seed) {
  FaultPlan plan;
  for (const AgentKind kind : kAgentKinds) {
    const std::size_t n = scenario.agents(kind).size();
    std::vector<std::size_t> ids(n);
    std::iota(ids.begin(), ids.end(), 0);
    Random(seed, Stream::kPacketFault, kPlanEntity + 1, static_cast<std::uint64_t>(kind))
        .Shuffle(ids);
    ids.resize(static_cast<std::size_t>(std::lround(share * static_cast<double>(n))));
    for (const std::size_t id : ids) {
      PlannedFault& fault = plan.emplace_back();
      fault.target = fmt::format("{}:{}", ToString(kind), id);
      fault.id = fmt::format("{}-{}", ToString(kind), id);
      fault.kind = FaultKind::kAgentFails;
      fault.at_us = at_us;
    }
  }
  return plan;
}

}  // namespace muster::tools
