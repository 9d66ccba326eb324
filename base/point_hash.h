#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/geometry.h"

namespace muster {

/// Two words as one, for tables in memory: nothing that is written anywhere depends on it.
inline std::uint64_t Mixed(std::uint64_t a, std::uint64_t b) {
  a ^= b + 0x9e3779b97f4a7c15U + (a << 6) + (a >> 2);
  a *= 0xbf58476d1ce4e5b9U;
  return a ^ (a >> 31);
}

/// Of a place; minus zero is zero.
struct PointHash {
  std::size_t operator()(Point p) const {
    return Mixed(std::bit_cast<std::uint64_t>(p.x_m + 0.0),
                 std::bit_cast<std::uint64_t>(p.y_m + 0.0));
  }
};

}  // namespace muster
