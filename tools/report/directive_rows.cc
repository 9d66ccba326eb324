#include "tools/report/directive_rows.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace muster::tools {
namespace {

struct Row {
  Directive directive;
  TimeUs from_us = 0;
  std::optional<TimeUs> until_us;
};

/// Whether the order ends what that directive says.
bool Ends(const Order& order, const Directive& one) {
  using What = Directive::Kind;
  if (order.kind == OrderKind::kUnpin) return one.kind == What::kPin && one.task == order.task_id;
  if (order.kind == OrderKind::kRelease) return one.order == order.closure;
  // The later word of its kind about an agent stands.
  if (!order.directive || order.directive->kind != one.kind) return false;
  if (one.kind != What::kGoTo && one.kind != What::kChargeNow) return false;
  const AgentKind kind = one.agent_kind();
  return order.directive->agents[kind] == one.agents[kind];
}

}  // namespace

nlohmann::ordered_json DirectiveRows(const OrderBook& orders) {
  const Rules& rules = orders.scenario()->rules;
  std::vector<Row> rows;
  for (const auto& [tick, said] : orders.said()) {
    if (tick > orders.tick()) break;
    const TimeUs t = rules.TimeOf(tick);
    for (const TakenOrder& taken : orders.TakenAt(tick)) {
      if (RowOf(taken.order.kind).subject != OrderSubject::kDirective) continue;
      for (Row& row : rows) {
        if (!row.until_us && Ends(taken.order, row.directive)) row.until_us = t;
      }
      if (!taken.order.directive) continue;
      Row& row = rows.emplace_back();
      row.directive = *taken.order.directive;
      row.directive.order = taken.order.id;
      row.directive.issuer = taken.order.issuer;
      row.from_us = t;
    }
  }
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const auto& [one, from_us, until_us] : rows) {
    constexpr OrderKind kKinds[] = {OrderKind::kPin, OrderKind::kForbid, OrderKind::kChargeNow,
                                    OrderKind::kGoTo};
    json.push_back({from_us / 1000, until_us ? nlohmann::ordered_json(*until_us / 1000) : nullptr,
                    one.order, one.issuer, RowOf(kKinds[static_cast<std::size_t>(one.kind)]).name,
                    ToString(one), one.agents.uavs, one.agents.workers, one.agents.vehicles,
                    one.task});
  }
  return json;
}

}  // namespace muster::tools
