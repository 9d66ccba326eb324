#include "tools/scenario/import.h"
#include "tools/map/local_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "model/scenario_json.h"
#include "tools/scenario/window.h"

namespace muster::tools {
namespace {

constexpr TimeUs kDayUs = 24 * 60 * kMinuteUs;
/// The busiest period starts at a multiple of this.
constexpr TimeUs kStartStepUs = 10 * kMinuteUs;

const std::vector<std::string> kLatitudeNames = {
    "latitude", "lat", "start_lat", "start_latitude", "pickup_latitude", "y"};
const std::vector<std::string> kLongitudeNames = {
    "longitude",        "lon", "lng", "long", "start_lng", "start_lon", "start_longitude",
    "pickup_longitude", "x"};
const std::vector<std::string> kTimeNames = {
    "time",       "timestamp", "datetime",        "date",        "incident_date", "started_at",
    "start_time", "stime",     "pickup_datetime", "created_at",  "unix_time",     "epoch",
    "received",   "reported",  "received_at",     "reported_at", "call_time",     "occurred_at"};

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
  int row, column;        ///< of the 1 km cell
  std::size_t table_row;  ///< in the table
  TimeUs since_us = 0;    ///< the start of the mission's period of the day
};

struct Cell {
  int row, column;
  std::size_t count;
  bool is_taken = false;  ///< by a task
};
using CellPlace = std::pair<int, int>;             // row, column
using DayOfClocks = std::pair<std::int64_t, int>;  // since 1970; minutes east of UTC

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
    const std::set<CellPlace> task_cells =
        request_.are_reports ? MakeReportedTasks(&scenario) : MakeCellTasks(&scenario);
    if (request_.depots.empty()) {
      MakeChargingPoints(task_cells, &scenario);
    } else {
      TakeDepots(&scenario);
    }
    if (request_.fleet.empty()) {
      MakeAgents(&scenario);
    } else {
      TakeFleet(&scenario);
    }
    scenario.start = start_moment_;
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
    bool shrunk = false;
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
      shrunk = request_.may_shrink && Shrink(places, count == places.at.size());
    }
    Say("window: {} km east x {} km north, south-west corner {:.6f}, {:.6f} ({}): {} of {} places",
        settings_.width_km, settings_.height_km, corner_.latitude_deg, corner_.longitude_deg,
        request_.window ? "as given"
        : shrunk        ? count == places.at.size() ? "around all places"
                                                    : "the densest, and around fleet and depots"
                        : "the densest",
        count, places.at.size());
  }

  /// The places that the area has to hold beside those of the table.
  std::vector<Origin> OwnPlaces() const {
    std::vector<Origin> places;
    for (const FleetAgent& agent : request_.fleet) places.push_back(agent.place);
    for (const Depot& depot : request_.depots) places.push_back(depot.place);
    return places;
  }

  /// Takes whole kilometres around fleet, depots and the window's places, half a kilometre or more
  /// on each side. `all`: the window holds all places of the table. False: it stays as it is.
  bool Shrink(const Places& places, bool all) {
    const std::vector<Point> own = Project(OwnPlaces(), corner_);
    if (own.empty() && !all) return false;
    Point low{1e9, 1e9}, high{-1e9, -1e9};
    const auto hold = [&](Point p) {
      low = {std::min(low.x_m, p.x_m), std::min(low.y_m, p.y_m)};
      high = {std::max(high.x_m, p.x_m), std::max(high.y_m, p.y_m)};
    };
    for (const Point& p : Project(places.at, corner_)) {
      if (Inside(p)) hold(p);
    }
    for (const Point& p : own) hold(p);
    const auto side_km = [](double extent_m) {
      return std::max(std::ceil(extent_m / 1000) + 1, 2.0);
    };
    const double width_km = side_km(high.x_m - low.x_m), height_km = side_km(high.y_m - low.y_m);
    constexpr double kWidestKm = 200;  // with a fleet that is further away something is wrong
    if (width_km > kWidestKm || height_km > kWidestKm) return false;
    if (own.empty() && (width_km >= settings_.width_km || height_km >= settings_.height_km)) {
      return false;
    }
    const Point corner{(low.x_m + high.x_m - KmToM(width_km)) / 2,
                       (low.y_m + high.y_m - KmToM(height_km)) / 2};
    corner_ = RoundToMicrodegrees(LocalFrame(corner_).ToPlace(corner));
    settings_.width_km = width_km;
    settings_.height_km = height_km;
    return true;
  }

  /// The place on the map of what the user has. Throws InputError where it is outside the area.
  Point OnMap(Origin place, const std::string& what) const {
    const Point at = Project({place}, corner_).front();
    if (Inside(at)) return at;
    throw InputError(what, "place",
                     fmt::format("{:.6f}, {:.6f}", place.latitude_deg, place.longitude_deg),
                     fmt::format("a place in the area, {} by {} km (--area or --window makes it "
                                 "larger)",
                                 settings_.width_km, settings_.height_km));
  }

  void TakeDepots(Scenario* scenario) {
    for (const Depot& depot : request_.depots) {
      const std::string what = fmt::format("depot {}", scenario->charging_points.size());
      scenario->charging_points.push_back({OnMap(depot.place, what), depot.capacity});
    }
    Say("charging points: {} depots", request_.depots.size());
  }

  void TakeFleet(Scenario* scenario) {
    for (const FleetAgent& agent : request_.fleet) {
      auto& agents = ByKind(agent.kind, scenario->uavs, scenario->workers, scenario->vehicles);
      AgentSpec spec = agent.spec;
      spec.at = OnMap(agent.place, fmt::format("{}:{}", ToString(agent.kind), agents.size()));
      agents.push_back(spec);
    }
    Say("agents: {} UAVs, {} workers, {} vehicles of the fleet", scenario->uavs.size(),
        scenario->workers.size(), scenario->vehicles.size());
  }

  bool Inside(Point p) const {
    return InWindow(p, KmToM(settings_.width_km), KmToM(settings_.height_km));
  }

  /// Rows of a role that are in the window, in the table's order.
  std::vector<Record> RecordsOf(const ImportRole& role) const {
    const Places places = PlacesOf(role.at.value_or(own_), role.where);
    const std::vector<Point> points = Project(places.at, corner_);
    std::vector<Record> records;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!Inside(points[i])) continue;
      records.push_back({points[i], static_cast<int>(points[i].y_m / kCellM),
                         static_cast<int>(points[i].x_m / kCellM), places.rows[i]});
    }
    return records;
  }

  /// The cells that hold records, most records first.
  std::vector<Cell> CellsOf(const std::vector<Record>& records, std::string_view what,
                            const ImportRole& role) const {
    std::map<CellPlace, std::size_t> counts;
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

  Point CentreOf(int row, int column) const {
    return CellCentre(column, row, KmToM(settings_.width_km), KmToM(settings_.height_km));
  }

  Point PlaceOf(const Record& record) const {
    return settings_.placement == Placement::kContinuous
               ? Point{std::floor(record.at.x_m), std::floor(record.at.y_m)}
               : CentreOf(record.row, record.column);
  }

  std::optional<std::size_t> ColumnOf(const std::optional<std::string>& name) const {
    return name ? std::optional(table_.Column(*name)) : std::nullopt;
  }

  /// What the row's field says; none where it is blank or there is no such column.
  std::optional<Priority> PriorityOfRow(std::size_t row) const {
    const auto column = ColumnOf(request_.priority);
    if (!column || IsBlank(table_.rows[row][*column])) return std::nullopt;
    const auto priority = PriorityOf(table_.rows[row][*column]);
    if (!priority) {
      throw InputError(table_.file,
                       fmt::format("{}, column {}", table_.RowName(row), *request_.priority),
                       fmt::format("'{}'", Printable(table_.rows[row][*column])),
                       "a priority: 0 to 3, or low, normal, high or emergency");
    }
    return priority;
  }

  /// A task of that row's words, with the rest drawn.
  Task TaskOf(std::size_t row, Point at, std::size_t id) const {
    const auto text = [&](const std::optional<std::string>& name) {
      const auto column = ColumnOf(name);
      if (!column || IsBlank(table_.rows[row][*column])) return std::string();
      return std::string(Trim(table_.rows[row][*column]));
    };
    Task task;
    task.at = at;
    task.cost_m = DrawTaskCostM(settings_, request_.seed, id);
    task.priority = PriorityOfRow(row).value_or(DrawPriority(settings_, request_.seed, id));
    task.reported_us = DrawReport(settings_, request_.seed, id);
    task.name = text(request_.task_name);
    task.external_id = text(request_.external_id);
    task.note = FirstBytes(text(request_.task_note), kMostNote);
    return task;
  }

  /// Returns the cells of the tasks, as does MakeReportedTasks.
  std::set<CellPlace> MakeCellTasks(Scenario* scenario) {
    const std::vector<Record> records = RecordsOf(request_.tasks);
    std::vector<Cell> cells = CellsOf(records, "tasks", request_.tasks);
    const std::size_t all_cells = cells.size();
    cells.resize(std::min(all_cells, static_cast<std::size_t>(settings_.tasks)));
    struct Told {
      int urgency;
      std::size_t row;
    };
    std::map<CellPlace, Told> told;  // by which row
    for (const Record& record : records) {
      const auto priority = PriorityOfRow(record.table_row);
      const Told by = {priority ? static_cast<int>(*priority) : -1, record.table_row};
      const auto [at, is_new] = told.try_emplace({record.row, record.column}, by);
      if (!is_new && by.urgency > at->second.urgency) at->second = by;
    }
    std::set<CellPlace> places;
    for (const Cell& cell : cells) {
      const std::size_t id = scenario->tasks.size();
      const CellPlace place = {cell.row, cell.column};
      Task& task = scenario->tasks.emplace_back(
          TaskOf(told.at(place).row, CentreOf(cell.row, cell.column), id));
      DrawDeadlines(settings_, request_.seed, id, &task);
      places.insert(place);
    }
    Say("tasks: {} of {} wanted, cells with {} to {} rows; {} rows{}{} are in {} cells",
        cells.size(), settings_.tasks, cells.front().count, cells.back().count, records.size(),
        Shown(request_.tasks.where), PlaceNames(request_.tasks), all_cells);
    return places;
  }

  std::set<CellPlace> MakeReportedTasks(Scenario* scenario) {
    std::vector<Record> records = RecordsOf(request_.tasks);
    for (const Record& record : records) PriorityOfRow(record.table_row);  // throws
    if (!KeepPeriod("times of tasks", &records)) {
      throw InputError(table_.file, "columns", fmt::format("{}", fmt::join(table_.columns, ", ")),
                       "a time that can be read, for the reports (name its column with --time)");
    }
    if (records.empty()) {
      throw InputError(table_.file, "rows",
                       fmt::format("none in the window and the mission's period of the day for the "
                                   "tasks{}",
                                   Shown(request_.tasks.where)),
                       "at least one");
    }
    const std::size_t all_rows = records.size();
    std::vector<std::pair<double, std::size_t>> ranks;
    for (std::size_t i = 0; i < records.size(); ++i) {
      ranks.emplace_back(DrawTaskRank(request_.seed, records[i].table_row), i);
    }
    std::sort(ranks.begin(), ranks.end());
    ranks.resize(std::min(all_rows, static_cast<std::size_t>(settings_.tasks)));
    std::sort(ranks.begin(), ranks.end(), [&](const auto& a, const auto& b) {
      return std::pair(records[a.second].since_us, a.second) <
             std::pair(records[b.second].since_us, b.second);
    });
    std::set<CellPlace> places;
    for (const auto& [rank, i] : ranks) {
      const std::size_t id = scenario->tasks.size();
      const Record& record = records[i];
      Task& task = scenario->tasks.emplace_back(TaskOf(record.table_row, PlaceOf(record), id));
      task.reported_us = record.since_us / kOnlineStepUs * kOnlineStepUs;
      DrawDeadlines(settings_, request_.seed, id, &task);
      places.insert({record.row, record.column});
    }
    Say("tasks: {} of {} wanted, each one of {} rows{}{}, reported at its time; in {} cells",
        ranks.size(), settings_.tasks, all_rows, Shown(request_.tasks.where),
        PlaceNames(request_.tasks), places.size());
    return places;
  }

  void MakeChargingPoints(const std::set<CellPlace>& task_cells, Scenario* scenario) {
    const std::vector<Record> records = RecordsOf(request_.charging);
    std::vector<Cell> cells = CellsOf(records, "charging points", request_.charging);
    for (Cell& cell : cells) cell.is_taken = task_cells.contains({cell.row, cell.column});
    std::stable_partition(cells.begin(), cells.end(),
                          [](const Cell& cell) { return !cell.is_taken; });
    const std::size_t all_cells = cells.size();
    cells.resize(std::min(all_cells, static_cast<std::size_t>(settings_.charging_points)));
    for (const Cell& cell : cells) {
      scenario->charging_points.push_back({CentreOf(cell.row, cell.column), settings_.capacity});
    }
    Say("charging points: {} of {} wanted, {} in cells of tasks; {} rows{}{} are in {} cells",
        cells.size(), settings_.charging_points,
        std::count_if(cells.begin(), cells.end(), [](const Cell& cell) { return cell.is_taken; }),
        records.size(), Shown(request_.charging.where), PlaceNames(request_.charging), all_cells);
  }

  /// Leaves the records of the mission's period of the day, with their time in it; returns whether
  /// times are used. The first call chooses the period. `what`: for the summary.
  bool KeepPeriod(std::string_view what, std::vector<Record>* records) {
    std::optional<std::string> name = request_.time;
    if (!name) name = table_.FirstOf(kTimeNames);
    if (!name || name->empty()) {
      Say("times: none; uptimes are drawn");
      return false;
    }
    const std::size_t column = table_.Column(*name);
    DateOrderFinder dates;
    for (const auto& row : table_.rows) dates.Look(row[column]);
    std::vector<std::optional<FieldTime>> times;
    std::vector<std::size_t> steps(kDayUs / kStartStepUs);
    std::size_t readable = 0;
    for (const Record& record : *records) {
      times.push_back(ReadTime(table_.rows[record.table_row][column], dates.order()));
      if (!times.back()) continue;
      if (request_.offset_min) times.back() = times.back()->On(*request_.offset_min);
      ++readable;
      ++steps[static_cast<std::size_t>(times.back()->of_day_us / kStartStepUs)];
    }
    if (readable == 0) {
      if (request_.time) {
        throw InputError(table_.file, *name, "no time of day in any row",
                         "clock times (H:MM, H:MM:SS.fff), ISO 8601, Unix seconds or ms");
      }
      Say("times: none that can be read in {}; uptimes are drawn", *name);
      return false;
    }
    const TimeUs limit_us = std::min(settings_.rules.limit_us, kDayUs);
    if (!start_us_) {
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
          start_us_ = static_cast<TimeUs>(i) * kStartStepUs;
        }
      }
    }
    const bool is_first = !std::exchange(has_period_, true);
    std::vector<Record> kept;
    std::map<DayOfClocks, std::size_t> days;
    for (std::size_t i = 0; i < records->size(); ++i) {
      if (!times[i]) continue;
      const TimeUs of_day_us = times[i]->of_day_us;
      const TimeUs since_us = (of_day_us - *start_us_ + kDayUs) % kDayUs;
      if (since_us >= limit_us) continue;
      kept.emplace_back((*records)[i]).since_us = since_us;
      const auto offset_min = times[i]->offset_min ? times[i]->offset_min : request_.offset_min;
      if (!times[i]->day || !offset_min) continue;
      ++days[{*times[i]->day - (of_day_us < *start_us_ ? 1 : 0), *offset_min}];
    }
    Say("{}: {}, time of day; the mission is {}-{} ({}): {} of {} rows, {} without a time", what,
        *name, Clock(*start_us_), Clock(*start_us_ + limit_us),
        request_.start ? "as given" : "the busiest", kept.size(), records->size(),
        records->size() - readable);
    if (is_first && !start_moment_) TakeDay(days);
    *records = std::move(kept);
    return true;
  }

  /// The mission begins on the day that has most of its rows.
  void TakeDay(const std::map<DayOfClocks, std::size_t>& days) {
    const auto best = std::max_element(
        days.begin(), days.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    if (best == days.end()) {
      if (request_.offset_min)
        Say("start: unknown, because the times have no date that can be read");
      return;
    }
    const auto [day, offset_min] = best->first;
    const std::int64_t unix_us = day * kDayUs + *start_us_ - offset_min * kMinuteUs;
    start_moment_ = ParseMoment(MomentText(unix_us, offset_min));
    if (!start_moment_) return;  // of no sane year
    Say("start: {}, the day with most of these rows: {}", start_moment_->text, best->second);
  }

  void MakeAgents(Scenario* scenario) {
    std::vector<Record> records = RecordsOf(request_.agents);
    const bool has_times = KeepPeriod(request_.are_reports ? "times of agents" : "times", &records);
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
        agent.at = PlaceOf(record);
        if (has_times) {
          const TimeUs online_us = agent.online_until_us - agent.online_from_us;
          const TimeUs limit_us = settings_.rules.limit_us;
          const TimeUs latest_us = settings_.uptime == Uptime::kAnyTime
                                       ? limit_us
                                       : std::max<TimeUs>(0, limit_us - online_us);
          const double part = static_cast<double>(record.since_us) /
                              static_cast<double>(std::min(limit_us, kDayUs));
          const TimeUs steps = latest_us / kOnlineStepUs;
          agent.online_from_us =
              static_cast<TimeUs>(part * static_cast<double>(steps)) * kOnlineStepUs;
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
  std::optional<TimeUs> start_us_ = request_.start;  ///< time of day, once it is known
  std::optional<Moment> start_moment_ = request_.start_moment;
  bool has_period_ = false;
  std::vector<std::string> summary_;
};

}  // namespace

ImportResult Import(const Table& table, const ImportRequest& request) {
  return Importer(table, request).Run();
}

}  // namespace muster::tools
