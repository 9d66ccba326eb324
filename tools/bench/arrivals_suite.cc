#include "tools/bench/arrivals_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>

#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"

namespace muster::tools {
namespace {

constexpr const char* kArrivals[] = {"steady", "bursts"};
constexpr int kBursts = 6;

/// Nine of ten tasks are reported while the mission runs. The more one matters, the sooner it is
/// due; twice that long after its report it is gone.
GeneratorSettings SettingsOf(const std::string& arrivals, double load) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.tasks = std::max(1, static_cast<int>(std::lround(settings.tasks * load)));
  settings.arrivals = {0.9, arrivals == "bursts" ? kBursts : 0};
  settings.priority_shares = {0.3, 0.4, 0.2, 0.1};
  constexpr double kDue_min[] = {60, 40, 25, 15};
  for (std::size_t p = 0; p < kPriorities; ++p) {
    settings.due_min[p] = Always(kDue_min[p]);
    settings.expires_min[p] = Always(2 * kDue_min[p]);
  }
  return settings;
}

double Share(double part, double all) { return all > 0 ? part / all : std::nan(""); }

struct Means {
  int n = 0;
  double worth = 0, done = 0, on_time = 0, expired = 0, mean_s = 0, p90_s = 0, emergency = 0;
};

}  // namespace

void RunArrivals(const ArrivalsOptions& options,
                 const std::function<void(const ArrivalsRow&)>& report) {
  for (const char* arrivals : kArrivals) {
    for (const double load : options.loads) {
      for (int i = 0; i < options.seeds; ++i) {
        const auto seed = static_cast<std::uint64_t>(options.first_seed + i);
        const std::string json = ScenarioToJson(Generate(SettingsOf(arrivals, load), seed));
        for (const std::string& policy : options.policies) {
          RunRecord record;
          Simulate(json, policy, [&](const Packet& packet) { record.Add(packet); });
          report({arrivals, load, seed, policy, ServiceOf(record, *record.scenario())});
        }
      }
    }
  }
}

std::string ArrivalsCsvHeader() {
  return "arrivals,load,seed,policy,reported,done,on_time,expired,worth_done,worth_all,"
         "mean_response_s,median_response_s,p90_response_s,emergencies,emergencies_on_time\n";
}

std::string ToCsv(const ArrivalsRow& row) {
  const Service& s = row.service;
  const Service::Of& emergency = s.by_priority[static_cast<std::size_t>(Priority::kEmergency)];
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{:.3f},{:.3f},{:.3f},{},{}\n", row.arrivals,
                     row.load, row.seed, row.policy, s.reported(), s.done(), s.on_time(), s.expired,
                     s.worth_done, s.worth_all, s.mean_response_s(), s.response_quantile_s(0.5),
                     s.response_quantile_s(0.9), emergency.reported, emergency.on_time);
}

std::string SummaryOf(const std::vector<ArrivalsRow>& rows) {
  std::map<std::pair<std::string, double>, std::vector<std::pair<std::string, Means>>> table;
  for (const ArrivalsRow& row : rows) {
    auto& group = table[{row.arrivals, row.load}];
    auto found = std::find_if(group.begin(), group.end(),
                              [&](const auto& entry) { return entry.first == row.policy; });
    if (found == group.end()) found = group.insert(group.end(), {row.policy, Means()});
    Means& means = found->second;
    const Service& s = row.service;
    const Service::Of& emergency = s.by_priority[static_cast<std::size_t>(Priority::kEmergency)];
    ++means.n;
    means.worth += Share(s.worth_done, s.worth_all);
    means.done += Share(s.done(), s.reported());
    means.on_time += Share(s.on_time(), s.reported());
    means.emergency += emergency.reported == 0 ? 1 : Share(emergency.on_time, emergency.reported);
    means.expired += Share(s.expired, s.reported());
    means.mean_s += s.response_s.empty() ? 0 : s.mean_response_s();
    means.p90_s += s.response_s.empty() ? 0 : s.response_quantile_s(0.9);
  }
  std::string text =
      "| arrivals | load | policy | worth % | done % | on time % | emergencies on time % | expired "
      "% | response, min | p90, min |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
  for (const auto& [key, group] : table) {
    for (const auto& [policy, m] : group) {
      fmt::format_to(std::back_inserter(text),
                     "| {} | {} | `{}` | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | "
                     "{:.1f} |\n",
                     key.first, key.second, policy, 100 * m.worth / m.n, 100 * m.done / m.n,
                     100 * m.on_time / m.n, 100 * m.emergency / m.n, 100 * m.expired / m.n,
                     m.mean_s / m.n / 60, m.p90_s / m.n / 60);
    }
  }
  return text;
}

std::string ArrivalsPlot(const std::vector<ArrivalsRow>& rows, const std::string& svg_file) {
  std::map<std::string, std::map<std::string, std::map<double, Means>>> lines;
  std::vector<std::string> policies;
  for (const ArrivalsRow& row : rows) {
    Means& means = lines[row.arrivals][row.policy][row.load];
    ++means.n;
    means.worth += Share(row.service.worth_done, row.service.worth_all);
    if (std::find(policies.begin(), policies.end(), row.policy) == policies.end()) {
      policies.push_back(row.policy);
    }
  }
  std::string text = fmt::format(
      "set terminal svg size 900,400 noenhanced background 'white'\nset output '{}'\n"
      "set multiplot layout 1,2\nset xlabel 'tasks, times those of Random_1'\n"
      "set ylabel 'share of the worth'\nset yrange [0:1]\nset key top right\n",
      svg_file);
  for (const auto& [arrivals, by_policy] : lines) {
    std::string plot;
    for (std::size_t i = 0; i < policies.size(); ++i) {
      text += fmt::format("${}_{} << EOD\n", arrivals, i);
      for (const auto& [load, means] : by_policy.at(policies[i])) {
        text += fmt::format("{} {:.4f}\n", load, means.worth / means.n);
      }
      text += "EOD\n";
      plot += fmt::format("{}${}_{} with linespoints title '{}'", i == 0 ? "" : ", ", arrivals, i,
                          policies[i]);
    }
    text += fmt::format("set title '{}'\nplot {}\n", arrivals, plot);
  }
  return text + "unset multiplot\n";
}

}  // namespace muster::tools
