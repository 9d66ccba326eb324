#include "scheduler/weights.h"

#include <algorithm>
#include <cmath>

namespace muster::scheduler {
namespace {

constexpr double kLeastLikelihood = 1e-6;

}  // namespace

double Softplus(double x) { return std::max(x, 0.0) + std::log1p(std::exp(-std::abs(x))); }

double TaskLikelihood(double range_share) {
  return std::max(kLeastLikelihood, (1 - std::exp(-range_share)) / (1 - std::exp(-1.0)));
}

double ChargeLikelihood(double range_share) { return TaskLikelihood(1.0 - range_share); }

double MoveBenefit(double before, double after, std::int32_t intervals) {
  const double gain = before == 0 && after == 0 ? 0.0 : (before - after) / before;
  return Softplus(gain) / intervals;
}

double UavBenefit(double range_after_m, double range_full_m, double task_benefit,
                  double charge_benefit) {
  if (range_full_m <= 0) return charge_benefit;
  return range_after_m / range_full_m * task_benefit +
         (range_full_m - range_after_m) / range_full_m * charge_benefit;
}

double SenseFoundation(Foundation foundation) {
  return Softplus(foundation == Foundation::kHierarchical ? 100.0 : 1.0);
}

double ChargeFoundation(Foundation foundation, double range_share) {
  return foundation == Foundation::kHierarchical ? Softplus(10.0 + std::exp(1.0 - range_share))
                                                 : Softplus(std::exp(-range_share));
}

}  // namespace muster::scheduler
