#include "tools/orders/feed_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <iostream>
#include <map>
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
#include "tools/orders/feed_rows.h"
#include "tools/orders/order_socket.h"
#include "tools/orders/report_feed.h"
#include "tools/orders/web_client.h"
#include "tools/scenario/fields.h"
#include "tools/scenario/order_text.h"
#include "tools/scenario/table.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;
using std::chrono::milliseconds;

constexpr int kMostShown = 20;  ///< refusals in words
constexpr const char* kStdin = "stdin";

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
  MissionSink(const std::string& run, const std::string& key_file, const StopSignals& stop)
      : client_(run, key_file), stop_(stop) {}

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

/// One line of a stream: an order, a GeoJSON feature, an object of columns, or a CSV record. An
/// order that adds a line of a file has an id that follows from the line, so that the file may be
/// given again; what stdin had before is not known.
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
    const Json task = reader_->TaskOf(table, 0);
    if (file_ == kStdin) return AddOrder(FreshOrderId(), task);
    const std::string content = task.dump();
    return AddOrder(
        "line-" + Sha256(fmt::format("{} {}", content, n_seen_[content]++)).substr(0, 32), task);
  }

  const std::string file_;
  const bool csv_;
  const Columns columns_;
  std::map<std::string, int> n_seen_;  ///< by task
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
  columns->CountFrom(*scenario->start);
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
  if (!IsWebAddress(arguments.Get("file"))) {
    throw InputError("command line", "--token-file", file,
                     "a web address as FILE: only a server takes a token");
  }
  const std::string text = ReadFile(file);
  std::string token(Trim(text));
  if (token.empty())
    throw InputError("command line", "--token-file", file, "a file with a token in it");
  return token;
}

/// What kinds of documents there are, which files of a folder they are, and how each is read.
struct DocumentFormat {
  std::vector<std::string> endings;
  std::function<Reports(const std::string& document, const std::string& file)> read;
  std::function<std::string(const std::string& document)> next_page = {};
};

DocumentFormat FormatOf(const std::string& name, const Arguments& arguments,
                        const std::optional<Scenario>& scenario, const Columns& columns) {
  if (name == "csv") {
    return {{".csv", ".tsv"}, [=](const std::string& text, const std::string& file) {
              return ReadRows(ParseCsv(text, file), columns);
            }};
  }
  if (name == "geojson") {
    return {{".geojson", ".json"}, [=](const std::string& text, const std::string& file) {
              return ReadRows(ParseGeoJson(text, file), columns);
            }};
  }
  if (name == "cap") {
    const std::string status = arguments.Has("exercise") ? "Exercise" : "Actual";
    const std::optional<Moment> start = scenario ? scenario->start : std::nullopt;
    return {{".xml", ".cap"}, [=](const std::string& text, const std::string& file) {
              return ReadCap(text, file, status, start);
            }};
  }
  std::vector<std::string> names;
  for (const auto* column :
       {&columns.latitude, &columns.longitude, &columns.time, &columns.priority, &columns.name,
        &columns.note, &columns.external_id, &columns.cost}) {
    if (*column) names.push_back(**column);
  }
  return {{".json"},
          [=](const std::string& text, const std::string& file) {
            return ReadKobo(text, file, names, [&](const Table& row) {
              return RowReader(row, columns).TaskOf(row, 0);
            });
          },
          NextPageOfKobo};
}

