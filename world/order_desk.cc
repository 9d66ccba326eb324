#include "world/order_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/number_text.h"
#include "base/text.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/signing.h"
#include "model/high_zones.h"
#include "model/person.h"
#include "model/scenario_json.h"
#include "world/directive_check.h"

namespace muster::world {
namespace {

/// As messages carry it.
constexpr std::size_t kMostReason = 1024;

/// What a message can carry of it: an order may quote anything.
std::string ReasonFrom(std::string_view text) {
  std::string reason = Printable(text.substr(0, kMostReason));
  orders_t message{};
  message.header.sender = process_name::kWorld;
  message.refused = {{"id", "issuer", reason}};
  return Valid(message) ? reason : "it is no order";
}

constexpr const char* kDecideNow = R"({"order": "decide_now"})";

/// Of the world's own order to decide at that tick.
std::string DecisionId(std::int64_t tick) { return fmt::format("decide:{}", tick); }

bool IsOver(TaskStatus status) {
  return status == TaskStatus::kDone || status == TaskStatus::kExpired ||
         status == TaskStatus::kCancelled;
}

/// Throws InputError where the task's status does not allow it.
void CheckTask(const Order& order, TaskStatus status) {
  const auto refuse = [&](std::string_view why) {
    throw InputError(fmt::format("task {} is {}{}", order.task_id, ToString(status), why));
  };
  if (IsOver(status)) refuse("");
  const std::string_view against = RowOf(order.kind).against(status);
  if (!against.empty()) refuse(against);
}

/// Written by the world itself.
PlannedOrder Written(std::string id, std::string json) {
  PlannedOrder planned{ParseOrder(json, "order"), std::move(json)};
  planned.order.id = std::move(id);
  planned.order.issuer = process_name::kWorld;
  return planned;
}

PlannedOrder ToOrder(const PlannedClosure& closure, std::ptrdiff_t number) {
  std::string json =
      fmt::format("{{\"order\": \"road_close\", \"at_min\": {}, {}",
                  TimeToText(closure.from_us, kMinute), RoadAreaToJson(closure.area));
  if (!closure.name.empty()) json += fmt::format(", \"name\": {}", JsonText(closure.name));
  if (closure.until_us != kNever) {
    json += fmt::format(", \"until_min\": {}", TimeToText(closure.until_us, kMinute));
  }
  return Written(fmt::format("closure:{}", number), json + "}");
}

PlannedOrder ToOrder(const PlannedZone& planned, std::ptrdiff_t number) {
  std::string json = fmt::format("{{\"order\": \"zone_add\", \"at_min\": {}, {}",
                                 TimeToText(planned.from_us, kMinute), ZoneToJson(planned.zone));
  if (!planned.zone.name.empty()) {
    json += fmt::format(", \"name\": {}", JsonText(planned.zone.name));
  }
  if (planned.until_us != kNever) {
    json += fmt::format(", \"until_min\": {}", TimeToText(planned.until_us, kMinute));
  }
  return Written(fmt::format("zone:{}", number), json + "}");
}

bool IsWithdrawal(const std::string& json) {
  const std::string name = JsonText(RowOf(OrderKind::kWithdraw).name);
  if (json.find(name) == std::string::npos) return false;
  try {
    return ParseOrder(json, "order").kind == OrderKind::kWithdraw;
  } catch (const InputError&) {
    return false;
  }
}

bool IsInForce(const std::string& closure, const Scenario& scenario) {
  return std::any_of(scenario.closures.begin(), scenario.closures.end(),
                     [&](const Closure& one) { return one.order == closure; });
}

/// Whether an emergency opens at t: reported now, as planned or by one of the orders, or changed or
/// resumed by one. `status`: after the tick before; `scenario`: with the orders.
bool EmergencyOpens(const orders_t& orders, TimeUs t, std::span<const TaskStatus> status,
                    const Scenario& scenario) {
  const auto is_emergency = [&](std::int32_t id) {
    return scenario.tasks[static_cast<std::size_t>(id)].priority == Priority::kEmergency;
  };
  for (std::int32_t id = 0; id < static_cast<std::int32_t>(scenario.n_tasks()); ++id) {
    const auto i = static_cast<std::size_t>(id);
    if (is_emergency(id) && status[i] == TaskStatus::kUnreported &&
        scenario.tasks[i].reported_us <= t) {
      return true;
    }
  }
  return std::any_of(orders.taken.begin(), orders.taken.end(), [&](const taken_order_t& taken) {
    const OrderKind kind = ParseOrder(taken.json, "order").kind;
    if (kind != OrderKind::kTaskChange && kind != OrderKind::kTaskResume) return false;
    return is_emergency(taken.task_id) &&
           (kind == OrderKind::kTaskResume ||
            status[static_cast<std::size_t>(taken.task_id)] == TaskStatus::kOpen);
  });
}

}  // namespace

OrderDesk::OrderDesk(const Scenario& scenario, std::vector<PlannedOrder> planned)
    : book_(scenario),
      has_persons_(std::any_of(
          planned.begin(), planned.end(),
          [](const PlannedOrder& one) { return one.order.kind == OrderKind::kPerson; })),
      planned_(std::move(planned)) {
  if (scenario.roads) {
    for (const PlannedClosure& closure : scenario.roads->closures) {
      planned_.push_back(ToOrder(closure, &closure - scenario.roads->closures.data()));
    }
  }
  if (scenario.air) {
    for (const PlannedZone& zone : scenario.air->zones) {
      if (IsHigh(zone, *scenario.air)) continue;  // it bars no way
      planned_.push_back(ToOrder(zone, &zone - scenario.air->zones.data()));
    }
  }
  std::stable_sort(planned_.begin(), planned_.end(), [](const auto& a, const auto& b) {
    return a.order.not_before_us < b.order.not_before_us;
  });
  std::reverse(planned_.begin(), planned_.end());
}

std::int64_t OrderDesk::AnsweredAt(const std::string& id) const {
  const auto answered = answered_.find(id);
  return answered == answered_.end() ? -1 : answered->second;
}

bool OrderDesk::Admits(const order_t& order, std::int64_t run_id) const {
  if (IsIdOfWorld(order.id)) return false;  // the world's own are never on the bus
  const std::vector<Person>& persons = scenario().persons;
  if (!has_persons_ && persons.empty()) return true;
  // It is repeated until it is answered; looking at it once is enough, and Hear() keeps the first.
  if (waiting_ids_.contains(order.id) || answered_.contains(order.id)) return true;
  if (order.issuer == process_name::kWorld) return false;  // its own are never on the bus
  try {
    const SignedOrder parts = SplitSignature(order.json, "order");
    const Person* const signer = FindPerson(persons, parts.key);
    const bool for_another = parts.key != parts.by;
    return signer != nullptr && NamesIssuer(order.issuer, parts.by) &&
           (!for_another || parts.key == kLauncherPerson) &&
           IsSignature(parts.signature, TextToSign(run_id, order.id, order.issuer, parts),
                       signer->key);
  } catch (const InputError&) {
    return false;
  }
}

bool OrderDesk::Hear(const order_t& order) {
  if (answered_.contains(order.id)) return false;
  if (waiting_.size() >= kMostWaiting || waiting_ids_.contains(order.id)) return true;
  waiting_ids_.insert(order.id);
  Waiting waiting{order.id, order.issuer, order.json, IsWithdrawal(order.json)};
  const auto place = !waiting.withdraws
                         ? waiting_.end()
                         : std::find_if(waiting_.begin(), waiting_.end(),
                                        [](const Waiting& w) { return !w.withdraws; });
  waiting_.insert(place, std::move(waiting));
  return true;
}

void OrderDesk::EndFulfilled(const Event& event) {
  using Kind = Directive::Kind;
  const bool charged = event.kind == Event::Kind::kChargingDone;
  const bool over = event.kind == Event::Kind::kSensingDone ||
                    event.kind == Event::Kind::kTaskExpired ||
                    event.kind == Event::Kind::kTaskCancelled;
  for (const Directive& one : scenario().directives) {
    const bool charges =
        charged && one.kind == Kind::kChargeNow && one.agents.uavs == event.uav.value;
    const bool pins = over && one.kind == Kind::kPin && one.task == event.task.value;
    if (!charges && !pins) continue;
    Give(fmt::format("release:{}", one.order),
         fmt::format("{{\"order\": \"release\", \"directive\": {}}}", JsonText(one.order)));
  }
}

void OrderDesk::DecideIfReopened(const Event& event) {
  const Rules& rules = scenario().rules;
  const std::int64_t next = book_.tick() + 1;
  if (!rules.emergencies_at_once || event.kind != Event::Kind::kSensingAborted ||
      scenario().tasks[event.task.index()].priority != Priority::kEmergency ||
      rules.TimeOf(next) >= rules.limit_us || rules.DecisionAt(next) >= 0) {
    return;
  }
  Give(DecisionId(next), kDecideNow);
}

void OrderDesk::Revisit(TaskId id, TimeUs done_us) {
  Task task = scenario().tasks[id.index()];
  const TimeUs late_us = task.due_us == kNever ? kNever : task.due_us - task.reported_us;
  const TimeUs gone_us = task.expires_us == kNever ? kNever : task.expires_us - task.reported_us;
  task.reported_us = done_us + task.revisit_us;
  if (late_us != kNever) task.due_us = task.reported_us + late_us;
  if (gone_us != kNever) task.expires_us = task.reported_us + gone_us;
  Give(fmt::format("revisit:{}", id.value),
       fmt::format("{{\"order\": \"task_add\", \"task\": {}}}", TaskToJson(task)));
}

void OrderDesk::Give(const std::string& id, std::string json) {
  order_t order{};
  order.id = id;
  order.issuer = process_name::kWorld;
  order.json = std::move(json);
  Hear(order);
}

void OrderDesk::PlanOpening(const TakenOrder& taken, TimeUs t) {
  const TimeUs until_us = taken.order.UntilUs(t);
  const bool is_zone = taken.order.kind == OrderKind::kZoneAdd;
  if ((taken.order.kind != OrderKind::kRoadClose && !is_zone) || until_us == kNever) return;
  std::string id = (is_zone ? "lift:" : "open:") + taken.order.id;
  const auto is_same = [&](const PlannedOrder& other) { return other.order.id == id; };
  if (std::any_of(planned_.begin(), planned_.end(), is_same)) return;
  PlannedOrder opening = Written(
      std::move(id), fmt::format("{{\"order\": \"{}\", \"at_min\": {}, \"{}\": {}}}",
                                 is_zone ? "zone_lift" : "road_open", TimeToText(until_us, kMinute),
                                 is_zone ? "zone" : "closure", JsonText(taken.order.id)));
  const auto place = std::lower_bound(planned_.begin(), planned_.end(), opening,
                                      [](const PlannedOrder& a, const PlannedOrder& b) {
                                        return a.order.not_before_us > b.order.not_before_us;
                                      });
  planned_.insert(place, std::move(opening));
}

orders_t OrderDesk::Decide(std::int64_t tick, std::span<const TaskStatus> status,
                           const Agents& agents) {
  if (book_.complete(tick)) return book_.SaidAt(tick);  // by an earlier start of the world
  orders_t said{};
  said.tick = tick;
  said.before = book_.size();
  Scenario scenario = this->scenario();
  const TimeUs t = scenario.rules.TimeOf(tick);
  std::size_t bytes = 0;
  for (; !planned_.empty() && planned_.back().order.not_before_us <= t && bytes < kMostBytes;
       planned_.pop_back()) {
    const PlannedOrder& next = planned_.back();
    if (answered_.contains(next.order.id)) continue;
    // Somebody has opened those roads, or lifted that zone, already.
    const std::string& ended = next.order.closure;
    if (!ended.empty() && next.order.issuer == process_name::kWorld &&
        !IsInForce(ended, scenario)) {
      continue;
    }
    DecideOn({next.order.id, next.order.issuer, next.json}, t, status, agents, &scenario, &said);
    bytes += next.json.size();
  }
  std::vector<Waiting> later;
  for (Waiting& waiting : waiting_) {
    if (bytes < kMostBytes) {
      bytes += waiting.json.size();
      DecideOn(waiting, t, status, agents, &scenario, &said);
    } else {
      later.push_back(std::move(waiting));
    }
  }
  waiting_ = std::move(later);
  if (const Rules& rules = scenario.rules; rules.emergencies_at_once && t < rules.limit_us &&
                                           rules.DecisionAt(tick) < 0 &&
                                           EmergencyOpens(said, t, status, scenario)) {
    DecideOn({DecisionId(tick), process_name::kWorld, kDecideNow}, t, status, agents, &scenario,
             &said);
  }
  said.n_taken = static_cast<std::int32_t>(said.taken.size());
  said.n_refused = static_cast<std::int32_t>(said.refused.size());
  return said;
}

void OrderDesk::CheckWithdrawal(const Order& withdrawal, const orders_t& said) const {
  const std::string& id = withdrawal.closure;
  const auto is_it = [&](const auto& order) { return order.id == id; };
  if (answered_.contains(id) || std::any_of(said.taken.begin(), said.taken.end(), is_it) ||
      std::any_of(said.refused.begin(), said.refused.end(), is_it)) {
    throw InputError(fmt::format("order {} has been answered already", id));
  }
  if (scenario().persons.empty()) return;
  const auto check = [&](const std::string& by) {
    if (by != withdrawal.signed_by) throw InputError(fmt::format("order {} is of {}", id, by));
  };
  for (const Waiting& waiting : waiting_) {
    if (is_it(waiting)) check(SplitSignature(waiting.json, "order").by);
  }
  for (const PlannedOrder& planned : planned_) {
    if (is_it(planned.order)) check(planned.order.signed_by);
  }
}

std::pair<std::string, std::string> OrderDesk::Own(const std::string& id,
                                                   const Order& given) const {
  return {id, scenario().persons.empty() ? "" : given.signed_by};
}

void OrderDesk::DecideOn(const Waiting& waiting, TimeUs t, std::span<const TaskStatus> status,
                         const Agents& agents, Scenario* scenario, orders_t* said) {
  waiting_ids_.erase(waiting.id);
  std::vector<Directive> before = scenario->directives;
  try {
    Order order = ParseOrder(waiting.json, "order");
    order.id = waiting.id;
    order.issuer = waiting.issuer;
    if (order.not_before_us > t) {
      throw InputError("order", "at_min", TimeToText(order.not_before_us, kMinute),
                       fmt::format("a time that has come: it is {} now", TimeToText(t, kMinute)));
    }
    if (!scenario->persons.empty() && order.issuer != process_name::kWorld) {
      const std::string why = WhyMayNot(scenario->persons, order.signed_by, order.kind);
      if (!why.empty()) throw InputError(why);
    }
    const auto withdrawal = withdrawals_.find(Own(order.id, order));
    if (withdrawal != withdrawals_.end() && order.issuer != process_name::kWorld) {
      throw InputError(fmt::format("withdrawn by order {}", withdrawal->second));
    }
    if (order.kind == OrderKind::kWithdraw) {
      CheckWithdrawal(order, *said);
      withdrawals_.try_emplace(Own(order.closure, order), order.id);
    }
    const TakenOrder taken = TakeInto(scenario, order, t);
    if (order.task_id >= 0 && static_cast<std::size_t>(order.task_id) < status.size()) {
      CheckTask(order, status[static_cast<std::size_t>(order.task_id)]);
    }
    if (order.agent_id >= 0) {
      CheckAgent(t, agents[order.agent_kind][static_cast<std::size_t>(order.agent_id)]);
    }
    if (order.directive) CheckDirective(*order.directive, t, agents, *scenario);
    said->taken.push_back(ToWire(taken, waiting.json));
  } catch (const InputError& error) {
    scenario->directives = std::move(before);
    refused_order_t refused{};
    refused.id = waiting.id;
    refused.issuer = waiting.issuer;
    refused.reason = ReasonFrom(error.what());
    said->refused.push_back(std::move(refused));
  }
}

void OrderDesk::Note(const TakenOrder& taken, std::int64_t tick) {
  PlanOpening(taken, scenario().rules.TimeOf(tick));
  if (taken.order.kind == OrderKind::kWithdraw) {
    withdrawals_.try_emplace(Own(taken.order.closure, taken.order), taken.order.id);
  }
}

void OrderDesk::Take(const orders_t& orders) {
  MUSTER_CHECK(book_.Take(orders), "orders of tick {}", orders.tick);
  for (const TakenOrder& taken : book_.TakenAt(orders.tick)) Note(taken, orders.tick);
  for (const taken_order_t& order : orders.taken) answered_[order.id] = orders.tick;
  for (const refused_order_t& order : orders.refused) answered_[order.id] = orders.tick;
}

bool OrderDesk::Take(const order_book_t& book) {
  if (!book_.Take(book)) return false;
  for (const auto& [tick, orders] : book_.said()) {
    for (const taken_order_t& order : orders.taken) answered_[order.id] = tick;
    for (const refused_order_t& order : orders.refused) answered_[order.id] = tick;
    for (const TakenOrder& taken : book_.TakenAt(tick)) Note(taken, tick);
  }
  return true;
}

}  // namespace muster::world
