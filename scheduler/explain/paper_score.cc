#include <algorithm>
#include <cmath>
#include <utility>

#include "scheduler/explain/explain.h"
#include "scheduler/explain/forced.h"
#include "scheduler/solver/actions.h"
#include "scheduler/solver/build.h"
#include "scheduler/solver/solver.h"

namespace muster::scheduler {
namespace {

/// Index of the agent of that kind and id, or -1.
std::int32_t IndexOf(const std::vector<const AgentState*>& agents, AgentKind kind,
                     std::int32_t id) {
  for (std::size_t i = 0; i < agents.size(); ++i) {
    if (agents[i]->kind == kind && agents[i]->id == id) return static_cast<std::int32_t>(i);
  }
  return -1;
}

template <class Id>
std::int32_t IndexOf(const std::vector<Id>& ids, Id id) {
  const auto found = std::find(ids.begin(), ids.end(), id);
  return found == ids.end() ? -1 : static_cast<std::int32_t>(found - ids.begin());
}

bool Senses(const std::vector<Action>& actions, TaskId task) {
  return std::any_of(actions.begin(), actions.end(), [task](const Action& a) {
    return a.kind == ActionKind::kSense && a.task == task;
  });
}

/// The paper's weights, and exact decisions. Feasibility and weights are EnumerateCandidates'.
class ByPaper : public Score {
 public:
  ByPaper(const Situation& situation, std::vector<Action> commanded)
      : commanded_(std::move(commanded)), look_(situation), built_(BuildInstance(situation)) {
    const SolverResult solved = Solve(built_.instance);
    best_ = OptimumOf(solved.assignment, solved.assignment.weight, solved.bound);
  }

  Terms terms() const override { return Terms::kPaper; }
  const Look& look() const override { return look_; }
  const std::vector<Action>& commanded() const override { return commanded_; }

  Action DoneBy(AgentKind kind, std::int32_t id) const override {
    Action action = Score::DoneBy(kind, id);
    const bool logged = std::find(commanded_.begin(), commanded_.end(), action) != commanded_.end();
    if (!logged) action.weight = look_.WeightOf(action).value_or(0);
    return action;
  }

  void Oppose(Option* option) const override {
    option->uav_did = DoneBy(AgentKind::kUav, option->pair.uav.value);
    option->partner_did =
        DoneBy(option->charging ? AgentKind::kVehicle : AgentKind::kWorker, option->pair.partner);
    for (const Action& action : commanded_) {
      if (!IsPair(action.kind)) continue;
      const std::int32_t at = option->charging ? action.charge.value : action.task.value;
      if (at == option->site) option->site_holder = action;
    }
  }

  std::optional<Forcing> Force(const Demand& demand) const override {
    const auto pair = InInstance(demand);
    const auto forced = pair ? SolveWith(built_.instance, *pair) : std::nullopt;
    if (!forced) return {};
    Forcing forcing =
        ForcingOf(best_, OptimumOf(forced->assignment, forced->weight, forced->bound));
    for (const Action& action : forcing.with.actions) {
      if (!IsPair(action.kind)) continue;
      const bool meets =
          (!demand.task.valid() || action.task == demand.task) &&
          (!demand.charge.valid() || action.charge == demand.charge) &&
          (!demand.agent_kind || MemberOf(action, *demand.agent_kind) == demand.agent);
      if (meets) forcing.pair = action;
    }
    for (const Action& action : best_.actions) {
      if (action.kind == ActionKind::kSense && !Senses(forcing.with.actions, action.task)) {
        forcing.displaced.push_back(action.task);
      }
    }
    std::sort(forcing.displaced.begin(), forcing.displaced.end());
    return forcing;
  }

  DecisionQuality Quality() const override {
    constexpr double kSame = 1e-6;  // weights closer than this are equal
    const Situation& situation = look_.situation();
    DecisionQuality quality;
    quality.best = best_;
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentState& agent : situation.agents(kind)) {
        if (!agent.idle(situation.now_us)) continue;
        const Action action = DoneBy(kind, agent.id);
        // A pair counts once, with its UAV.
        if (IsPair(action.kind) && kind != AgentKind::kUav) continue;
        const std::optional<double> weight = look_.WeightOf(action);
        quality.weight += weight.value_or(0);
        if (!weight || std::abs(*weight - action.weight) > kSame) quality.own_weights = true;
      }
    }
    return quality;
  }

 private:
  Optimum OptimumOf(const Assignment& assignment, double weight, double bound) const {
    return {weight, std::max(bound, weight), ActionsOf(built_, assignment, look_.situation())};
  }

  /// None: no action of the instance can meet it.
  std::optional<PairDemand> InInstance(const Demand& demand) const {
    PairDemand pair;
    if (demand.task.valid()) {
      pair.site = IndexOf(built_.tasks, demand.task);
      if (pair.site < 0) return {};
    } else if (demand.charge.valid()) {
      pair.site = IndexOf(built_.charges, demand.charge);
      if (pair.site < 0) return {};
      pair.site += built_.n_tasks();
    }
    if (demand.agent_kind) {
      const bool is_uav = *demand.agent_kind == AgentKind::kUav;
      std::int32_t& index = is_uav ? pair.uav : pair.partner;
      index = IndexOf(is_uav ? built_.uavs : built_.partners, *demand.agent_kind, demand.agent);
      if (index < 0) return {};
    }
    return pair;
  }

  std::vector<Action> commanded_;
  PaperLook look_;
  BuiltInstance built_;
  Optimum best_;
};

}  // namespace

std::unique_ptr<Score> PaperScore(const Situation& situation, std::vector<Action> commanded) {
  return std::make_unique<ByPaper>(situation, std::move(commanded));
}

}  // namespace muster::scheduler
