#include "agents/driver/driver_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/check.h"
#include "base/command_text.h"

namespace muster::agents {
namespace {

using Json = nlohmann::ordered_json;

/// A driver's clock and ours: lines take their time, which is much where the mission runs fast.
constexpr TimeUs kClockErrorUs = kSecondUs / 4;
/// That a driver can say to people within a tick, and so many calls for help.
constexpr std::ptrdiff_t kMostMessages = 20;

/// Metres of the way of a UAV from there to the nearest charging point; none: none can be reached.
std::optional<double> OnToChargeM(const Scenario& scenario, Point from) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const ChargingPoint& point : scenario.charging_points) {
    least_m = std::min(least_m, scenario.ways->Length(AgentKind::kUav, from, point.at));
  }
  return std::isfinite(least_m) ? std::optional(least_m) : std::nullopt;
}

std::string NameOf(AgentKind kind, std::int32_t id) {
  return fmt::format("{}:{}", ToString(kind), id);
}

}  // namespace

DriverSession::DriverSession(const Scenario& scenario, const AgentState& agent, TimeUs at,
                             TimeUs wall_us, const Rules& rules)
    : scenario_(scenario),
      rules_(rules),
      places_(scenario),
      agent_(agent),
      taken_(agent),
      home_(PositionAt(agent, at)),
      at_(at),
      started_us_(wall_us),
      told_us_(wall_us) {
  Json hello = {{"type", "hello"},
                {"version", kDriverVersion},
                {"agent", NameOf(agent.kind, agent.id)},
                {"class", ToString(agent.kind)},
                {"speed_m_s", agent.speed_m_s}};
  if (agent.kind == AgentKind::kUav) {
    hello["full_range_m"] = agent.range_full_m;
    hello["range_m"] = RangeAt(agent, at, scenario.tasks);
  }
  hello["at"] = places_.ToJson(home_);
  hello["area"] = {{"width_m", scenario.width_m}, {"height_m", scenario.height_m}};
  hello["origin"] = nullptr;
  if (scenario.origin) {
    hello["origin"] = {{"latitude_deg", scenario.origin->latitude_deg},
                       {"longitude_deg", scenario.origin->longitude_deg}};
  }
  if (agent.kind == AgentKind::kUav && scenario.separation() != nullptr) {
    hello["altitudes"] = {
        {"lowest_m", scenario.separation()->lowest_m},
        {"highest_m", scenario.separation()->AltitudeOf(scenario.separation()->layers() - 1)}};
  }
  hello["rate"] = rules.rate > 0 ? Json(rules.rate) : Json(nullptr);
  hello["mission_s"] = ToSeconds(at);
  hello["online_from_s"] = ToSeconds(agent.online_from_us);
  hello["online_until_s"] = ToSeconds(agent.online_until_us);
  Say(hello);
}

void DriverSession::Follow(const AgentState& agent, TimeUs at, TimeUs wall_us,
                           std::string_view why) {
  if (over_) return;
  agent_ = taken_ = agent;
  TellZones(at);
  if (agent_.action == ActionKind::kNone) {
    if (open_) Cancel(at, why);
    activity_told_ = false;
    return TellAltitude(at);
  }
  // A leg that begins anew for the same command goes round what was closed.
  const bool is_new =
      agent_.decision != sent_ || (agent_.measured && agent_.measured->set_out_us > set_out_us_);
  if (is_new && !agent_.activity) GoTo(at);
  TellMeeting(at);
  if (agent_.activity && agent_.activity->start_us <= at && !activity_told_) BeginActivity();
  TellAltitude(at);
  if (asked_ && !owes_since_us_) owes_since_us_ = wall_us;
}

void DriverSession::GiveAltitude(const Clearance& clearance) {
  clearance_ = clearance;
  altitude_told_ = false;
}

void DriverSession::TellAltitude(TimeUs at) {
  if (std::exchange(altitude_told_, true)) return;
  Say({{"type", "altitude"}, {"mission_s", ToSeconds(at)}, {"altitude_m", clearance_->to_m}});
}

void DriverSession::Tick(TimeUs at, TimeUs wall_us) {
  if (over_) return;
  at_ = at;
  told_us_ = wall_us;
  const bool owes = asked_ || rules_.rate <= 0;
  answered_ = !owes;
  if (owes && !owes_since_us_) owes_since_us_ = wall_us;
  TellWayHome();
  Say({{"type", "time"}, {"mission_s", ToSeconds(at)}});
  TellReady();
}

