#include "tools/orders/feed_command.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "base/sha256.h"
#include "base/text.h"
#include "model/scenario_json.h"
#include "tools/files/pending_file.h"
#include "tools/host/stop_signals.h"
#include "tools/orders/alert_feed.h"
#include "tools/orders/order_socket.h"
#include "tools/orders/report_feed.h"
#include "tools/scenario/fields.h"
#include "tools/scenario/order_text.h"
#include "tools/scenario/table.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;
using std::chrono::milliseconds;

constexpr std::size_t kMostOpen = 1000;  ///< orders without an answer at a time
constexpr int kMostShown = 20;           ///< refusals in words
constexpr TimeUs kDayUs = 24 * 60 * kMinuteUs;

/// Which columns say what.
struct Columns {
  std::optional<std::string> latitude, longitude, time, priority, name, external_id, cost;
  std::optional<TimeUs> start;    ///< time of day of the mission's beginning
  std::optional<int> offset_min;  ///< of the clocks that it was read from, where they are known
  std::string source;
};

std::optional<std::string> Find(const Table& table, const std::optional<std::string>& given,
                                const std::vector<std::string>& usual) {
  if (!given) return table.FirstOf(usual);
  table.Column(*given);
  return given;
}

/// Rows as orders that add tasks.
class RowReader {
 public:
  RowReader(const Table& head, Columns columns) : columns_(std::move(columns)) {
    columns_.latitude = Find(head, columns_.latitude, {"latitude", "lat", "y"});
    columns_.longitude = Find(head, columns_.longitude, {"longitude", "lon", "lng", "long", "x"});
    if (!columns_.latitude || !columns_.longitude) {
      throw InputError(head.file, "columns", fmt::format("{}", fmt::join(head.columns, ", ")),
                       "a latitude and a longitude (--lat, --lon)");
    }
    for (auto* column : {&columns_.time, &columns_.priority, &columns_.name, &columns_.external_id,
                         &columns_.cost}) {
      if (*column) head.Column(**column);
    }
    if (columns_.time.has_value() != columns_.start.has_value()) {
      throw InputError("command line", columns_.time ? "--time" : "--start", "alone",
                       columns_.time ? "--start HH:MM, the mission's beginning, as its scenario "
                                       "has no start"
                                     : "--time COLUMN with --start HH:MM");
    }
  }

  /// Throws InputError naming the row.
  Json OrderOf(const Table& table, std::size_t row) const {
    const auto field = [&](const std::optional<std::string>& column) {
      return column ? std::string(Trim(table.rows[row][table.Column(*column)])) : std::string();
    };
    const auto refuse = [&](const std::string& column, const std::string& expected) {
      throw InputError(fmt::format("{}: {}", table.file, table.RowName(row)), column,
                       fmt::format("'{}'", field(column)), expected);
    };
    Json task;
    const auto latitude = Degrees(field(columns_.latitude), 90);
    const auto longitude = Degrees(field(columns_.longitude), 180);
    if (!latitude) refuse(*columns_.latitude, "degrees in [-90, 90]");
    if (!longitude) refuse(*columns_.longitude, "degrees in [-180, 180]");
    task["latitude_deg"] = *latitude;
    task["longitude_deg"] = *longitude;
    if (columns_.time) {
      auto time = ReadTime(field(columns_.time), DateOrder::kUnknown);
      if (!time) refuse(*columns_.time, "a time of day");
      if (columns_.offset_min) time = time->On(*columns_.offset_min);
      // A mission may go over midnight.
      task["reported_min"] = ToMinutes((time->of_day_us - *columns_.start + kDayUs) % kDayUs);
    }
    if (const std::string text = field(columns_.priority); !IsBlank(text)) {
      const auto priority = PriorityOf(text);
      if (!priority) refuse(*columns_.priority, "0 to 3, or low, normal, high or emergency");
      task["priority"] = static_cast<int>(*priority);
    }
    if (const std::string text = field(columns_.cost); !IsBlank(text)) {
      const auto cost = ToNumber(text);
      if (!cost) refuse(*columns_.cost, "km");
      task["cost_km"] = *cost;
    }
    if (const std::string text = field(columns_.name); !text.empty()) task["name"] = text;
    if (const std::string text = field(columns_.external_id); !text.empty()) {
      task["external_id"] = text;
    }
    if (!columns_.source.empty()) task["source"] = columns_.source;
    return {{"id", FreshOrderId()}, {"issuer", "feed"}, {"order", "task_add"}, {"task", task}};
  }

 private:
  Columns columns_;
};

