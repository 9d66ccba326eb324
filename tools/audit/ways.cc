#include "tools/audit/ways.h"

#include <cmath>
#include <utility>

namespace muster::tools::audit {
namespace {

std::shared_ptr<const Ways>& Default() {
  static auto ways = std::make_shared<const Ways>();
  return ways;
}

}  // namespace

double Apart(Place a, Place b) { return std::hypot(b.x_m - a.x_m, b.y_m - a.y_m); }

double Ways::Length(int, Place from, Place to) const { return Apart(from, to); }

Place Ways::After(int, Place from, Place to, double part) const {
  return {from.x_m + part * (to.x_m - from.x_m), from.y_m + part * (to.y_m - from.y_m)};
}

std::vector<double> Ways::TurnsOf(int, Place, Place) const { return {}; }

double Ways::rounding_m(int) const { return 0; }

std::pair<Place, int> Ways::StopNear(int, Place wanted) const { return {wanted, -1}; }

std::optional<Place> Ways::StopOf(int, int) const { return {}; }

std::optional<double> Ways::MeetsAt(int, Place, Place, double, const std::set<int>&,
                                    const Ways&) const {
  return {};
}

double Ways::Gone(int kind, Place from, Place to) const {
  const double way_m = Length(kind, from, to);
  return std::isinf(way_m) ? Apart(from, to) : way_m;
}

std::shared_ptr<const Ways> DefaultWays() { return Default(); }

ScopedDefaultWays::ScopedDefaultWays(std::shared_ptr<const Ways> ways)
    : before_(std::exchange(Default(), std::move(ways))) {}

ScopedDefaultWays::~ScopedDefaultWays() { Default() = std::move(before_); }

}  // namespace muster::tools::audit
