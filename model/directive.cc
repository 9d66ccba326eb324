#include "model/directive.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/check.h"

namespace muster {
namespace {

std::string AgentsOf(const Directive& directive) {
  std::vector<std::string> names;
  for (const AgentKind kind : kAgentKinds) {
    const std::int32_t id = directive.agents[kind];
    if (id >= 0) names.push_back(fmt::format("{}:{}", ToString(kind), id));
  }
  return fmt::format("{}", fmt::join(names, " and "));
}

}  // namespace

AgentKind Directive::agent_kind() const {
  for (const AgentKind one : kAgentKinds) {
    if (agents[one] >= 0) return one;
  }
  MUSTER_CHECK(false, "order {} names no agent", order);
}

std::string ToString(const Directive& directive) {
  switch (directive.kind) {
    case Directive::Kind::kPin:
      return fmt::format("pin: {} to task {}", AgentsOf(directive), directive.task);
    case Directive::Kind::kForbid:
      return directive.area
                 ? fmt::format("forbid: {}s in an area", ToString(directive.of_class))
                 : fmt::format("forbid: {} task {}", AgentsOf(directive), directive.task);
    case Directive::Kind::kChargeNow:
      return fmt::format(
          "charge now: {}{}", AgentsOf(directive),
          directive.charge < 0 ? "" : fmt::format(" at charge:{}", directive.charge));
    case Directive::Kind::kGoTo:
      return fmt::format("go to: {} to ({:.3f}, {:.3f}) km", AgentsOf(directive),
                         directive.place.x_m / 1000, directive.place.y_m / 1000);
  }
  MUSTER_CHECK(false, "kind={}", static_cast<int>(directive.kind));
}

std::vector<ForbiddenPair> ForbiddenPairs(std::span<const Directive> directives) {
  std::vector<ForbiddenPair> pairs;
  for (const Directive& one : directives) {
    if (one.kind != Directive::Kind::kForbid || one.area) continue;
    const AgentKind kind = one.agent_kind();
    pairs.push_back({kind, one.agents[kind], one.task});
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

bool IsOffLimits(std::span<const Directive> directives, AgentKind kind, Point place) {
  return std::any_of(directives.begin(), directives.end(), [&](const Directive& one) {
    return one.area && one.of_class == kind && IsInside(*one.area, place);
  });
}

}  // namespace muster
