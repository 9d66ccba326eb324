#include "tools/scenario/settings_options.h"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "base/check.h"
#include "model/scenario_json.h"
#include "tools/files/pending_file.h"

namespace muster::tools {
namespace {

constexpr double kMaxMinutes = 1e6;
constexpr int kMaxCount = 10'000'000;

[[noreturn]] void Fail(std::string_view flag, std::string_view found, std::string_view expected) {
  throw InputError("command line", fmt::format("--{}", flag), fmt::format("'{}'", found), expected);
}

/// One flag of a given name, when it is there.
class Flags {
 public:
  explicit Flags(const cxxopts::ParseResult& flags) : flags_(flags) {}

  const std::string* Text(const std::string& name) const {
    return flags_.count(name) > 0 ? &flags_[name].as<std::string>() : nullptr;
  }

  void Number(const std::string& name, double low, double high, double* to) const {
    const std::string* text = Text(name);
    if (text == nullptr) return;
    const std::string expected = low > 0 ? fmt::format("a number above 0 and at most {}", high)
                                         : fmt::format("a number in [{}, {}]", low, high);
    const double number = ParseNumber(name, *text, expected);
    if (number < low || number > high) Fail(name, *text, expected);
    *to = number;
  }

  void Count(const std::string& name, int* to) const {
    const std::string* text = Text(name);
    if (text == nullptr) return;
    int number = 0;
    const char* end = text->data() + text->size();
    const auto [at, error] = std::from_chars(text->data(), end, number);
    if (error != std::errc() || at != end || number < 1 || number > kMaxCount) {
      Fail(name, *text, fmt::format("an integer in [1, {}]", kMaxCount));
    }
    *to = number;
  }

  /// "A" or "A:B"; with `open_end` also "A:", up to the limit.
  void Range(const std::string& name, double low, double high, bool open_end, DrawRange* to) const {
    const std::string* text = Text(name);
    if (text == nullptr) return;
    const std::string expected =
        fmt::format("A, A:B{} with {} <= A <= B <= {}", open_end ? " or A:" : "", low, high);
    const std::vector<std::string> ends = Split(*text, ':');
    if (ends.size() > 2) Fail(name, *text, expected);
    DrawRange range = Always(ParseNumber(name, ends[0], expected));
    const bool is_open = open_end && ends.size() == 2 && ends[1].empty();
    if (ends.size() == 2) range.high = is_open ? kUpToLimit : ParseNumber(name, ends[1], expected);
    if (range.low < low || range.high < range.low || (range.high > high && !is_open)) {
      Fail(name, *text, expected);
    }
    *to = range;
  }

  void Minutes(const std::string& name, TimeUs* to) const {
    double minutes = 0;
    if (Text(name) == nullptr) return;
    Number(name, 1e-6, kMaxMinutes, &minutes);
    *to = ToUs(minutes * 60);
  }

  void Interval(const std::string& name, double high, double unit,
                Disturbances::Interval* to) const {
    DrawRange range;
    if (Text(name) == nullptr) return;
    Range(name, 0, high, false, &range);
    *to = {range.low * unit, range.high * unit};
  }

  /// True for the second of two words, false for the first.
  bool Second(const std::string& name, std::string_view first, std::string_view second,
              bool otherwise) const {
    const std::string* text = Text(name);
    if (text == nullptr) return otherwise;
    if (*text != first && *text != second)
      Fail(name, *text, fmt::format("{} or {}", first, second));
    return *text == second;
  }

  bool Set(const std::string& name) const { return flags_.count(name) > 0; }

 private:
  const cxxopts::ParseResult& flags_;
};

}  // namespace

std::vector<std::string> Split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t at = 0;;) {
    const std::size_t next = text.find(separator, at);
    parts.emplace_back(text.substr(at, next - at));
    if (next == text.npos) return parts;
    at = next + 1;
  }
}

