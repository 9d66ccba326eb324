#include "model/scenario_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <iterator>
#include <unordered_set>
#include <utility>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/number_text.h"
#include "base/object_reader.h"
#include "base/sha256.h"
#include "base/text_file.h"
#include "model/task_reader.h"
#include "model/ways_reader.h"

namespace muster {
namespace {

// Reading.

Point ReadPoint(const ObjectReader& object) {
  return {object.Number("x_km", kKm), object.Number("y_km", kKm)};
}

/// Checks that the ids of a list are 0, 1, 2, ...
class IdCounter {
 public:
  void Take(const ObjectReader& object) {
    const std::int64_t id = object.Integer("id", 0, INT32_MAX);
    const bool is_new = seen_.insert(id).second;
    if (id != next_) {
      object.Fail("id", fmt::format("{}{}", id, is_new ? "" : " again"),
                  fmt::format("{} (ids count from 0 in the order of the list)", next_));
    }
    ++next_;
  }

 private:
  std::int64_t next_ = 0;
  std::unordered_set<std::int64_t> seen_;  // only asked for membership
};

std::vector<AgentSpec> ReadAgents(const ObjectReader& top, std::string_view list, AgentKind kind,
                                  int version) {
  const std::vector<JsonValue>& items = top.Array(list);
  std::vector<AgentSpec> agents;
  agents.reserve(items.size());
  IdCounter ids;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const ObjectReader object = top.Element(list, items[i], i);
    if (kind == AgentKind::kUav) {
      object.AllowOnly({"id", "x_km", "y_km", "speed_km_per_min", "full_range_km", "range_km",
                        "online_from_min", "online_until_min", "measured"});
    } else if (kind == AgentKind::kWorker) {
      object.AllowOnly({"id", "x_km", "y_km", "speed_km_per_min", "online_from_min",
                        "online_until_min", "measured"});
    } else {
      object.AllowOnly({"id", "x_km", "y_km", "speed_km_per_min", "charge_km_per_min",
                        "online_from_min", "online_until_min", "measured"});
    }
    if (version == 1 && object.Has("measured")) {
      object.Fail("measured", "in version 1", "version 2");
    }
    ids.Take(object);
    AgentSpec agent;
    agent.at = ReadPoint(object);
    agent.speed_m_s = object.Number("speed_km_per_min", kKmPerMin);
    if (kind == AgentKind::kUav) {
      agent.range_full_m = object.Number("full_range_km", kKm);
      agent.range_m = object.Number("range_km", kKm);
    }
    if (kind == AgentKind::kVehicle) {
      agent.charge_rate_m_s = object.Number("charge_km_per_min", kKmPerMin);
    }
    agent.online_from_us = object.Time("online_from_min", kMinute);
    agent.online_until_us = object.Time("online_until_min", kMinute);
    agent.measured = object.Boolean("measured", false);
    agents.push_back(agent);
  }
  return agents;
}

std::vector<Task> ReadTasks(const ObjectReader& top, int version) {
  const std::vector<JsonValue>& items = top.Array("tasks");
  std::vector<Task> tasks;
  tasks.reserve(items.size());
  IdCounter ids;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const ObjectReader object = top.Element("tasks", items[i], i);
    if (version == 1) {
      object.AllowOnly({"id", "x_km", "y_km", "cost_km"});
    } else {
      object.AllowOnly({"id", "x_km", "y_km", "cost_km", "reported_min", "priority", "due_min",
                        "expires_min", "revisit_min", "name", "external_id", "source", "note"});
    }
    ids.Take(object);
    Task task;
    task.at = ReadPoint(object);
    task.cost_m = object.Number("cost_km", kKm);
    if (version > 1) ReadTaskTimes(object, &task);
    tasks.push_back(std::move(task));
  }
  return tasks;
}

