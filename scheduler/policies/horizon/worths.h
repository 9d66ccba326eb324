#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/units.h"
#include "scheduler/policies/horizon/settings.h"
#include "scheduler/situation.h"

namespace muster::scheduler {

/// What a pair is worth by the time that it takes, as an Instance wants it. The powers are looked
/// up, as a matching asks for one per way.
class Worths {
 public:
  /// Instance takes a pair's worth as base / level with whole levels. A level is here the
  /// reciprocal of the worth per unit of base in these parts, so a worth is off by at most 0.2 %.
  static constexpr double kParts = 256;

  Worths(const Situation& situation, const HorizonSettings& settings);

  /// decisions^-patience.
  double Of(std::int64_t decisions) const {
    return At(decisions) < of_.size() ? of_[At(decisions)] : Power(decisions);
  }
  /// Intervals(took, interval): the quotient by multiplication, right to 1, made right by its
  /// remainder.
  std::int64_t Decisions(TimeUs took) const {
    auto n = static_cast<std::int64_t>(static_cast<double>(took) * per_us_);
    TimeUs rest = took - n * interval_us_;
    if (rest < 0) {
      --n;
      rest += interval_us_;
    } else if (rest >= interval_us_) {
      ++n;
      rest -= interval_us_;
    }
    return std::max<std::int64_t>(1, n + (rest > 0 ? 1 : 0));
  }

  /// Level of a pair that ends that long after now.
  std::int32_t Level(TimeUs took) const {
    const std::int64_t decisions = Decisions(took);
    double worth = Of(decisions);
    if (finish_weight_ != 0) {
      const double into = static_cast<double>(took - (decisions - 1) * interval_us_) /
                          static_cast<double>(interval_us_);
      worth -= finish_weight_ * std::max(0.0, into) * (worth - Of(decisions + 1));
    }
    return static_cast<std::int32_t>(std::max<std::int64_t>(1, RoundHalfAway(kParts / worth)));
  }

 private:
  static std::size_t At(std::int64_t i) { return static_cast<std::size_t>(i); }
  double Power(std::int64_t decisions) const;

  double patience_, finish_weight_;
  TimeUs interval_us_;
  double per_us_;  ///< 1 / interval, rounded
  std::vector<double> of_;
};

}  // namespace muster::scheduler
