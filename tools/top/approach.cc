#include "tools/top/approach.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "lcmtypes/words.h"

namespace muster::tools {
namespace {

constexpr double kAhead_s = 120;

/// Metres above the ground at that time, by the plan.
double HeightAt(const Timeline::Height& plan, std::int64_t t_ms) {
  const auto& knots = plan.knots;
  std::size_t i = 0;
  while (i + 1 < knots.size() && knots[i + 1].first <= t_ms) ++i;
  if (i + 1 >= knots.size() || t_ms <= knots[i].first) return knots[i].second;
  const double share = static_cast<double>(t_ms - knots[i].first) /
                       static_cast<double>(knots[i + 1].first - knots[i].first);
  return knots[i].second + share * (knots[i + 1].second - knots[i].second);
}

/// By UAV: those that are in the air.
std::map<std::int32_t, Flying> InTheAir(const Timeline& timeline) {
  std::map<std::int32_t, const Timeline::Height*> plans;
  for (const Timeline::Height& plan : timeline.heights().rows) {
    if (plan.knots.empty() || plan.knots.front().first > timeline.now_ms()) continue;
    plans[plan.uav] = &plan;
  }
  std::map<std::int32_t, Flying> flying;
  for (const auto& [uav, plan] : plans) {
    const Timeline::Agent& agent =
        timeline.agents()[timeline.IndexOf(AgentKind::kUav, static_cast<std::size_t>(uav))];
    const double up_m = HeightAt(*plan, timeline.now_ms());
    if (up_m <= 0 || !agent.last) continue;
    const auto status = static_cast<AgentStatus>(agent.last->status);
    if (status == AgentStatus::kOffline || status == AgentStatus::kFailed) continue;
    Flying& one = flying[uav];
    one = {agent.last->x_m, agent.last->y_m, up_m, 0, 0};
    const auto& stops = agent.stops.rows;
    if (status != AgentStatus::kMoving || stops.size() < 2) continue;
    const Timeline::Stop &from = stops[stops.size() - 2], &to = stops.back();
    const double took_s = static_cast<double>(to.t_ms - from.t_ms) / 1000;
    if (took_s <= 0) continue;
    one.vx_m_s = (to.x_m - from.x_m) / took_s;
    one.vy_m_s = (to.y_m - from.y_m) / took_s;
  }
  return flying;
}

}  // namespace

std::optional<Approach> ApproachOf(const Flying& a, const Flying& b, const Separation& minima) {
  const double up_m = std::abs(a.up_m - b.up_m);
  if (up_m >= minima.vertical_m) return {};
  const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
  const double vx = b.vx_m_s - a.vx_m_s, vy = b.vy_m_s - a.vy_m_s;
  const double speed2 = vx * vx + vy * vy;
  const double in_s = speed2 == 0 ? 0 : std::clamp(-(dx * vx + dy * vy) / speed2, 0.0, kAhead_s);
  const double across_m = std::hypot(dx + vx * in_s, dy + vy * in_s);
  if (across_m >= minima.horizontal_m) return {};
  return Approach{in_s, across_m, up_m};
}

std::string ToText(const Approach& approach) {
  const auto in_s = std::llround(approach.in_s);
  return fmt::format("{:.0f} m across and {:.0f} m up from each other {}", approach.across_m,
                     approach.up_m,
                     in_s == 0 ? "now" : fmt::format("in {}:{:02}", in_s / 60, in_s % 60));
}

std::vector<NearPair> NearPairs(const Timeline& timeline) {
  const Scenario& scenario = timeline.scenario();
  const Separation* const minima = scenario.separation();
  std::vector<NearPair> pairs;
  if (minima == nullptr) return pairs;
  const auto is_measured = [&](std::int32_t uav) {
    return scenario.uavs[static_cast<std::size_t>(uav)].measured;
  };
  if (std::none_of(scenario.uavs.begin(), scenario.uavs.end(),
                   [](const AgentSpec& uav) { return uav.measured; })) {
    return pairs;
  }
  const std::map<std::int32_t, Flying> flying = InTheAir(timeline);
  for (const auto& [a, of_a] : flying) {
    if (!is_measured(a)) continue;
    for (const auto& [b, of_b] : flying) {
      if (b == a || (is_measured(b) && b < a)) continue;
      if (const auto approach = ApproachOf(of_a, of_b, *minima)) pairs.push_back({a, b, *approach});
    }
  }
  return pairs;
}

std::optional<AirPicture> AirPictureOf(const Timeline& timeline) {
  const Separation* const minima = timeline.scenario().separation();
  if (minima == nullptr) return {};
  const std::map<std::int32_t, Flying> flying = InTheAir(timeline);
  AirPicture picture;
  picture.n = flying.size();
  if (flying.empty()) return picture;
  const auto [low, high] = std::minmax_element(
      flying.begin(), flying.end(),
      [](const auto& a, const auto& b) { return a.second.up_m < b.second.up_m; });
  picture.lowest_m = low->second.up_m;
  picture.highest_m = high->second.up_m;
  if (flying.size() > AirPicture::kMostCompared) return picture;
  double least = std::numeric_limits<double>::infinity();
  for (auto a = flying.begin(); a != flying.end(); ++a) {
    for (auto b = std::next(a); b != flying.end(); ++b) {
      const double across_m =
          std::hypot(a->second.x_m - b->second.x_m, a->second.y_m - b->second.y_m);
      const double up_m = std::abs(a->second.up_m - b->second.up_m);
      const double share = std::max(across_m / minima->horizontal_m, up_m / minima->vertical_m);
      if (share >= least) continue;
      least = share;
      picture.nearest = NearPair{a->first, b->first, {0, across_m, up_m}};
    }
  }
  return picture;
}

}  // namespace muster::tools
