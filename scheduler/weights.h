#pragma once

#include <cstdint>

namespace muster::scheduler {

/// The terms of the weights of the conflict graph's nodes: Eq. 4-1 to 4-19 of the paper, as
/// docs/reference/scheduling.md reads them. All times in these equations are counts of decision
/// intervals (of minutes with Rules::ceil_to_minutes), at least 1. scheduler/solver/build.cc puts
/// the terms together; its sums over sites and agents are in scheduler/solver/expected_costs.h.

/// Which foundational weights the pairs get: 100 and 10 (section 4.1.2), or the uniform ones of
/// section 5.3.3.
enum class Foundation { kHierarchical, kUniform };

/// ln(1 + e^x), finite for every finite x. Source: Eq. 4-10.
double Softplus(double x);

/// E_tL = (1 - e^-s) / (1 - e^-1), at least 1e-6, for the share s = range / full range in [0, 1]:
/// how likely a UAV takes a task. Source: Eq. 4-1 (4-2 and 4-3: increasing and concave).
double TaskLikelihood(double range_share);

/// E_chL = TaskLikelihood(1 - s): how much a UAV needs charging. Source: Eq. 4-4.
double ChargeLikelihood(double range_share);

/// Expected benefit per interval of a move that takes `intervals` and changes the expected cost of
/// being matched: Softplus((before - after) / before) / intervals, where 0 / 0 counts 0.
/// Source: Eq. 4-10, 4-12, 4-14, 4-17.
double MoveBenefit(double before, double after, std::int32_t intervals);

/// icmUi: a UAV's two benefits, weighted by its share of range after the action; one without range
/// counts as empty. Source: Eq. 4-15.
double UavBenefit(double range_after_m, double range_full_m, double task_benefit,
                  double charge_benefit);

/// Numerator of the pair's own term for sensing: Softplus(100); uniform: Softplus(1).
/// Source: Eq. 4-18; section 5.3.3.
double SenseFoundation(Foundation foundation);

/// The same for charging a UAV whose share of range is `range_share` now: Softplus(10 + e^(1 - s));
/// uniform: Softplus(e^(1 - s) / e). Source: Eq. 4-19; section 5.3.3.
double ChargeFoundation(Foundation foundation, double range_share);

}  // namespace muster::scheduler
