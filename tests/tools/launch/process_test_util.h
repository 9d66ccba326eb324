#pragma once

#include <chrono>
#include <string>
#include <thread>

#include "tests/base/sanitized.h"
#include "tests/temporary_folder.h"

namespace muster::tools {

/// Looks again and again until `holds()` or the time is over, of which a sanitizer's build gets ten
/// times as much; returns what it held last.
template <class Condition>
bool Eventually(Condition holds, std::chrono::minutes longest = std::chrono::minutes(1)) {
  const auto deadline = std::chrono::steady_clock::now() + (kSanitized ? 10 : 1) * longest;
  while (!holds()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// The file's text; "" when it cannot be read.
std::string TextOf(const std::string& file);

}  // namespace muster::tools
