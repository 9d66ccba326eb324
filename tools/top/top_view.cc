#include "tools/top/top_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "lcmtypes/bus/codec.h"
#include "tools/host/progress.h"
#include "tools/top/approach.h"
#include "tools/top/attention.h"

namespace muster::tools {
namespace {

/// A process says something about once a second.
constexpr double kLateS = 3;

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

/// Text of a log or the bus for a display in ASCII, a column a byte: what is not, as "?".
std::string Ascii(std::string text) {
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
    if (header->wall_us < traffic->last_us - kSetBackUs) *traffic = {};
    traffic->recent.emplace_back(header->wall_us, packet.bytes.size());
    traffic->bytes += packet.bytes.size();
    traffic->last_us = std::max(traffic->last_us, header->wall_us);
    Forget(traffic, traffic->last_us - kWindowUs);
  }
}

TopView::Rate TopView::RateOf(const Traffic& traffic, std::int64_t now_us) {
  Traffic recent = traffic;
  Forget(&recent, now_us - kWindowUs);
  const double seconds = ToSeconds(kWindowUs);
  return {static_cast<double>(recent.recent.size()) / seconds,
          static_cast<double>(recent.bytes) / seconds};
}

std::string TopView::MissionLine() const {
  const Timeline& timeline = feed_.timeline();
  const auto& schedules = timeline.schedules().rows;
  const std::int64_t now_us = timeline.now_ms() * 1000;
  const std::int64_t limit_us = timeline.scenario().rules.limit_us;
  std::string line =
      fmt::format("{}  {} of {} ({:.0f} %){}", Ascii(timeline.scenario().name), ClockText(now_us),
                  ClockText(limit_us), 100 * ToSeconds(now_us) / std::max(1.0, ToSeconds(limit_us)),
                  timeline.ended() ? ", ended" : "");
  if (const auto& start = timeline.scenario().start) {
    line += fmt::format("  {}", MomentText(start->unix_us + now_us, start->offset_min));
  }
  if (!schedules.empty()) {
    line += fmt::format("  decision {} by {}", schedules.back().decision,
                        Ascii(schedules.back().policy));
  }
  return line;
}

std::array<int, kNames<TaskStatus>.size()> TopView::TaskCounts() const {
  std::array<int, kNames<TaskStatus>.size()> count{};
  for (const auto& task : feed_.timeline().tasks()) {
    const int status = task.rows.empty() ? 0 : task.rows.back().status;
    ++count[static_cast<std::size_t>(status)];
  }
  return count;
}

std::string TopView::TaskLine() const {
  const auto n = [count = TaskCounts()](TaskStatus status) {
    return count[static_cast<std::size_t>(status)];
  };
  // As the page and the launcher count: what has been reported and not been cancelled.
  const auto total = static_cast<int>(feed_.timeline().tasks().size()) -
                     n(TaskStatus::kUnreported) - n(TaskStatus::kCancelled);
  return fmt::format("tasks: {} of {} done, {} being sensed, {} reserved, {} open",
                     n(TaskStatus::kDone), total, n(TaskStatus::kSensing), n(TaskStatus::kReserved),
                     n(TaskStatus::kOpen));
}

std::string TopView::AirLine() const {
  const auto air = AirPictureOf(feed_.timeline());
  if (!air) return "";
  if (air->n == 0) return "air: no UAV is in the air";
  std::string line = fmt::format("air: {} UAVs, {:.0f} to {:.0f} m above the ground", air->n,
                                 air->lowest_m, air->highest_m);
  if (!air->nearest) return line;
  const NearPair& pair = *air->nearest;
  return line + fmt::format("; nearest uav:{} and uav:{}, {:.0f} m across and {:.0f} m up", pair.a,
                            pair.b, pair.approach.across_m, pair.approach.up_m);
}

std::string TopView::BusLine(std::int64_t now_us) const {
  if (all_.last_us == 0) return "bus: none, a simulated mission";
  const Rate rate = RateOf(all_, now_us);
  return fmt::format("bus: {:.0f} messages/s, {:.1f} kB/s, the newest {} old", rate.messages,
                     rate.bytes / 1000, Age(std::max(0.0, ToSeconds(now_us - all_.last_us))));
}

std::array<int, kNames<AgentStatus>.size()> TopView::AgentCounts(AgentKind kind) const {
  const Timeline& timeline = feed_.timeline();
  std::array<int, kNames<AgentStatus>.size()> count{};
  const std::size_t n = timeline.scenario().agents(kind).size();
  for (std::size_t id = 0; id < n; ++id) {
    const auto& last = timeline.agents()[timeline.IndexOf(kind, id)].last;
    ++count[last ? static_cast<std::size_t>(last->status) : 0];
  }
  return count;
}

void TopView::AddAgents(std::vector<Line>* lines) const {
  constexpr const char* kRow = "{:<10}{:>7}{:>7}{:>8}{:>9}{:>9}{:>10}{:>8}{:>9}";
  lines->push_back({fmt::format(kRow, "AGENTS", "all", "idle", "moving", "waiting", "sensing",
                                "charging", "failed", "offline"),
                    Look::kHead});
  for (const AgentKind kind : kAgentKinds) {
    const auto of = [count = AgentCounts(kind)](AgentStatus status) {
      return count[static_cast<std::size_t>(status)];
    };
    const int failed = of(AgentStatus::kFailed);
    const auto& specs = feed_.timeline().scenario().agents(kind);
    // Nor is a place that orders may fill an agent: never online, it counts as offline here.
    const auto vacant = std::count_if(specs.begin(), specs.end(), [](const AgentSpec& agent) {
      return agent.online_until_us <= agent.online_from_us;
    });
    const auto all = static_cast<std::ptrdiff_t>(specs.size()) - vacant;
    lines->push_back({fmt::format(kRow, std::string(ToString(kind)) + "s", all,
                                  of(AgentStatus::kIdle), of(AgentStatus::kMoving),
                                  of(AgentStatus::kWaiting) + of(AgentStatus::kNotReady),
                                  of(AgentStatus::kSensing), of(AgentStatus::kCharging), failed,
                                  of(AgentStatus::kOffline) - vacant),
                      failed > 0 ? Look::kBad : Look::kPlain});
  }
}

std::vector<TopView::ProcessRow> TopView::Processes(std::int64_t now_us) const {
  std::vector<ProcessRow> processes;
  for (const auto& [name, samples] : feed_.timeline().processes()) {
    const auto& rows = samples.rows;
    ProcessRow row;
    row.name = name;
    row.last = &rows.back();
    if (rows.size() > 1 && rows[rows.size() - 2].boot_id == row.last->boot_id) {
      const auto& before = rows[rows.size() - 2];
      const double wall_s = ToSeconds(row.last->wall_us - before.wall_us);
      if (wall_s > 0) row.cpu_frac = (row.last->cpu_s - before.cpu_s) / wall_s;
    }
    const auto found = senders_.find(name);
    const Traffic traffic = found == senders_.end() ? Traffic() : found->second;
    if (traffic.last_us != 0) row.age_s = std::max(0.0, ToSeconds(now_us - traffic.last_us));
    row.rate = RateOf(traffic, now_us);
    row.late = row.age_s > kLateS && row.last->state != ProcessState::kEnded;
    row.state = row.late ? "silent" : ToString<ProcessState>(row.last->state);
    if (!row.late && row.last->state == ProcessState::kDeciding) {
      row.decides_s = std::max(0.0, ToSeconds(now_us - row.last->since_wall_us));
    }
    processes.push_back(std::move(row));
  }
  return processes;
}

std::vector<std::string> TopView::SilentProcesses(std::int64_t now_us) const {
  std::vector<std::string> silent;
  for (const ProcessRow& row : Processes(now_us)) {
    if (row.late) silent.push_back(row.name);
  }
  return silent;
}

void TopView::AddAttention(std::int64_t now_us, std::vector<Line>* lines) const {
  constexpr std::size_t kShown = 3;  // of each kind
  const std::vector<Concern> all = Attention(feed_.timeline(), SilentProcesses(now_us));
  lines->push_back(
      {all.empty() ? "ATTENTION: nothing" : fmt::format("ATTENTION: {}", all.size()), Look::kHead});
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i;
    while (end < all.size() && all[end].kind == all[i].kind) ++end;
    std::string text = fmt::format("{}: {}", all[i].kind, end - i);
    for (std::size_t k = i; k < std::min(end, i + kShown); ++k) {
      text += fmt::format("{}{}{}", k == i ? "  " : "; ", Ascii(all[k].who),
                          all[k].note.empty() ? "" : " " + all[k].note);
    }
    if (end - i > kShown) text += "; ...";
    lines->push_back({std::move(text), all[i].bad ? Look::kBad : Look::kPlain});
    i = end;
  }
}

