#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "model/agent.h"
#include "protocol/inbox.h"

namespace muster::tools {

/// Whole milliseconds of microseconds: the page's unit of time.
inline std::int64_t Ms(std::int64_t us) { return us / 1000; }

/// Puts what belongs to consecutive ticks into order. Repairs make a log's order differ from the
/// ticks' by a few. A tick is given up when it is missing from a process that has started again
/// since, when it is still missing kPatienceUs of wall time later, and when kWindow later ones
/// wait.
template <class T>
class TickOrder {
 public:
  static constexpr std::size_t kWindow = 64;
  static constexpr std::int64_t kPatienceUs = 2'000'000;

  template <class Visit>
  void Add(std::int64_t tick, const header_t& header, T value, Visit visit) {
    if (header.boot_id > boot_id_) {
      Finish(visit);
      boot_id_ = header.boot_id;
      next_ = std::max(next_, tick);
    }
    newest_us_ = std::max(newest_us_, header.wall_us);
    if (tick < next_) return;
    waiting_.try_emplace(tick, Waiting{header.wall_us, std::move(value)});
    while (!waiting_.empty() && Due()) Pop(visit);
  }
  /// Nothing more comes: what still waits is visited, too.
  template <class Visit>
  void Finish(Visit visit) {
    while (!waiting_.empty()) Pop(visit);
  }

 private:
  struct Waiting {
    std::int64_t wall_us;
    T value;
  };

  bool Due() const {
    const auto& [tick, waiting] = *waiting_.begin();
    return tick == next_ || waiting_.size() > kWindow || newest_us_ - waiting.wall_us > kPatienceUs;
  }
  template <class Visit>
  void Pop(Visit visit) {
    auto first = waiting_.extract(waiting_.begin());
    next_ = first.key() + 1;
    visit(first.key(), std::move(first.mapped().value));
  }

  std::int64_t next_ = 0, boot_id_ = 0, newest_us_ = 0;
  std::map<std::int64_t, Waiting> waiting_;
};

/// Rows that grow; of those that are there, only the last may change, unless all is rebuilt.
template <class T>
struct Growing {
  std::vector<T> rows;
  std::int64_t version = 0;  ///< counts changes
  std::int64_t rebuilt = 0;  ///< counts those that touched more than the last row

  void Push(T row) {
    rows.push_back(std::move(row));
    ++version;
  }
  void ReplaceLast(T row) {
    rows.back() = std::move(row);
    ++version;
  }
};

/// A mission as functions of time, for pages and displays: where each agent was, what it did, how
/// the tasks stood. Times are milliseconds of mission time, distances metres. What is straight
/// between two ticks is one piece, so memory grows with legs, activities and decisions, not with
/// ticks.
class Timeline {
 public:
  struct Stop {
    std::int64_t t_ms = 0;
    double x_m = 0, y_m = 0;
    double range_m = 0;  ///< UAVs only
  };
  /// From t_ms on, until the next.
  struct Span {
    std::int64_t t_ms = 0;
    int status = 0;  ///< AgentStatus
  };
  struct TaskChange {
    std::int64_t t_ms = 0;
    int status = 0;  ///< TaskStatus
  };
  struct Done {
    std::int64_t t_ms = 0;
    std::int32_t tasks = 0;
  };
  struct ProcessSample {
    std::int64_t t_ms = 0;
    std::int64_t wall_us = 0;
    std::int64_t boot_id = 0;
    std::int64_t received = 0, lost = 0, rejected = 0, resent = 0;
    double cpu_s = 0;
    std::int64_t rss_bytes = 0;
    int state = 0;                   ///< ProcessState
    std::int64_t since_wall_us = 0;  ///< since when it is in that state
  };
  /// How high a UAV flies from its first time on, until its next plan.
  struct Height {
    std::int32_t uav = -1;
    std::vector<std::pair<std::int64_t, double>> knots;  ///< ms, metres above the ground
  };
  struct Agent {
    Growing<Stop> stops;
    Growing<Span> spans;
    std::int64_t failed_us = -1;
    std::optional<agent_t> last;  ///< at the latest tick in order
    std::int64_t last_us = -1;
  };

