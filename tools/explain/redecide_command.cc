#include "tools/explain/redecide_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "protocol/run_process.h"
#include "tools/explain/redecide.h"
#include "tools/explain/words.h"
#include "tools/host/build_info.h"
#include "tools/host/progress.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kListed = 10;
constexpr TimeUs kShowAfterUs = 2 * kSecondUs;  ///< progress is shown only after that long

std::string Number(double value) {
  return std::isnan(value) ? std::string("-") : fmt::format("{:.3f}", value);
}

Json ToJson(const schedule_t& schedule) {
  Json actions = Json::array();
  for (const action_t& action : schedule.actions) actions.push_back(ActionJson(action));
  return {{"policy", schedule.policy},
          {"weight", schedule.weight},
          {"bound", std::isnan(schedule.bound) ? Json() : Json(schedule.bound)},
          {"candidates", schedule.candidates},
          {"actions", std::move(actions)}};
}

/// The commit that made the run, from its manifest.json; "" when that does not say.
std::string CommitOf(const std::string& run) {
  std::ifstream file(std::filesystem::path(run) / "manifest.json");
  const auto manifest = nlohmann::json::parse(file, nullptr, false);
  if (!manifest.is_object() || !manifest.contains("commit")) return "";
  const auto& commit = manifest["commit"];
  return commit.is_string() ? commit.get<std::string>() : "";
}

int Verify(const std::string& run, const std::vector<Redecided>& decisions, bool json) {
  const std::vector<Divergence> divergences = DivergencesOf(decisions);
  std::size_t schedules = 0, unlogged = 0;
  for (const Redecided& d : decisions) {
    schedules += d.logged.size();
    unlogged += d.logged.empty() ? 1 : 0;
  }
  if (schedules == 0) throw InputError(fmt::format("{}: the log holds no schedule", run));
  const std::string made_by = CommitOf(run);
  if (json) {
    Json list = Json::array();
    for (const Divergence& d : divergences) {
      list.push_back({{"decision", d.decision}, {"at_s", ToSeconds(d.at_us)}, {"what", d.what}});
    }
    fmt::print("{}\n", Json{{"version", 1},
                            {"same", divergences.empty()},
                            {"decisions", decisions.size()},
                            {"schedules", schedules},
                            {"without_schedule", unlogged},
                            {"log_commit", made_by.empty() ? Json() : Json(made_by)},
                            {"commit", kCommit},
                            {"divergences", std::move(list)}}
                           .dump(2));
    return divergences.empty() ? kExitOk : kExitCheckFailed;
  }
  fmt::print("{}: {} decisions made again, {} logged schedules\n", run, decisions.size(),
             schedules);
  if (unlogged > 0) fmt::print("{} decisions have no logged schedule\n", unlogged);
  if (divergences.empty()) {
    fmt::print("every decision is the same, bit for bit\n");
    return kExitOk;
  }
  fmt::print("DIFFERENT in {} of them, the first ones:\n", divergences.size());
  for (std::size_t i = 0; i < std::min(kListed, divergences.size()); ++i) {
    const Divergence& d = divergences[i];
    fmt::print("  {}  decision {}: {}\n", ClockText(d.at_us), d.decision, d.what);
  }
  if (!made_by.empty() && made_by != kCommit) {
    fmt::print("The log was made by commit {}, this is {}: only the same build must agree.\n",
               made_by, kCommit);
  }
  return kExitCheckFailed;
}