void DriverSession::TellReady() {
  if (!greeted_ || !agent_.measured || agent_.failed || agent_.action != ActionKind::kNone) return;
  if (waits() && !agent_.online(at_)) return;
  if (waits() == agent_.not_ready() && waits_for_ == told_waits_for_) return;
  told_waits_for_ = waits_for_;
  MeasuredReport report;
  report.kind = waits() ? MeasuredReport::Kind::kNotReady : MeasuredReport::Kind::kReady;
  report.at_us = at_;
  report.reason = waits_for_;
  const std::string problem = Report(std::move(report), at_);
  MUSTER_CHECK(problem.empty(), "{}", problem);
}

void DriverSession::Bye(std::string_view reason) {
  if (!std::exchange(over_, true)) Say({{"type", "bye"}, {"reason", reason}});
}

void DriverSession::Say(const Json& line) { lines_.push_back(line.dump()); }

void DriverSession::Order(Command::Kind kind, const Json& line) {
  constexpr std::string_view kNames[] = {"goto", "sense", "charge"};
  commands_.push_back({kind, agent_.decision});
  Json whole = {{"type", kNames[static_cast<std::size_t>(kind)]}, {"id", commands_.size()}};
  whole.update(line);
  Say(whole);
  asked_ = open_ = true;
}

void DriverSession::GoTo(TimeUs at) {
  sent_ = agent_.decision;
  meeting_told_us_ = kNever;
  set_out_us_ = agent_.measured ? agent_.measured->set_out_us : agent_.depart_us;
  activity_told_ = false;
  const bool to_task = agent_.action == ActionKind::kSense ||
                       agent_.action == ActionKind::kUavToTask ||
                       agent_.action == ActionKind::kWorkerToTask;
  const bool to_charge = agent_.site() >= 0 && !to_task;
  Json line = {{"mission_s", ToSeconds(at)},
               {"to", places_.ToJson(agent_.to)},
               {"expected_s", ToSeconds(agent_.arrive_us)},
               {"then", "wait"},
               {"task", to_task ? Json(agent_.target) : Json(nullptr)},
               {"charging_point", to_charge ? Json(agent_.target) : Json(nullptr)},
               {"partner", nullptr}};
  if (to_task) {
    const Task& task = scenario_.tasks[static_cast<std::size_t>(agent_.target)];
    if (!task.name.empty()) line["task_name"] = task.name;
    if (!task.note.empty()) line["task_note"] = task.note;
    if (task.priority != Task().priority) line["priority"] = static_cast<int>(task.priority);
    if (task.due_us != Task().due_us) line["due_s"] = ToSeconds(task.due_us);
  }
  if (const auto on_m =
          agent_.kind == AgentKind::kUav ? OnToChargeM(scenario_, agent_.to) : std::nullopt) {
    line["on_to_charge_m"] = *on_m;
  }
  if (IsPair(agent_.action)) {
    const bool senses = agent_.action == ActionKind::kSense;
    const AgentKind other = agent_.kind != AgentKind::kUav ? AgentKind::kUav
                            : senses                       ? AgentKind::kWorker
                                                           : AgentKind::kVehicle;
    line["then"] = senses ? "sense" : "charge";
    line["partner"] = NameOf(other, agent_.partner);
  }
  if (clearance_) {
    const TimeUs hold_us = std::max<TimeUs>(0, clearance_->begin_us - at);
    line["altitude_m"] = clearance_->to_m;
    if (hold_us > 0) line["set_out_s"] = ToSeconds(clearance_->begin_us);
    line["expected_s"] = ToSeconds(agent_.arrive_us + hold_us);
    altitude_told_ = true;
  }
  if (!agent_.own_ways().straight()) {
    line["via"] = ViaJson(*agent_.leg_ways, agent_.from, agent_.to);
  }
  Order(Command::Kind::kGoTo, line);
}

Json DriverSession::ViaJson(const Ways& ways, Point from, Point to) const {
  Json via = Json::array();
  for (const Ways::Corner& corner : ways.Corners(agent_.kind, from, to)) {
    via.push_back(places_.ToJson(corner.at));
  }
  return via;
}

void DriverSession::TellZones(TimeUs at) {
  if (agent_.kind != AgentKind::kUav) return;
  std::set<std::string> in_force;
  for (const Closure& closure : scenario_.closures) {
    if (!closure.zone) continue;
    in_force.insert(closure.order);
    if (!zones_.insert(closure.order).second) continue;
    Json rings = Json::array();
    for (const std::vector<Point>& ring : closure.zone->rings) {
      Json& corners = rings.emplace_back(Json::array());
      for (const Point corner : ring) corners.push_back({{"x_m", corner.x_m}, {"y_m", corner.y_m}});
    }
    Say({{"type", "zone"}, {"mission_s", ToSeconds(at)}, {"id", closure.order}, {"rings", rings}});
  }
  for (const std::string& id : std::set(zones_)) {
    if (in_force.contains(id)) continue;
    zones_.erase(id);
    Say({{"type", "zone_lift"}, {"mission_s", ToSeconds(at)}, {"id", id}});
  }
}