double ParseNumber(std::string_view flag, std::string_view text, std::string_view expected) {
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || at != end || !std::isfinite(number)) Fail(flag, text, expected);
  return number;
}

void AddSettingsOptions(cxxopts::Options* options) {
  const GeneratorSettings defaults;
  const auto text = [] { return cxxopts::value<std::string>(); };
  const auto with_default = [](const auto& value) {
    return cxxopts::value<std::string>()->default_value(fmt::to_string(value));
  };
  options->add_options()("seed", "Seed of all random draws", with_default(1), "N")(
      "out", "File to write (default: standard output)", text(), "FILE")(
      "name", "Name of the scenario (default: the preset's)", text(), "TEXT");
  options->add_options("Number (default: the preset's; A:B is drawn per item)")(
      "area", "Kilometres east by north", text(), "WxH")("uavs", "UAVs", text(), "N")(
      "workers", "Workers", text(), "N")("vehicles", "Vehicles", text(), "N")(
      "tasks", "Tasks", text(), "N")("charging-points", "Charging points", text(), "N")(
      "online-min", "Minutes that an agent is online; 'A:' is at least A, up to the limit", text(),
      "A[:B]")("task-cost-km", "Range that sensing a task takes, km", text(), "A[:B]")(
      "charge-km-per-min", "Range that a vehicle gives, km per minute", text(), "A[:B]")(
      "capacity", "UAVs that charge at one point at a time, or none for no bound", with_default(1),
      "N")("scale", "Multiply the preset's area and counts, at the same density", with_default(1),
           "S");
  options->add_options("Unpublished setting")("uav-speed-km-per-min", "Speed of UAVs",
                                              with_default(defaults.uav_speed_km_per_min), "V")(
      "worker-speed-km-per-min", "Speed of workers", with_default(defaults.worker_speed_km_per_min),
      "V")("vehicle-speed-km-per-min", "Speed of vehicles",
           with_default(defaults.vehicle_speed_km_per_min),
           "V")("full-range-km", "Range of a full UAV", with_default(defaults.full_range_km), "D")(
      "start-fraction", "Part of the full range that a UAV has at the start",
      with_default(defaults.start_fraction.low), "A[:B]")(
      "placement", "cells: centres of 1 km cells; continuous: any metre", with_default("cells"),
      "HOW")("uptime", "Online from: within: [0, limit - online time]; any: [0, limit]",
             with_default("within"), "HOW");
  options->add_options("Rule")("interval", "Minutes between decisions",
                               with_default(ToMinutes(defaults.rules.interval_us)), "MIN")(
      "limit", "Minutes that the mission lasts", with_default(ToMinutes(defaults.rules.limit_us)),
      "MIN")("tick", "Seconds between ticks; divides the interval",
             with_default(ToSeconds(defaults.rules.tick_us)), "S")(
      "availability", "strict: actions end before downtime; overrun: they may end later",
      with_default("strict"), "HOW")("ceil-to-minutes", "Weights count minutes, not intervals")(
      "mean-over-all", "Eq. 4-5 and 4-7 divide by all idle UAVs")(
      "start-on-meeting", "Agents that meet in a cell start without a pair action");
  options->add_options("Disturbance (off unless given)")(
      "wind", "Extra range per kilometre of a UAV's way", text(), "A[:B]")(
      "communication-km", "Range that an action costs a UAV", text(), "A[:B]")(
      "agent-failure", "Probability that an agent fails at a decision", text(), "A[:B]")(
      "match-failure", "Probability that a pair's match fails", text(), "A[:B]");
}

