#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace muster {

/// An id that is its own type, so that swapping two does not compile. Ids count from 0 in each list
/// of a scenario and are indices into it; -1 means none.
template <class Tag>
struct Id {
  std::int32_t value = -1;

  constexpr Id() = default;
  constexpr explicit Id(std::int32_t v) : value(v) {}
  constexpr explicit Id(std::size_t v) : value(static_cast<std::int32_t>(v)) {}
  constexpr bool valid() const { return value >= 0; }
  constexpr std::size_t index() const { return static_cast<std::size_t>(value); }
  constexpr auto operator<=>(const Id&) const = default;
};

using UavId = Id<struct UavTag>;
using WorkerId = Id<struct WorkerTag>;
using VehicleId = Id<struct VehicleTag>;
using TaskId = Id<struct TaskTag>;
using ChargeId = Id<struct ChargeTag>;

}  // namespace muster

template <class Tag>
struct std::hash<muster::Id<Tag>> {
  std::size_t operator()(muster::Id<Tag> id) const { return std::hash<std::int32_t>()(id.value); }
};