std::vector<ChargingPoint> ReadChargingPoints(const ObjectReader& top) {
  const std::vector<JsonValue>& items = top.Array("charging_points");
  std::vector<ChargingPoint> points;
  points.reserve(items.size());
  IdCounter ids;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const ObjectReader object = top.Element("charging_points", items[i], i);
    object.AllowOnly({"id", "x_km", "y_km", "capacity"});
    ids.Take(object);
    ChargingPoint point;
    point.at = ReadPoint(object);
    if (const JsonValue* capacity = object.Optional("capacity")) {
      if (capacity->type == JsonValue::Type::kNull) {
        point.capacity = std::nullopt;
      } else {
        point.capacity = static_cast<int>(object.ReadInteger("capacity", *capacity, 1, INT32_MAX));
      }
    }
    points.push_back(point);
  }
  return points;
}

/// What rules have in version 2 only.
void ReadOpenRules(const ObjectReader& object, Rules* rules) {
  if (object.Has("late_worth")) {
    rules->late_worth = object.Number("late_worth", kOne);
  }
  if (object.Has("patience_min")) {
    rules->patience_us = object.Time("patience_min", kMinute);
  }
  rules->emergencies_at_once = object.Boolean("emergencies_at_once", false);
  if (!object.Has("priority_worth")) return;
  const std::vector<JsonValue>& worths = object.Array("priority_worth");
  if (worths.size() != kPriorities) {
    object.Fail("priority_worth", fmt::format("an array of {}", worths.size()),
                "[low, normal, high, emergency]");
  }
  for (std::size_t i = 0; i < kPriorities; ++i) {
    rules->priority_worth[i] =
        object.ReadNumber(fmt::format("priority_worth[{}]", i), worths[i], kOne);
  }
}

void ReadRules(const ObjectReader& object, int version, Rules* rules) {
  if (version == 1) {
    object.AllowOnly(
        {"availability", "tick_s", "ceil_to_minutes", "mean_over_all", "start_on_meeting"});
  } else {
    object.AllowOnly({"availability", "tick_s", "ceil_to_minutes", "mean_over_all",
                      "start_on_meeting", "priority_worth", "late_worth", "patience_min",
                      "emergencies_at_once"});
    ReadOpenRules(object, rules);
  }
  if (object.Has("availability")) {
    const std::string name = object.String("availability");
    if (name != "strict" && name != "overrun") {
      object.Fail("availability", *object.Optional("availability"), "\"strict\" or \"overrun\"");
    }
    rules->availability = name == "strict" ? Availability::kStrict : Availability::kOverrun;
  }
  if (object.Has("tick_s")) rules->tick_us = object.Time("tick_s", kSecond);
  rules->ceil_to_minutes = object.Boolean("ceil_to_minutes", rules->ceil_to_minutes);
  rules->mean_over_all = object.Boolean("mean_over_all", rules->mean_over_all);
  rules->start_on_meeting = object.Boolean("start_on_meeting", rules->start_on_meeting);
}

Room ReadRoom(const ObjectReader& object) {
  object.AllowOnly({"tasks", "uavs", "workers", "vehicles"});
  const auto count = [&](std::string_view key) {
    const JsonValue* value = object.Optional(key);
    return value == nullptr
               ? std::size_t{0}
               : static_cast<std::size_t>(object.ReadInteger(key, *value, 0, kMostRoom));
  };
  return {count("tasks"), {count("uavs"), count("workers"), count("vehicles")}};
}

void TakeRoads(const ObjectReader& object, const std::string& text, std::string_view file,
               Scenario* scenario) {
  ScenarioRoads roads = ReadRoadsKey(object);
  const std::string expected = object.String("sha256");
  if (text.empty()) {
    throw RoadsLacking(fmt::format("{}: roads: found no road file, expected {}", file, roads.file));
  }
  if (const std::string found = Sha256(text); found != expected) {
    throw RoadsLacking(fmt::format("{}: roads.sha256: the road file {} has {}, expected {}", file,
                                   roads.file, found, expected));
  }
  roads.text = text;
  const std::string name = roads.file;
  UseRoads(std::move(roads), name, scenario);
}

