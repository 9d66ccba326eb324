#include "scheduler/policies/horizon/worths.h"

#include <cmath>

namespace muster::scheduler {

Worths::Worths(const Situation& situation, const HorizonSettings& settings)
    : patience_(settings.patience),
      finish_weight_(settings.ties ? settings.finish_weight : 0),
      interval_us_(situation.site->rules.interval_us),
      per_us_(1 / static_cast<double>(interval_us_)) {
  const std::int64_t most =
      Intervals(situation.site->rules.limit_us - situation.now_us, interval_us_) + 1;
  // Entry 0 is never asked for.
  for (std::int64_t n = 0; n <= std::min<std::int64_t>(most, 1000); ++n) of_.push_back(Power(n));
}

double Worths::Power(std::int64_t decisions) const {
  return std::pow(static_cast<double>(decisions), -patience_);
}

}  // namespace muster::scheduler
