#include "tools/orders/order_commands.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "base/text.h"
#include "model/order.h"
#include "model/scenario_json.h"
#include "tools/host/progress.h"
#include "tools/orders/order_socket.h"
#include "tools/scenario/fields.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

/// Where a task or an agent is to be: "X,Y" in km, or "LAT,LON" in degrees.
void ReadPlace(const Arguments& arguments, Json* item) {
  const auto read = [&](const char* flag, const char* first, const char* second,
                        const char* expected) {
    if (!arguments.Has(flag)) return;
    const std::string text = arguments.Get(flag);
    const std::vector<std::string> parts = Split(text, ',');
    const auto a = ToNumber(parts.front()), b = ToNumber(parts.back());
    if (parts.size() != 2 || !a || !b) {
      throw InputError("command line", fmt::format("--{}", flag), text, expected);
    }
    (*item)[first] = *a;
    (*item)[second] = *b;
  };
  if (arguments.Has("at") == arguments.Has("place")) {
    throw InputError("command line", "--at", arguments.Has("at") ? "--place too" : "nothing",
                     "--at X,Y or --place LAT,LON");
  }
  read("at", "x_km", "y_km", "X,Y in km from the area's south-west corner");
  read("place", "latitude_deg", "longitude_deg", "LAT,LON in degrees");
}

void AddPlaceOptions(Options* options) {
  options->Add("at", "X,Y", "Where: km to the east and north of the area's south-west corner");
  options->Add("place", "LAT,LON", "Where: degrees, if the scenario has an origin");
}

/// Sends the order and tells what became of it.
int Give(Json order, const Arguments& arguments) {
  if (arguments.Has("id")) order["id"] = arguments.Get("id");
  if (arguments.Has("issuer")) {
    order["issuer"] = arguments.Get("issuer");
  } else if (!arguments.Has("sign")) {
    order["issuer"] = "command line";
  }
  // What is wrong with it in itself is an error of the command line.
  ParseOrder(
      [&] {
        Json bare = order;
        for (const char* item : {"task", "agent"}) {
          if (!bare.contains(item) || !bare[item].is_object()) continue;
          if (!bare[item].contains("latitude_deg")) continue;
          bare[item].erase("latitude_deg");
          bare[item].erase("longitude_deg");
          bare[item]["x_km"] = bare[item]["y_km"] = 0;
        }
        if (bare.contains("latitude_deg")) {
          bare.erase("latitude_deg");
          bare.erase("longitude_deg");
          bare["x_km"] = bare["y_km"] = 0;
        }
        if (bare.erase("area_deg") > 0) bare["area_km"] = {{0, 0}, {1, 0}, {0, 1}};
        if (bare.erase("circle_deg") > 0) bare["circle_km"] = {0, 0, 1};
        if (bare.erase("near_deg") > 0) bare["near_km"] = {0, 0};
        return bare.dump();
      }(),
      "order");
  OrderClient client(arguments.Get("run"), SigningKeyFile(arguments));
  client.Send(order.dump());
  const double wait_s = arguments.Get<double>("wait");
  const std::string text =
      client.Receive(std::chrono::milliseconds(static_cast<std::int64_t>(wait_s * 1000)));
  if (text.empty()) {
    throw SystemError(client.gone() ? std::string("the mission has ended without an answer")
                                    : fmt::format("no answer within {} s: the order stays given, "
                                                  "and is taken when the mission goes on",
                                                  wait_s));
  }
  const Json answer = Json::parse(text);
  if (arguments.Has("json")) fmt::print("{}\n", text);
  if (answer.contains("error")) throw InputError(answer["error"].get<std::string>());
  if (answer.contains("refused")) {
    Say("muster: refused: {}\n", answer["refused"].get<std::string>());
    return kExitCheckFailed;
  }
  if (arguments.Has("json")) return kExitOk;
  const Json& taken = answer["taken"];
  std::string what = taken.contains("agent") ? taken["agent"].get<std::string>()
                     : taken.contains("task")
                         ? fmt::format("task {}", taken["task"].dump())
                         : fmt::format("({})", answer["id"].get<std::string>());
  fmt::print("taken at {}: {} {}\n", ClockText(ToUs(taken["sim_s"].get<double>())),
             order["order"].get<std::string>(), what);
  return kExitOk;
}

