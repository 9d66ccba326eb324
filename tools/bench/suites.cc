#include "tools/bench/suites.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <numeric>

#include "base/random.h"
#include "lcmtypes/bus/bus.h"
#include "model/scenario_json.h"
#include "scheduler/policies/certified/certified_policy.h"
#include "scheduler/policies/registry.h"
#include "scheduler/solver/candidates.h"
#include "simulation/simulator.h"
#include "tools/bench/plot.h"
#include "tools/bench/sheet.h"
#include "tools/bench/statistics.h"
#include "tools/graph/situations.h"

namespace muster::tools {
namespace {

using scheduler::Situation;

/// Starts a new count of the process's largest memory, where the kernel lets us.
void ResetPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }

std::int64_t PeakBytes() {
  std::ifstream status("/proc/self/status");
  std::int64_t kib = 0;
  for (std::string word; status >> word;) {
    if (word == "VmHWM:" && status >> kib) break;
  }
  return kib * 1024;
}

void DecideAll(const Situation& situation, BenchRow row, const BenchOptions& options,
               const std::function<void(const BenchRow&)>& report) {
  for (const std::string& method : options.methods) {
    row.method = method;
    const auto policy = scheduler::MakePolicy(method);
    for (row.repetition = 0; row.repetition < options.repetitions; ++row.repetition) {
      ResetPeak();
      const auto start = std::chrono::steady_clock::now();
      scheduler::Decision decision;
      if (method == "certified") {
        scheduler::SolverLimits limits;
        limits.threads = options.threads;
        scheduler::CertifiedProfile profile;
        decision = scheduler::DecideCertified(situation, limits, &profile);
        row.weights_s = profile.weights_s;
        row.candidates_s = profile.candidates_s;
        row.bound_s = profile.bound_s;
        row.search_s = profile.search_s;
      } else {
        decision = policy->Decide(situation);
        row.weights_s = row.candidates_s = row.bound_s = row.search_s = kNotKnown;
      }
      row.total_s =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() +
          (std::isnan(row.fuse_s) ? 0 : row.fuse_s);
      row.peak_bytes = PeakBytes();
      row.nodes = decision.candidates;
      row.weight = decision.weight;
      row.bound = decision.bound;
      report(row);
    }
  }
}

}  // namespace

std::vector<std::uint64_t> BenchOptions::AllSeeds() const {
  std::vector<std::uint64_t> all(static_cast<std::size_t>(seeds));
  std::iota(all.begin(), all.end(), static_cast<std::uint64_t>(first_seed));
  return all;
}

void RunDecisions(const BenchOptions& options, const std::function<void(const BenchRow&)>& report) {
  for (const std::string& instance : options.instances) {
    for (const std::uint64_t seed : options.AllSeeds()) {
      std::vector<double> fuse_s;
      const std::vector<Situation> situations = SituationsOf(PresetByName(instance), seed, &fuse_s);
      for (std::size_t d = 0; d < situations.size(); ++d) {
        BenchRow row;
        row.instance = instance;
        row.seed = seed;
        row.decision = situations[d].decision;
        row.fuse_s = fuse_s[d];
        row.edges = CountEdges(situations[d]);
        DecideAll(situations[d], row, options, report);
      }
    }
  }
}

void RunScale(const BenchOptions& options, const std::function<void(const BenchRow&)>& report) {
  for (const double scale : options.scales) {
    for (const std::uint64_t seed : options.AllSeeds()) {
      BenchRow row;
      row.instance = fmt::format("Random_29 x{:g}", scale);
      row.seed = seed;
      row.fuse_s = kNotKnown;
      const Situation situation =
          MidMission(Scaled(PresetByName("Random_29"), scale), row.seed, options.availability);
      row.decision = situation.decision;
      // Written-out nodes of a tenth of the largest size take a gigabyte already.
      if (scale <= 3) row.edges = CountEdges(situation);
      DecideAll(situation, row, options, report);
    }
  }
}

std::vector<Situation> SituationsOf(const GeneratorSettings& settings, std::uint64_t seed,
                                    std::vector<double>* fuse_s) {
  SituationRecorder recorder;
  Simulate(TextOf(Generate(settings, seed)), "certified",
           [&](const Packet& packet) { recorder.Add(packet); });
  return recorder.Situations(fuse_s);
}

Situation MidMission(const GeneratorSettings& settings, std::uint64_t seed,
                     Availability availability) {
  Scenario scenario = Generate(settings, seed);
  scenario.rules.availability = availability;
  Situation situation;
  situation.site = std::make_shared<const scheduler::Site>(scenario);
  situation.decision = static_cast<std::int32_t>(60 * kMinuteUs / scenario.rules.interval_us);
  situation.now_us = situation.decision * scenario.rules.interval_us;
  const auto add = [&](AgentKind kind, std::vector<AgentState>* agents) {
    std::int32_t id = 0;
    for (AgentSpec spec : scenario.agents(kind)) {
      Random random(seed, Stream::kPolicy, static_cast<std::uint64_t>(id));
      spec.range_m = spec.range_full_m * std::min(1.0, random.Uniform(0.3, 1.3));
      const AgentState agent = StartOf(kind, id++, spec, *scenario.ways);
      if (agent.online(situation.now_us)) agents->push_back(agent);
    }
  };
  add(AgentKind::kUav, &situation.uavs);
  add(AgentKind::kWorker, &situation.workers);
  add(AgentKind::kVehicle, &situation.vehicles);
  for (std::size_t x = 0; x < scenario.tasks.size(); ++x) {
    const bool done = Random(seed, Stream::kPolicy, x, 1).Uniform() < 0.3;
    situation.task_status.push_back(done ? TaskStatus::kDone : TaskStatus::kOpen);
  }
  situation.charging_load.assign(scenario.charging_points.size(), 0);
  return situation;
}

