#include "tools/scenario/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "base/check.h"
#include "base/text.h"
#include "model/scenario_json.h"
#include "tools/scenario/window.h"

namespace muster::tools {
namespace {

constexpr TimeUs kHourUs = 60 * kMinuteUs;
constexpr TimeUs kDayUs = 24 * kHourUs;
/// The busiest period starts at a multiple of this.
constexpr TimeUs kStartStepUs = 10 * kMinuteUs;

const std::vector<std::string> kLatitudeNames = {
    "latitude", "lat", "start_lat", "start_latitude", "pickup_latitude", "y"};
const std::vector<std::string> kLongitudeNames = {
    "longitude",        "lon", "lng", "long", "start_lng", "start_lon", "start_longitude",
    "pickup_longitude", "x"};
const std::vector<std::string> kTimeNames = {
    "time",       "timestamp", "datetime",        "date",      "incident_date", "started_at",
    "start_time", "stime",     "pickup_datetime", "created_at"};

std::string_view Trim(std::string_view text) {
  const auto blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

bool IsBlank(std::string_view field) {
  std::string upper(Trim(field));
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return upper.empty() || upper == "NA" || upper == "N/A" || upper == "NAN" || upper == "NULL";
}

/// Degrees in [-limit, limit]; none otherwise.
std::optional<double> Degrees(std::string_view field, double limit) {
  field = Trim(field);
  if (field.starts_with('+')) field.remove_prefix(1);
  const auto value = ToNumber(field);
  return value && std::abs(*value) <= limit ? value : std::nullopt;
}

std::string Shown(const std::vector<RowFilter>& filters) {
  std::string text;
  for (const RowFilter& filter : filters) {
    text += fmt::format("{}{}={}", text.empty() ? " with " : " and ", filter.column,
                        fmt::join(filter.patterns, ","));
  }
  return text;
}

std::string Clock(TimeUs t) {
  const TimeUs minutes = t / kMinuteUs % (24 * 60);
  return fmt::format("{:02}:{:02}", minutes / 60, minutes % 60);
}

/// Rows with a usable place.
struct Places {
  std::vector<std::size_t> rows;
  std::vector<Origin> at;
  std::size_t filtered = 0, blank = 0, unreadable = 0;
};

/// Rows whose place is in the window.
struct Record {
  Point at;
  int row, column;  ///< of the 1 km cell
  double part = 0;  ///< of the mission's period of the day, in [0, 1)
};

struct Cell {
  int row, column;
  std::size_t count;
  bool is_taken = false;  ///< by a task
};

class Importer {
 public:
  Importer(const Table& table, const ImportRequest& request)
      : table_(table), request_(request), settings_(request.settings) {}

  ImportResult Run() {
    const std::string latitude = ColumnName(request_.latitude, kLatitudeNames, "latitude", "--lat");
    const std::string longitude =
        ColumnName(request_.longitude, kLongitudeNames, "longitude", "--lon");
    own_ = {latitude, longitude};
    const Places places = PlacesOf(own_, {});
    Say("{}: {} rows{}; place: {}, {}", table_.file, table_.rows.size(),
        table_.not_points > 0
            ? fmt::format(" and {} features that are no points, left out", table_.not_points)
            : "",
        latitude, longitude);
    SayLeftOut(places);
    if (places.at.empty()) {
      throw InputError(table_.file, "rows", "no usable place" + Shown(request_.where),
                       "at least one");
    }
    ChooseWindow(places);

    ImportResult result;
    Scenario& scenario = result.scenario;
    scenario.name = settings_.name;
    scenario.seed = request_.seed;
    scenario.width_m = KmToM(settings_.width_km);
    scenario.height_m = KmToM(settings_.height_km);
    scenario.origin = corner_;
    scenario.rules = settings_.rules;
    scenario.disturbances = settings_.disturbances;
    MakeSites(&scenario);
    MakeAgents(&scenario);
    ValidateScenario(scenario, table_.file);
    result.summary = std::move(summary_);
    return result;
  }

 private:
  using Columns = std::pair<std::string, std::string>;

  template <class... Args>
  void Say(fmt::format_string<Args...> format, Args&&... args) {
    summary_.push_back(fmt::format(format, std::forward<Args>(args)...));
  }

  std::string ColumnName(const std::optional<std::string>& given,
                         const std::vector<std::string>& names, std::string_view what,
                         std::string_view flag) const {
    if (given) return *given;
    if (const auto found = table_.FirstOf(names)) return *found;
    throw InputError(table_.file, "columns", fmt::format("{}", fmt::join(table_.columns, ", ")),
                     fmt::format("a {} (name its column with {})", what, flag));
  }

  bool Keeps(std::size_t row, const std::vector<RowFilter>& filters) const {
    return std::all_of(filters.begin(), filters.end(), [&](const RowFilter& filter) {
      return filter.Matches(table_.rows[row][table_.Column(filter.column)]);
    });
  }

  Places PlacesOf(const Columns& columns, const std::vector<RowFilter>& filters) const {
    const std::size_t latitude = table_.Column(columns.first);
    const std::size_t longitude = table_.Column(columns.second);
    Places places;
    for (std::size_t i = 0; i < table_.rows.size(); ++i) {
      if (!Keeps(i, request_.where) || !Keeps(i, filters)) {
        ++places.filtered;
        continue;
      }
      const std::vector<std::string>& row = table_.rows[i];
      if (IsBlank(row[latitude]) || IsBlank(row[longitude])) {
        ++places.blank;
        continue;
      }
      const auto north = Degrees(row[latitude], 90);
      const auto east = Degrees(row[longitude], 180);
      if (!north || !east) {
        ++places.unreadable;
        continue;
      }
      places.rows.push_back(i);
      places.at.push_back({*north, *east});
    }
    return places;
  }

  void SayLeftOut(const Places& places) {
    if (places.filtered > 0) Say("  {} rows not{}", places.filtered, Shown(request_.where));
    if (places.blank > 0) Say("  {} rows left out: no place (NA or blank)", places.blank);
    if (places.unreadable > 0) {
      Say("  {} rows left out: a place that is no degrees", places.unreadable);
    }
  }

  void ChooseWindow(const Places& places) {
    std::size_t count = 0;
    if (request_.window) {
      corner_ = request_.window->corner;
      settings_.width_km = request_.window->width_km;
      settings_.height_km = request_.window->height_km;
      for (const Point& p : Project(places.at, corner_)) count += Inside(p) ? 1 : 0;
    } else {
      Window best = DensestWindow(places.at, KmToM(settings_.width_km), KmToM(settings_.height_km));
      if (request_.may_turn && settings_.width_km != settings_.height_km) {
        const Window turned =
            DensestWindow(places.at, KmToM(settings_.height_km), KmToM(settings_.width_km));
        if (turned.count > best.count) {
          best = turned;
          std::swap(settings_.width_km, settings_.height_km);
        }
      }
      corner_ = best.corner;
      count = best.count;
    }
    Say("window: {} km east x {} km north, south-west corner {:.6f}, {:.6f} ({}): {} of {} places",
        settings_.width_km, settings_.height_km, corner_.latitude_deg, corner_.longitude_deg,
        request_.window ? "as given" : "the densest", count, places.at.size());
  }

  bool Inside(Point p) const {
    return InWindow(p, KmToM(settings_.width_km), KmToM(settings_.height_km));
  }

  /// Rows of a role that are in the window, in the table's order.
  std::vector<Record> RecordsOf(const ImportRole& role, std::vector<std::size_t>* rows) const {
    const Places places = PlacesOf(role.at.value_or(own_), role.where);
    const std::vector<Point> points = Project(places.at, corner_);
    std::vector<Record> records;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!Inside(points[i])) continue;
      records.push_back({points[i], static_cast<int>(points[i].y_m / kCellM),
                         static_cast<int>(points[i].x_m / kCellM)});
      if (rows != nullptr) rows->push_back(places.rows[i]);
    }
    return records;
  }

