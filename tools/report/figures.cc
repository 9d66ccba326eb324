#include "tools/report/figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>
#include <system_error>

#include "base/check.h"
#include "base/spawn.h"
#include "lcmtypes/words.h"
#include "tools/files/pending_file.h"

namespace muster::tools {
namespace {

/// Colours that people with any colour vision tell apart (M. Okabe, K. Ito, 2008).
constexpr const char* kColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                    "#E69F00", "#56B4E9", "#000000"};
constexpr const char* kGrey = "#999999";
constexpr double kInch_cm = 2.54;

double Minutes(std::int64_t t_ms) { return static_cast<double>(t_ms) / 60'000; }
double Km(double metres) { return metres / 1000; }

/// A text of gnuplot, without its markup.
std::string Quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "''" : std::string(1, c);
  return quoted + "'";
}

/// Points of one curve, under a name of their own.
class Blocks {
 public:
  /// Returns its name in the script.
  std::string Add(const std::string& points) {
    std::string name = fmt::format("$points_{}", n_++);
    text_ += fmt::format("{} << EOD\n{}EOD\n", name, points);
    return name;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  int n_ = 0;
};

/// Terminal and size. `height`: as a share of the width.
std::string Terminal(const FigureFormat& format, double height, const std::string& file) {
  const double width_cm = format.width_cm;
  std::string terminal;
  if (format.format == "pdf") {
    terminal = fmt::format("pdfcairo noenhanced color size {:.2f}cm,{:.2f}cm font 'Sans,7' lw 0.8",
                           width_cm, width_cm * height);
  } else {
    // 96 pixels an inch as browsers have them, 300 for a picture of points.
    const bool svg = format.format == "svg";
    const double px = width_cm / kInch_cm * (svg ? 96 : 300);
    terminal = fmt::format("{} noenhanced size {:.0f},{:.0f} background 'white' font 'Sans,{}'{}",
                           svg ? "svg" : "pngcairo", px, px * height, svg ? 9 : 7,
                           svg ? "" : " fontscale 3 linewidth 3 pointscale 3");
  }
  return fmt::format("reset\nset terminal {}\nset output {}\n", terminal, Quoted(file));
}

constexpr const char* kFrame =
    "set border 3 lw 0.7\nset tics nomirror out scale 0.5\nset key top left Left reverse "
    "samplen 1.5 spacing 0.9\n";

std::string Completion(const std::vector<FigureRun>& runs, Blocks* blocks) {
  std::vector<std::string> curves;
  double until_min = 0;
  for (const FigureRun& run : runs) {
    until_min = std::max(until_min, ToMinutes(run.timeline->scenario().rules.limit_us));
    const double all = static_cast<double>(run.timeline->scenario().n_tasks());
    std::string points = "0 0\n";
    double done = 0;
    for (const Timeline::Done& row : run.timeline->done().rows) {
      done = all > 0 ? 100 * row.tasks / all : 100;
      fmt::format_to(std::back_inserter(points), "{:.3f} {:.4f}\n", Minutes(row.t_ms), done);
    }
    fmt::format_to(std::back_inserter(points), "{:.3f} {:.4f}\n", Minutes(run.timeline->now_ms()),
                   done);
    curves.push_back(fmt::format("{} using 1:2 with steps lw 2 lc rgb '{}' title {}",
                                 blocks->Add(points), kColours[curves.size() % std::size(kColours)],
                                 Quoted(run.name)));
  }
  return fmt::format(
      "{}set xlabel 'mission time (min)'\nset ylabel 'tasks done (%)'\nset yrange [0:105]\nset "
      "xrange [0:{:.3f}]\n{}plot {}\n",
      kFrame, until_min, runs.size() == 1 ? "unset key\n" : "set key bottom right\n",
      fmt::join(curves, ", \\\n     "));
}

/// What an agent does, as rectangles: one row of the figure an agent, UAVs at the top.
std::string TimelineOf(const Timeline& timeline, Blocks* blocks) {
  constexpr AgentStatus kShown[] = {AgentStatus::kMoving, AgentStatus::kWaiting,
                                    AgentStatus::kSensing, AgentStatus::kCharging,
                                    AgentStatus::kFailed};
  const Scenario& scenario = timeline.scenario();
  std::map<int, std::string> rows;
  double row = 0;
  std::string marks;
  for (const AgentKind kind : kAgentKinds) {
    const std::size_t n = scenario.n_agents(kind);
    if (n == 0) continue;
    const bool is_uav = kind == AgentKind::kUav;
    marks += fmt::format("{}'{}s' {}", marks.empty() ? "" : ", ", is_uav ? "UAV" : ToString(kind),
                         row - (static_cast<double>(n) - 1) / 2);
    for (std::size_t id = 0; id < n; ++id, --row) {
      const auto& spans = timeline.agents()[timeline.IndexOf(kind, id)].spans.rows;
      for (std::size_t i = 0; i < spans.size(); ++i) {
        const std::int64_t end_ms = i + 1 < spans.size() ? spans[i + 1].t_ms : timeline.now_ms();
        fmt::format_to(std::back_inserter(rows[spans[i].status]), "{:.3f} {} {:.3f} {:.3f} {} {}\n",
                       Minutes(spans[i].t_ms), row, Minutes(spans[i].t_ms), Minutes(end_ms),
                       row - 0.4, row + 0.4);
      }
    }
    --row;  // a gap between the classes
  }
  std::vector<std::string> curves;
  for (const AgentStatus& status : kShown) {
    const auto of = rows.find(static_cast<int>(status));
    if (of == rows.end()) continue;
    curves.push_back(
        fmt::format("{} using 1:2:3:4:5:6 with boxxyerror fs solid noborder lc rgb '{}' title '{}'",
                    blocks->Add(of->second), kColours[&status - kShown], ToString(status)));
  }
  if (curves.empty()) curves.emplace_back("NaN notitle");
  return fmt::format(
      "{}set key outside top center horizontal\nset xlabel 'mission time (min)'\nset xrange "
      "[0:{:.3f}]\nset yrange [{}:1]\nset ytics ({}) scale 0\nset style fill solid\nplot {}\n",
      kFrame, Minutes(timeline.now_ms()), row + 0.5, marks, fmt::join(curves, ", \\\n     "));
}

/// x and y of each stop; a blank line between two agents. `with_time`: the time as well.
std::string TrailsOf(const Timeline& timeline, AgentKind kind, bool with_time) {
  std::string points;
  for (std::size_t id = 0; id < timeline.scenario().n_agents(kind); ++id) {
    for (const Timeline::Stop& stop : timeline.agents()[timeline.IndexOf(kind, id)].stops.rows) {
      fmt::format_to(std::back_inserter(points), "{:.4f} {:.4f}", Km(stop.x_m), Km(stop.y_m));
      if (with_time) fmt::format_to(std::back_inserter(points), " {:.3f}", Minutes(stop.t_ms));
      points += '\n';
    }
    points += '\n';
    if (with_time) points += '\n';  // gnuplot's mark of another surface
  }
  return points;
}

std::string RoadsOf(const Scenario& scenario) {
  std::string points;
  if (scenario.roads == nullptr) return points;
  const Roads& network = *scenario.roads->network;
  for (const Road& road : network.roads) {
    for (const std::int32_t index : road.points) {
      const Point corner = ToPoint(network.points[static_cast<std::size_t>(index)]);
      fmt::format_to(std::back_inserter(points), "{:.4f} {:.4f}\n", Km(corner.x_m), Km(corner.y_m));
    }
    points += '\n';
  }
  return points;
}

std::string MapOf(const Timeline& timeline, Blocks* blocks) {
  const Scenario& scenario = timeline.scenario();
  std::string done, open, charging;
  for (std::size_t x = 0; x < scenario.n_tasks(); ++x) {
    const auto& changes = timeline.tasks()[x].rows;
    const bool is_done =
        !changes.empty() && changes.back().status == static_cast<int>(TaskStatus::kDone);
    fmt::format_to(std::back_inserter(is_done ? done : open), "{:.4f} {:.4f}\n",
                   Km(scenario.tasks[x].at.x_m), Km(scenario.tasks[x].at.y_m));
  }
  for (const ChargingPoint& point : scenario.charging_points) {
    fmt::format_to(std::back_inserter(charging), "{:.4f} {:.4f}\n", Km(point.at.x_m),
                   Km(point.at.y_m));
  }
  std::vector<std::string> curves;
  const auto add = [&](const std::string& points, const std::string& style) {
    if (points.find_first_not_of('\n') == std::string::npos) return;
    curves.push_back(fmt::format("{} using 1:2 {}", blocks->Add(points), style));
  };
  add(RoadsOf(scenario), fmt::format("with lines lw 0.5 lc rgb '{}' notitle", "#CCCCCC"));
  add(TrailsOf(timeline, AgentKind::kWorker, false),
      fmt::format("with lines lw 0.6 lc rgb '{}' title 'workers'", kColours[4]));
  add(TrailsOf(timeline, AgentKind::kVehicle, false),
      fmt::format("with lines lw 0.6 lc rgb '{}' title 'vehicles'", kColours[3]));
  add(TrailsOf(timeline, AgentKind::kUav, false),
      fmt::format("with lines lw 0.8 lc rgb '{}' title 'UAVs'", kColours[0]));
  add(charging,
      fmt::format("with points pt 9 ps 0.6 lc rgb '{}' title 'charging points'", kColours[6]));
  add(done, fmt::format("with points pt 7 ps 0.4 lc rgb '{}' title 'tasks done'", kColours[2]));
  add(open, fmt::format("with points pt 6 ps 0.4 lc rgb '{}' title 'not done'", kColours[1]));
  if (curves.empty()) curves.emplace_back("NaN notitle");
  return fmt::format(
      "{}set key outside top center horizontal\nset size ratio -1\nset xlabel 'km'\nset ylabel "
      "'km'\nset xrange [0:{:.4f}]\nset yrange [0:{:.4f}]\nplot {}\n",
      kFrame, Km(scenario.width_m), Km(scenario.height_m), fmt::join(curves, ", \\\n     "));
}

/// UAVs through space and time, with their sensing: the plane is the map, upwards is time.
std::string SpaceTimeOf(const Timeline& timeline, Blocks* blocks) {
  const Scenario& scenario = timeline.scenario();
  std::string sensed;
  for (const activity_t& activity : timeline.activities().rows) {
    if (activity.kind != static_cast<int>(Activity::Kind::kSensing)) continue;
    const Point at = scenario.tasks[static_cast<std::size_t>(activity.site_id)].at;
    for (const std::int64_t t_us : {activity.start_us, activity.end_us}) {
      fmt::format_to(std::back_inserter(sensed), "{:.4f} {:.4f} {:.3f}\n", Km(at.x_m), Km(at.y_m),
                     Minutes(Ms(t_us)));
    }
    sensed += "\n\n";
  }
  std::vector<std::string> curves = {
      fmt::format("{} using 1:2:3 with lines lw 0.8 lc rgb '{}' title 'UAVs'",
                  blocks->Add(TrailsOf(timeline, AgentKind::kUav, true)), kColours[0])};
  if (!sensed.empty()) {
    curves.push_back(fmt::format("{} using 1:2:3 with lines lw 3 lc rgb '{}' title 'sensing'",
                                 blocks->Add(sensed), kColours[1]));
  }
  return fmt::format(
      "{}set key top right\nset border 31 lw 0.5 lc rgb '{}'\nset xyplane 0\nset view "
      "62,30,1.05,1.1\nset xlabel 'km'\nset ylabel 'km'\nset zlabel 'mission time (min)' rotate "
      "parallel offset 2,0\nset xrange [0:{:.4f}]\nset yrange [0:{:.4f}]\nset zrange "
      "[0:{:.3f}]\nsplot {}\n",
      kFrame, kGrey, Km(scenario.width_m), Km(scenario.height_m), Minutes(timeline.now_ms()),
      fmt::join(curves, ", \\\n     "));
}

double HeightOf(Figure figure, const Scenario& scenario) {
  if (figure == Figure::kCompletion) return 0.62;
  if (figure == Figure::kTimeline) return 1.1;
  if (figure == Figure::kSpaceTime) return 0.85;
  return std::clamp(scenario.height_m / scenario.width_m, 0.3, 3.0) * 0.95 + 0.15;  // with its key
}

}  // namespace

std::string FigureScript(Figure figure, const std::vector<FigureRun>& runs,
                         const FigureFormat& format, const std::string& file) {
  MUSTER_CHECK(runs.size() == 1 || (figure == Figure::kCompletion && !runs.empty()), "runs");
  const Timeline& first = *runs.front().timeline;
  Blocks blocks;
  const std::string plot = figure == Figure::kCompletion ? Completion(runs, &blocks)
                           : figure == Figure::kTimeline ? TimelineOf(first, &blocks)
                           : figure == Figure::kMap      ? MapOf(first, &blocks)
                                                         : SpaceTimeOf(first, &blocks);
  return Terminal(format, HeightOf(figure, first.scenario()), file) + blocks.text() + plot +
         "unset output\n";
}

void WriteFigure(Figure figure, const std::vector<FigureRun>& runs, const FigureFormat& format,
                 const std::string& file) {
  if (!FindProgram("gnuplot")) {
    throw SystemError("figures need gnuplot (Debian: gnuplot-nox)");
  }
  PendingFile pending(file);
  // gnuplot draws on its stdout where it cannot write a file.
  std::FILE* const empty = std::fopen(pending.temporary().c_str(), "wb");
  if (empty == nullptr) FailToWrite(file, errno);
  std::fclose(empty);
  const std::string script = FigureScript(figure, runs, format, pending.temporary());
  // Its words go to stderr: they are about the script, which is ours.
  std::FILE* const gnuplot = popen("gnuplot > /dev/null", "w");
  const bool written =
      gnuplot != nullptr && std::fwrite(script.data(), 1, script.size(), gnuplot) == script.size();
  const bool ended_well = gnuplot != nullptr && pclose(gnuplot) == 0;
  std::error_code none;
  if (!written || !ended_well || std::filesystem::file_size(pending.temporary(), none) == 0 ||
      none) {
    throw SystemError(
        fmt::format("{}: gnuplot has not drawn it (its reason is above, if it gave one)", file));
  }
  pending.Commit();
}

}  // namespace muster::tools
