#include "tools/scenario/settings_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "base/check.h"
#include "base/text.h"
#include "model/scenario_json.h"
#include "tools/files/pending_file.h"
#include "tools/files/scenario_file.h"

namespace muster::tools {
namespace {

constexpr double kMaxMinutes = 1e6;
constexpr int kMaxCount = 10'000'000;

[[noreturn]] void Fail(std::string_view flag, std::string_view found, std::string_view expected) {
  throw InputError("command line", fmt::format("--{}", flag), fmt::format("'{}'", found), expected);
}

/// "A" or "A:B", from `low` to `high`; with `open_end` also "A:", up to the limit.
std::optional<DrawRange> RangeOf(const std::string& text, double low, double high, bool open_end) {
  const std::vector<std::string> ends = Split(text, ':');
  const auto from = ToNumber(ends.front());
  auto until = ToNumber(ends.back());
  const bool is_open = open_end && ends.size() == 2 && ends[1].empty();
  if (is_open) until = kUpToLimit;
  if (ends.size() > 2 || !from || !until || *from < low || *until < *from ||
      (*until > high && !is_open)) {
    return std::nullopt;
  }
  return DrawRange{*from, *until};
}

void ReadRange(const Arguments& arguments, const std::string& name, double low, double high,
               bool open_end, DrawRange* to) {
  if (!arguments.Has(name)) return;
  const std::string text = arguments.Get(name);
  const auto range = RangeOf(text, low, high, open_end);
  if (!range) {
    Fail(name, text,
         fmt::format("A, A:B{} with {} <= A <= B <= {}", open_end ? " or A:" : "", low, high));
  }
  *to = *range;
}

/// "steady" or "bursts:N", with ":SHARE" behind it or not.
void ReadArrivals(const Arguments& arguments, bool may_be_rows, GeneratorSettings* settings) {
  if (!arguments.Has("arrivals")) return;
  const std::string text = arguments.Get("arrivals");
  if (may_be_rows && text == kArrivalsOfRows) return;
  const std::vector<std::string> parts = Split(text, ':');
  const bool is_bursts = parts[0] == "bursts" && parts.size() > 1;
  const auto bursts = is_bursts ? ToInteger(parts[1], 1, kMaxCount) : 0;
  const std::size_t words = is_bursts ? 2 : 1;
  const auto share = parts.size() > words ? ToNumber(parts[words]) : 1;
  if ((parts[0] != "steady" && !is_bursts) || !bursts || !share || *share < 0 || *share > 1 ||
      parts.size() > words + 1) {
    Fail("arrivals", text,
         fmt::format("{}steady or bursts:N, and :SHARE in [0, 1] behind it or not",
                     may_be_rows ? "rows, " : ""));
  }
  settings->arrivals = {*share, static_cast<int>(*bursts)};
}

/// Four shares, from low to emergency.
void ReadPriorities(const Arguments& arguments, GeneratorSettings* settings) {
  if (!arguments.Has("priorities")) return;
  const std::string text = arguments.Get("priorities");
  const std::vector<std::string> shares = Split(text, ',');
  double sum = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const auto share = ToNumber(shares[i]);
    if (shares.size() != kPriorities || !share || *share < 0 || *share > 1e6) {
      sum = 0;
      break;
    }
    sum += settings->priority_shares[i] = *share;
  }
  if (sum <= 0) {
    Fail("priorities", text,
         "LOW,NORMAL,HIGH,EMERGENCY: four shares of at least 0, not all 0, like 1,6,2,1");
  }
}

/// One range for all priorities, or four from low to emergency; "none" is one too.
void ReadDelays(const Arguments& arguments, const std::string& name, Delays* to) {
  if (!arguments.Has(name)) return;
  const std::string text = arguments.Get(name);
  const std::vector<std::string> parts = Split(text, ',');
  for (std::size_t i = 0; i < kPriorities; ++i) {
    const std::string& part = parts.size() == 1 ? parts[0] : parts[std::min(i, parts.size() - 1)];
    (*to)[i] = RangeOf(part, 0, kMaxMinutes, false);
    if ((parts.size() != 1 && parts.size() != kPriorities) || (!(*to)[i] && part != "none")) {
      Fail(name, text,
           fmt::format("minutes A, A:B or none, for all or for LOW,NORMAL,HIGH,EMERGENCY, with 0 "
                       "<= A <= B <= {}",
                       kMaxMinutes));
    }
  }
}

void ReadInterval(const Arguments& arguments, const std::string& name, double high, double unit,
                  Disturbances::Interval* to) {
  if (!arguments.Has(name)) return;
  DrawRange range;
  ReadRange(arguments, name, 0, high, false, &range);
  *to = {range.low * unit, range.high * unit};
}

/// "WxH"
void ReadArea(const Arguments& arguments, GeneratorSettings* settings) {
  if (!arguments.Has("area")) return;
  const std::string text = arguments.Get("area");
  const std::vector<std::string> sides = Split(text, 'x');
  const auto width_km = ToNumber(sides.front());
  const auto height_km = ToNumber(sides.back());
  if (sides.size() != 2 || !width_km || !height_km || *width_km <= 0 || *height_km <= 0) {
    Fail("area", text, "WxH, kilometres above 0, like 30x20");
  }
  settings->width_km = *width_km;
  settings->height_km = *height_km;
}

}  // namespace

