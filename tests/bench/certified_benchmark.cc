// Micro-benchmarks of a decision's parts. Not a test: times are for docs/results/benchmarks.md.
#include <benchmark/benchmark.h>

#include "base/random.h"
#include "scheduler/policies/horizon/pairs.h"
#include "scheduler/solver/build.h"
#include "scheduler/solver/dual.h"
#include "scheduler/solver/solver.h"
#include "tools/bench/suites.h"

namespace muster {
namespace {

scheduler::Situation SituationFor(const benchmark::State& state) {
  const char* preset = state.range(0) == 1 ? "Random_1" : "Random_29";
  return tools::MidMission(PresetByName(preset), 1);
}

void BuildInstance(benchmark::State& state) {
  const auto situation = SituationFor(state);
  for (auto _ : state) {
    benchmark::DoNotOptimize(scheduler::BuildInstance(situation).instance.uav_arcs.size());
  }
}
BENCHMARK(BuildInstance)->Arg(1)->Arg(29)->Unit(benchmark::kMicrosecond);

void BoundAtPrices(benchmark::State& state) {
  const auto built = scheduler::BuildInstance(SituationFor(state));
  scheduler::Dual dual(built.instance, 1);
  for (auto _ : state) benchmark::DoNotOptimize(dual.Evaluate());
}
BENCHMARK(BoundAtPrices)->Arg(1)->Arg(29)->Unit(benchmark::kMicrosecond);

void Solve(benchmark::State& state) {
  const auto built = scheduler::BuildInstance(SituationFor(state));
  for (auto _ : state) benchmark::DoNotOptimize(scheduler::Solve(built.instance).bound);
}
BENCHMARK(Solve)->Arg(1)->Arg(29)->Unit(benchmark::kMicrosecond);

/// Who could meet where, at so many times Random_29's size: grows with the ways in reach.
void HorizonPairs(benchmark::State& state) {
  const auto situation =
      tools::MidMission(Scaled(PresetByName("Random_29"), static_cast<double>(state.range(0))), 1);
  const scheduler::HorizonSettings settings;
  const auto participants = scheduler::ParticipantsOf(situation, settings);
  const auto open = scheduler::OpenSitesOf(situation);
  std::size_t ways = 0;
  for (auto _ : state) {
    const auto pairs = scheduler::FindPairs(situation, participants, open, settings);
    ways = pairs.instance.uav_arcs.size() + pairs.instance.partner_arcs.size();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(ways));
}
BENCHMARK(HorizonPairs)->Arg(1)->Arg(10)->Arg(100)->Unit(benchmark::kMillisecond);

void SoftmaxMean(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0));
  std::vector<Point> places;
  std::vector<double> values;
  for (std::size_t i = 0; i < n; ++i) {
    Random random(1, Stream::kTest, i);
    const double side = 60e3 * std::sqrt(static_cast<double>(n) / 480);
    places.push_back({random.Uniform(0, side), random.Uniform(0, side)});
    values.push_back(random.Uniform(1, 5));
  }
  const scheduler::PlaceSums sums(places, values, {});
  const scheduler::LevelOf level(1000.0 / 60, Rules{});
  scheduler::Queries from(places);
  for (auto _ : state) benchmark::DoNotOptimize(sums.SoftmaxMeans(&from, level).front());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(n));
}
BENCHMARK(SoftmaxMean)->Arg(480)->Arg(4800)->Arg(48000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace muster

BENCHMARK_MAIN();