Disturbances::Interval ReadInterval(const ObjectReader& object, std::string_view key, Unit unit) {
  if (!object.Has(key)) return {};
  const std::vector<JsonValue>& ends = object.Array(key);
  if (ends.size() != 2) {
    object.Fail(key, fmt::format("an array of {}", ends.size()), "[low, high]");
  }
  return {object.ReadNumber(fmt::format("{}[0]", key), ends[0], unit),
          object.ReadNumber(fmt::format("{}[1]", key), ends[1], unit)};
}

Disturbances ReadDisturbances(const ObjectReader& object) {
  object.AllowOnly({"wind", "communication_km", "agent_failure", "match_failure"});
  return {ReadInterval(object, "wind", kOne), ReadInterval(object, "communication_km", kKm),
          ReadInterval(object, "agent_failure", kOne), ReadInterval(object, "match_failure", kOne)};
}

std::uint64_t ReadSeed(const ObjectReader& top) {
  const JsonValue& value = top.Required("seed", "an integer");
  // The parser writes integers that fit 64 bits with digits alone; all else fails here.
  const bool is_digits = value.type == JsonValue::Type::kNumber &&
                         value.text.find_first_not_of("0123456789") == std::string::npos;
  errno = 0;
  const unsigned long long seed = is_digits ? std::strtoull(value.text.c_str(), nullptr, 10) : 0;
  if (!is_digits || errno == ERANGE) {
    top.Fail("seed", value, "an integer in [0, 18446744073709551615]");
  }
  return seed;
}

/// "": none.
std::string RoadFileNamedBy(const std::string& json, std::string_view file) {
  if (json.find("\"roads\"") == std::string::npos) return "";
  const JsonValue tree = ParseJson(json, file);
  const ObjectReader top(tree, "", file);
  return top.Has("roads") ? ReadRoadFileName(top.Child("roads")) : "";
}

// Writing.

class Writer {
 public:
  std::string Write(const Scenario& scenario) {
    const Rules& rules = scenario.rules;
    const bool open = scenario.IsOpen();
    Add("{{\n  \"version\": {},\n  \"name\": {},\n  \"seed\": {},\n",
        open || scenario.roads || scenario.air ? 2 : 1, JsonText(scenario.name), scenario.seed);
    Add("  \"area_km\": [{}, {}],\n", ToText(scenario.width_m, kKm),
        ToText(scenario.height_m, kKm));
    Add("  \"interval_min\": {},\n  \"limit_min\": {},\n", TimeToText(rules.interval_us, kMinute),
        TimeToText(rules.limit_us, kMinute));
    if (scenario.start) Add("  \"start\": {},\n", JsonText(scenario.start->text));
    if (scenario.origin) {
      Add("  \"origin\": {{\"latitude_deg\": {}, \"longitude_deg\": {}}},\n",
          ToText(scenario.origin->latitude_deg, kOne),
          ToText(scenario.origin->longitude_deg, kOne));
    }
    Add("  \"rules\": {{\"availability\": \"{}\", \"tick_s\": {}, \"ceil_to_minutes\": {}, "
        "\"mean_over_all\": {}, \"start_on_meeting\": {}",
        rules.availability == Availability::kStrict ? "strict" : "overrun",
        TimeToText(rules.tick_us, kSecond), rules.ceil_to_minutes, rules.mean_over_all,
        rules.start_on_meeting);
    if (open) {
      const auto& worth = rules.priority_worth;
      Add(", \"priority_worth\": [{}, {}, {}, {}], \"late_worth\": {}", ToText(worth[0], kOne),
          ToText(worth[1], kOne), ToText(worth[2], kOne), ToText(worth[3], kOne),
          ToText(rules.late_worth, kOne));
      if (rules.patience_us != Rules().patience_us) {
        Add(", \"patience_min\": {}", TimeToText(rules.patience_us, kMinute));
      }
      if (rules.emergencies_at_once) Add(", \"emergencies_at_once\": true");
    }
    Add("}},\n");
    const Disturbances& disturbances = scenario.disturbances;
    Add("  \"disturbances\": {{\"wind\": {}, \"communication_km\": {}, \"agent_failure\": {}, "
        "\"match_failure\": {}}},\n",
        Ends(disturbances.wind, kOne), Ends(disturbances.communication_m, kKm),
        Ends(disturbances.agent_failure, kOne), Ends(disturbances.match_failure, kOne));
    if (scenario.room.any()) {
      const Room& room = scenario.room;
      Add("  \"room\": {{\"tasks\": {}, \"uavs\": {}, \"workers\": {}, \"vehicles\": {}}},\n",
          room.tasks, room.agents.uavs, room.agents.workers, room.agents.vehicles);
    }
    if (scenario.roads) AddRoads(*scenario.roads);
    if (scenario.air) AddAir(*scenario.air);
    Agents("uavs", AgentKind::kUav, scenario);
    Agents("workers", AgentKind::kWorker, scenario);
    Agents("vehicles", AgentKind::kVehicle, scenario);
    List("tasks", scenario.tasks, scenario.n_tasks(), [&](const Task& task) { AddTask(task); });
    List("charging_points", scenario.charging_points, scenario.charging_points.size(),
         [&](const ChargingPoint& point) {
           Place(point.at);
           Add(", \"capacity\": {}", point.capacity ? fmt::to_string(*point.capacity) : "null");
         });
    text_.replace(text_.size() - 2, 2, "\n}\n");  // the last list's comma
    return std::move(text_);
  }

