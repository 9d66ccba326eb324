#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scheduler/policies/learned/shape.h"
#include "scheduler/situation.h"

namespace muster::scheduler::learned {

/// A place that an agent may choose: a task, a charging point, or to stay.
struct PlaceOption {
  enum class Kind : std::int8_t { kNone, kStay, kTask, kCharge };
  Kind kind = Kind::kNone;  ///< kNone: not available
  std::int32_t site = -1;
};

/// One idle agent, as its network sees it. Distances and times count in ways of one interval and in
/// shares of the mission.
struct AgentView {
  std::int32_t id = -1;
  std::int32_t position = -1;  ///< in Situation::agents(kind)
  Point at;
  double reach_m = 0;  ///< way of one interval
  /// x / width, y / height, urgency, time / limit, online time left / limit, share of range,
  /// distance to the nearest charging point in ways of one interval (at most 4).
  std::array<float, kAgentFeatures> own{};
  std::array<PlaceOption, kOptions> options{};  ///< [0] is to stay
  /// Of each option: dx, dy, intervals needed, reachable within one, is a task, is a charging
  /// point; UAVs, workers, vehicles that reach it within one; open tasks within 3.5 km to each
  /// side; my rank among idle agents of my kind; intervals of the nearest partner; the longer of
  /// both ways; how many options that partner has nearer than this one. "Stay" has the first ten.
  std::array<std::array<float, kOptionFeatures>, kOptions> features{};
};

/// What the networks of one decision see. Source: the paper's appendix B (maps, location, urgency,
/// id); options instead of cells, their features: ours, docs/reference/learned.md.
struct Observation {
  /// [kMaps x rows x columns]: UAVs, workers, vehicles, urgency of the UAVs in 1/32, open tasks,
  /// charging points with a free place, by cell, at most 255.
  std::vector<std::uint8_t> maps;
  PerKind<std::vector<AgentView>> agents;  ///< idle ones of the shape
};

/// 1 - E_tL: falls, ever more slowly, as range grows. Source: the paper's appendix B, Eq. 4-1.
double Urgency(const AgentState& uav, double range_m);

Observation Observe(const Situation& situation, const Shape& shape);

/// Which of its options each agent takes: [agents] indices into AgentView::options.
using Choices = PerKind<std::vector<int>>;

/// The actions that the choices come to. A UAV and a worker (vehicle) that chose the same place and
/// can meet there before the next decision become a pair, the lowest UAV first, then the lowest
/// partner. An agent without a partner goes towards its choice, as far as one interval allows.
std::vector<Action> ActionsOf(const Situation& situation, const Observation& observation,
                              const Choices& choices);

}  // namespace muster::scheduler::learned
