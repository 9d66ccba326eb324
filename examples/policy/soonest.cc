// A scheduler with a policy of its own: of all pairs that could sense or charge, those that are
// done soonest, one after the other, as long as nobody is in two. UAVs charge below 40 % of their
// range. Who is in no pair stays.

#include <algorithm>
#include <utility>

#include "model/agent.h"
#include "scheduler/process/scheduler_main.h"
#include "scheduler/solver/candidates.h"

namespace {

using namespace muster;
using namespace muster::scheduler;

constexpr double kChargeBelow = 0.4;

/// When the pair would be done, by the rule book.
TimeUs EndOf(const Situation& situation, AgentState uav, AgentState partner, const Action& action) {
  for (AgentState* agent : {&uav, &partner}) {
    Begin(agent, action, situation.decision, situation.now_us, Disturbances(), 0);
  }
  return PlanActivity(uav, partner, situation.site->tasks).end_us;
}

class Soonest : public Policy {
 public:
  Decision Decide(const Situation& situation) override {
    const Candidates candidates = EnumerateCandidates(situation);
    std::vector<std::pair<TimeUs, Node>> pairs;  // and when they would be done
    for (const Node& node : candidates.nodes) {
      if (!IsPair(node.kind)) continue;
      const AgentState& uav = candidates.UavOf(node);
      if (node.kind == ActionKind::kCharge &&
          situation.range_m(uav) > kChargeBelow * uav.range_full_m) {
        continue;
      }
      const Action action = candidates.ToAction(situation, node);
      pairs.emplace_back(EndOf(situation, uav, candidates.PartnerOf(node), action), node);
    }
    // Equal ends stay in the order of the candidates: a decision can be repeated.
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::int32_t> places = candidates.elements.capacity;
    std::vector<Action> actions;
    for (const auto& [end_us, node] : pairs) {
      const NodeElements elements = ElementsOf(node, candidates.elements);
      const auto free = [&](std::int32_t e) { return places[static_cast<std::size_t>(e)] > 0; };
      if (!std::all_of(elements.begin(), elements.end(), free)) continue;
      for (const std::int32_t e : elements) --places[static_cast<std::size_t>(e)];
      actions.push_back(candidates.ToAction(situation, node));
    }
    return MakeDecision(std::move(actions), static_cast<std::int64_t>(candidates.nodes.size()));
  }
};

}  // namespace

int main(int argc, char** argv) {
  return SchedulerMain(argc, argv, {{"soonest", [] { return std::make_unique<Soonest>(); }}});
}
