#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "tools/log/log_source.h"

namespace muster::tools {

struct EditResult {
  std::int64_t read = 0;
  std::int64_t written = 0;
};

/// Writes one clean log of a damaged or split one: every whole message once, in order, no garbage.
/// `out` must not exist (InputError); nothing is left behind when writing fails.
EditResult RepairLog(LogSource* source, const std::string& out);

/// Keeps the messages whose mission time is in [from_us, to_us], and the scenario. Messages without
/// a header go with the one before.
EditResult CutLog(LogSource* source, std::int64_t from_us, std::int64_t to_us,
                  const std::string& out);

}  // namespace muster::tools
