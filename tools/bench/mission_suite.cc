#include "tools/bench/mission_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/check.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "tools/files/scratch_folder.h"
#include "tools/host/worker_pool.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

constexpr std::array<std::string_view, 8> kKinds = {
    "world", "uav", "worker", "vehicle", "scheduler", "recorder", "launcher", "simulate"};

/// From the process that has run the mission to this one.
std::string ToText(const MissionFigures& f) {
  Json kinds = Json::object();
  for (const auto& [name, usage] : f.kinds) kinds[name] = {usage.cpu_s, usage.peak_bytes};
  return Json{f.end,
              f.wall_s,
              f.cpu_s,
              f.sent_datagrams,
              f.sent_bytes,
              f.received_datagrams,
              f.buffer_errors,
              f.resent,
              f.log_bytes,
              f.log_messages,
              f.log_doubles,
              f.digest,
              kinds}
      .dump(-1, ' ', false, Json::error_handler_t::replace);
}

MissionFigures FromText(const std::string& text) {
  const Json json = Json::parse(text);
  MissionFigures f;
  std::size_t at = 0;
  const auto take = [&](auto* value) { json.at(at++).get_to(*value); };
  take(&f.end), take(&f.wall_s), take(&f.cpu_s), take(&f.sent_datagrams), take(&f.sent_bytes);
  take(&f.received_datagrams), take(&f.buffer_errors), take(&f.resent), take(&f.log_bytes);
  take(&f.log_messages), take(&f.log_doubles), take(&f.digest);
  for (const auto& [name, usage] : json.at(at).items()) {
    f.kinds[name] = {usage.at(0).get<double>(), usage.at(1).get<std::int64_t>()};
  }
  return f;
}

struct Instance {
  std::string name;
  GeneratorSettings settings;
  double size = 1;
};

std::vector<Instance> InstancesOf(const MissionSuite& suite) {
  std::vector<Instance> instances;
  for (const std::string& name : suite.instances) {
    instances.push_back({name, PresetByName(name), 1});
  }
  for (const double scale : suite.scales) {
    instances.push_back(
        {fmt::format("Random_29 x{:g}", scale), Scaled(PresetByName("Random_29"), scale), scale});
  }
  return instances;
}

double Median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Least squares of log(y) over log(x); NaN: less than two sizes.
double Exponent(const std::vector<std::pair<double, double>>& points) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [size, value] : points) {
    if (size <= 0 || value <= 0) continue;
    const double a = std::log(size), b = std::log(value);
    n += 1, x += a, y += b, xx += a * a, xy += a * b;
  }
  const double spread = n * xx - x * x;
  return n < 2 || spread < 1e-9 ? std::nan("") : (n * xy - x * y) / spread;
}

/// Rows of one instance, run and number of processes.
using Group = std::vector<const MissionRow*>;
using Key = std::tuple<std::string, std::string, int>;

double MedianOf(const Group& group, const std::function<double(const MissionFigures&)>& value) {
  std::vector<double> values;
  for (const MissionRow* row : group) values.push_back(value(row->figures));
  return Median(std::move(values));
}

std::string GrowthOf(const std::vector<MissionRow>& rows, const std::map<Key, Group>& groups) {
  std::map<std::pair<std::string, int>, std::vector<std::pair<double, double>>> walls, logs;
  for (const auto& [key, group] : groups) {
    const MissionRow& row = *group.front();
    if (!row.instance.starts_with("Random_29")) continue;
    const auto agents = static_cast<double>(row.agents);
    walls[{row.run, row.processes}].emplace_back(
        agents, MedianOf(group, [](const MissionFigures& f) { return f.wall_s; }));
    logs[{row.run, row.processes}].emplace_back(
        agents,
        MedianOf(group, [](const MissionFigures& f) { return static_cast<double>(f.log_bytes); }));
  }
  std::string text;
  for (const auto& [key, points] : walls) {
    const double wall = Exponent(points), log = Exponent(logs[key]);
    if (std::isnan(wall)) continue;
    text += fmt::format("Random_29, {}, {} a class: wall time grows with agents^{:.2f}", key.first,
                        key.second, wall);
    text += std::isnan(log) ? "\n" : fmt::format(", the log with agents^{:.2f}\n", log);
  }
  return rows.empty() ? "" : text;
}

}  // namespace

