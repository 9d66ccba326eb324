#pragma once

#include <string>
#include <vector>

#include "model/action.h"
#include "model/order.h"
#include "tools/explain/decision_log.h"

namespace muster::tools {

/// The newest decision of a log, made again with one directive more, or one less.
struct WhatIf {
  std::int32_t decision = -1;
  TimeUs at_us = 0;
  std::string order;                      ///< what it says, for people
  double weight = 0, weight_without = 0;  ///< of the decision with it, and as it was
  std::vector<Action> instead_of, now;    ///< actions that only one of them has, without stays
  std::vector<std::string> unkept;        ///< why it could not be kept
};

/// Throws InputError when the log has no whole decision or its policy is none of ours, and when
/// the order is no directive or cannot be taken; `run` is named then. Costs two decisions.
WhatIf TellWhatIf(const DecisionLog& log, const std::string& run, const Order& order);

std::string ToText(const WhatIf& what_if);

/// `muster what-if`: says what a directive would change at the newest decision.
int WhatIfCommand(int argc, const char* const* argv);

}  // namespace muster::tools
