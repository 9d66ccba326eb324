// The log's events against the outcomes that followed from the ticks.
#include <fmt/format.h>

#include <algorithm>

#include "tools/audit/checks.h"

namespace muster::tools::audit {

void CheckEvents(const View& view, const std::vector<event_t>& events, std::int64_t until_us) {
  std::set<EventKey> seen;
  for (const event_t& event : events) {
    if (!IsOutcome(static_cast<EventKind>(event.kind))) continue;
    const EventKey key = KeyOf(event);
    const std::int64_t at = event.at_us;
    if (!seen.insert(key).second) {
      view.findings->Add(at, "events", "said twice: {}", Name(key));
    }
    if (at > until_us || event.kind == EventKind::kAgentBack) continue;
    if (!view.expected.contains(key)) {
      view.findings->Add(at, "events", "said but not so: {}", Name(key));
    }
  }
  for (const EventKey& key : view.expected) {
    if (std::get<0>(key) <= until_us && !seen.contains(key)) {
      view.findings->Add(std::get<0>(key), "events", "not said: {}", Name(key));
    }
  }
  // When an agent comes back is the fault injector's word; it must lie in the tick that shows it.
  std::size_t n_back = 0;
  for (const auto& [agent, after, at] : view.expected_back) {
    const auto [kind, id] = agent;
    const auto fits = [kind = kind, id = id, from = after, to = at](const EventKey& key) {
      const int ids[] = {std::get<2>(key), std::get<3>(key), std::get<4>(key)};
      return std::get<1>(key) == EventKind::kAgentBack && ids[kind] == id &&
             std::get<0>(key) > from && std::get<0>(key) <= to;
    };
    if (std::any_of(seen.begin(), seen.end(), fits)) {
      ++n_back;
    } else {
      view.findings->Add(at, "events", "not said: agent back {}:{} in ({}, {}] us",
                         ToString<AgentKind>(kind), id, after, at);
    }
  }
  const auto n_said =
      static_cast<std::size_t>(std::count_if(seen.begin(), seen.end(), [&](const EventKey& key) {
        return std::get<1>(key) == EventKind::kAgentBack && std::get<0>(key) <= until_us;
      }));
  if (n_said > n_back) {
    view.findings->Add(until_us, "events", "{} agents said to be back, {} came back", n_said,
                       n_back);
  }
}

}  // namespace muster::tools::audit
