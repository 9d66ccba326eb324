#include "tools/launch/launch_options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "base/check.h"
#include "base/program.h"
#include "lcmtypes/bus/multicast.h"
#include "model/agent.h"
#include "model/scenario_json.h"
#include "scheduler/policies/registry.h"
#include "tools/live/live_server.h"
#include "tools/report/page.h"

namespace muster::tools {
namespace {

constexpr std::string_view kCommandLine = "command line";
constexpr int kMostProcesses = 64;

/// The whole text as a number; none otherwise.
template <class T>
std::optional<T> ToNumber(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

void CheckRate(const std::string& rate) {
  if (rate == "max") return;
  const auto value = ToNumber<double>(rate);
  if (!value || !std::isfinite(*value) || *value <= 0) {
    throw InputError(kCommandLine, "--rate", rate,
                     "max, or mission seconds per wall second above 0");
  }
}

std::map<AgentKind, int> ReadProcesses(const std::vector<std::string>& entries) {
  std::map<AgentKind, int> processes;
  for (const AgentKind kind : kAgentKinds) processes[kind] = 1;
  for (const std::string& entry : entries) {
    const std::size_t equals = entry.find('=');
    const std::string_view name = std::string_view(entry).substr(0, equals);
    std::optional<int> count;
    if (equals != std::string::npos) {
      count = ToNumber<int>(std::string_view(entry).substr(equals + 1));
    }
    bool known = false;
    for (const AgentKind kind : kAgentKinds) {
      if (name != ToString(kind)) continue;
      known = true;
      if (count) processes[kind] = *count;
    }
    if (!known || !count || *count < 0 || *count > kMostProcesses) {
      throw InputError(
          kCommandLine, "--processes", entry,
          fmt::format("uav=N, worker=N or vehicle=N with N from 0 to {}", kMostProcesses));
    }
  }
  return processes;
}

std::map<std::string, std::string> ReadPrograms(const std::vector<std::string>& entries) {
  static constexpr std::string_view kRoles[] = {"world", "uav", "worker", "vehicle", "scheduler"};
  namespace fs = std::filesystem;
  std::map<std::string, std::string> programs;
  for (const std::string& entry : entries) {
    const std::size_t equals = std::min(entry.find('='), entry.size());
    const std::string role = entry.substr(0, equals);
    const std::string file = entry.substr(std::min(equals + 1, entry.size()));
    if (std::find(std::begin(kRoles), std::end(kRoles), role) == std::end(kRoles) ||
        !fs::is_regular_file(file) || access(file.c_str(), X_OK) != 0) {
      throw InputError(kCommandLine, "--program", entry,
                       "ROLE=FILE: world, uav, worker, vehicle or scheduler, and a program");
    }
    programs[role] = fs::absolute(file).string();
  }
  return programs;
}

}  // namespace

std::optional<LaunchOptions> ParseLaunchOptions(int argc, const char* const* argv) {
  cxxopts::Options parser("muster run",
                          "Runs a whole mission: world, agents and scheduler as processes of "
                          "their own over LCM, recorded by lcm-logger.");
  AddMissionOptions(&parser);
  parser.add_options()("deadline",
                       "Milliseconds that a decision may take, the best found until then is taken "
                       "(default: none, so that a mission can be repeated)",
                       cxxopts::value<double>(), "MS");
  parser.add_options()("rate", "Mission seconds per wall second, or max",
                       cxxopts::value<std::string>()->default_value("max"), "R");
  parser.add_options()("processes",
                       "Processes per agent class, e.g. uav=2,vehicle=3; 0: none, you start them",
                       cxxopts::value<std::vector<std::string>>(), "CLASS=N,...");
  parser.add_options()("program",
                       "Your own program in place of muster-ROLE, with the same options, e.g. "
                       "worker=./my-worker (docs/installing.md)",
                       cxxopts::value<std::vector<std::string>>(), "ROLE=FILE,...");
  parser.add_options()("drop", "Share of received packets that each process drops, 0 to 1",
                       cxxopts::value<double>()->default_value("0"), "P");
  parser.add_options()("faults", "Fault plan (docs/faults.md)", cxxopts::value<std::string>(),
                       "FILE");
  parser.add_options()("fault", "One more fault, e.g. loss:*@30+10=0.3 or process_killed:uav@45",
                       cxxopts::value<std::vector<std::string>>(), "FAULT");
  parser.add_options()("on-loss",
                       "When an agent process or the scheduler is lost: wait for it, or continue "
                       "without it until it is back",
                       cxxopts::value<std::string>()->default_value("wait"), "wait|continue");
  parser.add_options()("lost-after", "Seconds of silence after which a process is lost",
                       cxxopts::value<double>()->default_value("5"), "S");
  parser.add_options()("restarts",
                       "How often each process that ends by itself is started again; 0: it ends "
                       "the mission",
                       cxxopts::value<std::string>()->default_value("5"), "N");
  parser.add_options()("l,lcm-url", "LCM URL (default: a network of the mission's own)",
                       cxxopts::value<std::string>(), "URL");
  parser.add_options()("hosts", "Which process runs on which host (docs/hosts.md)",
                       cxxopts::value<std::string>(), "FILE");
  parser.add_options()(
      "live",
      "Show the mission in browsers of this host, and keep the page after its end "
      "until Ctrl-C; PORT 0: any free one",
      cxxopts::value<std::string>()->implicit_value(std::to_string(kDefaultLivePort)), "PORT");
  const auto result = ParseOptions(&parser, argc, argv);
  if (!result) return std::nullopt;

  LaunchOptions options;
  if (result->count("program") > 0) {
    options.programs = ReadPrograms((*result)["program"].as<std::vector<std::string>>());
  }
  const bool own_policy = options.programs.contains("scheduler");
  static_cast<MissionOptions&>(options) = ReadMissionOptions(*result, own_policy);
  if (own_policy && result->count("policy") == 0) {
    throw InputError(kCommandLine, "--program", "scheduler without --policy",
                     "--policy with it: the name of a policy that your scheduler has");
  }
  options.rate = (*result)["rate"].as<std::string>();
  CheckRate(options.rate);
  if (result->count("deadline") > 0) options.deadline_ms = (*result)["deadline"].as<double>();
  // Throws where it does not fit.
  if (!own_policy) scheduler::MakePolicy(options.policy, options.deadline_ms);
  options.processes = ReadProcesses(result->count("processes") > 0
                                        ? (*result)["processes"].as<std::vector<std::string>>()
                                        : std::vector<std::string>());
  options.drop = (*result)["drop"].as<double>();
  if (!(options.drop >= 0 && options.drop < 1)) {
    throw InputError(kCommandLine, "--drop", fmt::to_string(options.drop), "a share in [0, 1)");
  }
  if (result->count("faults") > 0) {
    options.faults = LoadFaultPlan((*result)["faults"].as<std::string>());
  }
  if (result->count("fault") > 0) {
    for (const std::string& text : (*result)["fault"].as<std::vector<std::string>>()) {
      options.faults.push_back(ParseFaultFlag(text, options.faults.size()));
    }
  }
  options.on_loss = (*result)["on-loss"].as<std::string>();
  if (options.on_loss != "wait" && options.on_loss != "continue") {
    throw InputError(kCommandLine, "--on-loss", options.on_loss, "wait or continue");
  }
  options.lost_after_s = (*result)["lost-after"].as<double>();
  if (!(options.lost_after_s >= 0.5 && options.lost_after_s <= 3600)) {
    throw InputError(kCommandLine, "--lost-after", fmt::to_string(options.lost_after_s),
                     "seconds from 0.5 to 3600");
  }
  const std::string restarts = (*result)["restarts"].as<std::string>();
  options.restarts = ToNumber<int>(restarts).value_or(-1);
  if (options.restarts < 0) {
    throw InputError(kCommandLine, "--restarts", restarts, "an integer from 0");
  }
  if (result->count("lcm-url") > 0) {
    options.lcm_url = (*result)["lcm-url"].as<std::string>();
    ParseMulticastUrl(options.lcm_url);
  }
  if (result->count("hosts") > 0) {
    options.hosts_file = (*result)["hosts"].as<std::string>();
    options.hosts = LoadHosts(options.hosts_file);
    if (!options.lcm_url.empty()) {
      throw InputError(kCommandLine, "--lcm-url", options.lcm_url,
                       "not with --hosts, whose file has it as lcm_url");
    }
    options.lcm_url = options.hosts.lcm_url;
  }
  if (result->count("live") > 0) {
    RequirePage();
    options.live_port = ParsePort("--live", (*result)["live"].as<std::string>());
  }
  for (const auto& [kind, count] : options.processes) {
    if (count == 0 && options.lcm_url.empty()) {
      throw InputError(kCommandLine, "--processes", fmt::format("{}=0", ToString(kind)),
                       "--lcm-url with it: a process of yours cannot reach a network of the "
                       "mission's own");
    }
  }
  return options;
}

std::vector<ProcessPlan> PlanProcesses(const LaunchOptions& options, const Scenario& scenario,
                                       const MissionIdentity& mission) {
  std::vector<ProcessPlan> plans;
  const auto add = [&](const std::string& name, const std::string& role,
                       std::vector<std::string> arguments) {
    const auto own = options.programs.find(role);
    const std::string program = own == options.programs.end() ? "muster-" + role : own->second;
    arguments.insert(arguments.end(), {"--name", name, "--lcm-url", mission.lcm_url, "--run-id",
                                       fmt::to_string(mission.run_id)});
    if (options.drop > 0) {
      arguments.insert(arguments.end(), {"--drop", fmt::to_string(options.drop), "--drop-seed",
                                         fmt::to_string(scenario.seed + plans.size())});
    }
    plans.push_back({name, program, std::move(arguments)});
  };
  std::vector<std::string> world = {
      mission.scenario_file, "--rate",   options.rate,
      "--recorder",          "--window", fmt::to_string(kWorldWindow)};
  if (options.on_loss != "wait") {
    world.insert(world.end(), {"--on-loss", options.on_loss, "--lost-after",
                               fmt::to_string(options.lost_after_s)});
  }
  for (const std::string& outage : OutagesOf(options.faults)) {
    world.insert(world.end(), {"--outage", outage});
  }
  add("world", "world", std::move(world));
  for (const AgentKind kind : kAgentKinds) {
    const std::string class_name(ToString(kind));
    const int n = static_cast<int>(scenario.agents(kind).size());
    const int k = options.processes.at(kind);
    if (k > n) {
      throw InputError(kCommandLine, "--processes", fmt::format("{}={}", class_name, k),
                       fmt::format("at most {}, the scenario's {}s", n, class_name));
    }
    for (int i = 0; i < k; ++i) {
      std::vector<std::string> arguments = {"--window", fmt::to_string(kProcessWindow)};
      if (k > 1) {
        const int first = n * i / k;
        const int last = n * (i + 1) / k - 1;
        arguments.insert(arguments.end(), {"--ids", fmt::format("{}-{}", first, last)});
      }
      add(k > 1 ? fmt::format("{}-{}", class_name, i + 1) : class_name, class_name,
          std::move(arguments));
    }
  }
  std::vector<std::string> scheduler = {"--policy", options.policy, "--window",
                                        fmt::to_string(kProcessWindow)};
  if (options.deadline_ms) {
    scheduler.insert(scheduler.end(), {"--deadline", fmt::to_string(*options.deadline_ms)});
  }
  add("scheduler", "scheduler", std::move(scheduler));
  return plans;
}

}  // namespace muster::tools
