#include "tools/orders/what_if.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <string>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "scheduler/policies/directives/directing.h"
#include "tools/explain/words.h"
#include "tools/host/progress.h"
#include "tools/scenario/order_text.h"

namespace muster::tools {
namespace {

using scheduler::Situation;

/// The same situation under other directives.
Situation Under(const std::vector<Directive>& directives, const Situation& situation) {
  auto site = std::make_shared<scheduler::Site>(*situation.site);
  site->directives = directives;
  site->forbidden = ForbiddenPairs(directives);
  Situation under = situation;
  under.site = std::move(site);
  return under;
}

std::string Weighed(const Action& action) {
  return fmt::format("{} ({:.3f})", Words(action), action.weight);
}

}  // namespace

WhatIf TellWhatIf(const DecisionLog& log, const std::string& run, const Order& order) {
  if (RowOf(order.kind).subject != OrderSubject::kDirective) {
    throw InputError(run, "order", RowOf(order.kind).name,
                     "a directive: pin, unpin, forbid, charge_now, go_to or release");
  }
  const std::unique_ptr<scheduler::Policy> policy = LoggedPolicy(log).policy;
  if (policy == nullptr) throw InputError(run, "policy", "none of ours", "one that Muster has");
  for (auto logged = log.decisions.rbegin(); logged != log.decisions.rend(); ++logged) {
    const auto situation = SituationOf(logged->second, log);
    if (!situation) continue;
    WhatIf what_if;
    what_if.decision = logged->first;
    what_if.at_us = logged->second.at_us;
    Scenario scenario = *log.orders->scenario();
    what_if.order = order.directive ? ToString(*order.directive) : RowOf(order.kind).name;
    scenario.directives = situation->site->directives;
    TakeInto(&scenario, order, what_if.at_us);
    const scheduler::Decision was = scheduler::DecideWithDirectives(*situation, policy.get());
    const scheduler::Decision would =
        scheduler::DecideWithDirectives(Under(scenario.directives, *situation), policy.get());
    what_if.weight = would.weight;
    what_if.weight_without = was.weight;
    what_if.instead_of = OnlyIn(was.actions, would.actions);
    what_if.now = OnlyIn(would.actions, was.actions);
    for (const std::string& one : would.unkept) {
      if (std::find(was.unkept.begin(), was.unkept.end(), one) == was.unkept.end()) {
        what_if.unkept.push_back(one);
      }
    }
    return what_if;
  }
  throw InputError(run, "decisions", "none that is whole", "a mission that has decided");
}

std::string ToText(const WhatIf& what_if) {
  std::string text = fmt::format("decision {} at {}, the newest, made again with {}\n",
                                 what_if.decision, ClockText(what_if.at_us), what_if.order);
  for (const std::string& why : what_if.unkept) text += fmt::format("cannot be kept: {}\n", why);
  const double costs = what_if.weight_without - what_if.weight;
  text += fmt::format("the decision weighs {:.3f}, {:.3f} {} than without\n", what_if.weight,
                      std::abs(costs), costs < 0 ? "more" : "less");
  for (const Action& action : what_if.now) text += "then    " + Weighed(action) + "\n";
  for (const Action& action : what_if.instead_of) text += "not     " + Weighed(action) + "\n";
  if (what_if.now.empty() && what_if.instead_of.empty()) text += "nobody would be sent elsewhere\n";
  return text;
}

int WhatIfCommand(int argc, const char* const* argv) {
  Options options(argv[0],
                  "Says what a directive would change: the newest decision of a run, made again "
                  "with it (docs/guide/directives.md). The mission is not touched.");
  options.Run();
  options.Positional("order", "ORDER").Required("an order as JSON; -: a line of stdin");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string run = arguments->Get("run");
  std::string json = arguments->Get("order");
  if (json == "-") std::getline(std::cin, json);
  LogSource source(run);
  const DecisionLog log = ReadDecisionLog(&source);
  Order order = ReadOrder(json, "order", log.scenario.origin).order;
  fmt::print("{}", ToText(TellWhatIf(log, run, order)));
  return kExitOk;
}

}  // namespace muster::tools
