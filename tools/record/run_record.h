#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/interval_set.h"
#include "lcmtypes/bus/bus.h"
#include "model/scenario.h"
#include "muster/event_t.hpp"
#include "muster/fault_t.hpp"
#include "muster/process_status_t.hpp"
#include "muster/scenario_t.hpp"
#include "muster/schedule_t.hpp"
#include "muster/world_state_t.hpp"
#include "protocol/mission_reader.h"
#include "tools/log/air_record.h"
#include "tools/record/measured_legs.h"

namespace muster::tools {

/// A UAV's track through the mission. Legs begin at ticks, so the flown distance is the sum of the
/// ways between its positions at consecutive ticks.
class Track {
 public:
  /// The scenario must outlive the track, and takes the orders of the mission.
  explicit Track(const Scenario& scenario) : scenario_(&scenario) {}
  /// Position at a tick. Ticks may come in any order within a window of 64; a tick that comes
  /// later than that is left out. Of two positions at one tick, as after a restart, the later
  /// counts.
  void Add(std::int64_t tick, Point at, double range_left_m);
  /// What is said of that tick does not count: the UAV is ruled to have failed before it.
  void Exclude(std::int64_t tick);
  double length_m() const;
  /// Range left at the last tick heard of; metres.
  double final_range_m() const { return last().range_left_m; }
  std::int64_t final_tick() const { return last().tick; }

 private:
  struct Mark {
    std::int64_t tick = -1;
    Point at;
    double range_left_m = 0;
  };
  /// Metres from one to the other, by the ways at the time of the first.
  double WayM(const Mark& from, const Mark& to) const;
  Mark last() const { return pending_.empty() ? base_.value_or(Mark()) : pending_.back(); }

  const Scenario* scenario_;
  std::vector<Mark> pending_;  // ascending by tick
  std::optional<Mark> base_;   // last tick that is summed up
  double length_m_ = 0;
  std::set<std::int64_t> excluded_;
};

/// What a mission left on the bus, gathered by a MissionReader from its packets in any order.
/// Memory grows with decisions, events, agents and gaps, not with the number of ticks.
class RunRecord {
 public:
  /// Messages are of run `run_id`; none: of the run of the first scenario.
  explicit RunRecord(std::optional<std::int64_t> run_id = {}) : reader_(run_id) {}

  /// `also` visits what the record has taken, after it.
  void Add(const Packet& packet, const MissionReader::Visit& also = {});
  /// Says that a part of the log could not be read (torn tail, damaged event).
  void NoteDamage(std::string what) { damage_.push_back(std::move(what)); }
  /// Says that a file ends in a torn event since its logger was killed: reported apart, as another
  /// file goes on from there.
  void NoteTornTail(std::string what) { torn_tails_.push_back(std::move(what)); }

  const MissionReader& reader() const { return reader_; }
  const MissionReader::Counts& counts() const { return reader_.counts(); }

  /// Nothing below is filled before the scenario has come.
  std::shared_ptr<const Scenario> scenario() const { return reader_.scenario(); }
  const std::string& scenario_sha256() const { return scenario_sha256_; }
  std::int64_t run_id() const { return reader_.run_id().value_or(-1); }

  /// By decision, without skipped_decisions(). When several schedules name one decision, the one of
  /// the lowest (boot, seq).
  const std::map<std::int32_t, schedule_t>& schedules() const { return schedules_; }
  /// Decisions that no clock required: the scheduler was lost, and its schedule, if any, came late.
  const std::set<std::int32_t>& skipped_decisions() const { return skipped_; }
  /// Sorted by (at_us, kind, uav, worker, vehicle, task, charge, fault_id, detail), without
  /// repeats.
  const std::vector<event_t>& events() const;
  const std::map<std::string, fault_t>& faults() const { return faults_; }
  /// Of the highest tick; none before the first.
  const std::optional<world_state_t>& final_world() const { return final_world_; }
  /// [n_uavs]
  /// Of the UAVs that are or have been there.
  std::span<const Track> tracks() const {
    return std::span(tracks_).first(scenario() ? scenario()->n_agents(AgentKind::kUav) : 0);
  }
  /// The ways of measured agents, planned and told.
  std::vector<MeasuredLeg> measured_legs() const {
    return scenario() ? measured_legs_.List(*scenario(), schedules()) : std::vector<MeasuredLeg>();
  }
  /// Of a mission that keeps UAVs apart.
  const AirRecord& air() const { return air_; }
  /// Newest status per (name, boot).
  const std::map<std::pair<std::string, std::int64_t>, process_status_t>& processes() const {
    return processes_;
  }
  /// Wall time from the first to the last clock_t, seconds. Where the host's clock was set back, or
  /// forward by more than an hour, between two ticks, those two count as one time.
  double wall_s() const;

