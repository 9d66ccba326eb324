#include <algorithm>
#include <cmath>
#include <utility>

#include "scheduler/explain/explain.h"

namespace muster::scheduler {
namespace {

bool Senses(const std::vector<Action>& actions, TaskId task) {
  return std::any_of(actions.begin(), actions.end(), [task](const Action& a) {
    return a.kind == ActionKind::kSense && a.task == task;
  });
}

/// The paper's weights, and exact decisions. Feasibility and weights are EnumerateCandidates'.
class ByPaper : public Score {
 public:
  ByPaper(const Situation& situation, std::vector<Action> commanded)
      : commanded_(std::move(commanded)), look_(situation), exact_(situation) {}

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
    auto with = exact_.Forced(demand);
    if (!with) return {};
    Forcing forcing = ForcingOf(exact_.best(), std::move(*with));
    for (const Action& action : forcing.with.actions) {
      if (!IsPair(action.kind)) continue;
      const bool meets =
          (!demand.task.valid() || action.task == demand.task) &&
          (!demand.charge.valid() || action.charge == demand.charge) &&
          (!demand.agent_kind || MemberOf(action, *demand.agent_kind) == demand.agent);
      if (meets) forcing.pair = action;
    }
    for (const Action& action : exact_.best().actions) {
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
    quality.best = exact_.best();
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
  std::vector<Action> commanded_;
  PaperLook look_;
  ExactDecisions exact_;
};

}  // namespace

std::unique_ptr<Score> PaperScore(const Situation& situation, std::vector<Action> commanded) {
  return std::make_unique<ByPaper>(situation, std::move(commanded));
}

}  // namespace muster::scheduler
