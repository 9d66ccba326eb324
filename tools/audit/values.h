#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>

#include "lcmtypes/bus/codec.h"
#include "tools/audit/agent_model.h"
#include "tools/audit/audit_scenario.h"

namespace muster::tools::audit {

/// The process that rules on a mission, and that gives some orders of its own.
inline constexpr const char* kWorld = "world";

/// Rounding of arrival times to microseconds and of sums: far above both, far below what matters.
inline constexpr double kTolerance_m = 1e-3;
inline constexpr std::int64_t kToleranceUs = 2;

inline double ToSeconds(std::int64_t us) { return static_cast<double>(us) * 1e-6; }

/// Equal but for rounding.
bool Near(double a_m, double b_m);
bool NearUs(std::int64_t a, std::int64_t b);
bool Within(double value, Interval range, double tolerance);
bool SameCell(Place a, Place b);

/// An outcome as in event_t: at_us, kind, uav, worker, vehicle, task, charge.
using EventKey = std::tuple<std::int64_t, int, int, int, int, int, int>;
EventKey KeyOf(const event_t& event);
std::string Name(const EventKey& key);
/// "UiTxWj uav:3 worker:5 task:17"
std::string Name(const action_t& action);
/// "sensing of uav:3 and worker:5 at task:17 in [400000000, 700000000] us"
std::string Name(const Activity& activity);
/// What a task is by that number: "open", "being sensed".
std::string_view TaskWords(std::int64_t status);

Activity FromWire(const activity_t& activity);

}  // namespace muster::tools::audit