std::int64_t CountEdges(const Situation& situation) {
  // Pairs that share one element, less those counted twice since they share two. No two nodes
  // share three.
  const scheduler::Candidates graph = scheduler::EnumerateCandidates(situation);
  std::vector<std::int64_t> at_element(graph.elements.capacity.size(), 0);
  std::vector<std::int64_t> pairs;
  for (const scheduler::Node& node : graph.nodes) {
    std::vector<std::int32_t> elements;
    for (const std::int32_t e : ElementsOf(node, graph.elements)) {
      if (graph.elements.capacity[static_cast<std::size_t>(e)] == 1) elements.push_back(e);
    }
    for (std::size_t i = 0; i < elements.size(); ++i) {
      ++at_element[static_cast<std::size_t>(elements[i])];
      for (std::size_t j = i + 1; j < elements.size(); ++j) {
        pairs.push_back(static_cast<std::int64_t>(elements[i]) << 32 | elements[j]);
      }
    }
  }
  std::int64_t edges = 0;
  for (const std::int64_t n : at_element) edges += n * (n - 1) / 2;
  std::sort(pairs.begin(), pairs.end());
  for (std::size_t k = 0; k < pairs.size();) {
    const std::size_t first = k;
    while (k < pairs.size() && pairs[k] == pairs[first]) ++k;
    const auto n = static_cast<std::int64_t>(k - first);
    edges -= n * (n - 1) / 2;
  }
  return edges;
}

std::string CsvHeader() {
  return "instance,seed,decision,method,repetition,n,m,weight,bound,gap,fuse_s,weights_s,"
         "candidates_s,bound_s,search_s,total_s,peak_bytes\n";
}

std::string ToCsv(const BenchRow& row) {
  return fmt::format("{},{},{},{},{},{},{},{:.9f},{},{},{},{},{},{},{},{},{}\n", row.instance,
                     row.seed, row.decision, row.method, row.repetition, row.nodes,
                     row.edges < 0 ? "" : fmt::to_string(row.edges), row.weight,
                     std::isnan(row.bound) ? "" : fmt::format("{:.9f}", row.bound),
                     std::isnan(row.bound) ? "" : fmt::format("{:.3g}", row.gap()),
                     Number(row.fuse_s), Number(row.weights_s), Number(row.candidates_s),
                     Number(row.bound_s), Number(row.search_s), Number(row.total_s),
                     row.peak_bytes);
}

std::string SummaryOf(const std::vector<BenchRow>& rows) {
  Sheet sheet(
      "instance|method|runs|nodes<=|median_ms|p10_ms|p90_ms|max_ms|gap<=|gap<=0.1%|peak_MiB");
  const auto key = [](const BenchRow& row) { return std::pair(row.instance, row.method); };
  for (const auto& named : GroupsOf(rows, key)) {
    const auto& [instance, method] = named.first;
    const auto& group = named.second;
    const auto ms = ValuesOf(group, [](const BenchRow& row) { return row.total_s * 1e3; });
    const auto gaps = ValuesOf(
        group, [](const BenchRow& row) { return std::isnan(row.bound) ? kNotKnown : row.gap(); });
    const auto most = [&](auto member) {
      return Quantile(ValuesOf(group, [&](const BenchRow& row) { return row.*member; }), 1);
    };
    sheet.Add(fmt::format(
        "{}|{}|{}|{:.0f}|{:.3f}|{:.3f}|{:.3f}|{:.3f}|{}|{}|{:.1f}", instance, method, group.size(),
        most(&BenchRow::nodes), Quantile(ms, 0.5), Quantile(ms, 0.1), Quantile(ms, 0.9),
        Quantile(ms, 1), Shown("{:.2g}", Quantile(gaps, 1)),
        Shown("{:.2f}%", PercentUpTo(1e-3, gaps)), most(&BenchRow::peak_bytes) / (1 << 20)));
  }
  return sheet.Text();
}

std::string PlotScript(const std::string& csv_file, const std::string& svg_file) {
  Chart chart;
  for (const char* part : {"total", "weights", "candidates", "bound", "search"}) {
    chart.curves.push_back(
        {"",
         fmt::format("using (column('n')):(column('{}_s')) smooth unique with linespoints", part),
         part});
  }
  const Plot plot{800,
                  500,
                  "set logscale xy\nset xlabel 'nodes'\nset ylabel 'seconds'\nset key left top\n",
                  {chart}};
  return ScriptOf(plot, svg_file, csv_file);
}

}  // namespace muster::tools
