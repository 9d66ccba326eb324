// A scheduler with a policy of its own: of all pairs that could sense or charge, those that are
// done soonest, one after the other, as long as nobody is in two. UAVs charge below 40 % of their
// range. Who is in no pair stays.

#include <algorithm>
#include <utility>

#include "scheduler/candidates.h"
#include "scheduler/process/scheduler_main.h"

namespace {

using namespace muster;
using namespace muster::scheduler;

constexpr double kChargeBelow = 0.4;

class Soonest : public Policy {
 public:
  Decision Decide(const Situation& situation) override {
    const Candidates candidates = EnumerateCandidates(situation);
    const Feasibility feasible(situation, candidates.weights);
    std::vector<std::pair<TimeUs, Node>> pairs;  // and when they would be done
    for (const Node& node : candidates.nodes) {
      if (node.kind == ActionKind::kSense) {
        pairs.emplace_back(feasible.SenseEnd(node.uav, node.site, node.partner), node);
      } else if (node.kind == ActionKind::kCharge) {
        const auto row = static_cast<std::size_t>(node.uav);
        const auto position = static_cast<std::size_t>(candidates.weights.uavs[row]);
        const AgentState& uav = situation.uavs[position];
        if (situation.range_m(uav) > kChargeBelow * uav.range_full_m) continue;
        pairs.emplace_back(feasible.ChargeEnd(node.uav, node.site, node.partner), node);
      }
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
