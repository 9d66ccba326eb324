#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "base/units.h"

namespace muster::world {

/// The fastest of the recent answers: asking again sooner than that is in vain.
class AnswerTime {
 public:
  void Note(TimeUs took_us) {
    took_us_[next_] = took_us;
    next_ = (next_ + 1) % took_us_.size();
  }
  /// Whether as many answers have come as it remembers.
  bool known() const { return took_us_[next_] > 0; }
  /// Half as long again, between the two.
  TimeUs Patience(TimeUs least_us, TimeUs most_us) const {
    const TimeUs fastest_us = *std::min_element(took_us_.begin(), took_us_.end());
    return std::clamp(fastest_us + fastest_us / 2, least_us, most_us);
  }

 private:
  std::array<TimeUs, 8> took_us_ = {};
  std::size_t next_ = 0;
};

}  // namespace muster::world
