#pragma once

#include <cstdint>
#include <cstdlib>

namespace muster {

/// How many cases a test draws: `few` in every run of the tests, `many` in the slow ones (CTest
/// label slow), which set MUSTER_MANY_CASES.
inline std::uint64_t Cases(std::uint64_t few, std::uint64_t many) {
  return std::getenv("MUSTER_MANY_CASES") != nullptr ? many : few;
}

}  // namespace muster