  /// The cells that hold records, most records first.
  std::vector<Cell> CellsOf(const std::vector<Record>& records, std::string_view what,
                            const ImportRole& role) const {
    std::map<std::pair<int, int>, std::size_t> counts;
    for (const Record& record : records) ++counts[{record.row, record.column}];
    if (counts.empty()) {
      throw InputError(table_.file, "rows",
                       fmt::format("none in the window for the {}{}", what, Shown(role.where)),
                       "at least one");
    }
    std::vector<Cell> cells;
    for (const auto& [at, count] : counts) cells.push_back({at.first, at.second, count});
    std::stable_sort(cells.begin(), cells.end(),
                     [](const Cell& a, const Cell& b) { return a.count > b.count; });
    return cells;
  }

  std::string PlaceNames(const ImportRole& role) const {
    return role.at ? fmt::format(" at {}, {}", role.at->first, role.at->second) : "";
  }

  void MakeSites(Scenario* scenario) {
    const auto centre = [&](const Cell& cell) {
      return CellCentre(cell.column, cell.row, scenario->width_m, scenario->height_m);
    };
    const std::vector<Record> task_records = RecordsOf(request_.tasks, nullptr);
    std::vector<Cell> tasks = CellsOf(task_records, "tasks", request_.tasks);
    const std::size_t task_cells = tasks.size();
    tasks.resize(std::min(task_cells, static_cast<std::size_t>(settings_.tasks)));
    for (const Cell& cell : tasks) {
      const std::size_t id = scenario->tasks.size();
      scenario->tasks.push_back({centre(cell), DrawTaskCostM(settings_, request_.seed, id)});
    }
    Say("tasks: {} of {} wanted, cells with {} to {} rows; {} rows{}{} are in {} cells",
        tasks.size(), settings_.tasks, tasks.front().count, tasks.back().count, task_records.size(),
        Shown(request_.tasks.where), PlaceNames(request_.tasks), task_cells);

    const std::vector<Record> charge_records = RecordsOf(request_.charging, nullptr);
    std::vector<Cell> charging = CellsOf(charge_records, "charging points", request_.charging);
    for (Cell& cell : charging) {
      cell.is_taken = std::any_of(tasks.begin(), tasks.end(), [&](const Cell& task) {
        return task.row == cell.row && task.column == cell.column;
      });
    }
    std::stable_partition(charging.begin(), charging.end(),
                          [](const Cell& cell) { return !cell.is_taken; });
    const std::size_t charging_cells = charging.size();
    charging.resize(std::min(charging_cells, static_cast<std::size_t>(settings_.charging_points)));
    for (const Cell& cell : charging) {
      scenario->charging_points.push_back({centre(cell), settings_.capacity});
    }
    Say("charging points: {} of {} wanted, {} in cells of tasks; {} rows{}{} are in {} cells",
        charging.size(), settings_.charging_points,
        std::count_if(charging.begin(), charging.end(),
                      [](const Cell& cell) { return cell.is_taken; }),
        charge_records.size(), Shown(request_.charging.where), PlaceNames(request_.charging),
        charging_cells);
  }

