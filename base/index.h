#pragma once

#include <concepts>
#include <cstddef>

namespace muster {

/// As an index: i is not negative.
template <std::integral Index>
constexpr std::size_t At(Index i) {
  return static_cast<std::size_t>(i);
}

}  // namespace muster