GeneratorSettings SettingsFrom(const cxxopts::ParseResult& parsed, const GeneratorSettings& base) {
  const Flags flags(parsed);
  double scale = 1;
  flags.Number("scale", 1e-6, 1e6, &scale);
  GeneratorSettings settings = Scaled(base, scale);
  if (scale != 1) settings.name += fmt::format("_x{}", scale);
  if (const std::string* name = flags.Text("name")) settings.name = *name;
  if (const std::string* area = flags.Text("area")) {
    constexpr std::string_view kExpected = "WxH, kilometres above 0, like 30x20";
    const std::vector<std::string> sides = Split(*area, 'x');
    if (sides.size() != 2) Fail("area", *area, kExpected);
    settings.width_km = ParseNumber("area", sides[0], kExpected);
    settings.height_km = ParseNumber("area", sides[1], kExpected);
    if (settings.width_km <= 0 || settings.height_km <= 0) Fail("area", *area, kExpected);
  }
  flags.Count("uavs", &settings.uavs);
  flags.Count("workers", &settings.workers);
  flags.Count("vehicles", &settings.vehicles);
  flags.Count("tasks", &settings.tasks);
  flags.Count("charging-points", &settings.charging_points);
  flags.Range("online-min", 0, kMaxMinutes, true, &settings.online_min);
  flags.Range("task-cost-km", 0, 1e6, false, &settings.task_cost_km);
  flags.Range("charge-km-per-min", 1e-3, 1e6, false, &settings.charge_km_per_min);
  flags.Range("start-fraction", 0, 1, false, &settings.start_fraction);
  if (const std::string* capacity = flags.Text("capacity"); capacity && *capacity == "none") {
    settings.capacity = std::nullopt;
  } else if (capacity != nullptr) {
    flags.Count("capacity", &settings.capacity.emplace());
  }
  flags.Number("uav-speed-km-per-min", 1e-6, 1e6, &settings.uav_speed_km_per_min);
  flags.Number("worker-speed-km-per-min", 1e-6, 1e6, &settings.worker_speed_km_per_min);
  flags.Number("vehicle-speed-km-per-min", 1e-6, 1e6, &settings.vehicle_speed_km_per_min);
  flags.Number("full-range-km", 1e-3, 1e6, &settings.full_range_km);
  if (flags.Second("placement", "cells", "continuous", false)) {
    settings.placement = Placement::kContinuous;
  }
  if (flags.Second("uptime", "within", "any", false)) settings.uptime = Uptime::kAnyTime;
  flags.Minutes("interval", &settings.rules.interval_us);
  flags.Minutes("limit", &settings.rules.limit_us);
  double tick_s = ToSeconds(settings.rules.tick_us);
  flags.Number("tick", 1e-6, kMaxMinutes, &tick_s);
  settings.rules.tick_us = ToUs(tick_s);
  if (flags.Second("availability", "strict", "overrun", false)) {
    settings.rules.availability = Availability::kOverrun;
  }
  settings.rules.ceil_to_minutes = flags.Set("ceil-to-minutes");
  settings.rules.mean_over_all = flags.Set("mean-over-all");
  settings.rules.start_on_meeting = flags.Set("start-on-meeting");
  flags.Interval("wind", 1000, 1, &settings.disturbances.wind);
  flags.Interval("communication-km", 1e6, 1000, &settings.disturbances.communication_m);
  flags.Interval("agent-failure", 1, 1, &settings.disturbances.agent_failure);
  flags.Interval("match-failure", 1, 1, &settings.disturbances.match_failure);
  return settings;
}

std::uint64_t SeedFrom(const cxxopts::ParseResult& flags) {
  const std::string& text = flags["seed"].as<std::string>();
  std::uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, seed);
  if (error != std::errc() || at != end) {
    Fail("seed", text, "an integer in [0, 18446744073709551615]");
  }
  return seed;
}

void WriteScenario(const Scenario& scenario, const cxxopts::ParseResult& flags) {
  ValidateScenario(scenario, "scenario");
  const std::string text = ScenarioToJson(scenario);
  if (flags.count("out") == 0) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() ||
        std::fflush(stdout) != 0) {
      throw SystemError(fmt::format("cannot write to standard output: {}", std::strerror(errno)));
    }
    return;
  }
  WriteFile(flags["out"].as<std::string>(), text);
}

}  // namespace muster::tools