  std::string Write(const Task& task) {
    text_ = "{";
    AddTask(task);
    return text_ + "}";
  }

 private:
  template <class... Args>
  void Add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }

  void AddRoads(const ScenarioRoads& roads) {
    const auto ground = [](const OpenGround& open) {
      return fmt::format("{{\"percent\": {}, \"reach_km\": {}}}", open.percent,
                         ToText(open.reach_m, kKm));
    };
    Add("  \"roads\": {{\"file\": {}, \"sha256\": \"{}\",\n", JsonText(roads.file),
        Sha256(roads.text));
    Add("    \"open_ground\": {{\"workers\": {}, \"vehicles\": {}}}",
        ground(roads.open_ground.workers), ground(roads.open_ground.vehicles));
    for (const PlannedClosure& closure : roads.closures) {
      Add("{}\n      {{{}", &closure == roads.closures.data() ? ",\n    \"closures\": [" : ",",
          RoadAreaToJson(closure.area));
      if (!closure.name.empty()) Add(", \"name\": {}", JsonText(closure.name));
      AddFromUntil(closure.from_us, closure.until_us);
      text_ += '}';
    }
    text_ += roads.closures.empty() ? "},\n" : "]},\n";
  }

  void AddFromUntil(TimeUs from_us, TimeUs until_us) {
    Add(", \"from_min\": {}", TimeToText(from_us, kMinute));
    if (until_us != kNever) Add(", \"until_min\": {}", TimeToText(until_us, kMinute));
  }

  void AddAir(const ScenarioAir& air) {
    Add("  \"air\": {{\"margin_km\": {}", ToText(air.margin_m, kKm));
    if (!air.separation) {
      text_ += ", \"separation\": false";
    } else if (*air.separation != Separation()) {
      const Separation& s = *air.separation;
      Add(", \"separation\": {{\"horizontal_m\": {}, \"vertical_m\": {}, \"lowest_m\": {}, "
          "\"ceiling_m\": {}}}",
          ToText(s.horizontal_m, kOne), ToText(s.vertical_m, kOne), ToText(s.lowest_m, kOne),
          ToText(s.ceiling_m, kOne));
    }
    for (const PlannedZone& planned : air.zones) {
      Add("{}\n    {{{}", &planned == air.zones.data() ? ", \"zones\": [" : ",",
          ZoneToJson(planned.zone));
      if (!planned.zone.name.empty()) Add(", \"name\": {}", JsonText(planned.zone.name));
      AddFromUntil(planned.from_us, planned.until_us);
      if (planned.lower_m > 0) Add(", \"lower_m\": {}", ToText(planned.lower_m, kOne));
      text_ += '}';
    }
    text_ += air.zones.empty() ? "},\n" : "]},\n";
  }

  void AddTask(const Task& task) {
    Place(task.at);
    Add(", \"cost_km\": {}", ToText(task.cost_m, kKm));
    Times(task);
  }

  /// What a plain task has not.
  void Times(const Task& task) {
    const auto time = [&](std::string_view key, TimeUs t, TimeUs usual) {
      if (t != usual) Add(", \"{}\": {}", key, TimeToText(t, kMinute));
    };
    const auto text = [&](std::string_view key, const std::string& value) {
      if (!value.empty()) Add(", \"{}\": {}", key, JsonText(value));
    };
    time("reported_min", task.reported_us, 0);
    time("due_min", task.due_us, kNever);
    time("expires_min", task.expires_us, kNever);
    time("revisit_min", task.revisit_us, kNever);
    if (task.priority != Priority::kNormal) {
      Add(", \"priority\": {}", static_cast<int>(task.priority));
    }
    text("name", task.name);
    text("external_id", task.external_id);
    text("source", task.source);
    text("note", task.note);
  }

  static std::string Ends(const Disturbances::Interval& interval, Unit unit) {
    return fmt::format("[{}, {}]", ToText(interval.low, unit), ToText(interval.high, unit));
  }

  void Place(Point at) {
    Add("\"x_km\": {}, \"y_km\": {}", ToText(at.x_m, kKm), ToText(at.y_m, kKm));
  }

  template <class T, class Body>
  void List(std::string_view name, const std::vector<T>& items, std::size_t n, const Body& body) {
    Add("  \"{}\": [", name);
    for (std::size_t i = 0; i < n; ++i) {
      Add("{}\n    {{\"id\": {}, ", i == 0 ? "" : ",", i);
      body(items[i]);
      text_ += '}';
    }
    text_ += "\n  ],\n";
  }

  void Agents(std::string_view name, AgentKind kind, const Scenario& scenario) {
    List(name, scenario.agents(kind), scenario.n_agents(kind), [&](const AgentSpec& agent) {
      Place(agent.at);
      Add(", \"speed_km_per_min\": {}", ToText(agent.speed_m_s, kKmPerMin));
      if (kind == AgentKind::kUav) {
        Add(", \"full_range_km\": {}, \"range_km\": {}", ToText(agent.range_full_m, kKm),
            ToText(agent.range_m, kKm));
      }
      if (kind == AgentKind::kVehicle) {
        Add(", \"charge_km_per_min\": {}", ToText(agent.charge_rate_m_s, kKmPerMin));
      }
      Add(", \"online_from_min\": {}, \"online_until_min\": {}",
          TimeToText(agent.online_from_us, kMinute), TimeToText(agent.online_until_us, kMinute));
      if (agent.measured) text_ += ", \"measured\": true";
    });
  }

  std::string text_;
};

}  // namespace

