#include "tools/top/attention.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "lcmtypes/words.h"
#include "model/feasibility.h"
#include "protocol/fault_kinds.h"
#include "tools/host/progress.h"
#include "tools/top/approach.h"

namespace muster::tools {
namespace {

constexpr TimeUs kLongWaitUs = 5 * kMinuteUs;
constexpr std::int64_t kMessageMs = 10 * 60 * 1000;  ///< so long a message is shown
constexpr double kLowRange = 0.2;                    ///< of the full range

std::string Since(std::int64_t ms) { return "since " + ClockText(ms * 1000); }

/// Concerns of one kind, the most harmful first.
class Kind {
 public:
  Kind(std::string name, bool bad) : name_(std::move(name)), bad_(bad) {}

  void Add(std::string who, std::string note, double harm) {
    found_.emplace_back(-harm, Concern{name_, std::move(who), std::move(note), bad_});
  }
  void MoveTo(std::vector<Concern>* all) {
    std::stable_sort(found_.begin(), found_.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [harm, concern] : found_) all->push_back(std::move(concern));
  }

 private:
  std::string name_;
  bool bad_;
  std::vector<std::pair<double, Concern>> found_;
};

/// By id: faults that were applied and have not ended. Faults of one agent are left out, because
/// the agent is listed itself. So are killed processes, which are listed with how long they are
/// away.
std::map<std::string, std::int64_t> InForce(const Timeline& timeline) {
  std::map<std::string, std::int64_t> since;
  for (const event_t& event : timeline.events().rows) {
    if (event.kind == EventKind::kFaultApplied) since.try_emplace(event.fault_id, Ms(event.at_us));
  }
  for (const event_t& event : timeline.events().rows) {
    if (event.kind == EventKind::kFaultEnded) since.erase(event.fault_id);
  }
  for (const auto& [id, fault] : timeline.faults()) {
    const auto kind = static_cast<FaultKind>(fault.kind);
    if (RowOf(kind).of_agents() || kind == FaultKind::kProcessKilled) since.erase(id);
  }
  return since;
}

/// What schedulers of the mission do not agree on.
void AddDisputes(const Timeline& timeline, Kind* differ) {
  std::size_t n = 0;
  const event_t* newest = nullptr;
  for (const event_t& event : timeline.events().rows) {
    if (event.kind != EventKind::kDecisionsDiffer) continue;
    ++n;
    newest = &event;
  }
  if (newest != nullptr)
    differ->Add(n == 1 ? "once" : fmt::format("{} times", n), newest->detail, 0);
}

/// What the driver of each agent has said last that it waits for.
std::map<std::pair<AgentKind, std::int32_t>, std::string> WaitsOfDrivers(const Timeline& timeline) {
  std::map<std::pair<AgentKind, std::int32_t>, std::string> waits;
  for (const event_t& event : timeline.events().rows) {
    if (event.kind != EventKind::kDriverWaits) continue;
    const PerKind<std::int32_t> ids = {event.uav_id, event.worker_id, event.vehicle_id};
    for (const AgentKind kind : kAgentKinds) {
      if (ids[kind] >= 0) waits[{kind, ids[kind]}] = event.detail;
    }
  }
  return waits;
}

/// What the driver of each agent has said last to people: the event.
std::map<std::pair<AgentKind, std::int32_t>, const event_t*> MessagesOfDrivers(
    const Timeline& timeline) {
  std::map<std::pair<AgentKind, std::int32_t>, const event_t*> messages;
  for (const event_t& event : timeline.events().rows) {
    if (event.kind != EventKind::kDriverSays && event.kind != EventKind::kDriverCalls) continue;
    const PerKind<std::int32_t> ids = {event.uav_id, event.worker_id, event.vehicle_id};
    for (const AgentKind kind : kAgentKinds) {
      if (ids[kind] >= 0) messages[{kind, ids[kind]}] = &event;
    }
  }
  return messages;
}

/// Adds who calls for help, until something else is said, and what was said lately.
void AddMessages(const Timeline& timeline, Kind* calls, Kind* says) {
  if (timeline.ended()) return;
  for (const auto& [agent, event] : MessagesOfDrivers(timeline)) {
    const bool is_call = event->kind == EventKind::kDriverCalls;
    if (!is_call && timeline.now_ms() - Ms(event->at_us) > kMessageMs) continue;
    (is_call ? calls : says)
        ->Add(fmt::format("{}:{}", ToString(agent.first), agent.second), event->detail,
              -static_cast<double>(event->at_us));
  }
}

/// The newest sensing of each task, by task.
std::map<std::int32_t, const activity_t*> LatestSensing(const Timeline& timeline) {
  std::map<std::int32_t, const activity_t*> latest;
  for (const activity_t& activity : timeline.activities().rows) {
    if (activity.kind == ActivityKind::kSensing) latest[activity.site_id] = &activity;
  }
  return latest;
}

/// Adds the tasks that will be late or lost, and those that nobody is sent to or that were not
/// done.
void AddTasks(const Timeline& timeline, Kind* at_risk, Kind* undone) {
  constexpr std::array<const char*, kPriorities> kWords = {"low, ", "", "high, ", "emergency, "};
  const Scenario& scenario = timeline.scenario();
  const TimeUs now_us = timeline.now_ms() * 1000;
  const auto latest = LatestSensing(timeline);
  const bool late = timeline.ended() || 2 * now_us >= scenario.rules.limit_us;
  for (std::size_t i = 0; i < timeline.tasks().size(); ++i) {
    const Task& task = scenario.tasks[i];
    const auto& rows = timeline.tasks()[i].rows;
    const auto status =
        rows.empty() ? TaskStatus::kOpen : static_cast<TaskStatus>(rows.back().status);
    const std::string who = fmt::format("task {}", i);
    const auto priority = static_cast<std::size_t>(task.priority);
    const double matters = 10 * static_cast<double>(priority);
    if (timeline.ended()) {
      if (status == TaskStatus::kExpired) undone->Add(who, "expired", 1 + matters);
      if (IsToDo(status)) undone->Add(who, "", (status == TaskStatus::kOpen ? 2 : 1) + matters);
      if (status == TaskStatus::kHeld) undone->Add(who, "held by an order", 1 + matters);
      continue;
    }
    const auto sensing = latest.find(static_cast<std::int32_t>(i));
    const auto start_us = status == TaskStatus::kReserved && sensing != latest.end()
                              ? std::optional<TimeUs>(sensing->second->start_us)
                              : std::nullopt;
    if (const auto risk = RiskOf(task, status, start_us, now_us, scenario.rules.interval_us)) {
      at_risk->Add(who, kWords[priority] + risk->note, matters + risk->harm);
    } else if (late && status == TaskStatus::kOpen) {
      undone->Add(who, "", matters);
    }
  }
}

}  // namespace

std::optional<TaskRisk> RiskOf(const Task& task, TaskStatus status, std::optional<TimeUs> start_us,
                               TimeUs now_us, TimeUs interval_us) {
  const auto minutes = [](TimeUs us) {
    return fmt::format("{} min", std::llround(ToSeconds(us) / 60));
  };
  if (status == TaskStatus::kReserved) {
    if (!start_us) return {};  // a live mission may not have told yet when it starts
    if (!task.AllowsStart(*start_us)) {
      return TaskRisk{7, fmt::format("starts at {}, expires at {}", ClockText(*start_us),
                                     ClockText(task.expires_us))};
    }
    if (*start_us <= task.due_us) return {};
    return TaskRisk{3, fmt::format("starts at {}, {} too late", ClockText(*start_us),
                                   minutes(*start_us - task.due_us))};
  }
  if (status != TaskStatus::kOpen && status != TaskStatus::kHeld) return {};
  const TimeUs soon_us = 2 * interval_us;
  const char* const why = status == TaskStatus::kHeld ? "held by an order" : "nobody is on the way";
  // Sooner is worse, by less than what tells the kinds apart.
  const auto nearness = [&](TimeUs left_us) { return 1 - ToSeconds(left_us) / ToSeconds(soon_us); };
  if (task.expires_us != kNever && task.expires_us - now_us <= soon_us) {
    const TimeUs left_us = std::max<TimeUs>(0, task.expires_us - now_us);
    return TaskRisk{6 + nearness(left_us), fmt::format("expires in {}, {}", minutes(left_us), why)};
  }
  if (task.due_us <= now_us) {
    return TaskRisk{5, fmt::format("was due {} ago, {}", minutes(now_us - task.due_us), why)};
  }
  if (task.due_us == kNever || task.due_us - now_us > soon_us) return {};
  return TaskRisk{4 + nearness(task.due_us - now_us),
                  fmt::format("due in {}, {}", minutes(task.due_us - now_us), why)};
}

std::optional<AgentTrouble> TroubleOf(AgentKind kind, AgentStatus status, TimeUs since_us,
                                      TimeUs now_us, double range_m, double range_full_m,
                                      const std::function<std::optional<double>()>& nearest_m) {
  using Trouble = AgentTrouble::Kind;
  if (status == AgentStatus::kFailed) {
    return AgentTrouble{Trouble::kFailed, -ToSeconds(since_us), "since " + ClockText(since_us)};
  }
  if (status == AgentStatus::kWaiting) {
    const TimeUs waited_us = now_us - since_us;
    if (waited_us < kLongWaitUs) return {};
    return AgentTrouble{Trouble::kWait, ToSeconds(waited_us),
                        fmt::format("for {} min", std::llround(ToMinutes(waited_us)))};
  }
  const bool flies = kind == AgentKind::kUav && status != AgentStatus::kOffline &&
                     status != AgentStatus::kCharging;
  if (!flies || !(range_m < kLowRange * range_full_m)) return {};
  const auto km = [](double metres) { return fmt::format("{:.1f} km", metres / 1000); };
  if (const auto nearest = nearest_m(); nearest && range_m < *nearest) {
    return AgentTrouble{Trouble::kStranded, *nearest - range_m,
                        fmt::format("{} left, {} to the nearest", km(range_m), km(*nearest))};
  }
  return AgentTrouble{Trouble::kRange, -range_m / range_full_m,
                      fmt::format("{} of {} left", km(range_m), km(range_full_m))};
}

std::vector<Concern> Attention(const Timeline& timeline, const std::vector<std::string>& silent) {
  const Scenario& scenario = timeline.scenario();
  const std::int64_t now_ms = timeline.now_ms();
  Kind processes("processes silent", true), differ("schedulers disagree", true),
      faults("faults in force", true), failed("agents failed", true), calls("calls for help", true),
      says("says", false), near("UAVs come too close", true),
      stranded("cannot reach a charging point", true), at_risk("tasks at risk", true),
      tasks(timeline.ended() ? "tasks not done" : "tasks nobody is sent to", timeline.ended()),
      not_ready("not ready", false), waiting("waiting for a partner", false),
      low("low range", false);
  const auto waits = WaitsOfDrivers(timeline);
  for (const std::string& name : silent) processes.Add(name, "", 0);
  AddDisputes(timeline, &differ);
  for (const auto& [id, since_ms] : InForce(timeline)) {
    if (timeline.ended()) break;
    const auto fault = timeline.faults().find(id);
    const bool known = fault != timeline.faults().end();
    faults.Add(known ? fmt::format("{} {}", Spaced(ToString<FaultKind>(fault->second.kind)),
                                   fault->second.target)
                     : id,
               Since(since_ms), -static_cast<double>(since_ms));
  }
  for (const AgentKind kind : kAgentKinds) {
    for (std::size_t id = 0; id < scenario.agents(kind).size(); ++id) {
      const Timeline::Agent& agent = timeline.agents()[timeline.IndexOf(kind, id)];
      if (!agent.last || agent.spans.rows.empty()) continue;
      if (agent.last->status == AgentStatus::kNotReady) {
        const std::int64_t since_ms = agent.spans.rows.back().t_ms;
        const auto wait = waits.find({kind, static_cast<std::int32_t>(id)});
        not_ready.Add(fmt::format("{}:{}", ToString(kind), id),
                      wait == waits.end() ? Since(since_ms) : "waits for " + wait->second,
                      -static_cast<double>(since_ms));
        continue;
      }
      const auto nearest_m = [&]() -> std::optional<double> {
        if (scenario.charging_points.empty()) return {};
        return NearestChargeM(*scenario.ways, {agent.last->x_m, agent.last->y_m},
                              scenario.charging_points);
      };
      const auto trouble = TroubleOf(kind, static_cast<AgentStatus>(agent.last->status),
                                     agent.spans.rows.back().t_ms * 1000, now_ms * 1000,
                                     agent.last->range_left_m, agent.last->range_full_m, nearest_m);
      if (!trouble) continue;
      Kind* const of[] = {&failed, &stranded, &waiting, &low};
      of[static_cast<int>(trouble->kind)]->Add(fmt::format("{}:{}", ToString(kind), id),
                                               trouble->note, trouble->harm);
    }
  }
  for (const NearPair& pair : timeline.ended() ? std::vector<NearPair>() : NearPairs(timeline)) {
    near.Add(fmt::format("uav:{} and uav:{}", pair.a, pair.b), ToText(pair.approach),
             -pair.approach.in_s);
  }
  AddTasks(timeline, &at_risk, &tasks);
  AddMessages(timeline, &calls, &says);
  std::vector<Concern> all;
  for (Kind* kind : {&calls, &processes, &differ, &faults, &failed, &near, &stranded, &at_risk,
                     &tasks, &says, &not_ready, &waiting, &low}) {
    kind->MoveTo(&all);
  }
  return all;
}

}  // namespace muster::tools