  /// Leaves the records of the mission's period of the day, with their part of it; returns whether
  /// times are used.
  bool KeepPeriod(std::vector<Record>* records, const std::vector<std::size_t>& rows) {
    std::optional<std::string> name = request_.time;
    if (!name) name = table_.FirstOf(kTimeNames);
    if (!name || name->empty()) {
      Say("times: none; uptimes are drawn");
      return false;
    }
    const std::size_t column = table_.Column(*name);
    std::vector<std::optional<TimeUs>> times;
    std::vector<std::size_t> steps(kDayUs / kStartStepUs);
    std::size_t readable = 0;
    for (const std::size_t row : rows) {
      times.push_back(TimeOfDay(table_.rows[row][column]));
      if (!times.back()) continue;
      ++readable;
      ++steps[static_cast<std::size_t>(*times.back() / kStartStepUs)];
    }
    if (readable == 0) {
      if (request_.time) {
        throw InputError(table_.file, *name, "no time of day in any row",
                         "H:MM, H:MM:SS or H:MM:SS.fff");
      }
      Say("times: none that can be read in {}; uptimes are drawn", *name);
      return false;
    }
    const TimeUs limit_us = std::min(settings_.rules.limit_us, kDayUs);
    TimeUs start_us = request_.start.value_or(0);
    if (!request_.start) {
      // The most records in whole steps; the last step counts as far as it is covered.
      double most = -1;
      for (std::size_t i = 0; i < steps.size(); ++i) {
        double count = 0;
        for (TimeUs t = 0; t < limit_us; t += kStartStepUs) {
          const double covered =
              static_cast<double>(std::min(kStartStepUs, limit_us - t)) / kStartStepUs;
          count +=
              covered * static_cast<double>(
                            steps[(i + static_cast<std::size_t>(t / kStartStepUs)) % steps.size()]);
        }
        if (count > most) {
          most = count;
          start_us = static_cast<TimeUs>(i) * kStartStepUs;
        }
      }
    }
    std::vector<Record> kept;
    for (std::size_t i = 0; i < records->size(); ++i) {
      if (!times[i]) continue;
      const TimeUs since_us = (*times[i] - start_us + kDayUs) % kDayUs;
      if (since_us >= limit_us) continue;
      Record& record = kept.emplace_back((*records)[i]);
      record.part = static_cast<double>(since_us) / static_cast<double>(limit_us);
    }
    Say("times: {}, time of day; the mission is {}-{} ({}): {} of {} rows, {} without a time",
        *name, Clock(start_us), Clock(start_us + limit_us),
        request_.start ? "as given" : "the busiest", kept.size(), records->size(),
        records->size() - readable);
    *records = std::move(kept);
    return true;
  }

