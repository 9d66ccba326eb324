#include <fmt/format.h>

#include <limits>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/text.h"
#include "model/agent.h"
#include "model/scenario_json.h"
#include "protocol/fault_kinds.h"
#include "protocol/run_process.h"
#include "world/world_process.h"

namespace muster::world {
namespace {

/// "uav:3:600000000:1200000000:f1"
Outage ReadOutage(const std::string& text) {
  const std::vector<std::string> parts = Split(text, ':');
  if (parts.size() == 5 && !parts[4].empty()) {
    const auto agent = ToInteger(parts[1], 0, std::numeric_limits<std::int32_t>::max());
    const auto from_us = ToInteger(parts[2]);
    const auto until_us = ToInteger(parts[3], from_us.value_or(0) + 1);
    for (const AgentKind kind : kAgentKinds) {
      if (parts[0] != ToString(kind) || !agent || !from_us || !until_us) continue;
      Outage outage;
      outage.kind = kind;
      outage.agent = static_cast<std::int32_t>(*agent);
      outage.from_us = *from_us;
      outage.until_us = *until_us;
      outage.reason = {FailureReason::Cause::kFault, parts[4]};
      return outage;
    }
  }
  throw InputError("command line", "--outage", text, "CLASS:ID:FROM_US:UNTIL_US:FAULT");
}

constexpr const char* kClosureForm = "KIND:X_KM/Y_KM/RADIUS_KM:FROM_US:UNTIL_US:FAULT";

/// "road_closed:2.5/3/0.4:600000000:1200000000:f1"
HiddenClosure ReadHiddenClosure(const std::string& text) {
  const std::vector<std::string> parts = Split(text, ':');
  if (parts.size() == 5 && !parts[4].empty()) {
    const auto kind = FromString<FaultKind>(parts[0]);
    const auto area = CircleFrom(parts[1]);
    const auto from_us = ToInteger(parts[2]);
    const auto until_us = ToInteger(parts[3], from_us.value_or(0) + 1);
    if (kind && RowOf(*kind).of_ways() && area && from_us && until_us) {
      return HiddenIn(*kind, *area, *from_us, *until_us, parts[4]);
    }
  }
  throw InputError("command line", "--closure", text, kClosureForm);
}

int Main(int argc, char** argv) {
  Options options("muster-world", "The world of a mission: its clock and its referee");
  options.Scenario();
  AddRateOption(&options);
  options.Flag("recorder", "A recorder takes part: wait for it, never run ahead of the log");
  options
      .Add("on-loss", "wait|continue",
           "When a process is lost: wait for it, or continue without it")
      .OneOf({"wait", "continue"})
      .Default("wait");
  options.Add("lost-after", "S", "Seconds of silence after which a process is lost")
      .Number({0.5, 3600})
      .Default(5);
  options
      .Add("schedulers", "N",
           "How many schedulers decide; several are named scheduler-1 to scheduler-N "
           "(docs/reference/schedulers.md)")
      .Integer(1, kMostSchedulers)
      .Default(1);
  options
      .Add("outage", "CLASS:ID:FROM_US:UNTIL_US:FAULT",
           "The fault of that name makes an agent fail in [FROM, UNTIL)")
      .Repeated();
  options
      .Add("closure", kClosureForm,
           "The fault of that name closes the roads in a circle in [FROM, UNTIL), or makes the "
           "circle a zone; KIND is road_closed or zone_unknown")
      .Repeated();
  options
      .Add("window-bytes", "N",
           "How many bytes may be sent before the recorder has confirmed them, if that is more "
           "than --window allows; only with muster-recorder")
      .Integer(0, 1 << 30)
      .Default(0);
  options.Add("orders", "FILE",
              "Orders to take in the course of the mission (docs/guide/orders.md)");
  AddProcessOptions(&options, process_name::kWorld);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  ProcessFlags flags = ReadProcessFlags(*arguments, process_name::kWorld);
  WorldOptions world;
  world.rate = arguments->Get("rate") == "max" ? 0 : arguments->Get<double>("rate");
  world.recorded = arguments->Has("recorder");
  world.schedulers = arguments->Get<int>("schedulers");
  world.goes_on = arguments->Get("on-loss") == "continue";
  world.lost_after_us = ToUs(arguments->Get<double>("lost-after"));
  for (const std::string& text : arguments->All("outage")) {
    world.faults.outages.push_back(ReadOutage(text));
  }
  for (const std::string& text : arguments->All("closure")) {
    world.faults.closures.push_back(ReadHiddenClosure(text));
  }
  if (arguments->Has("orders")) world.orders = ReadPlannedOrders(arguments->Get("orders"));
  if (world.recorded && flags.window == 0) flags.window = 10;
  const Scenario scenario = LoadScenario(arguments->Get("scenario"));
  const Window window(flags.window, arguments->Get<std::size_t>("window-bytes"));
  WorldProcess process(flags.identity, window, TextOf(scenario), world);
  const auto bus = OpenBus(flags, GuardedChannels::kOfWorld);
  return RunProcess(&process, bus.get(), flags.quiet);
}

}  // namespace
}  // namespace muster::world

int main(int argc, char** argv) {
  return muster::GuardedMain("muster-world", [&] { return muster::world::Main(argc, argv); });
}
