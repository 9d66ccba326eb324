#pragma once

#include <cstdint>
#include <optional>

#include "lcmtypes/words.h"

namespace muster {

/// The one of three that belongs to that class.
template <class T>
constexpr T& ByKind(AgentKind kind, T& of_uavs, T& of_workers, T& of_vehicles) {
  return kind == AgentKind::kUav ? of_uavs : kind == AgentKind::kWorker ? of_workers : of_vehicles;
}

/// One T for each agent class.
template <class T>
struct PerKind {
  T uavs{}, workers{}, vehicles{};

  constexpr T& operator[](AgentKind kind) { return ByKind(kind, uavs, workers, vehicles); }
  constexpr const T& operator[](AgentKind kind) const {
    return ByKind(kind, uavs, workers, vehicles);
  }
};

/// All agents of a mission in one row: UAVs, workers, vehicles.
class AgentRow {
 public:
  AgentRow() = default;
  explicit AgentRow(const PerKind<std::size_t>& counts) : counts_(counts) {
    for (const AgentKind kind : kAgentKinds) {
      first_[kind] = size_;
      size_ += counts_[kind];
    }
  }
  std::size_t size() const { return size_; }
  /// Its index in the row; none: there is no such agent.
  std::optional<std::size_t> Find(AgentKind kind, std::int64_t id) const {
    if (id < 0 || static_cast<std::size_t>(id) >= counts_[kind]) return {};
    return first_[kind] + static_cast<std::size_t>(id);
  }

 private:
  PerKind<std::size_t> counts_, first_;
  std::size_t size_ = 0;
};

}  // namespace muster