void TopView::AddProcesses(std::int64_t now_us, std::vector<Line>* lines) const {
  constexpr const char* kRow = "{:<14}{:<16}{:>6}{:>7}{:>8}{:>9}{:>7}{:>9}{:>8}{:>7}{:>6}{:>9}";
  lines->push_back({fmt::format(kRow, "PROCESS", "state", "age", "msg/s", "kB/s", "received",
                                "lost", "rejected", "resent", "starts", "CPU %", "memory"),
                    Look::kHead});
  for (const ProcessRow& row : Processes(now_us)) {
    const Timeline::ProcessSample& now = *row.last;
    const std::string state = row.decides_s < 0
                                  ? std::string(row.state)
                                  : fmt::format("{} {:.1f} s", row.state, row.decides_s);
    const std::string cpu = row.cpu_frac < 0 ? "-" : fmt::format("{:.0f}", 100 * row.cpu_frac);
    const std::string memory =
        now.rss_bytes <= 0 ? "-"
                           : fmt::format("{:.1f} MB", static_cast<double>(now.rss_bytes) / 1e6);
    lines->push_back(
        {fmt::format(
             kRow, Ascii(row.name), state, Age(row.age_s), fmt::format("{:.0f}", row.rate.messages),
             fmt::format("{:.1f}", row.rate.bytes / 1000), Amount(now.received), Amount(now.lost),
             Amount(now.rejected), Amount(now.resent), now.boot_id + 1, cpu, memory),
         row.late || now.state == ProcessState::kDegraded ? Look::kBad : Look::kPlain});
  }
}

