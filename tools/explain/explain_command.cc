#include "tools/explain/explain_command.h"

#include <fmt/format.h>

#include <limits>
#include <vector>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/text.h"
#include "protocol/run_process.h"
#include "tools/explain/hindsight.h"
#include "tools/explain/story.h"
#include "tools/host/progress.h"

namespace muster::tools {
namespace {

constexpr TimeUs kQuietUs = 2 * kSecondUs;  ///< progress is shown only after that long
constexpr std::int64_t kMostEffort = 1'000'000;
constexpr std::int64_t kMostId = std::numeric_limits<std::int32_t>::max();

std::pair<AgentKind, std::int32_t> ParseAgent(const std::string& text) {
  const std::vector<std::string> parts = Split(text, ':');
  const auto id = ToInteger(parts.back(), 0, kMostId);
  for (const AgentKind kind : kAgentKinds) {
    if (id && parts.size() == 2 && parts[0] == ToString(kind)) {
      return {kind, static_cast<std::int32_t>(*id)};
    }
  }
  throw InputError("command line", "--agent", fmt::format("'{}'", text),
                   "uav:N, worker:N or vehicle:N");
}

/// "17" or "task:17", as pages and events write it.
std::int32_t ParseTask(const std::string& text) {
  const std::string_view prefix = "task:";
  const auto id =
      ToInteger(text.starts_with(prefix) ? text.substr(prefix.size()) : text, 0, kMostId);
  if (id) return static_cast<std::int32_t>(*id);
  throw InputError("command line", "--task", fmt::format("'{}'", text), "N or task:N");
}

template <class Story>
void Print(const Story& story, bool json) {
  fmt::print("{}", json ? ToJson(story).dump(2) + "\n" : ToText(story));
}

}  // namespace

int ExplainCommand(int argc, const char* const* argv) {
  Options options(
      argv[0],
      "Says why a task or an agent was commanded as it was: what stood against it, what it lost\n"
      "to, what was planned for it, and what forcing it would have cost, in the terms of the\n"
      "policy that decided. With --best: what the mission could have done at best, and which\n"
      "decisions cost most.");
  options.Run();
  options.Positional("who", "[task:N|AGENT]");
  options.Add("task", "N", "A task: N or task:N");
  options.Add("agent", "NAME", "An agent: uav:N, worker:N or vehicle:N");
  options.Add("decision", "N", "One decision (default: all)").Integer(0, kMostId);
  options.Flag("best", "What could have been: the best plan found in hindsight");
  options.Add("effort", "N", "With --best: how long to search")
      .Integer(1, kMostEffort)
      .Default("5");
  options.Json();
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const int n_named = arguments->Has("task") + arguments->Has("agent") + arguments->Has("who") +
                      arguments->Has("best");
  if (n_named != 1) {
    throw InputError("command line", "task or agent", n_named == 0 ? "nothing" : "more than one",
                     "one of them, as task:17 or uav:3, or --best");
  }
  if (arguments->Has("best") && arguments->Has("decision")) {
    throw InputError("command line", "--decision", "--best", "one of them");
  }
  if (arguments->Has("effort") && !arguments->Has("best")) {
    throw InputError("command line", "--effort", "no --best", "it beside --best");
  }
  const std::string run = arguments->Get("run");
  const bool json = arguments->Has("json");
  std::optional<std::int32_t> decision;
  arguments->Read("decision", &decision);
  std::optional<std::pair<AgentKind, std::int32_t>> agent;
  std::string task = arguments->Has("task") ? arguments->Get("task") : "";
  if (arguments->Has("agent")) agent = ParseAgent(arguments->Get("agent"));
  if (arguments->Has("who")) {
    const std::string who = arguments->Get("who");
    who.starts_with("task:") ? void(task = who) : void(agent = ParseAgent(who));
  }

  ProgressPrinter printer(stderr, StyleFor(stderr, false));
  const TimeUs start_us = MonotonicUs();
  const DecisionProgress progress = [&](std::size_t told, std::size_t of) {
    const TimeUs now_us = MonotonicUs();
    if (now_us - start_us < kQuietUs || !printer.due(now_us)) return;
    printer.Show(fmt::format("{} of {} decisions {}", told, of,
                             arguments->Has("best") ? "searched" : "explained"),
                 now_us);
  };
  LogSource source(run);
  source.ShowProgress("explain");
  const DecisionLog log = ReadDecisionLog(&source);
  const auto print = [&](const auto& story) {
    printer.Break();
    Print(story, json);
  };
  if (arguments->Has("best")) {
    print(LookBack(log, run, arguments->Get<std::int64_t>("effort"), progress));
  } else if (agent) {
    print(TellAgent(log, run, agent->first, agent->second, decision, progress));
  } else {
    print(TellTask(log, run, ParseTask(task), decision, progress));
  }
  return kExitOk;
}

}  // namespace muster::tools
