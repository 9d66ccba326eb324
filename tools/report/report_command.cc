#include "tools/report/report_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/text_file.h"
#include "lcmtypes/bus/event_log.h"
#include "protocol/run_process.h"
#include "tools/files/log_files.h"
#include "tools/files/log_progress.h"
#include "tools/host/progress.h"
#include "tools/record/report_json.h"
#include "tools/report/background.h"
#include "tools/report/figures.h"
#include "tools/report/gshhg.h"
#include "tools/report/mission_feed.h"
#include "tools/report/page.h"
#include "tools/report/page_chunk.h"
#include "tools/report/reasons.h"
#include "tools/report/scene_film.h"
#include "tools/tiles/base_map.h"
#include "tools/tiles/tiles_beside.h"

namespace muster::tools {
namespace {

constexpr int kReasons = 10;  ///< what `muster explain` takes for each adds up
constexpr int kMostReasons = 1000000;

/// "runs/a/" -> "a", "x/mission.lcm" -> "x"
std::string NameOf(const std::string& run) {
  std::filesystem::path path = std::filesystem::absolute(run).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  if (path.filename() == "mission.lcm") path = path.parent_path();
  return path.filename().string();
}

/// "runs/a" -> "runs/a/FILE".
std::string BesideLog(const std::string& run, const std::string& file) {
  const std::filesystem::path path(run);
  return ((std::filesystem::is_directory(path) ? path : path.parent_path()) / file).string();
}

/// Pages may be made again; whatever else is at `out` stays.
void RequirePageOrNothing(const std::string& out) {
  std::ifstream file(out, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) return;  // nothing, or nothing in it
  if (text.str().find(kPageMark) != std::string::npos) return;
  throw InputError("command line", "--out", out + ", a file that is no page of Muster",
                   "a new file, or a page to write again");
}

/// What a page shows beside the run itself.
struct Shown {
  std::size_t reasons = 0;
  std::string background;       ///< a file; "": none
  std::string coast;            ///< as CoastOf takes it
  std::string tiles;            ///< a file, or kNoTiles; "": what lies beside the scenario
  std::size_t tiles_bytes = 0;  ///< at most, of those in the page
};

/// Takes all that the run's log has. Throws InputError where that is no mission.
void ReadLog(const std::string& run, MissionFeed* to) {
  MissionFeed& feed = *to;
  const std::vector<std::string> files = LogFilesOf(run);
  LogProgress progress(run, files);
  for (const std::string& file : files) {
    const auto log = OpenLog(file, EventLogReader::Tail::kFinal);
    while (const auto event = log->Next()) {
      progress.Add(*event);
      feed.Add(event->packet);
    }
    if (log->garbage_bytes() == 0) continue;
    std::string text = fmt::format("{}: {} bytes belong to no event", file, log->garbage_bytes());
    // A logger that was killed leaves a torn event; all of it is in the next file.
    if (file == files.back()) {
      feed.record().NoteDamage(std::move(text));
    } else {
      feed.record().NoteTornTail(std::move(text));
    }
  }
  progress.Break();
  if (!feed.ready()) throw InputError(files[0] + ": the log has no scenario");
  feed.Finish();
}

/// Throws InputError where a file that was asked for does not fit.
void AddBaseMap(const std::string& run, const Shown& shown, const Scenario& scenario,
                nlohmann::ordered_json* chunk) {
  const std::string& tiles = shown.tiles;
  const std::string file = tiles.empty() ? TilesOfRun(run) : tiles;
  if (file.empty() || file == kNoTiles) return;
  std::string told;
  try {
    (*chunk)["basemap"] = EmbeddedBaseMap(*OpenTiles(file), scenario, shown.tiles_bytes, &told);
  } catch (const InputError& error) {
    if (!tiles.empty()) throw;
    fmt::print(stderr, "no base map: {}\n", error.what());
    return;
  }
  fmt::print("{}: {}\n", file, told);
}

std::string ReadRun(const std::string& run, const Shown& shown) {
  MissionFeed feed;
  ReadLog(run, &feed);
  PageCursor cursor;
  nlohmann::ordered_json chunk = PageChunk(feed, NameOf(run), &cursor, true);
  const Scenario& scenario = feed.timeline().scenario();
  if (!shown.background.empty()) {
    chunk["background"] =
        Background(ReadTextFile(shown.background, "a map"), shown.background, scenario);
  }
  std::string missing;
  if (auto coast = CoastOf(shown.coast, scenario, &missing); !coast.is_null()) {
    chunk["coast"] = std::move(coast);
  }
  if (!missing.empty()) fmt::print(stderr, "{}\n", missing);
  AddBaseMap(run, shown, scenario, &chunk);
  if (shown.reasons > 0) {
    ProgressPrinter printer(stderr, StyleFor(stderr, false));
    const auto telling = [&](std::size_t told, std::size_t of) {
      const TimeUs now_us = MonotonicUs();
      if (told == 0 || !printer.due(now_us)) return;
      printer.Show(fmt::format("{}: {} of {} decisions explained", run, told, of), now_us);
    };
    try {
      chunk["reasons"] = Reasons(run, feed.timeline(), shown.reasons, telling);
    } catch (const InputError& error) {  // the page is worth having without them
      fmt::print(stderr, "no reasons: {}\n", error.what());
    }
    printer.Break();
  }
  // Names of processes and faults come from the bus: whatever is not UTF-8 is replaced.
  return chunk.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

int WriteScene(const std::string& page, SceneKind kind, const std::string& link,
               const std::string& file) {
  ProgressPrinter printer(stderr, StyleFor(stderr, false));
  const auto bytes = FilmScene(page, kind, link, [&](int taken, int of) {
    const TimeUs now_us = MonotonicUs();
    if (printer.due(now_us)) {
      printer.Show(fmt::format("{}: {} of {} frames", file, taken, of), now_us);
    }
  });
  printer.Break();
  if (!bytes) return kExitInterrupted;
  WriteFile(file, *bytes);
  fmt::print("{}: {:.0f} kB\n", file, static_cast<double>(bytes->size()) / 1000);
  return kExitOk;
}

int DrawFigure(const Arguments& arguments) {
  const std::vector<std::string> runs = arguments.All("runs");
  const std::string name = arguments.Get("figure");
  const auto figure = static_cast<Figure>(
      std::find(std::begin(kFigures), std::end(kFigures), name) - std::begin(kFigures));
  if (figure != Figure::kCompletion && runs.size() != 1) {
    throw InputError("command line", "RUN", fmt::format("{} runs", runs.size()),
                     fmt::format("one run: {} shows one", name));
  }
  for (const char* option : {"scene", "show", "background", "tiles"}) {
    if (!arguments.Has(option)) continue;
    throw InputError("command line", fmt::format("--{}", option), arguments.Get(option),
                     "nothing beside --figure");
  }
  const std::string format = arguments.Get("format");
  std::string out;
  if (arguments.Has("out")) {
    out = arguments.Get("out");
  } else if (runs.size() == 1) {
    out = BesideLog(runs[0], name + "." + format);
  } else {
    throw InputError("command line", "--out", "nothing", "a file to write, FILE." + format);
  }
  if (!out.ends_with("." + format)) {
    throw InputError("command line", "--out", out,
                     fmt::format("a file named FILE.{} (--format {})", format, format));
  }
  std::vector<std::unique_ptr<MissionFeed>> feeds;
  std::vector<FigureRun> read;
  for (const std::string& run : runs) {
    ReadLog(run, feeds.emplace_back(std::make_unique<MissionFeed>()).get());
    read.push_back({NameOf(run), &feeds.back()->timeline()});
  }
  WriteFigure(figure, read, {format, arguments.Get<double>("width")}, out);
  fmt::print("{}\n", out);
  return kExitOk;
}

}  // namespace

int ReportCommand(int argc, const char* const* argv) {
  Options options(
      argv[0],
      "Makes one self-contained page of one or several runs: map, timeline of every agent,\n"
      "curves, decisions. It opens in any browser and loads nothing from anywhere. Or a picture or "
      "a\n"
      "film of its scene in 3D, drawn by this machine's Chromium.");
  options.Positional("runs", "RUN [RUN...]").Repeated().Required("run directories or log files");
  options.Add("reasons", "N", "For how many undone tasks of a run the page gives reasons")
      .Integer(0, kMostReasons)
      .Default(kReasons);
  options.Add("background", "FILE", "GeoJSON in WGS84 degrees, drawn below the map");
  options
      .Add("coast", "WHICH",
           "Coast and water below a map with an origin: auto (what Debian's gmt-gshhg-full, -high "
           "or -low has), none, or a binned file of GSHHG")
      .Default("auto");
  options.Add("tiles", "FILE",
              "Base map: an MBTiles or PMTiles file, or none; the page holds the tiles of the area "
              "(default: the file beside the scenario that has its name)");
  options.Add("tiles-mb", "MB", "Upper limit for all tiles of the page together")
      .Number({0.01, 100})
      .Default(1.0);
  options.Out("FILE.html", "Page to write (default, of one run: report.html in its directory)");
  options.Add("scene", "FILE.png|FILE.webm", "Picture or film of the scene to write");
  options.Add("show", "LINK",
              "What the picture shows, as in the page's address: 't=4800&sel=uav:2&look=time'");
  options.Group("Figures for papers");
  options
      .Add(
          "figure", "NAME",
          "Draw one figure instead of a page, with gnuplot: completion (tasks done over time, also "
          "of several runs), timeline (what every agent does), map (tasks and trails) or "
          "space-time (UAVs in space and time)")
      .OneOf({std::begin(kFigures), std::end(kFigures)});
  options.Add("format", "pdf|svg|png", "Of the figure").OneOf({"pdf", "svg", "png"}).Default("pdf");
  options.Add("width", "CM", "Of the figure: one column of a paper, or 18 for two")
      .Number({3, 100})
      .Default(8.8);
  options.Group("");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  if (arguments->Has("figure")) return DrawFigure(*arguments);
  RequirePage();
  const auto runs = arguments->All("runs");
  const std::string scene = arguments->Has("scene") ? arguments->Get("scene") : "";
  const std::string out = arguments->Has("out")               ? arguments->Get("out")
                          : scene.empty() && runs.size() == 1 ? BesideLog(runs[0], "report.html")
                                                              : "";
  if (out.empty() && scene.empty()) {
    throw InputError("command line", "--out", "nothing", "a file to write, FILE.html");
  }
  if (arguments->Has("show") && scene.empty()) {
    throw InputError("command line", "--show", arguments->Get("show"), "--scene as well");
  }
  if (!out.empty()) RequirePageOrNothing(out);
  const SceneKind kind = scene.empty() ? SceneKind::kPicture : SceneKindOf(scene);
  const Shown shown = {
      static_cast<std::size_t>(out.empty() ? 0 : arguments->Get<std::int64_t>("reasons")),
      arguments->Has("background") ? arguments->Get("background") : "", arguments->Get("coast"),
      arguments->Has("tiles") ? arguments->Get("tiles") : "",
      static_cast<std::size_t>(arguments->Get<double>("tiles-mb") * 1e6)};
  std::vector<std::string> chunks;
  std::string title;
  for (const std::string& run : runs) {
    chunks.push_back(ReadRun(run, shown));
    title += (title.empty() ? "" : ", ") + NameOf(run);
  }
  const std::string page = StaticPage(title, chunks);
  if (!out.empty()) {
    WriteFile(out, page);
    fmt::print("{}: {} run{}, {:.0f} kB\n", out, runs.size(), runs.size() == 1 ? "" : "s",
               static_cast<double>(page.size()) / 1000);
  }
  if (scene.empty()) return kExitOk;
  return WriteScene(page, kind, arguments->Has("show") ? arguments->Get("show") : "", scene);
}

}  // namespace muster::tools
