#include "tools/audit/view.h"

#include <algorithm>

namespace muster::tools::audit {

View::View(const Scenario& of, Findings* to) : scenario(of), findings(to) {
  for (const int kind : kClasses) {
    for (const Scenario::Agent& spec : scenario.agents[kind]) {
      AgentModel model;
      model.kind = kind;
      model.id = static_cast<int>(agents[kind].size());
      model.spec = &spec;
      model.ways = model.leg_ways = scenario.ways.get();
      model.from = model.to = model.was = spec.at;
      model.range_at_departure_m = spec.range_m;
      model.Anchor(spec.at, 0, spec.range_m);
      agents[kind].push_back(model);
      ExpectPresence(model);
    }
    n_agents[kind] = static_cast<int>(agents[kind].size()) - scenario.room_agents[kind];
  }
  n_tasks = static_cast<int>(scenario.tasks.size()) - scenario.room_tasks;
  task_status.assign(scenario.tasks.size(), 0);
  flown.resize(agents[kUav].size());
}

Place View::SiteOf(const Activity& activity) const {
  const auto site = static_cast<std::size_t>(activity.site);
  return activity.senses() ? scenario.tasks[site].at : scenario.charges[site].at;
}

std::int64_t View::DurationOf(const Activity& activity, double range_m) {
  const auto [uav, partner] = MembersOf(activity);
  return activity.senses()
             ? DurationUs(TaskOf(activity.site).cost_m, uav->spec->speed_m_s)
             : DurationUs(uav->spec->range_full_m - range_m, partner->spec->charge_rate_m_s);
}

bool View::IsMeasured(const Activity& activity) {
  const auto [uav, partner] = MembersOf(activity);
  return uav->spec->measured || partner->spec->measured;
}

bool View::GoesRound(const Activity& activity) {
  const auto members = MembersOf(activity);
  return ways_since_us && std::any_of(members.begin(), members.end(), [&](const AgentModel* one) {
           const bool is_on_its_way = one->action == activity.action();
           return (is_on_its_way || one->action == ActionKind::kNone) && one->depart_us == now_us;
         });
}

std::int64_t View::LatestEnd(const AgentModel& model) const {
  return scenario.strict ? std::min(model.spec->online_until_us, scenario.limit_us) : kForever;
}

std::int64_t View::NextTickUs() const {
  return now_us < scenario.limit_us ? scenario.TimeOf(tick + 1) : now_us + scenario.tick_us;
}

void View::Expect(std::int64_t at_us, EventKind kind, const Activity& a) {
  const bool sensing = a.senses();
  expected.insert({at_us, NumberOf(kind), a.uav, sensing ? a.partner : -1, sensing ? -1 : a.partner,
                   sensing ? a.site : -1, sensing ? -1 : a.site});
}

void View::Expect(std::int64_t at_us, EventKind kind, AgentKey agent) {
  expected.insert(KeyOf(at_us, kind, agent));
}

void View::ExpectOfTask(std::int64_t at_us, EventKind kind, std::size_t task) {
  expected.insert({at_us, NumberOf(kind), -1, -1, -1, static_cast<int>(task), -1});
}

void View::ExpectPresence(const AgentModel& model) {
  const Scenario::Agent& spec = *model.spec;
  if (spec.online_from_us >= spec.online_until_us) return;
  if (spec.online_from_us <= scenario.limit_us) {
    Expect(spec.online_from_us, EventKind::kAgentOnline, AgentKey{model.kind, model.id});
  }
  if (spec.online_until_us <= scenario.limit_us) {
    Expect(spec.online_until_us, EventKind::kAgentOffline, AgentKey{model.kind, model.id});
  }
}

EventKey KeyOf(std::int64_t at_us, EventKind kind, AgentKey agent) {
  const auto [of, id] = agent;
  return {at_us,
          NumberOf(kind),
          of == kUav ? id : -1,
          of == kWorker ? id : -1,
          of == kVehicle ? id : -1,
          -1,
          -1};
}

}  // namespace muster::tools::audit