std::int64_t TopView::ToldUs(std::int64_t now_us) const {
  return ended() || all_.last_us == 0 ? all_.last_us : now_us;
}

std::string TopView::Json(std::int64_t now_us) const {
  using Json = nlohmann::ordered_json;
  now_us = ToldUs(now_us);
  const Timeline& timeline = feed_.timeline();
  const auto or_null = [](double value) { return value < 0 ? Json() : Json(value); };
  Json json = {{"version", 1},
               {"scenario", timeline.scenario().name},
               {"at_s", static_cast<double>(timeline.now_ms()) * 1e-3},
               {"limit_s", ToSeconds(timeline.scenario().rules.limit_us)},
               {"at", nullptr},
               {"ended", timeline.ended()},
               {"decision", nullptr},
               {"policy", nullptr}};
  if (const auto& start = timeline.scenario().start) {
    json["at"] = MomentText(start->unix_us + timeline.now_ms() * 1000, start->offset_min);
  }
  if (const auto& schedules = timeline.schedules().rows; !schedules.empty()) {
    json["decision"] = schedules.back().decision;
    json["policy"] = schedules.back().policy;
  }
  const auto tasks = TaskCounts();
  for (std::size_t i = 0; i < tasks.size(); ++i) json["tasks"][kNames<TaskStatus>[i]] = tasks[i];
  for (const AgentKind kind : kAgentKinds) {
    const auto count = AgentCounts(kind);
    Json& agents = json["agents"][std::string(ToString(kind))];
    for (std::size_t i = 0; i < count.size(); ++i) agents[kNames<AgentStatus>[i]] = count[i];
  }
  const Rate rate = RateOf(all_, now_us);
  json["bus"] = {{"messages_per_s", rate.messages},
                 {"bytes_per_s", rate.bytes},
                 {"age_s", or_null(all_.last_us == 0 ? -1 : ToSeconds(now_us - all_.last_us))}};
  if (const auto air = AirPictureOf(timeline)) {
    json["air"] = {{"uavs", air->n},
                   {"lowest_m", air->lowest_m},
                   {"highest_m", air->highest_m},
                   {"nearest", nullptr}};
    if (air->nearest) {
      json["air"]["nearest"] = {{"uavs", {air->nearest->a, air->nearest->b}},
                                {"across_m", air->nearest->approach.across_m},
                                {"up_m", air->nearest->approach.up_m}};
    }
  }
  json["attention"] = Json::array();
  for (const Concern& concern : Attention(timeline, SilentProcesses(now_us))) {
    json["attention"].push_back(
        {{"kind", concern.kind}, {"who", concern.who}, {"note", concern.note}});
  }
  json["processes"] = Json::array();
  for (const ProcessRow& row : Processes(now_us)) {
    json["processes"].push_back({{"name", row.name},
                                 {"state", row.state},
                                 {"deciding_s", or_null(row.decides_s)},
                                 {"age_s", or_null(row.age_s)},
                                 {"messages_per_s", row.rate.messages},
                                 {"bytes_per_s", row.rate.bytes},
                                 {"received", row.last->received},
                                 {"lost", row.last->lost},
                                 {"rejected", row.last->rejected},
                                 {"resent", row.last->resent},
                                 {"starts", row.last->boot_id + 1},
                                 {"cpu_frac", or_null(row.cpu_frac)},
                                 {"rss_bytes", row.last->rss_bytes}});
  }
  // Names come from the bus: whatever is not UTF-8 is replaced.
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

std::vector<TopView::Line> TopView::Lines(std::int64_t now_us, std::size_t width) const {
  std::vector<Line> lines;
  if (!feed_.ready()) {
    lines.push_back(
        {feed_.heard_run_id() ? "heard a mission; waiting for its scenario" : "nothing heard yet"});
  } else {
    now_us = ToldUs(now_us);
    lines.push_back({MissionLine(), Look::kHead});
    lines.push_back({TaskLine()});
    if (std::string air = AirLine(); !air.empty()) lines.push_back({std::move(air)});
    lines.push_back({BusLine(now_us)});
    lines.push_back({});
    AddAgents(&lines);
    lines.push_back({});
    AddAttention(now_us, &lines);
    lines.push_back({});
    AddProcesses(now_us, &lines);
  }
  for (Line& line : lines) {
    if (width > 0 && line.text.size() > width) line.text.resize(width);
  }
  return lines;
}

}  // namespace muster::tools