/// Where orders go.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual void Give(const Json& order) = 0;
  /// Hears what has become of some; waits for all when there are no more.
  virtual void Hear(bool all) = 0;
  virtual void Finish() {}
  int taken = 0, refused = 0;

  void Refuse(const std::string& why) {
    if (++refused <= kMostShown) Say("muster: refused: {}\n", why);
    if (refused == kMostShown) Say("muster: further refusals are only counted\n");
  }
};

class MissionSink : public Sink {
 public:
  MissionSink(const std::string& run, const StopSignals& stop) : client_(run), stop_(stop) {}

  void Give(const Json& order) override {
    while (open_ >= kMostOpen && !client_.gone() && stop_.count() == 0) HearOne(milliseconds(200));
    client_.Send(order.dump());
    ++open_;
  }
  void Hear(bool all) override {
    while (HearOne(milliseconds(0))) continue;
    while (all && open_ > 0 && !client_.gone() && stop_.count() == 0) HearOne(milliseconds(200));
    if (client_.gone() && open_ > 0) {
      throw SystemError(fmt::format("the mission has ended; {} orders had no answer", open_));
    }
  }

 private:
  bool HearOne(milliseconds wait) {
    const std::string text = client_.Receive(wait);
    if (text.empty()) return false;
    --open_;
    const Json answer = Json::parse(text);
    if (answer.contains("taken")) {
      ++taken;
    } else {
      Refuse(answer.contains("refused") ? answer["refused"].get<std::string>()
                                        : answer["error"].get<std::string>());
    }
    return true;
  }

  OrderClient client_;
  const StopSignals& stop_;
  std::size_t open_ = 0;
};

class FileSink : public Sink {
 public:
  FileSink(std::string file, const Scenario& scenario)
      : file_(std::move(file)), scenario_(scenario) {}

  void Give(const Json& order) override {
    try {
      const world::PlannedOrder planned = ReadOrder(order.dump(), "order", scenario_.origin);
      Scenario roomy = scenario_;
      AddRoom({1, {1, 1, 1}}, &roomy);
      TakeInto(&roomy, planned.order, 0);
      orders_.push_back(planned);
      // Rows come as they were drawn; the same rows give the same file.
      orders_.back().order.id = fmt::format("feed-{}", orders_.size());
      ++taken;
    } catch (const InputError& error) {
      Refuse(error.what());
    }
  }
  void Hear(bool) override {}
  void Finish() override { WriteFile(file_, OrderLines(orders_)); }

 private:
  const std::string file_;
  const Scenario scenario_;
  std::vector<world::PlannedOrder> orders_;
};

bool IsOrder(const Json& object) { return object.is_object() && object.contains("order"); }

/// One line of a stream: an order, a GeoJSON feature, an object of columns, or a CSV record.
class LineReader {
 public:
  LineReader(std::string file, bool csv, Columns columns)
      : file_(std::move(file)), csv_(csv), columns_(std::move(columns)) {}

  /// None: nothing to give. Throws InputError naming the line.
  std::optional<Json> Read(const std::string& line) {
    ++number_;
    if (Trim(line).empty()) return {};
    const std::string where = fmt::format("{}: line {}", file_, number_);
    if (csv_ && head_.empty()) {
      head_ = line + "\n";
      reader_.emplace(ParseCsv(head_, file_), columns_);
      return {};
    }
    if (csv_) return Row(ParseCsv(head_ + line + "\n", where));
    ParseJson(line, where);  // for its own errors, and for what another parser would let pass
    Json json = Json::parse(line);
    if (!json.is_object()) throw InputError(where, "line", "no JSON object", "an object");
    if (IsOrder(json)) return json;
    if (json.value("type", "") == "Feature") {
      return Row(
          ParseGeoJson(Json{{"type", "FeatureCollection"}, {"features", {json}}}.dump(), where));
    }
    Table table;
    table.file = where;
    table.rows.emplace_back();
    for (const auto& [key, value] : json.items()) {
      table.columns.push_back(key);
      table.rows[0].push_back(value.is_string() ? value.get<std::string>()
                              : value.is_null() ? ""
                                                : value.dump());
    }
    return Row(table);
  }

 private:
  std::optional<Json> Row(const Table& table) {
    if (table.rows.empty()) return {};
    if (!csv_) reader_.emplace(table, columns_);
    return reader_->OrderOf(table, 0);
  }

  const std::string file_;
  const bool csv_;
  const Columns columns_;
  std::string head_;
  std::optional<RowReader> reader_;
  int number_ = 0;
};

