#include "tools/report/report_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "lcmtypes/bus/event_log.h"
#include "tools/files/log_files.h"
#include "tools/record/report_json.h"
#include "tools/report/mission_feed.h"
#include "tools/report/page.h"
#include "tools/report/page_chunk.h"

namespace muster::tools {
namespace {

/// "runs/a/" -> "a", "x/mission.lcm" -> "x"
std::string NameOf(const std::string& run) {
  std::filesystem::path path = std::filesystem::absolute(run).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  if (path.filename() == "mission.lcm") path = path.parent_path();
  return path.filename().string();
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

std::string ReadRun(const std::string& run) {
  const std::vector<std::string> files = LogFilesOf(run);
  MissionFeed feed;
  for (const std::string& file : files) {
    const auto log = OpenLog(file, EventLogReader::Tail::kFinal);
    while (const auto event = log->Next()) feed.Add(event->packet);
    if (log->garbage_bytes() == 0) continue;
    std::string text = fmt::format("{}: {} bytes belong to no event", file, log->garbage_bytes());
    // A logger that was killed leaves a torn event; all of it is in the next file.
    if (file == files.back()) {
      feed.record().NoteDamage(std::move(text));
    } else {
      feed.record().NoteTornTail(std::move(text));
    }
  }
  if (!feed.ready()) throw InputError(files[0] + ": the log has no scenario");
  feed.Finish();
  PageCursor cursor;
  // Names of processes and faults come from the bus: whatever is not UTF-8 is replaced.
  return PageChunk(feed, NameOf(run), &cursor, true)
      .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

int ReportCommand(int argc, const char* const* argv) {
  Options options(
      argv[0],
      "Makes one self-contained page of one or several runs: map, timeline of every agent,\n"
      "curves, decisions. It opens in any browser and loads nothing from anywhere.");
  options.Positional("runs", "RUN [RUN...]").Repeated().Required("run directories or log files");
  options.Out("FILE.html", "Page to write").Required("a file to write, FILE.html");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  RequirePage();
  const auto runs = arguments->All("runs");
  const std::string out = arguments->Get("out");
  RequirePageOrNothing(out);
  std::vector<std::string> chunks;
  std::string title;
  for (const std::string& run : runs) {
    chunks.push_back(ReadRun(run));
    title += (title.empty() ? "" : ", ") + NameOf(run);
  }
  const std::string page = StaticPage(title, chunks);
  WriteFile(out, page);
  fmt::print("{}: {} run{}, {:.0f} kB\n", out, runs.size(), runs.size() == 1 ? "" : "s",
             static_cast<double>(page.size()) / 1000);
  return kExitOk;
}

}  // namespace muster::tools
