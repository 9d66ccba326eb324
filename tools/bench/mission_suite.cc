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
#include "tools/bench/plot.h"
#include "tools/bench/sheet.h"
#include "tools/bench/statistics.h"
#include "tools/files/scenario_file.h"
#include "tools/files/scratch_folder.h"
#include "tools/host/worker_pool.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;

constexpr std::array<std::string_view, 8> kKinds = {
    "world", "uav", "worker", "vehicle", "scheduler", "recorder", "launcher", "simulate"};

/// What goes from the process that has run the mission to this one.
template <class Figures>
auto FieldsOf(Figures& f) {
  return std::tie(f.end, f.wall_s, f.cpu_s, f.sent_datagrams, f.sent_bytes, f.received_datagrams,
                  f.buffer_errors, f.resent, f.log_bytes, f.log_messages, f.log_doubles, f.digest);
}

std::string ToText(const MissionFigures& f) {
  Json kinds = Json::object();
  for (const auto& [name, usage] : f.kinds) kinds[name] = {usage.cpu_s, usage.peak_bytes};
  return Json{FieldsOf(f), kinds}.dump(-1, ' ', false, Json::error_handler_t::replace);
}

MissionFigures FromText(const std::string& text) {
  const Json json = Json::parse(text);
  MissionFigures f;
  std::size_t at = 0;
  std::apply([&](auto&... field) { (json.at(0).at(at++).get_to(field), ...); }, FieldsOf(f));
  for (const auto& [name, usage] : json.at(1).items()) {
    f.kinds[name] = {usage.at(0).get<double>(), usage.at(1).get<std::int64_t>()};
  }
  return f;
}

struct Instance {
  std::string name;
  GeneratorSettings settings;
  double size = 1;
};

std::vector<Instance> InstancesOf(const BenchOptions& options) {
  std::vector<Instance> instances;
  for (const std::string& name : options.instances) {
    instances.push_back({name, PresetByName(name), 1});
  }
  for (const double scale : options.scales) {
    instances.push_back(
        {fmt::format("Random_29 x{:g}", scale), Scaled(PresetByName("Random_29"), scale), scale});
  }
  return instances;
}

/// Rows of one instance, run and number of processes.
using Group = std::vector<const MissionRow*>;
using Key = std::tuple<std::string, std::string, int>;
Key KeyOf(const MissionRow& row) { return {row.instance, row.run, row.processes}; }

double MedianOf(const Group& group, const std::function<double(const MissionFigures&)>& value) {
  return Quantile(ValuesOf(group, [&](const MissionRow& row) { return value(row.figures); }), 0.5);
}

double WallOf(const Group& group) {
  return MedianOf(group, [](const MissionFigures& f) { return f.wall_s; });
}
double LogMbOf(const Group& group) {
  return MedianOf(group,
                  [](const MissionFigures& f) { return 1e-6 * static_cast<double>(f.log_bytes); });
}

/// How wall time and log grow over the sizes of Random_29, by run and processes.
std::string GrowthLines(const std::vector<std::pair<Key, Group>>& groups) {
  std::map<std::pair<std::string, int>, std::array<std::vector<std::pair<double, double>>, 2>>
      points;
  for (const auto& [key, group] : groups) {
    const MissionRow& row = *group.front();
    if (!row.instance.starts_with("Random_29")) continue;
    auto& [walls, logs] = points[{row.run, row.processes}];
    walls.emplace_back(row.agents, WallOf(group));
    logs.emplace_back(row.agents, LogMbOf(group));
  }
  std::string text;
  for (const auto& [key, of_run] : points) {
    const double wall = GrowthOf(of_run[0]), log = GrowthOf(of_run[1]);
    if (std::isnan(wall)) continue;
    text += fmt::format("Random_29, {}, {} a class: wall time grows with agents^{:.2f}", key.first,
                        key.second, wall);
    text += std::isnan(log) ? "\n" : fmt::format(", the log with agents^{:.2f}\n", log);
  }
  return text;
}

}  // namespace

