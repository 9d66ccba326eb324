// What the world took of the proposals of several schedulers.
#include <fmt/format.h>

#include <algorithm>

#include "tools/audit/checks.h"

namespace muster::tools::audit {
namespace {

/// The world's event about that decision; null: there is none.
const event_t* DisputeOf(const Heard& heard, std::int32_t decision) {
  const std::string begin = fmt::format("decision {}: ", decision);
  const auto found =
      std::find_if(heard.events.begin(), heard.events.end(), [&](const event_t& event) {
        return event.kind == EventKind::kDecisionsDiffer && event.detail.starts_with(begin) &&
               event.header.sender == heard.clock_sender;
      });
  return found == heard.events.end() ? nullptr : &*found;
}

}  // namespace

void CheckProposals(const View& view, const Heard& heard) {
  if (heard.proposals.empty()) return;
  std::set<std::string> schedulers;
  for (const auto& [decision, by_scheduler] : heard.proposals) {
    for (const auto& [scheduler, hashes] : by_scheduler) schedulers.insert(scheduler);
  }
  for (const auto& [decision, schedule] : heard.schedules) {
    const std::int64_t t = view.scenario.TimeOfDecision(decision);
    const auto altitudes = heard.clearances.find(decision);
    const std::size_t taken =
        DecisionHash(schedule, altitudes == heard.clearances.end() ? nullptr : &altitudes->second);
    const auto found = heard.proposals.find(decision);
    std::size_t agree = 0;
    std::string against;
    if (found != heard.proposals.end()) {
      for (const auto& [scheduler, hashes] : found->second) {
        if (hashes.contains(taken)) ++agree;
        if (hashes.size() > 1 || !hashes.contains(taken)) against = scheduler;
      }
    }
    if (agree == 0) {
      view.findings->Add(t, "proposals", "decision {} is what no scheduler proposed", decision);
      continue;
    }
    const event_t* const dispute = DisputeOf(heard, decision);
    if (!against.empty() && dispute == nullptr) {
      view.findings->Add(t, "proposals", "{} differs on decision {}, and no event says so", against,
                         decision);
    }
    if (against.empty() && dispute != nullptr) {
      view.findings->Add(t, "proposals", "decision {} is said to be disputed, but all agree",
                         decision);
    }
    if (dispute != nullptr && dispute->detail.find(" by majority, ") != std::string::npos &&
        2 * agree <= schedulers.size()) {
      view.findings->Add(t, "proposals", "decision {} is taken by a majority of {} of {}", decision,
                         agree, schedulers.size());
    }
  }
}

}  // namespace muster::tools::audit
