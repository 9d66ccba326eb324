#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/action.h"
#include "scheduler/policies/external/situation_json.h"
#include "scheduler/situation.h"

namespace muster::scheduler {

/// What an outside program says of itself when it is greeted.
struct Greeting {
  GraphWishes wishes;
  std::optional<double> deadline_s;  ///< that it asks for, for each decision
};

/// Reads such a line. Throws InputError that says what is wrong with it.
Greeting ReadGreeting(std::string_view line);

/// A line that answers.
struct Answer {
  std::int64_t id = -1;         ///< of the situation that it answers
  std::vector<Action> actions;  ///< without weights, as named; `by_node`: none
  std::vector<std::int64_t> nodes;
  bool by_node = false;
};

/// Reads such a line, without checking its ids, and adds the place where each action leads. Throws
/// InputError that says what is wrong with it.
Answer ReadAnswer(std::string_view line, const Situation& situation);

/// The protocol's version.
inline constexpr int kExternalVersion = 1;
/// The longest deadline that a program may ask for.
inline constexpr double kMostDeadlineS = 600;

}  // namespace muster::scheduler
