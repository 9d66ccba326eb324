#include "tools/audit/auditor.h"

#include <fmt/format.h>

#include "lcmtypes/channels.h"

namespace muster::tools::audit {
namespace {

constexpr std::size_t kMaxHeldBack = 20'000;

void CheckClock(const View& view) {
  const clock_t& clock = *view.said->clock;
  const auto expect = [&](const char* field, std::int64_t found, std::int64_t expected) {
    if (found == expected) return;
    view.Violate("clock", "clock_t of tick {}: {} is {}, expected {}", clock.tick, field, found,
                 expected);
  };
  expect("tick_us", clock.tick_us, view.now_us);
  expect("limit_us", clock.limit_us, view.scenario.limit_us);
  expect("decision", clock.decision, view.due);
  expect("required_decision", clock.required_decision, view.in_force);
}

}  // namespace

void Auditor::Add(const Packet& packet) {
  if (FindChannel(packet.channel) == nullptr) return;
  if (!view_ && packet.channel != channel::kScenario && packet.channel != channel::kRoads) {
    if (held_back_.size() < kMaxHeldBack) held_back_.push_back(packet);
    return;
  }
  intake_.Take(packet);
  if (!view_ && intake_.heard().scenario) {
    view_.emplace(*intake_.heard().scenario, &findings_);
    reports_.emplace(*view_);
    for (const Packet& held : std::exchange(held_back_, {})) Add(held);
  }
  while (view_ && !intake_.stopped()) {
    const TickFacts* tick = intake_.Next();
    if (tick == nullptr) break;
    Begin(*tick);
    CheckTick();
    view_->Holds() ? intake_.Drop() : intake_.Stop();
  }
}

void Auditor::Begin(const TickFacts& tick) {
  View& view = *view_;
  view.tick = intake_.next_tick();
  view.before_us = view.tick == 0 ? -1 : view.now_us;
  view.now_us = view.scenario.TimeOf(view.tick);
  if (view.due >= 0 && view.schedule != nullptr) view.in_force = view.due;
  view.scenario.extra_ticks = intake_.heard().scenario->extra_ticks;
  view.due = view.scenario.DecisionAt(view.tick);
  view.schedule = intake_.ScheduleOfNext();
  view.clearances = intake_.ClearancesOfNext();
  view.said = &tick;
  view.found_before = findings_.count();
}

void Auditor::CheckTick() {
  View& view = *view_;
  CheckClock(view);
  reports_->TakeLate(view, intake_.TakeLate());
  orders_.CheckWays(view);
  reports_->Check(view);
  orders_.Check(view);
  signatures_.Check(view);
  if (!view.Holds()) return;
  ReadRulings(view);
  CheckSaidFailed(view);
  CheckActivities(view);
  if (!view.Holds()) return;
  AbortActivities(view);
  SettleAgents(view);
  CheckMeetings(view);
  CheckTasks(view);
  ExpectEvents(view);
  if (view.due >= 0 && view.schedule == nullptr) {
    skipped_.insert(view.due);
    AllowOwnActions(view);
  }
  if (view.Holds() && view.schedule != nullptr) {
    CheckDecision(view);
    if (view.clearances != nullptr) CheckSeparation(view);
    view.withheld.clear();
    for (const event_t& event : intake_.heard().events) {
      const bool is_now = event.at_us == view.now_us && event.kind == EventKind::kActionWithheld;
      if (is_now) view.withheld.insert(event.task_id);
    }
    CheckDirectives(view);
  }
}

void Auditor::CheckSkipped() {
  for (const std::int32_t decision : skipped_) {
    const std::int64_t t = view_->scenario.TimeOfDecision(decision);
    // The world must have said that a process is lost, and not yet that it is back.
    std::set<std::string> lost;
    for (const event_t& event : intake_.heard().events) {
      if (event.at_us > t || event.header.sender != intake_.heard().clock_sender) continue;
      if (event.kind == EventKind::kProcessLost) lost.insert(event.detail);
      if (event.kind == EventKind::kProcessBack) lost.erase(event.detail);
    }
    if (lost.empty()) {
      findings_.Add(t, "lockstep", "the clock does not require decision {}, and nobody was lost",
                    decision);
    }
  }
}

const std::vector<Violation>& Auditor::Finish() {
  if (!view_) {
    if (findings_.count() == 0) {
      findings_.Add(0, "scenario", "the log has no {}",
                    intake_.waits_for_roads() ? "roads_t, which its scenario names" : "scenario_t");
    }
    return findings_.Sorted();
  }
  intake_.Finish();
  // Where checking stopped, nothing is expected of what came later.
  CheckEvents(*view_, intake_.heard().events,
              intake_.stopped() ? view_->before_us : view_->scenario.limit_us);
  CheckSkipped();
  CheckProposals(*view_, intake_.heard());
  if (!intake_.stopped()) GatherFacts();
  return findings_.Sorted();
}

void Auditor::GatherFacts() {
  reports_->TakeLate(*view_, intake_.TakeLate());
  const Heard& heard = intake_.heard();
  facts_.emplace();
  facts_->sha256 = heard.sha256;
  facts_->seed = view_->scenario.seed;
  facts_->schedules = heard.schedules;
  for (const std::int32_t decision : skipped_) facts_->schedules.erase(decision);
  facts_->events = heard.events;
  facts_->task_status = view_->task_status;
  facts_->task_status.resize(static_cast<std::size_t>(view_->n_tasks));
  for (int id = 0; id < view_->n_agents[kUav]; ++id) {
    const Flown& uav = view_->flown[static_cast<std::size_t>(id)];
    facts_->flown_m.push_back(uav.flown_m);
    facts_->final_range_m.push_back(uav.range_m);
  }
  facts_->messages = heard.messages;
  for (const auto& [decision, schedule] : facts_->schedules) {
    facts_->decided_us[decision] = view_->scenario.TimeOfDecision(decision);
  }
}

}  // namespace muster::tools::audit
