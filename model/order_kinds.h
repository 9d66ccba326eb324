#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "lcmtypes/words.h"

namespace muster {

enum class OrderKind : std::int8_t {
  kTaskAdd,
  kTaskChange,
  kTaskCancel,
  kTaskHold,
  kTaskResume,
  kAgentJoin,
  kAgentLeave,
  kAgentRecall,
  kRoadClose,
  kRoadOpen,
  kZoneAdd,
  kZoneLift,
  kPin,
  kUnpin,
  kForbid,
  kChargeNow,
  kGoTo,
  kRelease,
  kPerson,
  kWithdraw,
  kDecideNow,
};

/// What an order names, and so which keys it has.
enum class OrderSubject {
  kNewTask,
  kTask,
  kNewAgent,
  kAgent,
  kRoads,
  kAir,
  kDirective,
  kPerson,
  kOrder,
  kDecision
};

/// All that is particular to one kind of order but what comes of it: the referee and the audit each
/// have their own rules for that.
struct OrderRow {
  OrderKind kind;
  std::string_view name;
  OrderSubject subject;
  /// Of a task that is not over: what speaks against the order while the task has that status, to
  /// stand after the status's name. "": nothing does.
  std::string_view (*against)(TaskStatus status) = [](TaskStatus) { return std::string_view(); };
};

/// In the order of OrderKind.
inline constexpr OrderRow kOrderRows[] = {
    {OrderKind::kTaskAdd, "task_add", OrderSubject::kNewTask},
    {OrderKind::kTaskChange, "task_change", OrderSubject::kTask},
    {OrderKind::kTaskCancel, "task_cancel", OrderSubject::kTask},
    {OrderKind::kTaskHold, "task_hold", OrderSubject::kTask,
     [](TaskStatus status) -> std::string_view {
       if (status == TaskStatus::kHeld) return " already";
       if (status == TaskStatus::kSensing) return " under way: cancel ends it";
       return status == TaskStatus::kUnreported ? ": nobody is sent there yet" : "";
     }},
    {OrderKind::kTaskResume, "task_resume", OrderSubject::kTask,
     [](TaskStatus status) -> std::string_view {
       return status == TaskStatus::kHeld ? "" : ", not held";
     }},
    {OrderKind::kAgentJoin, "agent_join", OrderSubject::kNewAgent},
    {OrderKind::kAgentLeave, "agent_leave", OrderSubject::kAgent},
    {OrderKind::kAgentRecall, "agent_recall", OrderSubject::kAgent},
    {OrderKind::kRoadClose, "road_close", OrderSubject::kRoads},
    {OrderKind::kRoadOpen, "road_open", OrderSubject::kRoads},
    {OrderKind::kZoneAdd, "zone_add", OrderSubject::kAir},
    {OrderKind::kZoneLift, "zone_lift", OrderSubject::kAir},
    {OrderKind::kPin, "pin", OrderSubject::kDirective,
     [](TaskStatus status) -> std::string_view {
       if (status == TaskStatus::kHeld) return ": resume it first";
       if (status == TaskStatus::kUnreported) return ": nobody is sent there yet";
       return status == TaskStatus::kOpen ? "" : ": others are at it (task_hold or agent_recall)";
     }},
    {OrderKind::kUnpin, "unpin", OrderSubject::kDirective},
    {OrderKind::kForbid, "forbid", OrderSubject::kDirective},
    {OrderKind::kChargeNow, "charge_now", OrderSubject::kDirective},
    {OrderKind::kGoTo, "go_to", OrderSubject::kDirective},
    {OrderKind::kRelease, "release", OrderSubject::kDirective},
    {OrderKind::kPerson, "person", OrderSubject::kPerson},
    {OrderKind::kWithdraw, "withdraw", OrderSubject::kOrder},
    {OrderKind::kDecideNow, "decide_now", OrderSubject::kDecision},
};

constexpr const OrderRow& RowOf(OrderKind kind) {
  return kOrderRows[static_cast<std::size_t>(kind)];
}

/// Whether such orders change how agents travel.
constexpr bool ChangesWays(OrderKind kind) {
  const OrderSubject subject = RowOf(kind).subject;
  return subject == OrderSubject::kRoads || subject == OrderSubject::kAir;
}

}  // namespace muster