void AddSettingsOptions(Options* options, bool may_be_rows) {
  options->Add("seed", "N", "Seed of all random draws").Seed().Default(1);
  options->Out("FILE", "File to write (default: standard output)");
  AddNumberOptions(options, may_be_rows);
}

namespace {

constexpr NumberRange kPositive = {1e-6, 1e6};

void AddCounts(Options* options) {
  options->Add("name", "TEXT", "Name of the scenario (default: the preset's)");

  options->Group("Number (default: the preset's; A:B is drawn per item)");
  options->Add("area", "WxH", "Kilometres east by north");
  options->Add("uavs", "N", "UAVs").Integer(1, kMaxCount);
  options->Add("workers", "N", "Workers").Integer(1, kMaxCount);
  options->Add("vehicles", "N", "Vehicles").Integer(1, kMaxCount);
  options->Add("tasks", "N", "Tasks").Integer(1, kMaxCount);
  options->Add("charging-points", "N", "Charging points").Integer(1, kMaxCount);
  options->Add("online-min", "A[:B]",
               "Minutes that an agent is online; 'A:' is at least A, up to the limit");
  options->Add("task-cost-km", "A[:B]", "Range that sensing a task takes, km");
  options->Add("charge-km-per-min", "A[:B]", "Range that a vehicle gives, km per minute");
  options->Add("capacity", "N", "UAVs that charge at one point at a time, or none for no bound")
      .Integer(1, kMaxCount)
      .Or("none")
      .Default(1);
  options->Add("scale", "S", "Multiply the preset's area and counts, at the same density")
      .Number(kPositive)
      .Default(1);
}

void AddTaskTimes(Options* options, bool may_be_rows) {
  options->Group("Task time (default: all known from the start, normal, never due)");
  options->Add("arrivals", may_be_rows ? "rows|steady|bursts:N" : "steady|bursts:N",
               fmt::format("When tasks are reported: {}steady: at any time of the mission; "
                           "bursts:N: in N bursts of {} min; with :SHARE behind it only that share "
                           "of them, and the others are known from the start",
                           may_be_rows ? "rows: when their rows say; " : "", ToMinutes(kBurstUs)));
  options->Add("priorities", "L,N,H,E", "Shares of low, normal, high and emergency, like 1,6,2,1");
  options->Add(
      "due", "A[:B]",
      "Minutes from a task's report until it is due; four values with commas: by priority; "
      "each may be none");
  options->Add("expires", "A[:B]",
               "Minutes from a task's report until it expires; by priority as with --due");
}

void AddUnpublished(Options* options) {
  const GeneratorSettings defaults;
  options->Group("Unpublished setting");
  options->Add("uav-speed-km-per-min", "V", "Speed of UAVs")
      .Number(kPositive)
      .Default(defaults.uav_speed_km_per_min);
  options->Add("worker-speed-km-per-min", "V", "Speed of workers")
      .Number(kPositive)
      .Default(defaults.worker_speed_km_per_min);
  options->Add("vehicle-speed-km-per-min", "V", "Speed of vehicles")
      .Number(kPositive)
      .Default(defaults.vehicle_speed_km_per_min);
  options->Add("full-range-km", "D", "Range of a full UAV")
      .Number({1e-3, 1e6})
      .Default(defaults.full_range_km);
  options->Add("start-fraction", "A[:B]", "Part of the full range that a UAV has at the start")
      .Default(defaults.start_fraction.low);
  options->Add("placement", "HOW", "cells: centres of 1 km cells; continuous: any metre")
      .OneOf({"cells", "continuous"})
      .Default("cells");
  options->Add("uptime", "HOW", "Online from: within: [0, limit - online time]; any: [0, limit]")
      .OneOf({"within", "any"})
      .Default("within");
}

void AddRules(Options* options) {
  const GeneratorSettings defaults;
  options->Group("Rule");
  options->Add("interval", "MIN", "Minutes between decisions")
      .Number(Above0(kMaxMinutes))
      .Default(ToMinutes(defaults.rules.interval_us));
  options->Add("limit", "MIN", "Minutes that the mission lasts")
      .Number(Above0(kMaxMinutes))
      .Default(ToMinutes(defaults.rules.limit_us));
  options->Add("tick", "S", "Seconds between ticks; divides the interval")
      .Number(Above0(kMaxMinutes))
      .Default(ToSeconds(defaults.rules.tick_us));
  options
      ->Add("availability", "HOW",
            "strict: actions end before downtime; overrun: they may end later")
      .OneOf({"strict", "overrun"})
      .Default("strict");
  options->Flag("ceil-to-minutes", "Weights count minutes, not intervals");
  options->Flag("mean-over-all", "Eq. 4-5 and 4-7 divide by all idle UAVs");
  options->Flag("start-on-meeting", "Agents that meet in a cell start without a pair action");
}

void AddDisturbances(Options* options) {
  options->Group("Disturbance (off unless given)");
  options->Add("wind", "A[:B]", "Extra range per kilometre of a UAV's way");
  options->Add("communication-km", "A[:B]", "Range that an action costs a UAV");
  options->Add("agent-failure", "A[:B]", "Probability that an agent fails at a decision");
  options->Add("match-failure", "A[:B]", "Probability that a pair's match fails");
}

}  // namespace

