#include "tools/bench/random_missions.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "base/random.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tools/bench/statistics.h"

namespace muster::tools {
namespace {

constexpr std::array kLimitsMin = {30, 45, 60, 90, 120, 180, 240};
constexpr std::array kIntervalsMin = {5, 10, 15, 20, 30};
constexpr double kMostTimes = 30;       ///< the data set's size
constexpr double kMostTimesOfMany = 8;  ///< in missions of more than
constexpr int kManyDecisions = 16;

Scenario DrawnMission(std::uint64_t seed) {
  Random random(seed, Stream::kPolicy, 2, 7);
  const auto below = [&](std::size_t n) { return random.Below(static_cast<std::uint32_t>(n)); };
  // Half of them on the largest of the paper's drawn data sets.
  GeneratorSettings settings =
      below(2) == 0 ? PresetByName("Random_29") : Presets()[below(Presets().size())];
  const int limit_min = kLimitsMin[below(kLimitsMin.size())];
  const int interval_min = kIntervalsMin[below(kIntervalsMin.size())];
  const bool many = limit_min > kManyDecisions * interval_min;
  settings =
      Scaled(settings, std::exp(random.Uniform(0, std::log(many ? kMostTimesOfMany : kMostTimes))));
  settings.rules.limit_us = limit_min * kMinuteUs;
  settings.rules.interval_us = interval_min * kMinuteUs;
  settings.rules.availability = below(2) == 0 ? Availability::kStrict : Availability::kOverrun;
  return Generate(settings, seed);
}

const char* SizeOf(std::int64_t nodes) {
  if (nodes <= 1'000'000) return "to-1-million";
  return nodes <= 5'000'000 ? "to-5-million" : "more";
}

}  // namespace

void RunRandomMissions(const BenchOptions& options,
                       const std::function<void(const HardRow&)>& report) {
  for (const std::uint64_t seed : options.AllSeeds()) {
    Simulate(TextOf(DrawnMission(seed)), "certified", [&](const Packet& packet) {
      if (packet.channel != channel::kSchedule) return;
      const auto schedule = Decode<schedule_t>(packet.bytes);
      HardRow row;
      row.family = SizeOf(schedule->candidates);
      row.seed = seed;
      row.decision = schedule->decision;
      row.nodes = schedule->candidates;
      row.weight = schedule->weight;
      row.bound = schedule->bound;
      row.cpu_s = row.wall_s = static_cast<double>(schedule->solve_us) / kSecondUs;
      row.relaxation = row.cbc_relaxation = row.cbc_relaxation_s = kNotKnown;
      row.cbc_optimum = row.cbc_optimum_s = row.others = kNotKnown;
      report(row);
    });
  }
}

std::string RandomMissionsLimits() {
  return fmt::format(
      "half on Random_29, half on any of the {} data sets; size 1 to {:g} times, uniform in the "
      "logarithm ({:g} where there are more than {} decisions); limit {} min; interval {} min; "
      "half "
      "in each mode\n",
      Presets().size(), kMostTimes, kMostTimesOfMany, kManyDecisions, fmt::join(kLimitsMin, ", "),
      fmt::join(kIntervalsMin, ", "));
}

}  // namespace muster::tools
