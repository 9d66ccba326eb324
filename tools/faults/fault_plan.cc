#include "tools/faults/fault_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <variant>

#include "base/check.h"
#include "base/object_reader.h"
#include "base/text.h"
#include "base/text_file.h"
#include "model/agent.h"
#include "model/airspace.h"
#include "model/road_area.h"
#include "protocol/fault_kinds.h"

namespace muster::tools {
namespace {

constexpr double kLongestMin = 1e6;
constexpr double kLongest_s = 3600;

[[noreturn]] void Refuse(const PlannedFault& fault, std::string_view key, std::string_view found,
                         std::string_view expected) {
  throw InputError(fault.where, key, found, expected);
}

bool Deafens(const PlannedFault& fault) {
  return RowOf(fault.kind).deafens && fault.probability >= 1;
}

/// Whether the mission waits for a process while the fault lasts.
bool HoldsTheClock(const PlannedFault& fault) {
  return RowOf(fault.kind).holds_clock || Deafens(fault);
}

/// No mission goes on without its target, not even with --on-loss continue.
bool NeverMissed(const PlannedFault& fault) {
  const std::string& target = fault.target;
  if (const auto sides = SidesOf(target)) {
    const auto across = [](const auto& one, const auto& other) {
      return one.count(process_name::kWorld) > 0 && other.count(process_name::kRecorder) > 0;
    };
    return across(sides->first, sides->second) || across(sides->second, sides->first);
  }
  return target == process_name::kWorld || target == process_name::kLogger ||
         target == process_name::kRecorder || target == "*";
}

/// No fault of that kind can hit its target.
[[noreturn]] void RefuseTarget(const PlannedFault& fault, const std::string& expected) {
  Refuse(fault, "target", fault.target, fmt::format("{} for {}", expected, ToString(fault.kind)));
}

double InRange(const PlannedFault& fault, std::string_view key, double value, double longest,
               bool zero) {
  if (!std::isfinite(value) || value > longest || value < 0 || (value == 0 && !zero)) {
    Refuse(fault, key, fmt::format("{}", value),
           fmt::format("a number {} to {}", zero ? "from 0" : "above 0", longest));
  }
  return value;
}

/// The value of a plan, in the wire's unit.
void SetValue(std::string_view key, double value, PlannedFault* fault) {
  const FaultRow& row = RowOf(fault->kind);
  if (row.value_key.empty()) Refuse(*fault, key, fmt::format("{}", value), "none for this kind");
  fault->probability = InRange(*fault, key, value, row.value_most, false) * row.value_unit;
}

/// It has all that its kind needs, and times that its kind can have.
void CheckShape(const PlannedFault& fault) {
  const FaultRow& row = RowOf(fault.kind);
  if (row.by_world() && fault.for_real_us > 0) {
    Refuse(fault, "for_s", fmt::format("{}", ToSeconds(fault.for_real_us)),
           "for_min: agents fail, roads are closed and zones hold in mission time");
  }
  if ((row.must_end || Deafens(fault)) && fault.for_real_us == 0 && fault.for_us == 0) {
    Refuse(fault, row.of_agents() ? "for_min" : "for_s", "nothing",
           row.of_agents() ? "minutes until it comes back" : "how long, in real seconds");
  }
  if (!row.value_key.empty() && fault.probability == 0) {
    Refuse(fault, row.value_key, "nothing", fmt::format("a number above 0 to {}", row.value_most));
  }
}

Expectations ReadExpectations(const PlannedFault& fault, const ObjectReader& object) {
  object.AllowOnly({"detected_within_ticks", "partner_released_within_decisions",
                    "tasks_finished_by_min", "completion_rate", "same_decisions"});
  const auto count = [&](std::string_view key) {
    return static_cast<int>(object.Integer(key, 0, static_cast<std::int64_t>(kLongestMin)));
  };
  Expectations expect;
  if (object.Has("detected_within_ticks")) {
    expect.detected_within_ticks = count("detected_within_ticks");
    if (RowOf(fault.kind).of_packets()) {
      object.Fail("detected_within_ticks", *object.Optional("detected_within_ticks"),
                  "none: a fault on packets makes no process count as lost");
    }
  }
  if (object.Has("partner_released_within_decisions")) {
    expect.partner_released_within_decisions = count("partner_released_within_decisions");
  }
  if (object.Has("tasks_finished_by_min")) {
    expect.tasks_finished_by_us =
        ToUs(object.Number("tasks_finished_by_min", kOne, 0, kLongestMin) * 60);
  }
  if (object.Has("completion_rate")) {
    expect.completion_rate = object.Number("completion_rate", kOne, 0, 1);
  }
  if (object.Has("same_decisions")) {
    if (!object.Boolean("same_decisions", true)) object.Fail("same_decisions", "false", "true");
    expect.same_decisions = true;
  }
  return expect;
}

std::string TextOf(const ObjectReader& object, std::string_view key) {
  std::string text = object.String(key);
  if (text.empty()) object.Fail(key, *object.Optional(key), "a text");
  return text;
}

PlannedFault ReadFault(const ObjectReader& object, const std::string& where, std::size_t number) {
  PlannedFault fault;
  fault.where = where;
  fault.id = object.Has("id") ? TextOf(object, "id") : fmt::format("f{}", number);
  fault.kind = KindByName(TextOf(object, "kind"), where, "kind");
  fault.target = TextOf(object, "target");
  const std::string_view value_key = RowOf(fault.kind).value_key;
  if (value_key.empty()) {
    object.AllowOnly({"kind", "target", "at_min", "for_min", "for_s", "id", "expect"});
  } else {
    object.AllowOnly({"kind", "target", "at_min", "for_min", "for_s", "id", "expect", value_key});
  }
  const auto time = [&](std::string_view key, double longest, bool zero) {
    return InRange(fault, key, object.Number(key), longest, zero);
  };
  fault.at_us = ToUs(time("at_min", kLongestMin, true) * 60);
  if (object.Has("for_min")) fault.for_us = ToUs(time("for_min", kLongestMin, false) * 60);
  if (object.Has("for_s")) fault.for_real_us = ToUs(time("for_s", kLongest_s, false));
  if (!value_key.empty() && object.Has(value_key)) {
    SetValue(value_key, object.Number(value_key), &fault);
  }
  if (fault.for_us > 0 && fault.for_real_us > 0) {
    object.Fail("for_s", *object.Optional("for_s"), "one of for_min and for_s");
  }
  CheckShape(fault);
  if (object.Has("expect")) fault.expect = ReadExpectations(fault, object.Child("expect"));
  return fault;
}

}  // namespace

FaultKind KindByName(const std::string& name, const std::string& file, std::string_view key) {
  const auto kind = FromString<FaultKind>(name);
  if (!kind) {
    constexpr auto& names = kNames<FaultKind>;
    throw InputError(file, key, name,
                     fmt::format("{}{}", fmt::join(names, ", "),
                                 DidYouMean(name, {names.begin(), names.end()})));
  }
  return *kind;
}

FaultPlan ParseFaultPlan(const std::string& text, const std::string& file) {
  const JsonValue tree = ParseJson(text, file);
  const ObjectReader top(tree, "", file);
  top.AllowOnly({"version", "faults"});
  top.Expect("version", 1);
  FaultPlan plan;
  for (const JsonValue& item : top.Array("faults")) {
    const std::string where = fmt::format("{}: faults[{}]", file, plan.size());
    plan.push_back(ReadFault(ObjectReader(item, "", where), where, plan.size()));
  }
  return plan;
}

FaultPlan LoadFaultPlan(const std::string& file) {
  return ParseFaultPlan(ReadTextFile(file, "a fault plan"), file);
}

PlannedFault ParseFaultFlag(const std::string& text, std::size_t number) {
  PlannedFault fault;
  fault.where = "command line: --fault";
  fault.id = fmt::format("flag{}", number);
  const char* const kForm = "KIND:TARGET@MIN[+DURATION][=VALUE], e.g. loss:*@30+10=0.3";
  const std::size_t colon = text.find(':');
  const std::size_t at = text.rfind('@');
  if (colon == std::string::npos || at == std::string::npos || at < colon + 2) {
    throw InputError("command line", "--fault", text, kForm);
  }
  fault.kind = KindByName(text.substr(0, colon), fault.where, "kind");
  fault.target = text.substr(colon + 1, at - colon - 1);
  std::string_view rest = std::string_view(text).substr(at + 1);
  const auto take = [&](std::string_view ends) {
    const std::size_t size = std::min(rest.find_first_of(ends), rest.size());
    const auto value = ToNumber(rest.substr(0, size));
    if (!value) throw InputError("command line", "--fault", text, kForm);
    rest.remove_prefix(size);
    return *value;
  };
  fault.at_us = ToUs(InRange(fault, "MIN", take("+="), kLongestMin, true) * 60);
  if (!rest.empty() && rest.front() == '+') {
    rest.remove_prefix(1);
    const double duration = take("s=");
    if (!rest.empty() && rest.front() == 's') {
      rest.remove_prefix(1);
      fault.for_real_us = ToUs(InRange(fault, "DURATION", duration, kLongest_s, false));
    } else {
      fault.for_us = ToUs(InRange(fault, "DURATION", duration, kLongestMin, false) * 60);
    }
  }
  if (!rest.empty() && rest.front() == '=') {
    rest.remove_prefix(1);
    SetValue("VALUE", take(""), &fault);
  }
  if (!rest.empty()) throw InputError("command line", "--fault", text, kForm);
  CheckShape(fault);
  return fault;
}

namespace {

bool IsZoneIn(const Scenario& scenario, const RoadArea& area) {
  const auto& circle = std::get<RoadArea::Circle>(area.of);
  const Airspace::Extent extent{scenario.width_m, scenario.height_m};
  return circle.radius_m >= 1 && extent.Contains(circle.centre);
}

/// Whether faults of that kind can hit what it names.
void CheckTarget(const PlannedFault& fault, const std::vector<std::string>& names,
                 const Scenario& scenario, bool recorder_writes) {
  const std::string& target = fault.target;
  const std::string_view launcher =
      recorder_writes ? process_name::kLauncher : process_name::kRecorder;
  const std::string logger = recorder_writes ? process_name::kRecorder : process_name::kLogger;
  const FaultRow& row = RowOf(fault.kind);
  // The launcher cannot be started again.
  const bool with_launcher = row.of_packets() && !row.damages;
  std::vector<std::string_view> known;
  for (const std::string& name : names) {
    if (with_launcher || name != launcher) known.push_back(name);
  }
  const std::string processes = fmt::format("{}", fmt::join(known, ", "));
  const auto is_process = [&](std::string_view name) {
    return std::find(known.begin(), known.end(), name) != known.end();
  };
  switch (row.target) {
    case FaultTarget::kAgent:
      for (const AgentKind kind : kAgentKinds) {
        const std::size_t n = scenario.agents(kind).size();
        for (std::size_t id = 0; id < n; ++id) {
          if (target == fmt::format("{}:{}", ToString(kind), id)) return;
        }
      }
      RefuseTarget(fault, "an agent of the scenario, e.g. uav:3,");
    case FaultTarget::kRoads: {
      const auto area = CircleFrom(target);
      if (!area || scenario.roads == nullptr || RoadsIn(*scenario.roads->network, *area).empty()) {
        RefuseTarget(fault, "X_KM/Y_KM/RADIUS_KM, a circle with roads of the scenario,");
      }
      return;
    }
    case FaultTarget::kAir: {
      const auto area = CircleFrom(target);
      if (!area || scenario.air == nullptr || !IsZoneIn(scenario, *area)) {
        RefuseTarget(fault,
                     "X_KM/Y_KM/RADIUS_KM, a circle of at least 0.001 km around a place in the "
                     "area of a scenario with the key air,");
      }
      return;
    }
    case FaultTarget::kSides: {
      const auto sides = SidesOf(target);
      const auto are_known = [&](const std::set<std::string>& side) {
        return !side.empty() && std::all_of(side.begin(), side.end(), is_process);
      };
      const auto twice = [&](const std::string& name) { return sides->second.count(name) > 0; };
      if (!sides || !are_known(sides->first) || !are_known(sides->second) ||
          std::any_of(sides->first.begin(), sides->first.end(), twice)) {
        RefuseTarget(fault, fmt::format("ONE+...|OTHER+... of {},", processes));
      }
      return;
    }
    case FaultTarget::kLog:
      if (target != logger) RefuseTarget(fault, logger);
      return;
    case FaultTarget::kEverybody:
      if (target != "*") RefuseTarget(fault, "* (all processes receive them)");
      return;
    case FaultTarget::kReceivers:
      if (target != "*" && !is_process(target)) {
        RefuseTarget(fault, fmt::format("* or one of {},", processes));
      }
      return;
    case FaultTarget::kProcess:
      if (target != logger && !is_process(target)) {
        RefuseTarget(fault, recorder_writes ? fmt::format("one of {},", processes)
                                            : fmt::format("one of {}, {},", processes, logger));
      }
      return;
  }
}

}  // namespace

void CheckFaultPlan(FaultPlan* plan, const std::vector<std::string>& names,
                    const Scenario& scenario, bool goes_on, bool recorder_writes) {
  std::set<std::string> ids;
  for (PlannedFault& fault : *plan) {
    if (recorder_writes && fault.target == process_name::kLogger) {
      fault.target = process_name::kRecorder;
    }
    if (!ids.insert(fault.id).second)
      Refuse(fault, "id", fault.id, "an id that no other fault has");
    if (fault.id.size() > 64 || fault.id.find(':') != std::string::npos || HasControls(fault.id)) {
      Refuse(fault, "id", Printable(fault.id),
             "at most 64 characters, no colon, no control characters");
    }
    if (fault.at_us >= scenario.rules.limit_us) {
      Refuse(fault, "at_min", fmt::format("{}", ToMinutes(fault.at_us)),
             fmt::format("a time below the limit, {} min", ToMinutes(scenario.rules.limit_us)));
    }
    CheckTarget(fault, names, scenario, recorder_writes);
    if (fault.for_us == 0 || !HoldsTheClock(fault)) continue;
    const std::string whom = fmt::format("{} of {}", ToString(fault.kind), fault.target);
    if (!goes_on) {
      Refuse(fault, "for_min", fmt::format("{}", ToMinutes(fault.for_us)),
             fmt::format("for_s, real seconds, for {}: the mission's clock stands still while it "
                         "lasts. Only with --on-loss continue does a mission go on without an "
                         "agent process or the scheduler",
                         whom));
    }
    if (NeverMissed(fault)) {
      Refuse(
          fault, "for_min", fmt::format("{}", ToMinutes(fault.for_us)),
          fmt::format("for_s, real seconds, for {}: the mission's clock stands still without the "
                      "world or the recorder",
                      whom));
    }
  }
  std::stable_sort(plan->begin(), plan->end(),
                   [](const PlannedFault& a, const PlannedFault& b) { return a.at_us < b.at_us; });
}

fault_t ToWire(const PlannedFault& fault) {
  fault_t wire{};
  wire.fault_id = fault.id;
  wire.kind = NumberOf(fault.kind);
  wire.target = fault.target;
  wire.at_us = fault.at_us;
  wire.for_us = fault.for_us > 0        ? fault.for_us
                : fault.for_real_us > 0 ? fault.for_real_us
                                        : kNever;
  wire.probability = fault.probability;
  return wire;
}

std::string ToJson(const FaultPlan& plan) {
  nlohmann::ordered_json faults = nlohmann::ordered_json::array();
  for (const PlannedFault& fault : plan) {
    nlohmann::ordered_json row = {{"id", fault.id},
                                  {"kind", ToString(fault.kind)},
                                  {"target", fault.target},
                                  {"at_min", ToMinutes(fault.at_us)}};
    if (fault.for_us > 0) row["for_min"] = ToMinutes(fault.for_us);
    if (fault.for_real_us > 0) row["for_s"] = ToSeconds(fault.for_real_us);
    if (const FaultRow& kind = RowOf(fault.kind); fault.probability > 0) {
      row[std::string(kind.value_key)] =
          kind.value_unit == 1 ? fault.probability
                               : std::round(fault.probability * (1e3 / kind.value_unit)) / 1e3;
    }
    faults.push_back(std::move(row));
  }
  std::string text = "{\"version\": 1, \"faults\": [";
  for (const auto& row : faults) {
    text += fmt::format("{}\n  {}", &row == &faults.front() ? "" : ",", row.dump());
  }
  return text + "\n]}\n";
}

std::vector<std::string> WorldOptionsOf(const FaultPlan& plan) {
  std::vector<std::string> options;
  for (const PlannedFault& fault : plan) {
    const FaultRow& row = RowOf(fault.kind);
    if (!row.by_world()) continue;
    options.emplace_back(row.of_agents() ? "--outage" : "--closure");
    const std::string kind = row.of_agents() ? "" : fmt::format("{}:", ToString(fault.kind));
    options.push_back(fmt::format("{}{}:{}:{}:{}", kind, fault.target, fault.at_us,
                                  fault.for_us > 0 ? fault.at_us + fault.for_us : kNever,
                                  fault.id));
  }
  return options;
}

}  // namespace muster::tools