  void MakeAgents(Scenario* scenario) {
    std::vector<std::size_t> rows;
    std::vector<Record> records = RecordsOf(request_.agents, &rows);
    const bool has_times = KeepPeriod(&records, rows);
    if (records.empty()) {
      throw InputError(table_.file, "rows",
                       fmt::format("none in the window{} for the agents{}",
                                   has_times ? " and the mission's period of the day" : "",
                                   Shown(request_.agents.where)),
                       "at least one");
    }
    const auto make = [&](AgentKind kind, int count, std::vector<AgentSpec>* agents) {
      for (int i = 0; i < count; ++i) {
        const auto id = static_cast<std::size_t>(i);
        AgentSpec agent = DrawAgent(settings_, request_.seed, kind, id);
        const Record& record = records[DrawRecord(request_.seed, kind, id, records.size())];
        agent.at =
            settings_.placement == Placement::kContinuous
                ? Point{std::floor(record.at.x_m), std::floor(record.at.y_m)}
                : CellCentre(record.column, record.row, scenario->width_m, scenario->height_m);
        if (has_times) {
          const TimeUs online_us = agent.online_until_us - agent.online_from_us;
          const TimeUs limit_us = settings_.rules.limit_us;
          const TimeUs latest_us = settings_.uptime == Uptime::kAnyTime
                                       ? limit_us
                                       : std::max<TimeUs>(0, limit_us - online_us);
          agent.online_from_us =
              static_cast<TimeUs>(record.part * static_cast<double>(latest_us / kOnlineStepUs)) *
              kOnlineStepUs;
          agent.online_until_us = agent.online_from_us + online_us;
        }
        agents->push_back(agent);
      }
    };
    make(AgentKind::kUav, settings_.uavs, &scenario->uavs);
    make(AgentKind::kWorker, settings_.workers, &scenario->workers);
    make(AgentKind::kVehicle, settings_.vehicles, &scenario->vehicles);
    Say("agents: {} UAVs, {} workers, {} vehicles, each where one of {} rows{}{} is",
        settings_.uavs, settings_.workers, settings_.vehicles, records.size(),
        Shown(request_.agents.where), PlaceNames(request_.agents));
  }

  const Table& table_;
  const ImportRequest& request_;
  GeneratorSettings settings_;
  Columns own_;
  Origin corner_;
  std::vector<std::string> summary_;
};

}  // namespace

bool RowFilter::Matches(std::string_view field) const {
  for (const std::string& part : Split(field, ';')) {
    const std::string_view code = Trim(part);
    for (const std::string_view pattern : patterns) {
      if (pattern.ends_with('*') ? code.starts_with(pattern.substr(0, pattern.size() - 1))
                                 : code == pattern) {
        return true;
      }
    }
  }
  return false;
}

RowFilter ParseFilter(std::string_view flag, std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == text.npos || equals == 0 || equals + 1 == text.size()) {
    throw InputError("command line", flag, fmt::format("'{}'", text),
                     "COLUMN=VALUE[,VALUE...], a value may end in *");
  }
  return {std::string(text.substr(0, equals)), Split(text.substr(equals + 1), ',')};
}

std::optional<TimeUs> TimeOfDay(std::string_view text) {
  const auto digit = [&](std::size_t i) {
    return i < text.size() && text[i] >= '0' && text[i] <= '9';
  };
  const auto pair = [&](std::size_t i) { return (text[i] - '0') * 10 + (text[i + 1] - '0'); };
  for (std::size_t colon = text.find(':'); colon != text.npos; colon = text.find(':', colon + 1)) {
    if (colon == 0 || !digit(colon - 1) || !digit(colon + 1) || !digit(colon + 2)) continue;
    const bool has_two = colon >= 2 && digit(colon - 2);
    if (has_two && colon >= 3 && digit(colon - 3)) continue;
    int hour = has_two ? pair(colon - 2) : text[colon - 1] - '0';
    const int minute = pair(colon + 1);
    std::size_t at = colon + 3;
    TimeUs second_us = 0;
    if (at < text.size() && text[at] == ':' && digit(at + 1) && digit(at + 2)) {
      second_us = pair(at + 1) * kSecondUs;
      at += 3;
      if (at < text.size() && text[at] == '.') {
        TimeUs unit_us = kSecondUs / 10;
        for (++at; digit(at); ++at, unit_us /= 10) second_us += (text[at] - '0') * unit_us;
      }
    }
    if (digit(at)) continue;
    std::string half(Trim(text.substr(at)).substr(0, 2));
    for (char& c : half) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (half == "AM" || half == "PM") {
      if (hour < 1 || hour > 12) continue;
      hour = hour % 12 + (half == "PM" ? 12 : 0);
    }
    if (hour > 23 || minute > 59 || second_us >= kMinuteUs) continue;
    return hour * kHourUs + minute * kMinuteUs + second_us;
  }
  return std::nullopt;
}

ImportResult Import(const Table& table, const ImportRequest& request) {
  return Importer(table, request).Run();
}

}  // namespace muster::tools