Scenario ParseScenario(const ScenarioText& text, std::string_view file) {
  constexpr std::string_view kExpected =
      "a scenario; muster import makes one from a table of places (CSV or GeoJSON)";
  const std::size_t begin = text.json.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (begin != std::string::npos &&
      std::string_view("{[").find(text.json[begin]) == std::string_view::npos) {
    throw InputError(file, "line 1", "no JSON", kExpected);
  }
  const JsonValue tree = ParseJson(text.json, file);
  const ObjectReader top(tree, "", file);
  if (top.Has("features")) throw InputError(file, "features", "GeoJSON", kExpected);
  // The version first: another version's keys would only confuse.
  const JsonValue& number = top.Required("version", "1 or 2");
  if (number.type != JsonValue::Type::kNumber || (number.text != "1" && number.text != "2")) {
    top.Fail("version", number, "1 or 2");
  }
  const int version = number.text == "1" ? 1 : 2;
  top.AllowOnly({"version", "name", "seed", "area_km", "interval_min", "limit_min", "start",
                 "origin", "rules", "disturbances", "uavs", "workers", "vehicles", "tasks",
                 "charging_points", "room", "roads", "air"});
  for (const char* key : {"room", "roads", "air"}) {
    if (version == 1 && top.Has(key)) top.Fail(key, "in version 1", "version 2");
  }
  Scenario scenario;
  if (top.Has("room")) scenario.room = ReadRoom(top.Child("room"));
  scenario.name = top.String("name");
  scenario.seed = ReadSeed(top);
  const std::vector<JsonValue>& area = top.Array("area_km");
  if (area.size() != 2) {
    top.Fail("area_km", fmt::format("an array of {}", area.size()), "[width, height]");
  }
  scenario.width_m = top.ReadNumber("area_km[0]", area[0], kKm);
  scenario.height_m = top.ReadNumber("area_km[1]", area[1], kKm);
  scenario.rules.interval_us = top.Time("interval_min", kMinute);
  scenario.rules.limit_us = top.Time("limit_min", kMinute);
  if (top.Has("start")) {
    scenario.start = ParseMoment(top.String("start"));
    if (!scenario.start) top.Fail("start", *top.Optional("start"), kMomentExpected);
  }
  if (top.Has("origin")) {
    const ObjectReader origin = top.Child("origin");
    origin.AllowOnly({"latitude_deg", "longitude_deg"});
    scenario.origin =
        Origin{origin.Number("latitude_deg", kOne), origin.Number("longitude_deg", kOne)};
  }
  if (top.Has("rules")) ReadRules(top.Child("rules"), version, &scenario.rules);
  if (top.Has("disturbances")) {
    scenario.disturbances = ReadDisturbances(top.Child("disturbances"));
  }
  scenario.uavs = ReadAgents(top, "uavs", AgentKind::kUav, version);
  scenario.workers = ReadAgents(top, "workers", AgentKind::kWorker, version);
  scenario.vehicles = ReadAgents(top, "vehicles", AgentKind::kVehicle, version);
  scenario.tasks = ReadTasks(top, version);
  scenario.charging_points = ReadChargingPoints(top);
  const Room room = std::exchange(scenario.room, {});
  ValidateScenario(scenario, file, room.tasks > 0);
  if (top.Has("roads")) TakeRoads(top.Child("roads"), text.roads, file, &scenario);
  if (top.Has("air")) UseAir(ReadAir(top.Child("air")), &scenario);
  AddRoom(room, &scenario);
  return scenario;
}

Scenario LoadScenario(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path inside = fs::path(file) / "scenario.json";
  if (fs::is_regular_file(inside, ignored)) {
    throw InputError(
        fmt::format("{}: found a run directory, expected a scenario file; its scenario is {}", file,
                    inside.string()));
  }
  ScenarioText text(ReadTextFile(file, "a scenario"));
  if (const std::string roads = RoadFileNamedBy(text.json, file); !roads.empty()) {
    text.roads = ReadTextFile((fs::path(file).parent_path() / roads).string(), "the road file");
  }
  return ParseScenario(text, file);
}

ScenarioText TextOf(const Scenario& scenario) {
  return {ScenarioToJson(scenario), scenario.roads ? scenario.roads->text : ""};
}

std::string ScenarioToJson(const Scenario& scenario) { return Writer().Write(scenario); }

std::string TaskToJson(const Task& task) { return Writer().Write(task); }

}  // namespace muster