void RunMissionSuite(const MissionSuite& suite,
                     const std::function<void(const MissionRow&)>& report,
                     const std::function<bool()>& stop) {
  const ScratchFolder scratch("muster_bench");
  for (int repetition = 0; repetition < suite.repetitions; ++repetition) {
    for (const Instance& instance : InstancesOf(suite)) {
      Scenario scenario = Generate(instance.settings, suite.seed);
      if (suite.limit_min)
        scenario.rules.limit_us = std::llround(*suite.limit_min * static_cast<double>(kMinuteUs));
      const std::string file = scratch.File("scenario.json");
      std::ofstream(file, std::ios::trunc) << ScenarioToJson(scenario);
      MissionRow row;
      row.instance = instance.name;
      row.size = instance.size;
      row.tasks = static_cast<std::int64_t>(scenario.tasks.size());
      for (const AgentKind kind : kAgentKinds) {
        row.agents += static_cast<std::int64_t>(scenario.agents(kind).size());
      }
      row.limit_min = ToMinutes(scenario.rules.limit_us);
      row.policy = suite.policy;
      row.repetition = repetition;
      for (const int processes : suite.processes) {
        for (const std::string& run : suite.runs) {
          if (run == "simulate" && processes != suite.processes.front()) continue;
          if (stop()) return;
          row.processes = run == "simulate" ? 1 : processes;
          row.run = run;
          const ScratchFolder folder("muster_mission");
          const MissionSetting setting{file, suite.policy, row.processes, run};
          RunInProcesses(
              1, 1, [&](std::size_t) { return ToText(RunMeasured(setting, folder.path())); },
              [&](std::size_t, const std::string& text) { row.figures = FromText(text); },
              [&](std::size_t, const std::string& why) { throw SystemError(why); });
          report(row);
        }
      }
    }
  }
}

std::string MissionCsvHeader() {
  std::string header =
      "instance,size,agents,tasks,limit_min,policy,processes,run,repetition,end,wall_s,cpu_s,"
      "sent_datagrams,sent_bytes,received_datagrams,buffer_errors,resent,log_bytes,log_messages,"
      "log_doubles";
  for (const std::string_view kind : kKinds) header += fmt::format(",{}_cpu_s", kind);
  for (const std::string_view kind : kKinds) header += fmt::format(",{}_peak_bytes", kind);
  return header + ",digest\n";
}

std::string ToCsv(const MissionRow& row) {
  const MissionFigures& f = row.figures;
  std::string end = f.end;
  std::replace_if(
      end.begin(), end.end(), [](char c) { return c == ',' || c == '\n' || c == '"'; }, ' ');
  std::string text = fmt::format(
      "{},{:g},{},{},{:g},{},{},{},{},{},{:.6g},{:.6g},{},{},{},{},{},{},"
      "{},{}",
      row.instance, row.size, row.agents, row.tasks, row.limit_min, row.policy, row.processes,
      row.run, row.repetition, end, f.wall_s, f.cpu_s, f.sent_datagrams, f.sent_bytes,
      f.received_datagrams, f.buffer_errors, f.resent, f.log_bytes, f.log_messages, f.log_doubles);
  const auto add = [&](const auto& value) {
    for (const std::string_view kind : kKinds) {
      const auto usage = f.kinds.find(std::string(kind));
      text += usage == f.kinds.end() ? "," : fmt::format(",{}", value(usage->second));
    }
  };
  add([](const KindUsage& usage) { return fmt::format("{:.6g}", usage.cpu_s); });
  add([](const KindUsage& usage) { return usage.peak_bytes; });
  return text + "," + f.digest + "\n";
}

