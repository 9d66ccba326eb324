#include "tools/record/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "tools/log/air_record.h"
#include "tools/record/digest.h"
#include "tools/record/report_json.h"
#include "tools/record/service.h"

namespace muster::tools {
namespace {

std::string Times(double seconds) {
  return seconds < 1 ? fmt::format("{:.1f} ms", seconds * 1e3) : fmt::format("{:.2f} s", seconds);
}

std::string Range(const char* what, std::int64_t first, std::int64_t last) {
  return first == last ? fmt::format("{} {}", what, first)
                       : fmt::format("{} {} to {}", what, first, last);
}

/// How often that happened, and the detail of the first time.
std::pair<std::size_t, std::string> TimesOf(const RunRecord& record, EventKind kind) {
  std::pair<std::size_t, std::string> times;
  for (const event_t& event : record.events()) {
    if (event.kind == kind && ++times.first == 1) times.second = Printable(event.detail);
  }
  return times;
}

std::string LogLine(const RunRecord& record) {
  const RunRecord::Completeness log = record.CheckComplete();
  if (log.complete) return fmt::format("complete, {} messages", record.counts().messages);
  std::string text = fmt::format("NOT COMPLETE, {} messages", record.counts().messages);
  std::int64_t n_missing = log.n_missing;
  if (record.scenario() && !log.ended) {
    --n_missing;  // the end itself
    const Rules& rules = record.scenario()->rules;
    const std::int64_t last_tick = std::max<std::int64_t>(0, log.last_tick);
    text += fmt::format("; ends at {:.1f} of {:.0f} min{}", ToMinutes(rules.TimeOf(last_tick)),
                        ToMinutes(rules.limit_us),
                        n_missing == 0 && log.gaps.empty() && log.damage.empty()
                            ? ", all until then is there"
                            : "");
  }
  if (!log.damage.empty()) text += fmt::format("; {}", log.damage.front());
  if (!log.gaps.empty()) {
    const RunRecord::Gap& gap = log.gaps.front();
    text += fmt::format("; {} gaps, first: {} (start {}) {}", log.gaps.size(), gap.sender,
                        gap.boot_id, Range("seq", gap.first_seq, gap.last_seq));
  }
  if (n_missing > 0) {
    const RunRecord::Missing& m = log.missing.front();
    text +=
        fmt::format("; {} missing, first: {} {}", n_missing, m.owner,
                    Range(m.owner == "schedule" ? "decision" : "tick", m.first_tick, m.last_tick));
  }
  if (log.repeated > 0) text += fmt::format("; {} agent states said twice", log.repeated);
  return text;
}

std::string ServiceLine(const Service& service) {
  std::string text =
      fmt::format("worth {:.4g} of {:.4g}, {} of {} on time, {} expired", service.worth_done,
                  service.worth_all, service.on_time(), service.reported(), service.expired);
  if (!service.response_s.empty()) {
    text += fmt::format("; response {:.1f} min on average, 90 % within {:.1f}",
                        service.mean_response_s() / 60, service.response_quantile_s(0.9) / 60);
  }
  return text;
}

std::string ArrivalsLine(const std::vector<MeasuredLeg>& legs) {
  std::size_t arrived = 0;
  double late_s = 0, most_s = 0;
  for (const MeasuredLeg& leg : legs) {
    if (!leg.arrived_us) continue;
    const double late = ToSeconds(*leg.arrived_us - leg.planned_us);
    most_s = ++arrived == 1 ? late : std::max(most_s, late);
    late_s += late;
  }
  std::string text = fmt::format("{} of {} as measured", arrived, legs.size());
  if (arrived == 0) return text;
  return text + fmt::format(", {:.0f} s later than planned on average, {:.0f} s at most",
                            late_s / static_cast<double>(arrived), most_s);
}

/// Agents that failed, and processes that the world went on without; "": none.
std::string LostLine(const RunRecord& record) {
  std::size_t failed = 0;
  std::size_t back = 0;
  std::set<std::string> processes;
  for (const event_t& event : record.events()) {
    failed += event.kind == EventKind::kAgentFailed ? 1 : 0;
    back += event.kind == EventKind::kAgentBack ? 1 : 0;
    if (event.kind == EventKind::kProcessLost && event.header.sender == process_name::kWorld) {
      processes.insert(Printable(event.detail));
    }
  }
  std::vector<std::string> parts;
  if (failed > 0) parts.push_back(fmt::format("{} agents failed, {} came back", failed, back));
  if (!processes.empty()) {
    parts.push_back(fmt::format("without {} for a time", fmt::join(processes, ", ")));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

std::string SeparationLine(const RunRecord& record) {
  const AirSummary air = SummaryOf(record.air(), *record.scenario(), record.skipped_decisions());
  std::string text = fmt::format("{} conflicts", air.conflicts);
  if (air.closest) {
    text += fmt::format(", closest {:.0f} m across and {:.0f} m up",
                        air.closest->approach.horizontal_m, air.closest->approach.vertical_m);
  }
  if (air.held > 0) {
    text += fmt::format("; {} UAVs waited {:.0f} s in all for their altitude", air.held,
                        ToSeconds(air.held_us));
  }
  return text;
}

}  // namespace

std::string Summary(const RunRecord& record) {
  std::string text;
  const auto row = [&text](std::string_view name, const std::string& value) {
    fmt::format_to(std::back_inserter(text), "{:<14} {}\n", name, value);
  };
  if (!record.scenario()) {
    row("log", LogLine(record));
    return text;
  }
  const Scenario& scenario = *record.scenario();
  const std::size_t total = scenario.n_tasks();
  std::size_t done = 0;
  if (record.final_world()) {
    const auto& status = record.final_world()->task_status;
    done = static_cast<std::size_t>(std::count(status.begin(), status.end(), 3));
  }
  std::size_t charges = 0;
  for (const event_t& event : record.events())
    charges += event.kind == EventKind::kChargingDone ? 1 : 0;
  double flown_m = 0;
  for (const Track& track : record.tracks()) flown_m += track.length_m();
  double weight = 0;
  double bound = 0;  // NaN as soon as one decision has none
  for (const auto& [index, schedule] : record.schedules()) {
    weight += schedule.weight;
    bound += schedule.bound;
  }
  const DecisionTime time = DecisionTimeOf(record);

  row("scenario",
      fmt::format("{}, {} UAVs, {} workers, {} vehicles, {:.0f} min", Printable(scenario.name),
                  scenario.n_agents(AgentKind::kUav), scenario.n_agents(AgentKind::kWorker),
                  scenario.n_agents(AgentKind::kVehicle), ToMinutes(scenario.rules.limit_us)));
  row("tasks done",
      total == 0 ? fmt::format("{} of {}", done, total)
                 : fmt::format("{} of {} ({:.1f} %)", done, total,
                               100.0 * static_cast<double>(done) / static_cast<double>(total)));
  if (scenario.IsOpen()) row("served", ServiceLine(ServiceOf(record, scenario)));
  if (const auto legs = record.measured_legs(); !legs.empty()) row("arrivals", ArrivalsLine(legs));
  row("charges", fmt::format("{}", charges));
  row("flown", fmt::format("{:.1f} km", flown_m * 1e-3));
  row("decisions", fmt::format("{} of {}, total weight {:.6g}{}", record.schedules().size(),
                               scenario.decisions(), weight,
                               std::isnan(bound) ? "" : fmt::format(" (bound {:.6g})", bound)));
  if (scenario.separation() != nullptr) row("separation", SeparationLine(record));
  const auto [refused, first_refused] = TimesOf(record, EventKind::kAnswerRefused);
  if (refused > 0) {
    row("refused",
        fmt::format("{} answers of the outside scheduler, first: {}", refused, first_refused));
  }
  const auto [disputes, first_dispute] = TimesOf(record, EventKind::kDecisionsDiffer);
  if (disputes > 0) {
    row("disputes", fmt::format("{} among the schedulers, first: {}", disputes, first_dispute));
  }
  if (const std::string lost = LostLine(record); !lost.empty()) row("lost", lost);
  row("decision time", fmt::format("median {}, max {}", Times(time.median_s), Times(time.max_s)));
  if (record.wall_s() > 0) row("wall time", fmt::format("{:.2f} s", record.wall_s()));
  row("log", LogLine(record));
  row("digest", Digest(record));
  return text;
}

}  // namespace muster::tools