/// Gives everything; a line that is no order is one refusal.
template <class Next>
void GiveAll(Next next, Sink* sink, const StopSignals& stop) {
  while (stop.count() == 0) {
    try {
      const std::optional<Json> order = next();
      if (!order) break;
      if (!order->is_null()) sink->Give(*order);
    } catch (const InputError& error) {
      sink->Refuse(error.what());
    }
    sink->Hear(false);
  }
  sink->Hear(true);
  sink->Finish();
}

/// The scenario of a mission that runs there; none where its file has gone.
std::optional<Scenario> ScenarioOf(const std::string& run) {
  const std::filesystem::path file = std::filesystem::path(run) / "scenario.json";
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return std::nullopt;
  return LoadScenario(file.string());
}

/// Without --start, times count from the scenario's own.
void TakeStart(const std::optional<Scenario>& scenario, Columns* columns) {
  if (!columns->time || columns->start || !scenario || !scenario->start) return;
  const Moment& start = *scenario->start;
  FieldTime utc;
  utc.of_day_us = (start.unix_us % kDayUs + kDayUs) % kDayUs;
  utc.offset_min = 0;
  columns->start = utc.On(start.offset_min).of_day_us;
  columns->offset_min = start.offset_min;
}

int Finish(int taken, int refused, const StopSignals& stop) {
  fmt::print("{} taken, {} refused\n", taken, refused);
  if (stop.count() > 0) return kExitInterrupted;
  return refused == 0 ? kExitOk : kExitCheckFailed;
}

/// The token in a file that only its owner should read; "" without one.
std::string ReadToken(const Arguments& arguments) {
  if (!arguments.Has("token-file")) return "";
  const std::string file = arguments.Get("token-file");
  const std::string text = ReadFile(file);
  std::string token(Trim(text));
  if (token.empty())
    throw InputError("command line", "--token-file", file, "a file with a token in it");
  return token;
}

int FeedAlertsOrForms(const Arguments& arguments, const std::optional<Scenario>& scenario,
                      const Columns& columns) {
  const std::string format = arguments.Get("format"), from = arguments.Get("file");
  if (arguments.Has("out")) {
    throw InputError(
        "command line", "--out", arguments.Get("out"),
        fmt::format("none with --format {}: what replaces a report needs a mission that runs",
                    format));
  }
  const bool is_cap = format == "cap";
  FeedSettings settings;
  settings.run = arguments.Get("run");
  settings.format = format;
  settings.memory = fmt::format("{}-{}.json", format, Sha256(from).substr(0, 8));
  arguments.Read("every", &settings.every_s);
  if (settings.every_s > 0 && from == "-") {
    throw InputError("command line", "FILE", "-", "a file, a folder or an address with --every");
  }
  if (is_cap) {
    const std::string status = arguments.Has("exercise") ? "Exercise" : "Actual";
    const std::optional<Moment> start = scenario ? scenario->start : std::nullopt;
    settings.read = [=](const std::string& text, const std::string& file) {
      return ReadCap(text, file, status, start);
    };
  } else {
    std::vector<std::string> names;
    for (const auto* column :
         {&columns.latitude, &columns.longitude, &columns.time, &columns.priority, &columns.name,
          &columns.external_id, &columns.cost}) {
      if (*column) names.push_back(**column);
    }
    settings.read = [=](const std::string& text, const std::string& file) {
      return ReadKobo(text, file, names, [&](const Table& row) {
        return RowReader(row, columns).OrderOf(row, 0)["task"];
      });
    };
  }
  const StopSignals stop;
  const DocumentSource source(
      from, is_cap ? std::vector<std::string>{".xml", ".cap"} : std::vector<std::string>{".json"},
      ReadToken(arguments));
  const FeedCounts counts = FeedReports(source, settings, stop);
  return Finish(counts.taken, counts.refused, stop);
}

Columns ReadColumns(const Arguments& arguments) {
  Columns columns;
  arguments.Read("lat", &columns.latitude);
  arguments.Read("lon", &columns.longitude);
  arguments.Read("time", &columns.time);
  arguments.Read("priority", &columns.priority);
  arguments.Read("task-name", &columns.name);
  arguments.Read("external-id", &columns.external_id);
  arguments.Read("cost", &columns.cost);
  columns.source = arguments.Has("source") ? arguments.Get("source") : "";
  if (arguments.Has("start")) {
    columns.start = TimeOfDay(arguments.Get("start"));
    if (!columns.start) {
      throw InputError("command line", "--start", arguments.Get("start"),
                       "a time of day like 7:30");
    }
  }
  return columns;
}

