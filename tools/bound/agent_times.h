#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "model/scenario.h"
#include "tools/bound/timetable.h"

namespace muster::tools {

/// What a scenario's agents take for their ways and activities, and when they are there.
class AgentTimes {
 public:
  /// The scenario must outlive it.
  explicit AgentTimes(const Scenario& scenario);
  AgentTimes(const AgentTimes&) = delete;
  AgentTimes& operator=(const AgentTimes&) = delete;

  /// At which an agent can be free again: the last is at or after the limit.
  std::int32_t decisions() const { return decisions_; }
  std::size_t n_tasks() const { return tasks_.size(); }
  std::size_t n_charging() const { return charging_.size(); }

  struct Uav {
    const UavTable* table;
    UavTimes times;
  };
  struct Partner {
    const Timetable* table;
    AgentReach times;
  };
  const std::vector<Uav>& uavs() const { return uavs_; }
  const std::vector<Partner>& workers() const { return workers_; }    ///< sites: tasks
  const std::vector<Partner>& vehicles() const { return vehicles_; }  ///< sites: charging points

 private:
  AgentReach ReachOf(const AgentSpec& agent) const;
  std::vector<TimeUs> SensingTimes(double uav_speed_m_s) const;
  Timetable TableOf(std::span<const double> way_m, std::span<const TimeUs> activity_us,
                    double speed_m_s) const;
  void LimitToTaskTimes(std::span<const TimeUs> sensing_us, Timetable* table) const;
  std::vector<double> Ways(AgentKind kind, std::span<const Point> from,
                           std::span<const Point> to) const;
  void AddUav(const AgentSpec& uav);
  void AddPartner(AgentKind kind, const AgentSpec& agent, std::span<const TimeUs> activity_us);

  const Scenario& scenario_;
  const TimeUs interval_us_;
  const std::int32_t decisions_;
  std::vector<Point> tasks_, charging_, places_;
  std::map<double, UavTable> uav_tables_;  ///< by speed
  std::map<double, Timetable> worker_tables_, vehicle_tables_;
  std::vector<Uav> uavs_;
  std::vector<Partner> workers_, vehicles_;
};

}  // namespace muster::tools
