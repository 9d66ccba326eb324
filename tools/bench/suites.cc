#include "tools/bench/suites.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <tuple>

#include "base/random.h"
#include "lcmtypes/bus/bus.h"
#include "model/scenario_json.h"
#include "scheduler/candidates.h"
#include "scheduler/policies/certified/certified_policy.h"
#include "scheduler/policies/registry.h"
#include "simulation/simulator.h"
#include "tools/graph/situations.h"

namespace muster::tools {
namespace {

using scheduler::Situation;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

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
        row.weights_s = row.candidates_s = row.bound_s = row.search_s = kNone;
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

std::string Number(double value) { return std::isnan(value) ? "" : fmt::format("{:.9g}", value); }

double Quantile(const std::vector<double>& sorted, double share) {
  const auto at =
      static_cast<std::size_t>(std::lround(share * static_cast<double>(sorted.size() - 1)));
  return sorted[at];
}

}  // namespace

void RunDecisions(const BenchOptions& options, const std::function<void(const BenchRow&)>& report) {
  for (const std::string& instance : options.instances) {
    for (int seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed) {
      SituationRecorder recorder;
      const Scenario scenario = Generate(PresetByName(instance), static_cast<std::uint64_t>(seed));
      Simulate(ScenarioToJson(scenario), "certified",
               [&](const Packet& packet) { recorder.Add(packet); });
      std::vector<double> fuse_s;
      const std::vector<Situation> situations = recorder.Situations(&fuse_s);
      for (std::size_t d = 0; d < situations.size(); ++d) {
        BenchRow row;
        row.instance = instance;
        row.seed = static_cast<std::uint64_t>(seed);
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
    for (int seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed) {
      BenchRow row;
      row.instance = fmt::format("Random_29 x{:g}", scale);
      row.seed = static_cast<std::uint64_t>(seed);
      row.fuse_s = kNone;
      const Situation situation =
          MidMission(Scaled(PresetByName("Random_29"), scale), row.seed, options.availability);
      row.decision = situation.decision;
      // Written-out nodes of a tenth of the largest size take a gigabyte already.
      if (scale <= 3) row.edges = CountEdges(situation);
      DecideAll(situation, row, options, report);
    }
  }
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
  struct Group {
    std::vector<double> total_ms, gaps;
    std::int64_t most_nodes = 0;
    double peak_mib = 0;
  };
  std::vector<std::pair<std::string, std::string>> order;
  std::map<std::pair<std::string, std::string>, Group> groups;
  for (const BenchRow& row : rows) {
    const std::pair key(row.instance, row.method);
    if (groups.count(key) == 0) order.push_back(key);
    Group& group = groups[key];
    group.total_ms.push_back(row.total_s * 1e3);
    if (!std::isnan(row.bound)) group.gaps.push_back(row.gap());
    group.most_nodes = std::max(group.most_nodes, row.nodes);
    group.peak_mib = std::max(group.peak_mib, static_cast<double>(row.peak_bytes) / 1048576);
  }
  std::string text =
      fmt::format("{:<18} {:<10} {:>5} {:>9} {:>10} {:>10} {:>10} {:>10} {:>8} {:>9} {:>9}\n",
                  "instance", "method", "runs", "nodes<=", "median_ms", "p10_ms", "p90_ms",
                  "max_ms", "gap<=", "gap<=0.1%", "peak_MiB");
  for (const auto& key : order) {
    Group& group = groups[key];
    std::sort(group.total_ms.begin(), group.total_ms.end());
    std::string largest = "-", share = "-";
    if (!group.gaps.empty()) {
      largest = fmt::format("{:.2g}", *std::max_element(group.gaps.begin(), group.gaps.end()));
      const auto small = std::count_if(group.gaps.begin(), group.gaps.end(),
                                       [](double gap) { return gap <= 1e-3; });
      share = fmt::format(
          "{:.2f}%", 100.0 * static_cast<double>(small) / static_cast<double>(group.gaps.size()));
    }
    text += fmt::format(
        "{:<18} {:<10} {:>5} {:>9} {:>10.3f} {:>10.3f} {:>10.3f} {:>10.3f} {:>8} {:>9} {:>9.1f}\n",
        key.first, key.second, group.total_ms.size(), group.most_nodes,
        Quantile(group.total_ms, 0.5), Quantile(group.total_ms, 0.1), Quantile(group.total_ms, 0.9),
        group.total_ms.back(), largest, share, group.peak_mib);
  }
  return text;
}

std::string PlotScript(const std::string& csv_file, const std::string& svg_file) {
  return fmt::format(
      "# gnuplot: time of a decision against the size of its graph\n"
      "set terminal svg size 800,500 background 'white'\nset output '{}'\nset datafile separator "
      "','\n"
      "set logscale xy\nset xlabel 'nodes'\nset ylabel 'seconds'\nset key left top\n"
      "plot '{}' using (column('n')):(column('total_s')) smooth unique with linespoints "
      "title 'total', \\\n"
      "     '' using (column('n')):(column('weights_s')) smooth unique with linespoints "
      "title 'weights', \\\n"
      "     '' using (column('n')):(column('candidates_s')) smooth unique with "
      "linespoints title 'candidates', \\\n"
      "     '' using (column('n')):(column('bound_s')) smooth unique with linespoints "
      "title 'bound', \\\n"
      "     '' using (column('n')):(column('search_s')) smooth unique with linespoints "
      "title 'search'\n",
      svg_file, csv_file);
}

}  // namespace muster::tools
