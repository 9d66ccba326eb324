#include "tools/explain/redecide.h"

#include <fmt/format.h>

#include <bit>
#include <map>
#include <memory>
#include <set>
#include <tuple>

#include "base/check.h"
#include "base/text.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "muster/fields.h"
#include "scheduler/policies/registry.h"
#include "scheduler/process/scheduler_process.h"

namespace muster::tools {
namespace {

/// The scheduler's process of one policy, fed by hand.
class Scheduler {
 public:
  Scheduler(const DecisionLog& log, const std::string& policy)
      : process_({log.run_id, "muster-redecide", 0}, 0, policy, [] { return TimeUs{0}; }),
        log_(log),
        orders_(*log.orders),
        next_orders_(orders_.said().begin()) {
    Feed(log.scenario_packets);
  }

  /// None when it does not decide.
  std::optional<schedule_t> Decide(const LoggedDecision& decision) {
    clearances_.reset();
    if (!decision.clock) return {};
    const std::int64_t tick = orders_.scenario()->rules.TickOf(decision.at_us);
    std::vector<Packet> arrived;
    for (; next_orders_ != orders_.said().end() && next_orders_->first <= tick; ++next_orders_) {
      arrived.push_back({std::string(channel::kOrders), Encode(next_orders_->second)});
    }
    if (const Packet* in_force = ClearancesBefore(decision, log_)) arrived.push_back(*in_force);
    arrived.push_back(*decision.clock);
    arrived.insert(arrived.end(), decision.told.begin(), decision.told.end());
    for (const Packet& packet : Feed(arrived)) {
      if (packet.channel == channel::kClearances) clearances_ = Decode<clearances_t>(packet.bytes);
      if (packet.channel != channel::kSchedule) continue;
      auto schedule = Decode<schedule_t>(packet.bytes);
      if (schedule && schedule->decision == decision.decision) return schedule;
    }
    return {};
  }

  /// That go with the last decision; none: UAVs are not kept apart.
  const std::optional<clearances_t>& clearances() const { return clearances_; }

 private:
  /// One packet a step, as the process decides at the end of a step.
  std::vector<Packet> Feed(const std::vector<Packet>& packets) {
    std::vector<Packet> out;
    for (const Packet& packet : packets) process_.Step({packet}, Now(), &out);
    return out;
  }

  scheduler::SchedulerProcess process_;
  const DecisionLog& log_;
  std::optional<clearances_t> clearances_;
  const OrderBook& orders_;
  std::map<std::int64_t, orders_t>::const_iterator next_orders_;
};

/// The first field that differs, in the order of the calls.
class Comparison {
 public:
  template <class T>
  void operator()(const char* field, const T& again, const T& logged) {
    if (result_.empty() && !Same(again, logged)) {
      result_ =
          fmt::format("{}{} is {}, the log says {}", within, field, Text(again), Text(logged));
    }
  }
  std::string result() const { return result_; }

  std::string within;  ///< what the fields belong to, for the text