std::string SummaryOf(const std::vector<MissionRow>& rows) {
  std::vector<Key> order;
  std::map<Key, Group> groups;
  for (const MissionRow& row : rows) {
    const Key key(row.instance, row.run, row.processes);
    if (!groups.contains(key)) order.push_back(key);
    groups[key].push_back(&row);
  }
  std::string text = fmt::format(
      "{:<15} {:>7} {:<8} {:>5} {:>4} {:>8} {:>8} {:>8} {:>8} {:>7} {:>7} {:>8} {:>8}\n",
      "instance", "agents", "run", "procs", "runs", "wall_s", "ratio", "cpu_s", "sent_MB", "resent",
      "lost_%", "log_MB", "peak_MiB");
  for (const Key& key : order) {
    const Group& group = groups[key];
    const MissionRow& row = *group.front();
    const auto median = [&](const std::function<double(const MissionFigures&)>& value) {
      return MedianOf(group, value);
    };
    const double wall = median([](const MissionFigures& f) { return f.wall_s; });
    const auto alone = groups.find({row.instance, "simulate", 1});
    const double ratio =
        alone == groups.end()
            ? std::nan("")
            : wall / MedianOf(alone->second, [](const MissionFigures& f) { return f.wall_s; });
    const double peak = median([](const MissionFigures& f) {
      std::int64_t most = 0;
      for (const auto& [kind, usage] : f.kinds) most = std::max(most, usage.peak_bytes);
      return static_cast<double>(most);
    });
    const double lost = median([](const MissionFigures& f) {
      const auto all = f.received_datagrams + f.buffer_errors;
      return all > 0 ? 100 * static_cast<double>(f.buffer_errors) / static_cast<double>(all) : 0;
    });
    text += fmt::format(
        "{:<15} {:>7} {:<8} {:>5} {:>4} {:>8.2f} {:>8} {:>8.2f} {:>8.1f} {:>7.0f} {:>7.2g} "
        "{:>8.1f} "
        "{:>8.1f}\n",
        row.instance, row.agents, row.run, row.processes, group.size(), wall,
        std::isnan(ratio) ? "-" : fmt::format("{:.2f}", ratio),
        median([](const MissionFigures& f) { return f.cpu_s; }),
        median([](const MissionFigures& f) { return static_cast<double>(f.sent_bytes) / 1e6; }),
        median([](const MissionFigures& f) { return static_cast<double>(f.resent); }), lost,
        median([](const MissionFigures& f) { return static_cast<double>(f.log_bytes) / 1e6; }),
        peak / (1 << 20));
  }
  return text + GrowthOf(rows, groups);
}

std::vector<std::string> ProblemsOf(const std::vector<MissionRow>& rows) {
  std::vector<std::string> problems;
  std::map<std::string, std::string> digests;
  for (const MissionRow& row : rows) {
    const std::string which = fmt::format("{}, {} a class, {}, repetition {}", row.instance,
                                          row.processes, row.run, row.repetition);
    const MissionFigures& f = row.figures;
    if (f.end != "complete") problems.push_back(fmt::format("{}: {}", which, f.end));
    if (f.digest.empty() || f.end != "complete") continue;
    const auto [first, is_first] = digests.emplace(row.instance, f.digest);
    if (!is_first && first->second != f.digest) {
      problems.push_back(
          fmt::format("{}: decided otherwise than the first of its instance", which));
    }
  }
  return problems;
}

std::string MissionPlotScript(const std::string& csv_file, const std::string& svg_file, int most) {
  std::string script = fmt::format(
      "# gnuplot: wall time and log of missions against the number of their agents\n"
      "set terminal svg size 1000,460 background 'white'\nset output '{}'\n"
      "set datafile separator ','\nset datafile missing NaN\nset logscale xy\nset grid\n"
      "set key left top\nset xlabel 'agents'\n"
      "of(run, n, name) = strcol('run') eq run && column('processes') == n && strcol('end') eq "
      "'complete' && column('size') == column('size') ? column(name) : NaN\n"
      "set multiplot layout 1,2\n",
      svg_file);
  const auto plot = [&](std::string_view label, std::string_view column, double factor,
                        const std::vector<std::tuple<std::string, int, std::string>>& curves) {
    script += fmt::format("set ylabel '{}'\n", label);
    for (std::size_t i = 0; i < curves.size(); ++i) {
      const auto& [run, processes, title] = curves[i];
      script += fmt::format(
          "{}{} using (column('agents')):(of('{}', {}, '{}') * {}) smooth unique with "
          "linespoints title '{}'",
          i == 0 ? "plot " : ", \\\n     ", i == 0 ? fmt::format("'{}'", csv_file) : "''", run,
          processes, column, factor, title);
    }
    script += "\n";
  };
  std::vector<std::tuple<std::string, int, std::string>> walls = {
      {"muster", 1, "over LCM, with log"},
      {"none", 1, "over LCM, without log"},
      {"simulate", 1, "muster simulate"}};
  if (most > 1) {
    walls.insert(walls.begin() + 1,
                 {"muster", most, fmt::format("with log, {} processes a class", most)});
  }
  plot("wall time, s", "wall_s", 1, walls);
  plot("log, MB", "log_bytes", 1e-6, {{"muster", 1, "muster-recorder"}, {"lcm", 1, "lcm-logger"}});
  return script + "unset multiplot\n";
}

}  // namespace muster::tools