void RunMissionSuite(const BenchOptions& options,
                     const std::function<void(const MissionRow&)>& report,
                     const std::function<bool()>& stop) {
  const ScratchFolder scratch("muster_bench");
  for (int repetition = 0; repetition < options.repetitions; ++repetition) {
    for (const Instance& instance : InstancesOf(options)) {
      Scenario scenario =
          Generate(instance.settings, static_cast<std::uint64_t>(options.first_seed));
      if (options.limit_min) scenario.rules.limit_us = ToUs(*options.limit_min * 60);
      const std::string file = scratch.File("scenario.json");
      WriteScenarioFile(scenario, file);
      MissionRow row;
      row.instance = instance.name;
      row.size = instance.size;
      row.tasks = static_cast<std::int64_t>(scenario.tasks.size());
      for (const AgentKind kind : kAgentKinds) {
        row.agents += static_cast<std::int64_t>(scenario.agents(kind).size());
      }
      row.limit_min = ToMinutes(scenario.rules.limit_us);
      row.policy = options.methods.front();
      row.repetition = repetition;
      for (const int processes : options.processes) {
        for (const std::string& run : options.runs) {
          if (run == "simulate" && processes != options.processes.front()) continue;
          if (stop()) return;
          row.processes = run == "simulate" ? 1 : processes;
          row.run = run;
          const ScratchFolder folder("muster_mission");
          const MissionSetting setting{file, row.policy, row.processes, run};
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
  const auto groups = GroupsOf(rows, &KeyOf);
  Sheet sheet(
      "instance|agents|run|procs|runs|wall_s|ratio|cpu_s|sent_MB|resent|lost_%|log_MB|peak_MiB");
  for (const auto& named : groups) {
    const Group& group = named.second;
    const MissionRow& row = *group.front();
    const auto alone = std::find_if(groups.begin(), groups.end(), [&](const auto& other) {
      return other.first == Key(row.instance, "simulate", 1);
    });
    const double alone_s = alone == groups.end() ? kNotKnown : WallOf(alone->second);
    const auto lost_percent = [](const MissionFigures& f) {
      const auto all = f.received_datagrams + f.buffer_errors;
      return all > 0 ? 100 * static_cast<double>(f.buffer_errors) / static_cast<double>(all) : 0;
    };
    const auto peak_mib = [](const MissionFigures& f) {
      std::int64_t most = 0;
      for (const auto& [kind, usage] : f.kinds) most = std::max(most, usage.peak_bytes);
      return static_cast<double>(most) / (1 << 20);
    };
    const auto median = [&](auto member) {
      return MedianOf(group, [&](const auto& f) { return static_cast<double>(f.*member); });
    };
    sheet.Add(
        fmt::format("{}|{}|{}|{}|{}|{:.2f}|{}|{:.2f}|{:.1f}|{:.0f}|{:.2g}|{:.1f}|{:.1f}",
                    row.instance, row.agents, row.run, row.processes, group.size(), WallOf(group),
                    Shown("{:.2f}", WallOf(group) / alone_s), median(&MissionFigures::cpu_s),
                    median(&MissionFigures::sent_bytes) * 1e-6, median(&MissionFigures::resent),
                    MedianOf(group, lost_percent), LogMbOf(group), MedianOf(group, peak_mib)));
  }
  return sheet.Text() + GrowthLines(groups);
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
  const auto curve = [](const char* column, const char* factor, const std::string& run,
                        int processes, const std::string& title) {
    return Curve{"",
                 fmt::format("using (column('agents')):(of('{}', {}, '{}') * {}) smooth unique "
                             "with linespoints",
                             run, processes, column, factor),
                 title};
  };
  Chart wall{"set ylabel 'wall time, s'\n",
             {curve("wall_s", "1", "muster", 1, "over LCM, with log"),
              curve("wall_s", "1", "none", 1, "over LCM, without log"),
              curve("wall_s", "1", "simulate", 1, "muster simulate")}};
  if (most > 1) {
    wall.curves.insert(
        wall.curves.begin() + 1,
        curve("wall_s", "1", "muster", most, fmt::format("with log, {} processes a class", most)));
  }
  const Chart log{"set ylabel 'log, MB'\n",
                  {curve("log_bytes", "1e-6", "muster", 1, "muster-recorder"),
                   curve("log_bytes", "1e-6", "lcm", 1, "lcm-logger")}};
  return ScriptOf(
      {1000,
       460,
       "set datafile missing NaN\nset logscale xy\nset grid\nset key left top\n"
       "set xlabel 'agents'\n"
       "of(run, n, name) = strcol('run') eq run && column('processes') == n && strcol('end') eq "
       "'complete' && column('size') == column('size') ? column(name) : NaN\n",
       {wall, log},
       2},
      svg_file, csv_file);
}

}  // namespace muster::tools