  struct Gap {
    std::string sender;
    std::int64_t boot_id = 0;
    std::int64_t first_seq = 0;
    std::int64_t last_seq = 0;
  };
  /// Ticks that lack something: `owner` is "clock", "world", "rulings", "schedule" (then first and
  /// last count decisions), "end", or an agent, "uav:3".
  struct Missing {
    std::string owner;
    std::int64_t first_tick = 0;
    std::int64_t last_tick = 0;
  };
  struct Completeness {
    bool complete = false;
    bool ended = false;           ///< the mission's end was announced
    std::int64_t last_tick = -1;  ///< the newest that everything is asked of
    std::vector<Gap> gaps;        ///< by sender and boot, ascending
    /// Gaps of starts that a later start of the same sender followed: those could not be repeated.
    std::vector<Gap> lost_tails;
    std::vector<Missing> missing;  ///< at most kMaxListed, the earliest
    std::int64_t n_missing = 0;    ///< (owner, tick) pairs missing
    std::int64_t repeated = 0;     ///< states of an agent that were reported twice for one tick
    std::vector<std::string> damage;
    std::vector<std::string> torn_tails;
  };
  static constexpr std::size_t kMaxListed = 100;
  /// Whether everything that the mission said is here: no sender's seq has a gap, every tick has
  /// clock, world state, rulings and each agent once (unless it is ruled to have failed, as a lost
  /// process's agents are), every decision its schedule (unless it was skipped), and the end was
  /// announced. What comes after the newest tick of a mission without an end, and that tick, are
  /// not required. A sender without any message is found by its ticks. Messages of a killed start
  /// that were not logged are reported apart where they are known, and its ticks count.
  Completeness CheckComplete() const;

 private:
  struct TickCover {
    bool clock = false;
    bool world = false;
    bool rulings = false;
    std::vector<bool> agents;          // [n_uavs + n_workers + n_vehicles]
    std::vector<std::size_t> excused;  // of those: ruled to have failed, need not report
    std::size_t n_agents = 0;
  };
  void ListGaps(Completeness* result) const;
  void ListMissingTicks(Completeness* result) const;
  /// Ticks that one start of a sender has said of one agent.
  struct Said {
    std::string sender;
    std::int64_t boot_id = -1;
    std::int64_t first = 0;
    std::int64_t last = -1;
  };

  void Take(const Message& message);
  void TakeScenario(const scenario_t& message);
  void TakeClock(const clock_t& message);
  void TakeAgents(const agent_states_t& message);
  void TakeRulings(const rulings_t& message);
  void TakeWorld(const world_state_t& message);
  void TakeSchedule(const schedule_t& message);
  void TakeFault(const fault_t& message);
  void TakeProcess(const process_status_t& message);
  /// Forgets the cover of a tick that is complete.
  void Collapse(std::int64_t tick);
  TickCover* Cover(std::int64_t tick);
  void Excuse(const rulings_t& message, TickCover* cover);
  std::int64_t last_tick() const;

  MissionReader reader_;
  std::string scenario_sha256_;
  std::map<std::int32_t, schedule_t> schedules_;
  std::set<std::int32_t> skipped_;
  mutable std::vector<event_t> events_;
  mutable bool events_sorted_ = true;
  std::map<std::string, fault_t> faults_;
  std::optional<world_state_t> final_world_;
  std::vector<Track> tracks_;
  MeasuredLegs measured_legs_;
  AirRecord air_;
  std::map<std::pair<std::string, std::int64_t>, process_status_t> processes_;
  std::map<std::int64_t, std::pair<std::int64_t, std::int64_t>> tick_walls_;  // first, last wall_us
  bool end_announced_ = false;
  std::map<std::int64_t, TickCover> open_ticks_;
  IntervalSet covered_ticks_;
  AgentRow row_;
  std::vector<Said> said_;  ///< [n_agents] in the row
  std::int64_t repeated_ = 0;
  std::vector<std::string> damage_;
  std::vector<std::string> torn_tails_;
};

}  // namespace muster::tools