int Compare(const std::string& run, const std::vector<Redecided>& decisions,
            const std::string& policy, bool json) {
  Json rows = Json::array();
  const auto part = [](const std::string& weight, const std::string& bound,
                       const std::string& actions) {
    return fmt::format("  {:>9} {:>9} {:>7}", weight, bound, actions);
  };
  const auto part_of = [&](const schedule_t& schedule) {
    return part(Number(schedule.weight), Number(schedule.bound), fmt::to_string(MovesIn(schedule)));
  };
  if (!json) {
    fmt::print("{}: what {} would have decided in the situations of the log\n\n", run, policy);
    fmt::print("{:8}  {:>7}  {:^27}  {:^27}\n", "", "", "logged", policy);
    const std::string columns = part("weight", "bound", "actions");
    fmt::print("{:>8}  {:>7}{}{}  {:>7} {:>7}\n", "decision", "time", columns, columns, "dropped",
               "added");
  }
  std::size_t same = 0, compared = 0, changed = 0;
  for (const Redecided& d : decisions) {
    if (!d.missing.empty()) {
      rows.push_back(
          {{"decision", d.decision}, {"at_s", ToSeconds(d.at_us)}, {"missing", d.missing}});
      if (!json) {
        fmt::print("{:>8}  {}  cannot be made, the log lacks {}\n", d.decision, ClockText(d.at_us),
                   d.missing);
      }
      continue;
    }
    Json row = {{"decision", d.decision}, {"at_s", ToSeconds(d.at_us)}};
    std::string line = fmt::format("{:>8}  {}", d.decision, ClockText(d.at_us));
    if (d.logged.empty()) {
      row["logged"] = nullptr;
      line += part("-", "-", "-");
    } else {
      row["logged"] = ToJson(d.logged.front());
      line += part_of(d.logged.front());
    }
    row["redecided"] = ToJson(d.again);
    line += part_of(d.again);
    if (!d.logged.empty()) {
      const ActionDifference difference = DifferenceOf(d.again, d.logged.front());
      row["dropped"] = difference.only_logged;
      row["added"] = difference.only_again;
      line += fmt::format("  {:>7} {:>7}", difference.only_logged, difference.only_again);
      ++compared;
      const bool equal = difference.only_logged == 0 && difference.only_again == 0;
      same += equal ? 1 : 0;
      changed += static_cast<std::size_t>(difference.only_logged);
    }
    rows.push_back(std::move(row));
    if (!json) fmt::print("{}\n", line);
  }
  if (json) {
    fmt::print("{}\n",
               Json{{"version", 1}, {"policy", policy}, {"decisions", std::move(rows)}}.dump(2));
    return kExitOk;
  }
  fmt::print(
      "\n{} of {} decisions have the same actions; {} of the log's actions are not among {}'s.\n"
      "Each decision is made in the logged situation, not in one that {} would have led to.\n",
      same, compared, changed, policy, policy);
  return kExitOk;
}

}  // namespace

int RedecideCommand(int argc, const char* const* argv) {
  Options options(
      argv[0],
      "Makes a run's decisions again from its log.\n"
      "With the log's own policy each must be the same, bit for bit; exit code 4 when one is not.\n"
      "With another policy: a table of what it would have decided.");
  options.Run();
  options.Add(
      "policy", "NAME",
      "Policy to decide with; external:COMMAND: a program (default: the log's own, unless that "
      "is a program)");
  options.Json();
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string run = arguments->Get("run");
  const bool json = arguments->Has("json");
  LogSource source(run);
  source.ShowProgress("redecide");
  const DecisionLog log = ReadDecisionLog(&source);
  std::string policy;
  arguments->Read("policy", &policy);
  std::set<std::string> logged;
  for (const auto& [d, decision] : log.decisions) {
    for (const schedule_t& schedule : decision.schedules) logged.insert(schedule.policy);
  }
  const bool another = !policy.empty() && logged != std::set<std::string>{policy};
  ProgressPrinter printer(stderr, StyleFor(stderr, false));
  const TimeUs start_us = MonotonicUs();
  const auto decisions = Redecide(log, policy, [&](std::size_t made, std::size_t of) {
    const TimeUs now_us = MonotonicUs();
    if (now_us - start_us < kShowAfterUs || !printer.due(now_us)) return;
    printer.Show(fmt::format("{} of {} decisions made again", made, of), now_us);
  });
  printer.Break();
  return another ? Compare(run, decisions, policy, json) : Verify(run, decisions, json);
}

}  // namespace muster::tools