 private:
  static bool Same(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  }
  template <class T>
  static bool Same(const T& a, const T& b) {
    return a == b;
  }
  static std::string Text(double value) { return fmt::format("{:.17g}", value); }
  static std::string Text(std::int8_t value) { return fmt::to_string(int{value}); }
  template <class T>
  static std::string Text(const T& value) {
    return fmt::format("{}", value);
  }
  std::string result_;
};

using ActionKey = std::tuple<int, int, int, int, int, int, double, double>;

std::string AltitudeDifference(const std::optional<clearances_t>& again,
                               const std::optional<Packet>& logged_packet) {
  std::optional<clearances_t> logged;
  if (logged_packet) logged = Decode<clearances_t>(logged_packet->bytes);
  if (!again || !logged) {
    return again.has_value() == logged.has_value()
               ? ""
               : fmt::format("{} has no clearances_t", again ? "the log" : "the decision");
  }
  Comparison compare;
  for (std::size_t i = 0; i < again->clearances.size() && i < logged->clearances.size(); ++i) {
    compare.within = fmt::format("clearances[{}].", i);
    VisitFields(compare, again->clearances[i], logged->clearances[i]);
  }
  compare.within = "clearances ";
  compare("n", again->n, logged->n);
  return compare.result();
}

std::set<ActionKey> MovesOf(const schedule_t& schedule) {
  std::set<ActionKey> moves;
  for (const action_t& a : schedule.actions) {
    if (IsStay(static_cast<ActionKind>(a.kind))) continue;
    moves.insert(
        {a.kind, a.uav_id, a.worker_id, a.vehicle_id, a.task_id, a.charge_id, a.x_m, a.y_m});
  }
  return moves;
}

}  // namespace

std::vector<Redecided> Redecide(const DecisionLog& log, const std::string& policy,
                                const DecisionProgress& progress) {
  std::map<std::string, std::unique_ptr<Scheduler>> schedulers;
  std::vector<Redecided> decisions;
  std::size_t made = 0;
  for (const auto& [d, logged] : log.decisions) {
    if (progress) progress(made++, log.decisions.size());
    std::string missing = WhatIsMissing(logged, log);
    if (logged.schedules.empty() && !missing.empty()) continue;
    Redecided result{d, logged.at_us, {}, logged.schedules, {}};
    std::string name = policy;
    if (name.empty() && !logged.schedules.empty()) name = logged.schedules.front().policy;
    if (name.empty()) continue;  // nothing to say how, nothing to compare with
    if (policy.empty() && scheduler::IsExternal(name)) {
      // The log may come from anywhere, so no program that it names is started.
      throw InputError(
          "options", "--policy", fmt::format("none, and the log's is {}", Printable(name)),
          "--policy with it: a program that a log names is started only if you name it");
    }
    auto& scheduler = schedulers[name];
    if (!scheduler) scheduler = std::make_unique<Scheduler>(log, name);
    if (auto again = scheduler->Decide(logged)) {
      result.again = std::move(*again);
      result.altitudes = AltitudeDifference(scheduler->clearances(), logged.clearances);
    } else {
      result.missing = missing.empty() ? "a message that can be" : missing;
    }
    decisions.push_back(std::move(result));
  }
  return decisions;
}

std::string FirstDifference(const schedule_t& again, const schedule_t& logged) {
  Comparison compare;
  compare("decision", again.decision, logged.decision);
  compare("tick", again.tick, logged.tick);
  compare("policy", again.policy, logged.policy);
  for (std::size_t i = 0; i < again.actions.size() && i < logged.actions.size(); ++i) {
    compare.within = fmt::format("actions[{}].", i);
    VisitFields(compare, again.actions[i], logged.actions[i]);
  }
  compare.within.clear();
  compare("n", again.n, logged.n);
  compare("weight", again.weight, logged.weight);
  compare("bound", again.bound, logged.bound);
  compare("candidates", again.candidates, logged.candidates);
  return compare.result();
}

ActionDifference DifferenceOf(const schedule_t& again, const schedule_t& logged) {
  const auto ours = MovesOf(again);
  const auto theirs = MovesOf(logged);
  ActionDifference difference;
  for (const ActionKey& key : theirs) difference.only_logged += ours.contains(key) ? 0 : 1;
  for (const ActionKey& key : ours) difference.only_again += theirs.contains(key) ? 0 : 1;
  return difference;
}

std::vector<Divergence> DivergencesOf(const std::vector<Redecided>& decisions) {
  std::vector<Divergence> divergences;
  for (const Redecided& d : decisions) {
    if (!d.missing.empty()) {
      divergences.push_back(
          {d.decision, d.at_us, fmt::format("cannot be made again, the log lacks {}", d.missing)});
      continue;
    }
    for (const schedule_t& logged : d.logged) {
      std::string difference = FirstDifference(d.again, logged);
      if (difference.empty()) difference = d.altitudes;
      if (difference.empty()) continue;
      divergences.push_back(
          {d.decision, d.at_us,
           fmt::format("{} ({} start {}, seq {})", difference, logged.header.sender,
                       logged.header.boot_id, logged.header.seq)});
    }
  }
  return divergences;
}

}  // namespace muster::tools
