#include "tools/faults/score.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "base/check.h"
#include "model/agent.h"
#include "protocol/convert.h"
#include "protocol/fault_kinds.h"
#include "protocol/process.h"
#include "tools/record/digest.h"

namespace muster::tools {
namespace {

using Agent = std::pair<AgentKind, std::int32_t>;

Agent AgentOf(const event_t& event) {
  if (event.uav_id >= 0) return {AgentKind::kUav, event.uav_id};
  if (event.worker_id >= 0) return {AgentKind::kWorker, event.worker_id};
  return {AgentKind::kVehicle, event.vehicle_id};
}

/// What the log says of one fault.
class Case {
 public:
  Case(const PlannedFault& fault, const FaultEvidence& evidence)
      : fault_(fault), evidence_(evidence), record_(evidence.record) {
    for (const event_t& event : record_.events()) {
      if (event.fault_id == fault.id && event.kind == EventKind::kFaultApplied && !applied_)
        applied_ = &event;
      if (event.fault_id == fault.id && event.kind == EventKind::kFaultEnded) {
        ended_ = &event;
        packets_ += HitsOf(event.detail).value_or(0);
      }
    }
    FindFelled();
  }

  std::string Effect() const {
    if (applied_ == nullptr) return "";
    const FaultRow& row = RowOf(fault_.kind);
    if (row.of_packets()) {
      return packets_ == 0 ? "" : fmt::format("{} packets", packets_);
    }
    return row.of_agents() && felled_.empty() ? "" : std::string(row.effect);
  }

  /// How long until all was well again.
  std::string Recovery() const {
    if (applied_ == nullptr) return "";
    if (RowOf(fault_.kind).of_agents()) {
      const auto [done, open] = Interrupted();
      if (open > 0) return fmt::format("{} task{} left open", open, open == 1 ? "" : "s");
      if (done < 0) return "";
      return fmt::format("task done after {:.1f} min", ToMinutes(done - fault_.at_us));
    }
    if (RowOf(fault_.kind).of_packets() && !RowOf(fault_.kind).holds_clock) return "";
    const std::int64_t from = applied_->header.wall_us;
    for (const event_t& event : record_.events()) {
      const bool target =
          event.detail == fault_.target || event.detail.rfind(fault_.target + ",", 0) == 0;
      if (event.kind == EventKind::kProcessBack && target && event.header.wall_us >= from) {
        return fmt::format("back after {:.2f} s", ToSeconds(event.header.wall_us - from));
      }
    }
    // No process was missed: the clock went on by itself.
    const std::int64_t over = ended_ == nullptr ? from : ended_->header.wall_us;
    for (const auto& [t, wall_us] : evidence_.clock_wall_us) {
      if (wall_us < over) continue;
      return fmt::format("clock on {:.2f} s after its end", ToSeconds(wall_us - over));
    }
    return "";
  }

  /// Ticks from the fault until the mission reported it; -1: it never did.
  std::int64_t DetectedTicks() const {
    std::optional<TimeUs> said_us;
    const auto take = [&](const event_t& event) {
      if (event.header.sim_us >= fault_.at_us && (!said_us || event.header.sim_us < *said_us)) {
        said_us = event.header.sim_us;
      }
    };
    for (const event_t& event : record_.events()) {
      if (RowOf(fault_.kind).of_agents() && event.kind == EventKind::kAgentFailed &&
          event.detail == fault_.id) {
        take(event);
      }
      const bool target =
          event.detail == fault_.target || event.detail.rfind(fault_.target + " ", 0) == 0;
      if (!RowOf(fault_.kind).of_agents() && event.kind == EventKind::kProcessLost && target)
        take(event);
    }
    if (!said_us) return -1;
    const TimeUs tick_us = record_.scenario()->rules.tick_us;
    return (*said_us - fault_.at_us + tick_us - 1) / tick_us;
  }