int FeedDocuments(const std::string& name, const Arguments& arguments,
                  const std::optional<Scenario>& scenario, const Columns& columns) {
  const std::string from = arguments.Get("file");
  if (arguments.Has("exercise") && name != "cap")
    throw InputError("command line", "--exercise", "given", "--format cap with it");
  DocumentFormat format = FormatOf(name, arguments, scenario, columns);
  FeedSettings settings;
  settings.run = arguments.Get("run");
  settings.key_file = SigningKeyFile(arguments);
  settings.format = name;
  settings.memory = fmt::format("{}-{}.json", name, Sha256(from).substr(0, 8));
  settings.read = std::move(format.read);
  arguments.Read("every", &settings.every_s);
  if (settings.every_s > 0 && from == "-") {
    throw InputError("command line", "FILE", "-", "a file, a folder or an address with --every");
  }
  const StopSignals stop;
  const DocumentSource source(from, format.endings, ReadToken(arguments), format.next_page);
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
  arguments.Read("task-note", &columns.note);
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
  options.Positional("file", "FILE|-")
      .Required("a file, a folder, an address (http, https), or - for stdin");
  options
      .Add("format", "NAME",
           "csv, geojson, json (a line each), cap or kobo; default: by the file's name, json for -")
      .OneOf({"csv", "geojson", "json", "cap", "kobo"});
  options
      .Add("every", "S",
           "csv, geojson, cap, kobo: look again every S seconds until the mission ends")
      .Number(Above0(86400));
  AddSignOption(&options);
  options.Add("token-file", "FILE", "the server's token, sent as Authorization: Token");
  options.Flag("exercise", "cap: take alerts of status Exercise, and none of status Actual");
  options.Add("lat", "COLUMN", "Latitude (default: the usual names)");
  options.Add("lon", "COLUMN", "Longitude (default: the usual names)");
  options.Add("time", "COLUMN", "Time of the report; default: when it is taken");
  options.Add("start", "HH:MM",
              "Time of day at which the mission began (default: its scenario's start)");
  options.Add("priority", "COLUMN", "0 to 3, or low, normal, high or emergency");
  options.Add("task-name", "COLUMN", "What people call it");
  options.Add("task-note", "COLUMN", "What people should know of it");
  options.Add("external-id", "COLUMN", "What another system calls it");
  options.Add("cost", "COLUMN", "Range that sensing takes, km");
  options.Add("source", "TEXT", "Who reports these");
  options.Add("out", "ORDERS",
              "Write orders for muster run --orders instead; RUN is the scenario they are for");
  return options;
}

/// What is in FILE, by --format or by its name.
std::string FormatNameOf(const Arguments& arguments) {
  if (arguments.Has("format")) return arguments.Get("format");
  const std::string file = arguments.Get("file");
  if (file == "-") return "json";
  const std::string path = IsWebAddress(file) ? file.substr(0, file.find('?')) : file;
  const auto ends = [&](std::initializer_list<const char*> endings) {
    return std::any_of(endings.begin(), endings.end(),
                       [&](const char* ending) { return path.ends_with(ending); });
  };
  if (ends({".jsonl", ".ndjson", ".geojsonl"})) return "json";
  if (ends({".geojson", ".json"})) return "geojson";
  if (IsWebAddress(file) && !ends({".csv", ".tsv"})) {
    throw InputError("command line", "FILE", file, "--format with this address");
  }
  if (std::filesystem::is_directory(file)) {
    throw InputError("command line", "FILE", file, "--format with a folder");
  }
  return "csv";
}

/// Rows and orders of a stream, or of a file that becomes a file of orders.
int FeedRows(const std::string& format, const Arguments& arguments,
             const std::optional<Scenario>& scenario, const Columns& columns) {
  const std::string file = arguments.Get("file");
  const bool from_stdin = file == "-";
  for (const char* option : {"every", "token-file", "exercise"}) {
    if (arguments.Has(option)) {
      throw InputError(
          "command line", fmt::format("--{}", option), "given",
          "it only with a whole document (a file, folder or address), not with a stream or --out");
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
    sink = std::make_unique<MissionSink>(arguments.Get("run"), SigningKeyFile(arguments), stop);
  }
  if (from_stdin || format == "json") {
    std::istream& in = from_stdin ? std::cin : opened;
    LineReader reader(from_stdin ? kStdin : file, format == "csv", columns);
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
          return AddOrder(FreshOrderId(), reader.TaskOf(table, row++));
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
  const std::string format = FormatNameOf(*arguments);
  if (arguments->Has("out") && (format == "cap" || format == "kobo")) {
    throw InputError(
        "command line", "--out", arguments->Get("out"),
        fmt::format(
            "none with --format {}: reports that replace earlier ones need a running mission",
            format));
  }
  const bool is_stream = format == "json" || (format == "csv" && arguments->Get("file") == "-") ||
                         arguments->Has("out");
  return is_stream ? FeedRows(format, *arguments, scenario, columns)
                   : FeedDocuments(format, *arguments, scenario, columns);
}

}  // namespace muster::tools