void AddNumberOptions(Options* options, bool may_be_rows) {
  AddCounts(options);
  AddTaskTimes(options, may_be_rows);
  AddUnpublished(options);
  AddRules(options);
  AddDisturbances(options);
}

GeneratorSettings SettingsFrom(const Arguments& arguments, const GeneratorSettings& base,
                               bool may_be_rows) {
  const auto scale = arguments.Get<double>("scale");
  GeneratorSettings settings = Scaled(base, scale);
  if (scale != 1) settings.name += fmt::format("_x{}", scale);
  arguments.Read("name", &settings.name);
  ReadArea(arguments, &settings);
  arguments.Read("uavs", &settings.uavs);
  arguments.Read("workers", &settings.workers);
  arguments.Read("vehicles", &settings.vehicles);
  arguments.Read("tasks", &settings.tasks);
  arguments.Read("charging-points", &settings.charging_points);
  ReadRange(arguments, "online-min", 0, kMaxMinutes, true, &settings.online_min);
  ReadRange(arguments, "task-cost-km", 0, 1e6, false, &settings.task_cost_km);
  ReadRange(arguments, "charge-km-per-min", 1e-3, 1e6, false, &settings.charge_km_per_min);
  ReadRange(arguments, "start-fraction", 0, 1, false, &settings.start_fraction);
  if (arguments.Get("capacity") == "none") {
    settings.capacity = std::nullopt;
  } else {
    arguments.Read("capacity", &settings.capacity);
  }
  arguments.Read("uav-speed-km-per-min", &settings.uav_speed_km_per_min);
  arguments.Read("worker-speed-km-per-min", &settings.worker_speed_km_per_min);
  arguments.Read("vehicle-speed-km-per-min", &settings.vehicle_speed_km_per_min);
  arguments.Read("full-range-km", &settings.full_range_km);
  if (arguments.Get("placement") == "continuous") settings.placement = Placement::kContinuous;
  if (arguments.Get("uptime") == "any") settings.uptime = Uptime::kAnyTime;
  ReadArrivals(arguments, may_be_rows, &settings);
  ReadPriorities(arguments, &settings);
  ReadDelays(arguments, "due", &settings.due_min);
  ReadDelays(arguments, "expires", &settings.expires_min);
  Rules& rules = settings.rules;
  if (arguments.Has("interval")) rules.interval_us = ToUs(arguments.Get<double>("interval") * 60);
  if (arguments.Has("limit")) rules.limit_us = ToUs(arguments.Get<double>("limit") * 60);
  if (arguments.Has("tick")) rules.tick_us = ToUs(arguments.Get<double>("tick"));
  if (arguments.Get("availability") == "overrun") rules.availability = Availability::kOverrun;
  rules.ceil_to_minutes = arguments.Has("ceil-to-minutes");
  rules.mean_over_all = arguments.Has("mean-over-all");
  rules.start_on_meeting = arguments.Has("start-on-meeting");
  Disturbances& disturbances = settings.disturbances;
  ReadInterval(arguments, "wind", 1000, 1, &disturbances.wind);
  ReadInterval(arguments, "communication-km", 1e6, 1000, &disturbances.communication_m);
  ReadInterval(arguments, "agent-failure", 1, 1, &disturbances.agent_failure);
  ReadInterval(arguments, "match-failure", 1, 1, &disturbances.match_failure);
  return settings;
}

void WriteScenario(const Scenario& scenario, const Arguments& arguments) {
  ValidateScenario(scenario, "scenario");
  if (arguments.Has("out")) return WriteScenarioFile(scenario, arguments.Get("out"));
  if (scenario.roads) {
    throw InputError(
        "muster: --out: found none, expected a file: a road file is written beside it");
  }
  fmt::print("{}", ScenarioToJson(scenario));
}

}  // namespace muster::tools