Options FeedOptions() {
  Options options(
      "muster feed",
      "Gives a running mission tasks and orders as they come: rows of CSV, GeoJSON or JSON lines "
      "with a place each become tasks; a line with \"order\" is an order (docs/guide/orders.md). "
      "Alerts in CAP and forms of KoboToolbox become tasks too (docs/guide/feeds.md).");
  options.Positional("run", "RUN")
      .Required("the run directory of a mission, or with --out a scenario");
  options.Positional("file", "FILE|-").Required("a file, or - for stdin");
  options
      .Add(
          "format", "NAME",
          "csv, json (a line each), cap or kobo; default: by the file's name, json for -. With cap "
          "and kobo FILE may be a folder or an address (http, https)")
      .OneOf({"csv", "json", "cap", "kobo"});
  options.Add("every", "S", "cap, kobo: look again every S seconds until the mission ends")
      .Number(Above0(86400));
  options.Add("token-file", "FILE", "cap, kobo: the server's token, sent as Authorization: Token");
  options.Flag("exercise", "cap: take alerts of status Exercise, and none of status Actual");
  options.Add("lat", "COLUMN", "Latitude (default: the usual names)");
  options.Add("lon", "COLUMN", "Longitude (default: the usual names)");
  options.Add("time", "COLUMN", "Time of the report; default: when it is taken");
  options.Add("start", "HH:MM",
              "Time of day at which the mission began (default: its scenario's start)");
  options.Add("priority", "COLUMN", "0 to 3, or low, normal, high or emergency");
  options.Add("task-name", "COLUMN", "What people call it");
  options.Add("external-id", "COLUMN", "What another system calls it");
  options.Add("cost", "COLUMN", "Range that sensing takes, km");
  options.Add("source", "TEXT", "Who reports these");
  options.Add("out", "ORDERS",
              "Write orders for muster run --orders instead; RUN is the scenario they are for");
  return options;
}

/// Rows and orders of a file, or of a stream.
int FeedRows(const Arguments& arguments, const std::optional<Scenario>& scenario,
             const Columns& columns) {
  const std::string file = arguments.Get("file");
  const std::string format = arguments.Has("format") ? arguments.Get("format") : "";
  const bool from_stdin = file == "-";
  const bool is_lines = from_stdin || file.ends_with(".jsonl") || file.ends_with(".ndjson") ||
                        file.ends_with(".geojsonl") || format == "json";
  const bool csv = format.empty() ? !is_lines : format == "csv";
  for (const char* option : {"every", "token-file", "exercise"}) {
    if (arguments.Has(option)) {
      throw InputError("command line", fmt::format("--{}", option), "given",
                       "--format cap or kobo with it");
    }
  }
  std::ifstream opened;
  if (!from_stdin) {
    opened.open(file);
    if (!opened.is_open() || std::filesystem::is_directory(file)) {
      throw InputError(fmt::format("{}: cannot read rows from it", file));
    }
  }
  const StopSignals stop;
  std::unique_ptr<Sink> sink;
  if (arguments.Has("out")) {
    sink = std::make_unique<FileSink>(arguments.Get("out"), *scenario);
  } else {
    sink = std::make_unique<MissionSink>(arguments.Get("run"), stop);
  }
  if (is_lines) {
    std::istream& in = from_stdin ? std::cin : opened;
    LineReader reader(from_stdin ? "stdin" : file, csv, columns);
    GiveAll(
        [&]() -> std::optional<Json> {
          std::string line;
          if (!std::getline(in, line)) return {};
          return reader.Read(line).value_or(Json());
        },
        sink.get(), stop);
  } else {
    const Table table = ReadTable(file);
    const RowReader reader(table, columns);
    std::size_t row = 0;
    GiveAll(
        [&]() -> std::optional<Json> {
          if (row == table.rows.size()) return {};
          return reader.OrderOf(table, row++);
        },
        sink.get(), stop);
  }
  return Finish(sink->taken, sink->refused, stop);
}

}  // namespace

int FeedCommand(int argc, const char* const* argv) {
  const auto arguments = FeedOptions().Parse(argc, argv);
  if (!arguments) return kExitOk;
  Columns columns = ReadColumns(*arguments);
  const std::string run = arguments->Get("run");
  const auto scenario = arguments->Has("out") ? LoadScenario(run) : ScenarioOf(run);
  TakeStart(scenario, &columns);
  const std::string format = arguments->Has("format") ? arguments->Get("format") : "";
  return format == "cap" || format == "kobo" ? FeedAlertsOrForms(*arguments, scenario, columns)
                                             : FeedRows(*arguments, scenario, columns);
}

}  // namespace muster::tools