  /// Orders may change it in place while messages come.
  explicit Timeline(std::shared_ptr<const Scenario> scenario);
  explicit Timeline(const Scenario& scenario)
      : Timeline(std::make_shared<const Scenario>(scenario)) {}

  /// Takes a message of the mission; each once, in the log's order. Messages whose numbers do not
  /// fit the scenario are left out.
  void Add(const Message& message);
  /// Nothing more comes.
  void Finish();

  const Scenario& scenario() const { return *shared_; }
  /// UAVs, then workers, then vehicles, by id.
  const std::vector<Agent>& agents() const { return agents_; }
  /// [n_tasks]; open before the first.
  const std::vector<Growing<TaskChange>>& tasks() const { return tasks_; }
  const Growing<Done>& done() const { return done_; }
  /// In order of arrival, each decision once.
  const Growing<schedule_t>& schedules() const { return schedules_; }
  /// In order of arrival, without repeats. An aborted one has an event that says so.
  const Growing<activity_t>& activities() const { return activities_; }
  const Growing<event_t>& events() const { return events_; }
  /// Of UAVs that are kept apart, as decisions plan them.
  const Growing<Height>& heights() const { return heights_; }
  /// By name. Kept at most kSamples of each: beyond that every second one goes.
  const std::map<std::string, Growing<ProcessSample>>& processes() const { return processes_; }
  const std::map<std::string, fault_t>& faults() const { return faults_; }
  /// Latest mission time heard of.
  std::int64_t now_ms() const { return now_ms_; }
  bool ended() const { return ended_; }

  static constexpr std::size_t kSamples = 2000;

  std::size_t IndexOf(AgentKind kind, std::size_t id) const {
    return *row_.Find(kind, static_cast<std::int64_t>(id));
  }

 private:
  void TakeAgents(const agent_states_t& message);
  void TakeHeights(const agent_states_t& message);
  void TakeAgent(AgentKind kind, std::size_t index, const agent_t& now, std::int64_t now_us);
  /// Its process is lost: it stands failed where it was last heard, until it is heard again.
  static void Lose(Agent* agent, std::int64_t at_us, std::int64_t now_us);
  /// Adds the corners of a way by road that the agent has passed since its last report.
  void PassCorners(AgentKind kind, const Agent& agent, std::int64_t until_us,
                   Growing<Stop>* stops) const;
  void Move(AgentKind kind, Agent* agent, const agent_t& now, std::int64_t now_us);
  void Change(AgentKind kind, Agent* agent, const agent_t& now, std::int64_t now_us);
  void TakeWorld(const world_state_t& world, std::int64_t now_us);
  void TakeProcess(const process_status_t& status);
  /// The activity of that agent that is under way or was last; none before the first.
  const activity_t* ActivityOf(AgentKind kind, std::int32_t id) const;

  std::shared_ptr<const Scenario> shared_;
  const Scenario& scenario_;
  AgentRow row_;
  std::vector<Agent> agents_;
  std::vector<TickOrder<agent_t>> agent_order_;
  TickOrder<world_state_t> world_order_;
  std::vector<Growing<TaskChange>> tasks_;
  Growing<Done> done_;
  Growing<schedule_t> schedules_;
  std::set<std::int32_t> decided_;
  Growing<activity_t> activities_;
  using ActivityKey = std::tuple<int, std::int32_t, std::int32_t, std::int32_t, std::int64_t>;
  std::set<ActivityKey> known_activities_;
  std::map<std::pair<AgentKind, std::int32_t>, std::size_t> latest_activity_;  // by class and id
  Growing<event_t> events_;
  Growing<Height> heights_;
  std::map<std::int32_t, std::map<std::int32_t, Clearance>> clearances_;  ///< by decision and UAV
  using EventKey = std::tuple<std::int64_t, int, std::int32_t, std::int32_t, std::int32_t,
                              std::int32_t, std::int32_t, std::string, std::string>;
  std::set<EventKey> known_events_;
  std::map<std::string, Growing<ProcessSample>> processes_;
  std::map<std::string, std::size_t> sample_every_, samples_skipped_;
  std::map<std::string, fault_t> faults_;
  std::int64_t now_ms_ = 0;
  bool ended_ = false;
};

}  // namespace muster::tools
