#include "tools/drive/drive_command.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "tools/drive/driver_check.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

void PrintText(const DriverCheckResult& result) {
  if (result.ready_s > 0) fmt::print("ready     after {:.0f} s\n", result.ready_s);
  for (const DriverCheckResult::Step& step : result.steps) {
    std::string took = step.note;
    if (step.took_s) {
      took = fmt::format("took {:.0f} s", *step.took_s);
      const double late = 100 * (*step.took_s / step.planned_s - 1);
      if (late >= 1) took += fmt::format(", {:.0f} % late", late);
    } else if (took.empty()) {
      took = "not to its end";
    }
    fmt::print("{:<9} planned {:.0f} s, {}\n", step.what, step.planned_s, took);
  }
  for (const DriverCheckResult::Wrong& wrong : result.wrong) {
    fmt::print("WRONG     at {:.0f} s: {}\n", wrong.mission_s, wrong.what);
  }
  fmt::print("{}: {} wrong in {:.0f} min of a mission\n",
             result.name.empty() ? "the driver" : result.name, result.wrong.size(),
             result.mission_s / 60);
}

void PrintJson(const DriverCheckResult& result) {
  Json steps = Json::array(), wrong = Json::array();
  for (const DriverCheckResult::Step& step : result.steps) {
    steps.push_back({{"what", step.what},
                     {"planned_s", step.planned_s},
                     {"took_s", step.took_s ? Json(*step.took_s) : Json(nullptr)},
                     {"note", step.note}});
  }
  for (const DriverCheckResult::Wrong& found : result.wrong) {
    wrong.push_back({{"mission_s", found.mission_s}, {"what", found.what}});
  }
  const Json all = {{"version", 1},
                    {"name", result.name},
                    {"mission_s", result.mission_s},
                    {"ready_s", result.ready_s},
                    {"steps", steps},
                    {"wrong", wrong}};
  fmt::print("{}\n", all.dump(2));
}

}  // namespace

int DriveCommand(int argc, const char* const* argv) {
  Options options("muster drive",
                  "Plays a mission's part against a driver of an agent and says what it does wrong "
                  "(docs/guide/drivers.md).");
  options.Add("check", "COMMAND", "The driver: a program and its arguments")
      .Required("a program and its arguments");
  options.Add("class", "CLASS", "The agent that it drives")
      .OneOf({"uav", "worker", "vehicle"})
      .Default("uav");
  options.Add("rate", "R", "Mission seconds per wall second, or max")
      .Number(Above0(1e6))
      .Or("max")
      .Default("max");
  options.Add("lost-after", "SECONDS", "Seconds that it may take to answer")
      .Number(Above0(3600))
      .Default(5);
  options.Json();
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  DriverCheckOptions check;
  check.argv = agents::DriverCommand(arguments->Get("check"));
  check.kind = *FromString<AgentKind>(arguments->Get("class"));
  if (arguments->Get("rate") != "max") check.rules.rate = arguments->Get<double>("rate");
  check.rules.lost_after_us = ToUs(arguments->Get<double>("lost-after"));
  // As fast as possible it is over at once.
  if (check.rules.rate > 0) check.progress = [](const std::string& what) { Say("{}\n", what); };
  const DriverCheckResult result = CheckDriver(check);
  if (arguments->Has("json")) {
    PrintJson(result);
  } else {
    PrintText(result);
  }
  return result.wrong.empty() ? kExitOk : kExitCheckFailed;
}

}  // namespace muster::tools
