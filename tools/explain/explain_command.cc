#include "tools/explain/explain_command.h"

#include <fmt/format.h>

#include <charconv>

#include "base/check.h"
#include "base/program.h"
#include "tools/explain/story.h"

namespace muster::tools {
namespace {

std::optional<std::int32_t> ParseId(std::string_view text) {
  std::int32_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size() || id < 0) return {};
  return id;
}

std::pair<AgentKind, std::int32_t> ParseAgent(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos) {
    const auto id = ParseId(std::string_view(text).substr(colon + 1));
    for (const AgentKind kind : kAgentKinds) {
      if (id && text.substr(0, colon) == ToString(kind)) return {kind, *id};
    }
  }
  throw InputError("command line", "--agent", text, "uav:N, worker:N or vehicle:N");
}

std::int32_t IdFlag(const cxxopts::ParseResult& parsed, const char* flag) {
  const std::string text = parsed[flag].as<std::string>();
  const auto id = ParseId(text);
  if (!id) {
    throw InputError("command line", fmt::format("--{}", flag), text, "a number, at least 0");
  }
  return *id;
}

template <class Story>
void Print(const Story& story, bool json) {
  fmt::print("{}", json ? ToJson(story).dump(2) + "\n" : ToText(story));
}

}  // namespace

int ExplainCommand(int argc, const char* const* argv) {
  cxxopts::Options options(
      argv[0],
      "Says why a task or an agent was commanded as it was: what stood against it, what it lost\n"
      "to, and what forcing it would have cost. All weights are the paper's.");
  options.add_options()("run", "Run directory or log file", cxxopts::value<std::string>())(
      "task", "A task", cxxopts::value<std::string>(), "N")(
      "agent", "An agent: uav:N, worker:N or vehicle:N", cxxopts::value<std::string>(), "NAME")(
      "decision", "One decision (default: all)", cxxopts::value<std::string>(), "N")(
      "json", "Print the same facts as JSON");
  options.parse_positional({"run"});
  options.positional_help("RUN");
  const auto parsed = ParseOptions(&options, argc, argv);
  if (!parsed) return kExitOk;
  if (parsed->count("run") == 0) throw InputError("no RUN given: a run directory or a log file");
  if (parsed->count("task") + parsed->count("agent") != 1) {
    throw InputError("one of --task N and --agent uav:N is needed");
  }
  const std::string run = (*parsed)["run"].as<std::string>();
  const bool json = parsed->count("json") > 0;
  std::optional<std::int32_t> decision;
  if (parsed->count("decision") > 0) decision = IdFlag(*parsed, "decision");
  std::optional<std::pair<AgentKind, std::int32_t>> agent;
  if (parsed->count("agent") > 0) agent = ParseAgent((*parsed)["agent"].as<std::string>());
  const std::int32_t task = agent ? -1 : IdFlag(*parsed, "task");

  LogSource source(run);
  const DecisionLog log = ReadDecisionLog(&source);
  if (agent) {
    Print(TellAgent(log, run, agent->first, agent->second, decision), json);
  } else {
    Print(TellTask(log, run, task, decision), json);
  }
  return kExitOk;
}

}  // namespace muster::tools
