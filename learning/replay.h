#pragma once

#include <vector>

#include "learning/episode.h"
#include "learning/methods.h"

namespace muster::learning {

/// Situations as the networks take them.
Seen SeenOf(const std::vector<const Turn*>& turns, const scheduler::learned::Shape& shape);

struct Lesson {
  Seen seen;
  Happened happened;
};
/// Whole episodes, one after the other.
Lesson LessonOf(const std::vector<const Episode*>& episodes,
                const scheduler::learned::Shape& shape);

}  // namespace muster::learning