void DriverSession::TellWayHome() {
  if (agent_.kind != AgentKind::kUav) return;
  const Json via = ViaJson(*scenario_.ways, PositionAt(agent_, at_), home_);
  std::string text = via.dump();
  if (text == way_home_) return;
  way_home_ = std::move(text);
  Say({{"type", "way_home"}, {"mission_s", ToSeconds(at_)}, {"via", via}});
}

void DriverSession::TellMeeting(TimeUs at) {
  const bool is_ahead =
      agent_.activity && !activity_told_ && at < agent_.activity->start_us && sent_ >= 0;
  if (!is_ahead || agent_.activity->start_us == meeting_told_us_) return;
  meeting_told_us_ = agent_.activity->start_us;
  if (meeting_told_us_ == kNever) return;
  Say({{"type", "meeting"},
       {"id", commands_.size()},
       {"mission_s", ToSeconds(at)},
       {"expected_s", ToSeconds(meeting_told_us_)}});
}

void DriverSession::BeginActivity() {
  const Activity& activity = *agent_.activity;
  activity_told_ = true;
  Order(activity.kind == Activity::Kind::kSensing ? Command::Kind::kSense : Command::Kind::kCharge,
        {{"mission_s", ToSeconds(activity.start_us)},
         {"for_s", ToSeconds(activity.end_us - activity.start_us)}});
}

void DriverSession::Cancel(TimeUs at, std::string_view why) {
  Say({{"type", "cancel"},
       {"id", commands_.size()},
       {"mission_s", ToSeconds(at)},
       {"reason", why}});
  asked_ = open_ = false;
  owes_since_us_.reset();
}

std::vector<std::string> DriverSession::TakeLines() { return std::exchange(lines_, {}); }

std::vector<MeasuredReport> DriverSession::TakeReports(TimeUs at) {
  std::vector<MeasuredReport> taken, waiting;
  for (MeasuredReport& report : std::exchange(reports_, {})) {
    const bool fails = report.kind == MeasuredReport::Kind::kFailed;
    if (!waiting.empty() && !fails) {
      waiting.push_back(std::move(report));
      continue;
    }
    if (IsOver(report)) continue;
    MeasuredReport now = report;
    now.at_us = std::min(report.at_us, at);
    AgentState tried = taken_;
    const bool cannot_be = !ApplyReport(&tried, now, at, scenario_.tasks).empty();
    if (cannot_be && report.at_us > at) {
      waiting.push_back(std::move(report));
      continue;
    }
    taken_ = tried;
    taken.push_back(std::move(now));
  }
  reports_ = std::move(waiting);
  return taken;
}

bool DriverSession::IsOver(const MeasuredReport& report) const {
  const bool is_word =
      report.kind == MeasuredReport::Kind::kArrived || report.kind == MeasuredReport::Kind::kDone;
  return is_word && (taken_.action == ActionKind::kNone || report.decision != taken_.decision);
}

TimeUs DriverSession::MissionUs(TimeUs wall_us) const {
  if (rules_.rate <= 0) return at_;
  return at_ + ToUs(ToSeconds(wall_us - told_us_) * rules_.rate);
}

std::string DriverSession::Hear(std::string_view line, TimeUs wall_us) {
  DriverLine said;
  try {
    said = ReadDriverLine(line, places_);
  } catch (const InputError& error) {
    return over_ ? "" : Quote(error.what());
  }
  // Somebody who has left the mission may still call for help.
  if (over_ && said.type != DriverLine::Type::kMessage) return {};
  std::string problem = Take(said, MissionUs(wall_us));
  if (problem.empty()) owes_since_us_.reset();
  return problem;
}

std::string DriverSession::Take(const DriverLine& said, TimeUs now_us) {
  const bool greets = said.type == DriverLine::Type::kHello;
  if (greets != !greeted_) return greets ? "a second hello" : "its first line is no hello";
  switch (said.type) {
    case DriverLine::Type::kHello:
      greeted_ = true;
      name_ = Quote(said.name);
      waits_for_ = Quote(said.reason);
      TellReady();
      return {};
    case DriverLine::Type::kNotReady:
    case DriverLine::Type::kReady:
      waits_for_ = Quote(said.reason);
      TellReady();
      return {};
    case DriverLine::Type::kMessage:
      TakeMessage(said);
      return {};
    case DriverLine::Type::kState:
      return TakePlace(said, now_us);
    default:
      return TakeWord(said, now_us);
  }
}