  /// Of the felled agents' partners that were online at the next decision: the most decisions until
  /// one could be commanded again. None: there was no such partner; -1: one never could.
  std::optional<std::int64_t> ReleasedDecisions() const {
    std::optional<std::int64_t> most;
    const Rules& rules = record_.scenario()->rules;
    for (const event_t* aborted : aborted_) {
      const Agent partner = PartnerIn(*aborted);
      const std::int32_t first = rules.LastDecisionBefore(aborted->at_us) + 1;
      const auto& specs = record_.scenario()->agents(partner.first);
      if (specs[static_cast<std::size_t>(partner.second)].online_until_us <=
              rules.TimeOfDecision(first) ||
          felled_.count(partner) > 0) {
        continue;
      }
      std::int64_t n = -1;
      const auto words = evidence_.words.find(partner);
      for (auto d = first; words != evidence_.words.end() && d < record_.scenario()->decisions();
           ++d) {
        // What it says after the decision: it obeys, or it was free to and got no command.
        const auto word = words->second.upper_bound(rules.TimeOfDecision(d));
        if (word == words->second.end()) break;
        if (!word->second.idle && word->second.decision != d) continue;
        n = d - first + 1;
        break;
      }
      if (n < 0) return -1;
      most = std::max(most.value_or(0), n);
    }
    return most;
  }

  /// When the last of the tasks that it interrupted was done (-1: none was interrupted), and how
  /// many were not.
  std::pair<TimeUs, int> Interrupted() const {
    std::set<std::int32_t> tasks;
    for (const event_t* aborted : aborted_) {
      if (aborted->kind == EventKind::kSensingAborted) tasks.insert(aborted->task_id);
    }
    TimeUs last = -1;
    int open = 0;
    for (const std::int32_t task : tasks) {
      const auto done = std::find_if(
          record_.events().begin(), record_.events().end(),
          [&](const event_t& e) { return e.kind == EventKind::kSensingDone && e.task_id == task; });
      if (done == record_.events().end()) {
        ++open;
      } else {
        last = std::max(last, done->at_us);
      }
    }
    return {last, open};
  }

 private:
  /// The agents that failed by it, and what was aborted then.
  void FindFelled() {
    std::set<std::pair<Agent, TimeUs>> when;
    const TimeUs until_us = fault_.for_us > 0 ? fault_.at_us + fault_.for_us : kNever;
    for (const event_t& event : record_.events()) {
      if (event.kind != EventKind::kAgentFailed) continue;
      const bool by_loss = event.detail == LossDetail(fault_.target) &&
                           event.header.sim_us >= fault_.at_us && event.at_us < until_us;
      if (event.detail != fault_.id && !by_loss) continue;
      felled_.insert(AgentOf(event));
      when.insert({AgentOf(event), event.at_us});
    }
    for (const event_t& event : record_.events()) {
      if (event.kind != EventKind::kSensingAborted && event.kind != EventKind::kChargingAborted)
        continue;
      for (const Agent& agent : MembersOf(event)) {
        if (when.count({agent, event.at_us}) > 0) {
          aborted_.push_back(&event);
          break;
        }
      }
    }
  }
  static std::array<Agent, 2> MembersOf(const event_t& event) {
    const Agent uav{AgentKind::kUav, event.uav_id};
    return {uav, event.kind == EventKind::kSensingAborted
                     ? Agent{AgentKind::kWorker, event.worker_id}
                     : Agent{AgentKind::kVehicle, event.vehicle_id}};
  }
  Agent PartnerIn(const event_t& event) const {
    const auto [one, other] = MembersOf(event);
    return felled_.count(one) > 0 ? other : one;
  }

