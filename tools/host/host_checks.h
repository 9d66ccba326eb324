#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lcmtypes/bus/multicast.h"

namespace muster::tools {

/// One thing that a mission needs of its host.
struct HostCheck {
  enum class Result {
    kOk,
    kWarn,  ///< missions run, but not as they should
    kFail,  ///< missions do not run
  };
  std::string name;
  Result result = Result::kOk;
  std::string found;
  std::string advice;  ///< what to do; empty when kOk
};

/// Looks at networks, LCM, kernel limits and LCM's programs. `url`: what a mission would use, its
/// receive buffer above all. Ends up in a private network where the kernel allows one: call it once
/// and before any thread starts.
std::vector<HostCheck> CheckHost(const MulticastUrl& url);

}  // namespace muster::tools
