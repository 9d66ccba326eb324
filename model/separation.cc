#include "model/separation.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace muster {
namespace {

/// Closer by less is as the minimum says.
constexpr double kSlack_m = 1e-6;

bool Charges(const AgentState& uav) {
  return uav.action == ActionKind::kCharge || uav.action == ActionKind::kUavToCharge;
}

/// Part of a trajectory between two times.
struct Part {
  Point from, to;
  double from_m, to_m;  ///< altitudes
  bool on_ground() const { return from_m <= 0 && to_m <= 0; }
};

Point PlaceOf(const Trajectory& path, std::size_t knot, double t_s, double* up_m) {
  const Trajectory::Knot& last = path.knots.back();
  if (knot + 1 >= path.knots.size() || t_s >= last.t_s) {
    *up_m = last.up_m;
    return last.at;
  }
  const Trajectory::Knot& a = path.knots[knot];
  const Trajectory::Knot& b = path.knots[knot + 1];
  const double share = (t_s - a.t_s) / (b.t_s - a.t_s);
  *up_m = a.up_m + (b.up_m - a.up_m) * share;
  return Lerp(a.at, b.at, share);
}

/// Calls visit(t_s, seconds, part of a, part of b) for each time span in which both change evenly,
/// the last without end (seconds 0), until it returns true. Returns whether it did.
template <class Visit>
bool VisitTogether(const Trajectory& a, const Trajectory& b, Visit visit) {
  std::size_t i = 0, j = 0;
  double t_s = 0;
  const double end_s = std::max(a.knots.back().t_s, b.knots.back().t_s);
  while (t_s < end_s) {
    while (i + 1 < a.knots.size() && a.knots[i + 1].t_s <= t_s) ++i;
    while (j + 1 < b.knots.size() && b.knots[j + 1].t_s <= t_s) ++j;
    double next_s = end_s;
    if (i + 1 < a.knots.size()) next_s = std::min(next_s, a.knots[i + 1].t_s);
    if (j + 1 < b.knots.size()) next_s = std::min(next_s, b.knots[j + 1].t_s);
    Part x{}, y{};
    x.from = PlaceOf(a, i, t_s, &x.from_m);
    x.to = PlaceOf(a, i, next_s, &x.to_m);
    y.from = PlaceOf(b, j, t_s, &y.from_m);
    y.to = PlaceOf(b, j, next_s, &y.to_m);
    if (visit(t_s, next_s - t_s, x, y)) return true;
    t_s = next_s;
  }
  const Trajectory::Knot& x = a.knots.back();
  const Trajectory::Knot& y = b.knots.back();
  return visit(end_s, 0.0, Part{x.at, x.at, x.up_m, x.up_m}, Part{y.at, y.at, y.up_m, y.up_m});
}

struct Span {
  double low = 0, high = 1;
};

/// Where in [0, 1] a + b u + c u^2 is below 0, for c >= 0.
std::optional<Span> BelowZero(double a, double b, double c) {
  if (c <= 0) {
    if (b == 0) return a < 0 ? std::optional<Span>(Span{}) : std::nullopt;
    const double zero = -a / b;
    Span span = b > 0 ? Span{0, std::min(1.0, zero)} : Span{std::max(0.0, zero), 1};
    return span.low < span.high ? std::optional<Span>(span) : std::nullopt;
  }
  const double inside = b * b - 4 * a * c;
  if (inside <= 0) return {};
  const double root = std::sqrt(inside);
  const Span span{std::max(0.0, (-b - root) / (2 * c)), std::min(1.0, (-b + root) / (2 * c))};
  return span.low < span.high ? std::optional<Span>(span) : std::nullopt;
}

/// Between two parts, as functions of the share u of their time.
struct Between {
  Point gap, gap_change;
  double up, up_change;

  Between(const Part& a, const Part& b)
      : gap{a.from.x_m - b.from.x_m, a.from.y_m - b.from.y_m},
        gap_change{a.to.x_m - b.to.x_m - gap.x_m, a.to.y_m - b.to.y_m - gap.y_m},
        up(a.from_m - b.from_m),
        up_change(a.to_m - b.to_m - up) {}

  double GapM(double u) const {
    const double x = gap.x_m + gap_change.x_m * u, y = gap.y_m + gap_change.y_m * u;
    return std::sqrt(x * x + y * y);
  }
  double UpM(double u) const { return std::abs(up + up_change * u); }

  bool IsConflict(const Separation& minima) const {
    const double apart_m = minima.horizontal_m - kSlack_m, above_m = minima.vertical_m - kSlack_m;
    const double a = gap.x_m * gap.x_m + gap.y_m * gap.y_m - apart_m * apart_m;
    const double b = 2 * (gap.x_m * gap_change.x_m + gap.y_m * gap_change.y_m);
    const double c = gap_change.x_m * gap_change.x_m + gap_change.y_m * gap_change.y_m;
    const auto near = BelowZero(a, b, c);
    if (!near) return false;
    const auto below = BelowZero(up - above_m, up_change, 0);
    const auto above = BelowZero(-up - above_m, -up_change, 0);
    return below && above &&
           std::max({near->low, below->low, above->low}) <
               std::min({near->high, below->high, above->high});
  }