void DriverSession::TakeMessage(const DriverLine& said) {
  // Many words do not keep a call for help from being heard.
  const auto n = std::count_if(messages_.begin(), messages_.end(), [&](const DriverMessage& other) {
    return other.calls_help == said.calls_help;
  });
  if (n == kMostMessages) return;
  messages_.push_back({agent_.id, Quote(said.text), said.calls_help});
}

std::string DriverSession::TakePlace(const DriverLine& said, TimeUs now_us) {
  MeasuredReport report;
  report.at_us = said.mission_us.value_or(now_us);
  const TimeUs error_us = kMeasuredSlackUs + ToUs(ToSeconds(kClockErrorUs) * rules_.rate);
  if (report.at_us > now_us + error_us) {
    return fmt::format("its state is of {:.1f} s, and it is {:.1f} s", ToSeconds(report.at_us),
                       ToSeconds(now_us));
  }
  report.at = said.at;
  report.range_m = said.range_m;
  report.expected_us = said.expected_us;
  if (!said.mission_us || *said.mission_us >= at_ - kMeasuredSlackUs) answered_ = true;
  // Said before it heard what it is to do now: it does not know better.
  if (agent_.measured && IsOld(agent_, report)) return {};
  now_us = std::max(now_us, report.at_us);
  return Report(std::move(report), now_us);
}

std::string DriverSession::TakeWord(const DriverLine& said, TimeUs now_us) {
  const bool arrives = said.type == DriverLine::Type::kArrived;
  const bool fails = said.type == DriverLine::Type::kFailed;
  if (said.id && *said.id > static_cast<std::int64_t>(commands_.size())) {
    return fmt::format("id {} was never given", *said.id);
  }
  MeasuredReport report;
  report.at_us = now_us;
  if (fails) {
    report.kind = MeasuredReport::Kind::kFailed;
    report.reason = Quote(said.reason);
    std::string problem = Report(std::move(report), now_us);
    over_ = true;
    return problem;
  }
  const Command& command = commands_[static_cast<std::size_t>(*said.id - 1)];
  if (arrives != (command.kind == Command::Kind::kGoTo)) {
    return fmt::format("{} of id {}, which was {}", arrives ? "arrived" : "done", *said.id,
                       arrives ? "no goto" : "a goto");
  }
  // What is over or was replaced: it had not heard of that. A goal stays when the way to it
  // changes.
  const bool is_last = *said.id == static_cast<std::int64_t>(commands_.size()) ||
                       (arrives && commands_.back().kind == Command::Kind::kGoTo &&
                        commands_.back().decision == command.decision);
  if (!is_last || !asked_ || agent_.decision != command.decision ||
      agent_.action == ActionKind::kNone || (!arrives && !agent_.activity)) {
    return {};
  }
  report.kind = arrives ? MeasuredReport::Kind::kArrived : MeasuredReport::Kind::kDone;
  report.decision = command.decision;
  report.range_m = said.range_m;
  std::string problem = Report(std::move(report), now_us);
  if (!problem.empty()) return problem;
  asked_ = false;
  if (!arrives || !IsPair(agent_.action)) open_ = false;
  return {};
}

std::string DriverSession::Report(MeasuredReport report, TimeUs now_us) {
  report.agent_kind = agent_.kind;
  report.agent = agent_.id;
  std::string problem = ApplyReport(&agent_, report, now_us, scenario_.tasks);
  if (problem.empty()) reports_.push_back(std::move(report));
  return problem;
}

std::string DriverSession::Silence(TimeUs wall_us) const {
  if (over_) return {};
  if (!greeted_ && wall_us - started_us_ > rules_.HelloByUs()) {
    return fmt::format("no hello within {:g} s", ToSeconds(rules_.HelloByUs()));
  }
  if (!owes_since_us_ || wall_us - *owes_since_us_ <= rules_.lost_after_us) return {};
  constexpr std::string_view kWhat[] = {"on its way", "sensing", "charging"};
  return fmt::format("silent for {:g} s while it was {}", ToSeconds(rules_.lost_after_us),
                     asked_ ? kWhat[static_cast<std::size_t>(commands_.back().kind)] : "waiting");
}

}  // namespace muster::agents