  const PlannedFault& fault_;
  const FaultEvidence& evidence_;
  const RunRecord& record_;
  const event_t* applied_ = nullptr;
  const event_t* ended_ = nullptr;
  std::int64_t packets_ = 0;
  std::set<Agent> felled_;
  std::vector<const event_t*> aborted_;
};

}  // namespace

void FaultEvidence::Add(const Packet& packet) {
  record.Add(packet, [&](const Message& message, const Packet&) {
    Handle(
        message,
        [&](const agent_states_t& states) {
          for (const agent_t& agent : states.agents) {
            words[{static_cast<AgentKind>(states.kind), agent.id}][states.header.sim_us] = {
                agent.status == AgentStatus::kIdle, agent.decision};
          }
        },
        [&](const clock_t& clock) {
          if (clock.phase != ClockPhase::kRunning) return;
          clock_wall_us.try_emplace(clock.tick_us, clock.header.wall_us);
        });
  });
}

std::vector<FaultScore> ScoreFaults(const FaultPlan& plan, const FaultEvidence& evidence) {
  std::vector<FaultScore> scores;
  const RunRecord& record = evidence.record;
  MUSTER_CHECK(record.scenario(), "no scenario");
  for (const PlannedFault& fault : plan) {
    const Case that(fault, evidence);
    const std::string name = fmt::format("{} {} {}", fault.id, ToString(fault.kind), fault.target);
    const auto add = [&](std::string check, std::string expected, std::string observed, bool met) {
      scores.push_back({name, std::move(check), std::move(expected), std::move(observed), met, ""});
    };
    const std::string effect = that.Effect();
    add("visible effect", "one", effect.empty() ? "none" : effect, !effect.empty());
    scores.back().recovery = that.Recovery();
    const Expectations& expect = fault.expect;
    if (expect.detected_within_ticks) {
      const std::int64_t n = that.DetectedTicks();
      add("detected within", fmt::format("{} ticks", *expect.detected_within_ticks),
          n < 0 ? "never" : fmt::format("{} ticks", n),
          n >= 0 && n <= *expect.detected_within_ticks);
    }
    if (expect.partner_released_within_decisions) {
      const auto n = that.ReleasedDecisions();
      add("partner released within",
          fmt::format("{} decisions", *expect.partner_released_within_decisions),
          !n       ? "there was no partner"
          : *n < 0 ? "never"
                   : fmt::format("{} decisions", *n),
          n && *n >= 0 && *n <= *expect.partner_released_within_decisions);
    }
    if (expect.tasks_finished_by_us) {
      const auto [last, open] = that.Interrupted();
      add("interrupted tasks finished by",
          fmt::format("{:.1f} min", ToMinutes(*expect.tasks_finished_by_us)),
          open > 0   ? fmt::format("{} left open", open)
          : last < 0 ? "none was interrupted"
                     : fmt::format("{:.1f} min", ToMinutes(last)),
          open == 0 && last >= 0 && last <= *expect.tasks_finished_by_us);
    }
    if (expect.completion_rate) {
      double rate = 0;
      if (record.final_world() && !record.final_world()->task_status.empty()) {
        const auto& status = record.final_world()->task_status;
        rate = static_cast<double>(std::count(status.begin(), status.end(), TaskStatus::kDone)) /
               static_cast<double>(status.size());
      }
      add("completion rate at least", fmt::format("{:.3f}", *expect.completion_rate),
          fmt::format("{:.3f}", rate), rate >= *expect.completion_rate);
    }
    if (expect.same_decisions) {
      const bool same = Digest(record) == evidence.undisturbed_digest;
      add("decisions and outcomes", "as undisturbed", same ? "as undisturbed" : "others", same);
    }
  }
  return scores;
}

std::string ToTable(const std::vector<FaultScore>& scores) {
  const auto cells = [](const FaultScore& s) {
    return std::array<std::string, 6>{s.fault,    s.check,    s.expected,
                                      s.observed, s.recovery, s.met ? "met" : "MISSED"};
  };
  std::vector<std::array<std::string, 6>> rows = {
      {"fault", "check", "expected", "observed", "recovery", ""}};
  for (const FaultScore& score : scores) rows.push_back(cells(score));
  std::array<std::size_t, 6> widths{};
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += fmt::format("{:<{}}", row[i], widths[i] + 2);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

}  // namespace muster::tools