  /// The share at which the larger of the two distances, in shares of their minima, is least: at an
  /// end, where one of them is least, or where they are equal.
  double ClosestAt(const Separation& minima) const {
    const double h2 = minima.horizontal_m * minima.horizontal_m;
    const double v2 = minima.vertical_m * minima.vertical_m;
    const double c = gap_change.x_m * gap_change.x_m + gap_change.y_m * gap_change.y_m;
    const double half_b = gap.x_m * gap_change.x_m + gap.y_m * gap_change.y_m;
    std::array<double, 6> tried{0, 1, 0, 0, 0, 0};
    if (c > 0) tried[2] = -half_b / c;
    if (up_change != 0) tried[3] = -up / up_change;
    const double p = c / h2 - up_change * up_change / v2;
    const double q = 2 * (half_b / h2 - up * up_change / v2);
    const double r = (gap.x_m * gap.x_m + gap.y_m * gap.y_m) / h2 - up * up / v2;
    const double inside = q * q - 4 * p * r;
    if (p != 0 && inside >= 0) {
      tried[4] = (-q - std::sqrt(inside)) / (2 * p);
      tried[5] = (-q + std::sqrt(inside)) / (2 * p);
    } else if (p == 0 && q != 0) {
      tried[4] = -r / q;
    }
    double best = 0;
    for (const double u : tried) {
      const double in = std::clamp(u, 0.0, 1.0);
      if (ShareAt(in, minima) < ShareAt(best, minima)) best = in;
    }
    return best;
  }
  double ShareAt(double u, const Separation& minima) const {
    return std::max(GapM(u) / minima.horizontal_m, UpM(u) / minima.vertical_m);
  }
};

}  // namespace

LandingPlaces::LandingPlaces(std::span<const ChargingPoint> points) {
  for (const ChargingPoint& point : points) places_.insert(Rounded(point.at));
}

double AltitudeAt(const AgentState& uav, const Clearance& clearance, TimeUs t,
                  const LandingPlaces& landing) {
  if (uav.failed || !uav.online(t)) return 0;
  if (t < uav.arrive_us) return LevelAt(clearance, t);
  if (Charges(uav)) {
    const double down_m = kDescent_m_s * ToSeconds(t - uav.arrive_us);
    return std::max(0.0, LevelAt(clearance, uav.arrive_us) - down_m);
  }
  const bool landed = uav.action == ActionKind::kNone && landing.Contains(uav.to);
  return landed ? 0 : LevelAt(clearance, t);
}

bool Trajectory::IsEverAirborne() const {
  return std::any_of(knots.begin(), knots.end(), [](const Knot& knot) { return knot.up_m > 0; });
}

Trajectory TrajectoryOf(const AgentState& uav, const Clearance& clearance, TimeUs now,
                        const LandingPlaces& landing) {
  Trajectory path;
  if (uav.failed || !uav.online(now)) return path;
  // It goes offline on the ground; until then it is where it is. So it stays for ever here.
  AgentState stays = uav;
  stays.online_until_us = kNever;
  std::vector<TimeUs> times{now, clearance.begin_us, LevelReachedUs(clearance)};
  if (uav.arrive_us > now) {
    const TimeUs set_out_us = uav.depart_us + HoldUs(uav);
    times.push_back(set_out_us);
    times.push_back(uav.arrive_us);
    const auto way_us = static_cast<double>(uav.arrive_us - set_out_us);
    for (const Ways::Corner& corner : uav.leg_ways->Corners(uav.kind, uav.from, uav.to)) {
      times.push_back(set_out_us + static_cast<TimeUs>(std::llround(corner.share * way_us)));
    }
  }
  if (Charges(uav)) {
    const double down_m = LevelAt(clearance, uav.arrive_us);
    times.push_back(uav.arrive_us + ToUs(down_m / kDescent_m_s) + 1);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  for (const TimeUs t : times) {
    if (t < now) continue;
    path.knots.push_back(
        {ToSeconds(t - now), PositionAt(stays, t), AltitudeAt(stays, clearance, t, landing)});
  }
  path.low = path.high = path.knots.front().at;
  for (const Trajectory::Knot& knot : path.knots) {
    path.low = {std::min(path.low.x_m, knot.at.x_m), std::min(path.low.y_m, knot.at.y_m)};
    path.high = {std::max(path.high.x_m, knot.at.x_m), std::max(path.high.y_m, knot.at.y_m)};
  }
  return path;
}

bool AreFarApart(const Trajectory& a, const Trajectory& b, double metres) {
  return a.high.x_m + metres < b.low.x_m || b.high.x_m + metres < a.low.x_m ||
         a.high.y_m + metres < b.low.y_m || b.high.y_m + metres < a.low.y_m;
}

bool AreInConflict(const Trajectory& a, const Trajectory& b, const Separation& minima) {
  if (a.knots.empty() || b.knots.empty() || AreFarApart(a, b, minima.horizontal_m)) return false;
  return VisitTogether(a, b, [&](double, double, const Part& x, const Part& y) {
    return !x.on_ground() && !y.on_ground() && Between(x, y).IsConflict(minima);
  });
}

std::optional<Approach> ClosestApproach(const Trajectory& a, const Trajectory& b,
                                        const Separation& minima) {
  if (a.knots.empty() || b.knots.empty()) return {};
  std::optional<Approach> closest;
  VisitTogether(a, b, [&](double t_s, double seconds, const Part& x, const Part& y) {
    if (x.on_ground() || y.on_ground()) return false;
    const Between between(x, y);
    const double u = between.ClosestAt(minima);
    const Approach found{between.ShareAt(u, minima), between.GapM(u), between.UpM(u),
                         t_s + u * seconds};
    if (!closest || found.share < closest->share) closest = found;
    return false;
  });
  return closest;
}

}  // namespace muster
