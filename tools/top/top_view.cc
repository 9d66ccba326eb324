#include "tools/top/top_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "lcmtypes/bus/codec.h"
#include "tools/host/progress.h"

namespace muster::tools {
namespace {

constexpr std::array<const char*, 5> kStates = {"starting", "ready", "running", "degraded",
                                                "ended"};
constexpr int kDegraded = 3;
constexpr int kEnded = 4;
/// A process says something about once a second.
constexpr double kLateS = 3;

double Seconds(std::int64_t us) { return static_cast<double>(us) * 1e-6; }

std::string Amount(std::int64_t n) {
  if (n >= 10'000'000) return fmt::format("{}M", n / 1'000'000);
  return n >= 100'000 ? fmt::format("{}k", n / 1000) : fmt::to_string(n);
}

std::string Age(double seconds) {
  if (seconds < 0) return "-";
  if (seconds < 100) return fmt::format("{:.1f}s", seconds);
  return seconds < 6000 ? fmt::format("{:.0f}min", seconds / 60)
                        : fmt::format("{:.0f}h", seconds / 3600);
}

/// Text of a log or the bus, for a terminal: nothing that it would obey.
std::string Printable(std::string text) {
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text;
}

}  // namespace

void TopView::Forget(Traffic* traffic, std::int64_t before_us) {
  while (!traffic->recent.empty() && traffic->recent.front().first <= before_us) {
    traffic->bytes -= traffic->recent.front().second;
    traffic->recent.pop_front();
  }
}

void TopView::Add(const Packet& packet) {
  feed_.Add(packet);
  const auto header = DecodeHeader(packet);
  if (!header || (feed_.ready() && header->run_id != feed_.record().run_id())) return;
  for (Traffic* traffic : {&senders_[header->sender], &all_}) {
    traffic->recent.emplace_back(header->wall_us, packet.bytes.size());
    traffic->bytes += packet.bytes.size();
    traffic->last_us = std::max(traffic->last_us, header->wall_us);
    Forget(traffic, traffic->last_us - kWindowUs);
  }
}

TopView::Rate TopView::RateOf(const Traffic& traffic, std::int64_t now_us) {
  Traffic recent = traffic;
  Forget(&recent, now_us - kWindowUs);
  const double seconds = Seconds(kWindowUs);
  return {static_cast<double>(recent.recent.size()) / seconds,
          static_cast<double>(recent.bytes) / seconds};
}

std::string TopView::MissionLine() const {
  const Timeline& timeline = feed_.timeline();
  const auto& schedules = timeline.schedules().rows;
  const std::int64_t now_us = timeline.now_ms() * 1000;
  const std::int64_t limit_us = timeline.scenario().rules.limit_us;
  std::string line = fmt::format("{}  {} of {} ({:.0f} %){}", Printable(timeline.scenario().name),
                                 ClockText(now_us), ClockText(limit_us),
                                 100 * Seconds(now_us) / std::max(1.0, Seconds(limit_us)),
                                 timeline.ended() ? ", ended" : "");
  if (!schedules.empty()) {
    line += fmt::format("  decision {} by {}", schedules.back().decision,
                        Printable(schedules.back().policy));
  }
  return line;
}

std::string TopView::TaskLine() const {
  std::array<int, 4> count{};
  for (const auto& task : feed_.timeline().tasks()) {
    const int status = task.rows.empty() ? 0 : task.rows.back().status;
    ++count[static_cast<std::size_t>(std::clamp(status, 0, 3))];
  }
  return fmt::format("tasks: {} of {} done, {} being sensed, {} reserved, {} open", count[3],
                     feed_.timeline().tasks().size(), count[2], count[1], count[0]);
}

std::string TopView::BusLine(std::int64_t now_us) const {
  if (all_.last_us == 0) return "bus: none, a simulated mission";
  const Rate rate = RateOf(all_, now_us);
  return fmt::format("bus: {:.0f} messages/s, {:.1f} kB/s, the newest {} old", rate.messages,
                     rate.bytes / 1000, Age(std::max(0.0, Seconds(now_us - all_.last_us))));
}

void TopView::AddAgents(std::vector<Line>* lines) const {
  constexpr const char* kRow = "{:<10}{:>7}{:>7}{:>8}{:>9}{:>9}{:>10}{:>8}{:>9}";
  lines->push_back({fmt::format(kRow, "AGENTS", "all", "idle", "moving", "waiting", "sensing",
                                "charging", "failed", "offline"),
                    Look::kHead});
  const Timeline& timeline = feed_.timeline();
  for (const AgentKind kind : kAgentKinds) {
    std::array<int, 7> count{};
    const std::size_t n = timeline.scenario().agents(kind).size();
    for (std::size_t id = 0; id < n; ++id) {
      const auto& last = timeline.agents()[timeline.IndexOf(kind, id)].last;
      ++count[last ? static_cast<std::size_t>(std::clamp<int>(last->status, 0, 6)) : 0];
    }
    lines->push_back({fmt::format(kRow, std::string(ToString(kind)) + "s", n, count[1], count[2],
                                  count[3], count[4], count[5], count[6], count[0]),
                      count[6] > 0 ? Look::kBad : Look::kPlain});
  }
}

void TopView::AddProcesses(std::int64_t now_us, std::vector<Line>* lines) const {
  constexpr const char* kRow = "{:<14}{:<10}{:>6}{:>7}{:>8}{:>9}{:>7}{:>9}{:>8}{:>7}{:>6}{:>9}";
  lines->push_back({fmt::format(kRow, "PROCESS", "state", "age", "msg/s", "kB/s", "received",
                                "lost", "rejected", "resent", "starts", "CPU %", "memory"),
                    Look::kHead});
  for (const auto& [name, samples] : feed_.timeline().processes()) {
    const auto& rows = samples.rows;
    const Timeline::ProcessSample& now = rows.back();
    std::string cpu = "-";
    if (rows.size() > 1 && rows[rows.size() - 2].boot_id == now.boot_id) {
      const auto& before = rows[rows.size() - 2];
      const double wall_s = Seconds(now.wall_us - before.wall_us);
      if (wall_s > 0) cpu = fmt::format("{:.0f}", 100 * (now.cpu_s - before.cpu_s) / wall_s);
    }
    const auto found = senders_.find(name);
    const Traffic traffic = found == senders_.end() ? Traffic() : found->second;
    const double age_s =
        traffic.last_us == 0 ? -1 : std::max(0.0, Seconds(now_us - traffic.last_us));
    const Rate rate = RateOf(traffic, now_us);
    const bool late = age_s > kLateS && now.state != kEnded;
    const auto state = static_cast<std::size_t>(std::clamp(now.state, 0, kEnded));
    const std::string memory =
        now.rss_bytes <= 0 ? "-"
                           : fmt::format("{:.1f} MB", static_cast<double>(now.rss_bytes) / 1e6);
    lines->push_back(
        {fmt::format(kRow, Printable(name), late ? "silent" : kStates[state], Age(age_s),
                     fmt::format("{:.0f}", rate.messages), fmt::format("{:.1f}", rate.bytes / 1000),
                     Amount(now.received), Amount(now.lost), Amount(now.rejected),
                     Amount(now.resent), now.boot_id + 1, cpu, memory),
         late || now.state == kDegraded ? Look::kBad : Look::kPlain});
  }
}

std::vector<TopView::Line> TopView::Lines(std::int64_t now_us, std::size_t width) const {
  std::vector<Line> lines;
  if (!feed_.ready()) {
    lines.push_back(
        {feed_.heard_run_id() ? "heard a mission; waiting for its scenario" : "nothing heard yet"});
  } else {
    // A mission that is over is told as of its last message.
    if (ended() || all_.last_us == 0) now_us = all_.last_us;
    lines.push_back({MissionLine(), Look::kHead});
    lines.push_back({TaskLine()});
    lines.push_back({BusLine(now_us)});
    lines.push_back({});
    AddAgents(&lines);
    lines.push_back({});
    AddProcesses(now_us, &lines);
  }
  for (Line& line : lines) {
    if (width > 0 && line.text.size() > width) line.text.resize(width);
  }
  return lines;
}

}  // namespace muster::tools