void AddCommonOptions(Options* options) {
  options->Add("id", "TEXT",
               "The order's own id: given twice, it is taken once (default: a new one)");
  options->Add("issuer", "TEXT",
               "Who gives it (default: the person of --sign, or \"command line\")");
  AddSignOption(options);
  options->Add("wait", "S", "Seconds to wait for the mission's answer")
      .Number(Above0(86'400))
      .Default(30);
  options->Json();
}

/// The kinds of orders about tasks or agents, without "task_" or "agent_" in front.
void AddWhat(std::string_view about, Options* options) {
  std::vector<std::string> words;
  for (const OrderRow& row : kOrderRows) {
    if (row.name.starts_with(about)) words.emplace_back(row.name.substr(about.size()));
  }
  options->Positional("what", fmt::format("{}", fmt::join(words, "|")))
      .OneOf(words)
      .Required(fmt::format("one of {}", fmt::join(words, ", ")));
}

/// "A,B" or "A,B,C"
Json ReadNumbers(const std::string& flag, const std::string& text, std::size_t n,
                 const char* expected) {
  Json numbers = Json::array();
  for (const std::string& part : Split(text, ',')) {
    const auto number = ToNumber(part);
    if (!number) throw InputError("command line", "--" + flag, text, expected);
    numbers.push_back(*number);
  }
  if (numbers.size() != n) throw InputError("command line", "--" + flag, text, expected);
  return numbers;
}

/// --area or --circle; how many of them there are.
int ReadArea(const Arguments& arguments, Json* order) {
  const std::string unit = arguments.Has("degrees") ? "_deg" : "_km";
  int n = 0;
  if (arguments.Has("area")) {
    Json& corners = (*order)["area" + unit] = Json::array();
    for (const std::string& corner : Split(arguments.Get("area"), ' ')) {
      corners.push_back(ReadNumbers("area", corner, 2, "\"X,Y X,Y X,Y ...\""));
    }
    ++n;
  }
  if (arguments.Has("circle")) {
    (*order)["circle" + unit] =
        ReadNumbers("circle", arguments.Get("circle"), 3, "X,Y,RADIUS, the radius in km");
    ++n;
  }
  return n;
}

/// Which roads an order means.
void ReadRoads(const Arguments& arguments, Json* order) {
  const std::string unit = arguments.Has("degrees") ? "_deg" : "_km";
  int n = ReadArea(arguments, order);
  const auto has = [&](const char* flag) { return arguments.Has(flag) && ++n > 0; };
  if (has("near")) (*order)["near" + unit] = ReadNumbers("near", arguments.Get("near"), 2, "X,Y");
  if (has("ids")) {
    Json& ids = (*order)["roads"] = Json::array();
    for (const std::string& part : Split(arguments.Get("ids"), ',')) {
      const auto id = ToInteger(part);
      if (!id) throw InputError("command line", "--ids", arguments.Get("ids"), "ID,ID,...");
      ids.push_back(*id);
    }
  }
  if (has("closure")) (*order)["closure"] = arguments.Get("closure");
  if (n != 1) {
    throw InputError("command line", "--area", n == 0 ? "nothing" : "more than one of them",
                     "one of --area, --circle, --near, --ids, and to open --closure");
  }
}

/// The minute of the mission in that run directory at which a clock shows that time: the place's,
/// where the scenario has a start, else the mission's own. Throws InputError.
double MinuteAt(const std::string& run, const std::string& flag, const std::string& text) {
  const std::optional<TimeUs> at_us = TimeOfDay(text);
  if (!at_us) throw InputError("command line", flag, text, "a clock time, as 14:30");
  const Scenario scenario = LoadScenario((std::filesystem::path(run) / "scenario.json").string());
  constexpr TimeUs kDayUs = 24 * 60 * kMinuteUs;
  TimeUs start_us = 0;
  if (scenario.start) {
    start_us = scenario.start->unix_us + scenario.start->offset_min * kMinuteUs;
  }
  // The first time after the start that a clock shows it.
  return static_cast<double>(((*at_us - start_us) % kDayUs + kDayUs) % kDayUs) /
         static_cast<double>(kMinuteUs);
}

int ToTaskId(const Arguments& arguments) {
  if (!arguments.Has("task")) {
    throw InputError("command line", "TASK", "nothing", "the id of a task");
  }
  return arguments.Get<int>("task");
}

}  // namespace

int TaskCommand(int argc, const char* const* argv) {
  Options options(
      "muster task",
      "Adds a task to a running mission, changes it, cancels it, holds it or lets it go "
      "on (docs/guide/orders.md). The mission was started with muster run --take-orders.");
  AddWhat("task_", &options);
  options.Positional("run", "RUN").Required("the run directory of a mission");
  options.Positional("task", "[TASK]").Integer(0, INT32_MAX);
  AddPlaceOptions(&options);
  options.Add("cost", "KM", "Range that sensing takes (default: 3)").Number({0, 1e6});
  options.Add("priority", "0-3", "low, normal, high or emergency");
  options.Add("due-in", "MIN", "Sensing should begin within so many minutes").Number({0, 1e6});
  options.Add("due", "H:MM",
              "The same as a clock time: of the place if the scenario has a start, else of the "
              "mission, as 1:15");
  options.Add("expires-in", "MIN", "Sensing must begin within so many minutes").Number(Above0(1e6));
  options.Add("expires", "H:MM", "The same as a clock time");
  options.Add("revisit", "MIN", "To be done again so many minutes after it was done")
      .Number(Above0(1e6));
  options.Add("name", "TEXT", "What people call it");
  options.Add("note", "TEXT", "What people should know of it");
  options.Add("external-id", "TEXT", "What another system calls it");
  options.Add("source", "TEXT", "Who reported it");
  AddCommonOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string what = arguments->Get("what");
  Json order = {{"order", "task_" + what}};
  Json task = Json::object();
  const auto number = [&](const char* flag, const char* key) {
    if (arguments->Has(flag)) task[key] = arguments->Get<double>(flag);
  };
  const auto text = [&](const char* flag, const char* key) {
    if (arguments->Has(flag)) task[key] = arguments->Get(flag);
  };
  if (arguments->Has("priority")) {
    const auto priority = PriorityOf(arguments->Get("priority"));
    if (!priority) {
      throw InputError("command line", "--priority", arguments->Get("priority"),
                       "0 to 3, or low, normal, high or emergency");
    }
    task["priority"] = static_cast<int>(*priority);
  }
  number("cost", "cost_km");
  number("due-in", "due_in_min");
  number("expires-in", "expires_in_min");
  for (const char* flag : {"due", "expires"}) {
    if (!arguments->Has(flag)) continue;
    if (arguments->Has(fmt::format("{}-in", flag))) {
      throw InputError("command line", fmt::format("--{}", flag), arguments->Get(flag),
                       fmt::format("nothing beside --{}-in", flag));
    }
    task[fmt::format("{}_min", flag)] =
        MinuteAt(arguments->Get("run"), fmt::format("--{}", flag), arguments->Get(flag));
  }
  number("revisit", "revisit_min");
  text("name", "name");
  text("note", "note");
  text("external-id", "external_id");
  text("source", "source");
  if (what == "add") {
    if (arguments->Has("task")) {
      throw InputError("command line", "TASK", arguments->Get("task"),
                       "none: the mission gives the new task its id");
    }
    ReadPlace(*arguments, &task);
    order["task"] = task;
  } else {
    order["task"] = ToTaskId(*arguments);
    if (arguments->Has("at") || arguments->Has("place")) {
      throw InputError("command line", arguments->Has("at") ? "--at" : "--place", what,
                       "only with add: cancel the task and add another");
    }
    if (what == "change" && task.empty()) {
      throw InputError("command line", "change", "nothing to change",
                       "--priority, --due, --due-in, --expires, --expires-in or --name");
    }
    order.update(task);
  }
  return Give(std::move(order), *arguments);
}

int AgentCommand(int argc, const char* const* argv) {
  Options options(
      "muster agent",
      "Has an agent join a running mission, leave it when what is under way is done, or "
      "hand that back and leave at once (recall; docs/guide/orders.md).");
  AddWhat("agent_", &options);
  options.Positional("run", "RUN").Required("the run directory of a mission");
  options.Positional("agent", "CLASS|AGENT")
      .Required("uav, worker or vehicle to join; an agent as uav:3 to leave");
  AddPlaceOptions(&options);
  options.Add("speed", "KM/MIN", "Its speed").Number(Above0(1e6));
  options.Add("range", "KM", "A UAV's full range").Number(Above0(1e6));
  options.Add("range-left", "KM", "What is left of it (default: all)").Number({0, 1e6});
  options.Add("charge", "KM/MIN", "Range that a vehicle gives").Number(Above0(1e6));
  options.Add("until", "MIN", "Minute of the mission at which it leaves (default: the end)")
      .Number(Above0(1e9));
  AddCommonOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string what = arguments->Get("what");
  if (what != "join") {
    return Give({{"order", "agent_" + what}, {"agent", arguments->Get("agent")}}, *arguments);
  }
  Json agent = Json::object();
  ReadPlace(*arguments, &agent);
  const auto number = [&](const char* flag, const char* key) {
    if (arguments->Has(flag)) agent[key] = arguments->Get<double>(flag);
  };
  number("speed", "speed_km_per_min");
  number("range", "full_range_km");
  number("range-left", "range_km");
  number("charge", "charge_km_per_min");
  number("until", "online_until_min");
  return Give({{"order", "agent_join"}, {"class", arguments->Get("agent")}, {"agent", agent}},
              *arguments);
}

int RoadCommand(int argc, const char* const* argv) {
  Options options(
      "muster road",
      "Closes roads of a running mission, or opens them again (docs/guide/roads.md). Who is under "
      "way to a closed road goes round. The mission was started with muster run --take-orders.");
  AddWhat("road_", &options);
  options.Positional("run", "RUN").Required("the run directory of a mission");
  options.Add("area", "\"X,Y X,Y ...\"",
              "The roads in or across an area: its corners, km from the south-west corner");
  options.Add("circle", "X,Y,RADIUS", "The roads within so many km of a place");
  options.Add("near", "X,Y", "The one road that is nearest to a place");
  options.Add("ids", "ID,ID,...", "The roads with these ids in the map that they come from");
  options.Add("closure", "ID", "To open: what the order with that id has closed");
  options.Flag("degrees", "Places are given as LAT,LON in degrees");
  options.Add("for", "MIN", "To close: open them again after so many minutes").Number(Above0(1e6));
  options.Add("name", "TEXT", "To close: what people call it, as \"flood at the bridge\"");
  AddCommonOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  Json order = {{"order", "road_" + arguments->Get("what")}};
  ReadRoads(*arguments, &order);
  if (arguments->Has("for")) order["until_in_min"] = arguments->Get<double>("for");
  if (arguments->Has("name")) order["name"] = arguments->Get("name");
  return Give(std::move(order), *arguments);
}

int ZoneCommand(int argc, const char* const* argv) {
  Options options("muster zone",
                  "Adds a zone that UAVs keep out of to a running mission, or lifts it "
                  "(docs/guide/zones.md). UAVs under way through it fly around it. The mission was "
                  "started with muster run --take-orders, and its scenario has the key air.");
  AddWhat("zone_", &options);
  options.Positional("run", "RUN").Required("the run directory of a mission");
  options.Add("area", "\"X,Y X,Y ...\"",
              "To add: its corners, km from the area's south-west corner");
  options.Add("circle", "X,Y,RADIUS", "To add: its middle and radius, km");
  options.Flag("degrees", "Places are given as LAT,LON in degrees");
  options.Add("for", "MIN", "To add: lift it after so many minutes").Number(Above0(1e6));
  options.Add("name", "TEXT", "To add: what people call it, as \"rescue helicopter\"");
  options.Add("zone", "ID",
              "To lift: the id of the order that added it; zone:N is zone N of the scenario");
  AddCommonOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const bool adds = arguments->Get("what") == "add";
  Json order = {{"order", "zone_" + arguments->Get("what")}};
  const int n = ReadArea(*arguments, &order);
  if (n != (adds ? 1 : 0) || arguments->Has("zone") == adds) {
    throw InputError("command line", adds ? "--area" : "--zone",
                     n == 0 && !arguments->Has("zone") ? "nothing" : "too much",
                     adds ? "--area or --circle" : "--zone ID alone");
  }
  if (arguments->Has("zone")) order["zone"] = arguments->Get("zone");
  if (arguments->Has("for")) order["until_in_min"] = arguments->Get<double>("for");
  if (arguments->Has("name")) order["name"] = arguments->Get("name");
  return Give(std::move(order), *arguments);
}

int DecideCommand(int argc, const char* const* argv) {
  Options options("muster decide",
                  "Has the scheduler of a running mission decide at the next tick, not only at the "
                  "next interval (docs/guide/orders.md). The mission was started with muster run "
                  "--take-orders.");
  options.Positional("run", "RUN").Required("the run directory of a mission");
  AddCommonOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  return Give({{"order", "decide_now"}}, *arguments);
}

int DirectCommand(int argc, const char* const* argv) {
  Options options(
      "muster direct",
      "Decides in the policy's place (docs/guide/directives.md): who does a task (pin), who must "
      "not (forbid), which UAV charges now (charge), who goes where and waits (go). It holds until "
      "it is done, or until unpin or release. The mission was started with muster run "
      "--take-orders.");
  options.Positional("what", "pin|unpin|forbid|charge|go|release")
      .OneOf({"pin", "unpin", "forbid", "charge", "go", "release"})
      .Required("one of pin, unpin, forbid, charge, go, release");
  options.Positional("run", "RUN").Required("the run directory of a mission");
  options.Add("agents", "AGENT,...", "Who it is about, as uav:3; also without --agents").List();
  options.RestBelongsTo("agents");
  options.Add("task", "N", "To pin, unpin or forbid: the task").Integer(0, INT32_MAX);
  options
      .Add("charge", "N", "To charge: at that charging point (default: where it is soonest done)")
      .Integer(0, INT32_MAX);
  options.Add("class", "CLASS", "To forbid: uavs, workers or vehicles stay out of an area")
      .OneOf({"uav", "worker", "vehicle"});
  options.Add("area", "\"X,Y X,Y ...\"",
              "To forbid: the area's corners, km from the south-west corner");
  options.Add("circle", "X,Y,RADIUS", "To forbid: the area's middle and radius, km");
  options.Flag("degrees", "Corners and middles are given as LAT,LON in degrees");
  AddPlaceOptions(&options);
  options.Add("directive", "ID", "To release: the id of the order that gave it");
  AddCommonOptions(&options);
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string what = arguments->Get("what");
  const std::vector<std::string> agents = arguments->All("agents");
  Json order = {{"order", what == "charge" ? "charge_now" : what == "go" ? "go_to" : what}};
  const auto need = [&](const char* flag) {
    if (arguments->Has(flag)) return;
    throw InputError("command line", fmt::format("--{}", flag), "nothing",
                     fmt::format("--{} with {}", flag, what));
  };
  const auto need_agents = [&](std::size_t least, std::size_t most, const char* expected) {
    if (agents.size() >= least && agents.size() <= most) return;
    throw InputError("command line", "AGENT",
                     agents.empty() ? "nothing" : fmt::format("{}", fmt::join(agents, " ")),
                     expected);
  };
  if (what == "pin" || what == "unpin") {
    need("task");
    order["task"] = arguments->Get<int>("task");
    if (what == "unpin") need_agents(0, 0, "no agent: --task says which pin");
    if (what == "pin") need_agents(1, 2, "a UAV, a worker or both, as uav:3 worker:7");
    if (what == "pin") order["agents"] = agents;
  } else if (what == "forbid") {
    if (arguments->Has("class")) {
      need_agents(0, 0, "no agent beside --class");
      order["class"] = arguments->Get("class");
      if (ReadArea(*arguments, &order) != 1) {
        throw InputError("command line", "--area", "not one of them", "--area or --circle");
      }
    } else {
      need_agents(1, 1, "one agent, as uav:3, or --class");
      need("task");
      order["agent"] = agents.front();
      order["task"] = arguments->Get<int>("task");
    }
  } else if (what == "charge") {
    need_agents(1, 2, "a UAV, and the vehicle if it matters, as uav:3 vehicle:1");
    order["agents"] = agents;
    if (arguments->Has("charge")) order["charge"] = arguments->Get<int>("charge");
  } else if (what == "go") {
    need_agents(1, 1, "one agent, as worker:7");
    order["agent"] = agents.front();
    ReadPlace(*arguments, &order);
  } else {
    need("directive");
    order["directive"] = arguments->Get("directive");
  }
  return Give(std::move(order), *arguments);
}

}  // namespace muster::tools
