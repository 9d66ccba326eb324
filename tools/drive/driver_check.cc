#include "tools/drive/driver_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "tools/host/progress.h"

namespace muster::tools {
namespace {

using agents::DriverProgram;
using Clock = DriverProgram::Clock;

constexpr TimeUs kTickUs = 30 * kSecondUs;
constexpr TimeUs kPatienceUs = 10 * kMinuteUs;
/// An autopilot that was just switched on may take so long.
constexpr TimeUs kReadyUs = 15 * kMinuteUs;
/// Each way takes five ticks.
constexpr TimeUs kWayUs = 5 * kTickUs;
constexpr TimeUs kSensingUs = 90 * kSecondUs;
constexpr std::size_t kMostWrong = 20;
constexpr std::chrono::seconds kToEnd(5);
/// At a rate: what it drives comes home first, in mission time.
constexpr double kComesHome_s = 300;
constexpr std::chrono::milliseconds kLook(10);

/// One agent in the middle of an area with an origin, and its partners.
Scenario SmallArea() {
  Scenario scenario;
  scenario.width_m = scenario.height_m = 10'000;
  scenario.origin = Origin{52.2, 0.1};
  AgentSpec agent;
  agent.at = {4000, 4000};
  agent.online_until_us = scenario.rules.limit_us = 24 * 60 * kMinuteUs;
  agent.range_full_m = agent.range_m = 30'000;
  agent.charge_rate_m_s = 50;
  agent.speed_m_s = 50.0 / 3;
  agent.measured = true;
  scenario.uavs = {agent};
  agent.speed_m_s = 5;
  scenario.workers = {agent};
  agent.speed_m_s = 12.5;
  scenario.vehicles = {agent};
  scenario.tasks = {{{0, 0}, 1500}};
  scenario.charging_points = {{{0, 0}, 1}};
  return scenario;
}

class Check {
 public:
  explicit Check(const DriverCheckOptions& options)
      : options_(options),
        scenario_(SmallArea()),
        agent_(StartOf(options.kind, 0, scenario_.agents(options.kind)[0], *scenario_.ways)),
        program_(options.argv, scenario_, agent_, 0, options.rules),
        started_(Clock::now()) {}

  DriverCheckResult Run() {
    Listen(true, started_ + std::chrono::microseconds(options_.rules.HelloByUs()));
    result_.name = program_.session().name();
    Apply();
    AwaitReady();
    const double way = agent_.speed_m_s * ToSeconds(kWayUs);
    const Point start = agent_.to;
    const ActionKind second = options_.kind == AgentKind::kUav       ? ActionKind::kCharge
                              : options_.kind == AgentKind::kVehicle ? ActionKind::kCharge
                                                                     : ActionKind::kSense;
    const ActionKind first = options_.kind == AgentKind::kUav ? ActionKind::kSense : second;
    GoAndDo(first, {start.x_m + way, start.y_m});
    GoAndDo(second, {start.x_m + way, start.y_m + way});
    GoAndStay({start.x_m, start.y_m + way});
    GoTwice({start.x_m, start.y_m}, {start.x_m + way, start.y_m});
    if (goes_on()) {
      program_.session().Bye("the check is over");
      const double rate = options_.rules.rate;
      const std::chrono::seconds to_end =
          rate > 0 ? std::max(kToEnd, std::chrono::seconds(std::lround(kComesHome_s / rate)))
                   : kToEnd;
      const std::string end = program_.AwaitEnd(Clock::now() + to_end);
      if (end.empty()) Wrong(fmt::format("it did not end within {} s of bye", to_end.count()));
      if (!end.empty() && end != "exited with code 0") Wrong("after bye its program " + end);
    }
    result_.mission_s = ToSeconds(t_);
    return std::move(result_);
  }

 private:
  bool goes_on() const { return !over_ && !program_.ended(); }

  void Wrong(std::string what) {
    result_.wrong.push_back({ToSeconds(t_), std::move(what)});
    if (result_.wrong.size() >= kMostWrong) over_ = true;
  }

  /// Hears what it says; what is wrong is noted, and the rest heard.
  void Listen(bool patient, Clock::time_point deadline) {
    while (goes_on()) {
      std::string problem = program_.Pump(patient, deadline);
      if (problem.empty()) return;
      Wrong(std::move(problem));
      // Nothing that it says counts without a greeting.
      over_ = over_ || !program_.session().greeted();
      if (!program_.session().Silence(DriverProgram::WallUs()).empty()) over_ = true;
    }
  }

  void Apply() {
    for (const MeasuredReport& report : program_.session().TakeReports(t_)) {
      if (report.kind == MeasuredReport::Kind::kFailed) {
        Wrong(fmt::format("it says that it cannot go on: {}", report.reason));
        over_ = true;
      }
      if (report.kind == MeasuredReport::Kind::kNotReady && report.reason != waits_) {
        waits_ = report.reason;
        Tell("it waits for " + waits_);
      }
      const std::string problem = ApplyReport(&agent_, report, t_, scenario_.tasks);
      if (!problem.empty()) Wrong(problem);
    }
  }

  /// The next tick, as a mission has it.
  void Tick(const std::vector<Ruling>& rulings = {}) {
    t_ += kTickUs;
    const double rate = options_.rules.rate;
    if (rate > 0) {
      const auto due = started_ + std::chrono::microseconds(ToUs(ToSeconds(t_) / rate));
      for (; goes_on() && Clock::now() < due; std::this_thread::sleep_for(kLook)) {
        Listen(false, Clock::now());
      }
    }
    program_.session().Tick(t_, DriverProgram::WallUs());
    const TimeUs patience_us =
        rate > 0 ? ToUs(ToSeconds(kTickUs) / rate / 4) : options_.rules.lost_after_us * 2;
    Listen(true, Clock::now() + std::chrono::microseconds(patience_us));
    Apply();
    ExpectOnward(&agent_, t_, t_ + kTickUs);
    UpdateActivity();
    const Verdict verdict(activity_ ? std::vector{*activity_} : std::vector<Activity>(), rulings);
    Settle(&agent_, verdict, t_, scenario_.tasks);
    if (agent_.action == ActionKind::kNone) activity_.reset();
    Follow("the check cancels it");
  }

  /// Waits until it can set out.
  void AwaitReady() {
    while (goes_on() && agent_.not_ready() && t_ < kReadyUs) Tick();
    if (goes_on() && agent_.not_ready()) {
      Wrong(fmt::format("not ready after {:g} min: it waits for {}", ToMinutes(kReadyUs), waits_));
      over_ = true;
    }
    result_.ready_s = ToSeconds(t_);
  }

  void Follow(std::string_view why) {
    program_.session().Follow(agent_, t_, DriverProgram::WallUs(), why);
  }

  /// Its partner is there, and done, by computation.
  void UpdateActivity() {
    if (!IsPair(agent_.action) || !SaysArrived(agent_)) return;
    if (!activity_) {
      const bool senses = agent_.action == ActionKind::kSense;
      activity_ = Activity{senses ? ActivityKind::kSensing : ActivityKind::kCharging,
                           UavId(0),
                           0,
                           0,
                           agent_.arrive_us,
                           agent_.arrive_us + kSensingUs};
    }
    if (SaysDone(agent_)) {
      activity_->end_us = std::min(activity_->end_us, t_);
    } else if (activity_->end_us <= t_) {
      activity_->end_us = t_ + kTickUs;
    }
  }

  void Send(ActionKind kind, Point to) {
    Action action;
    action.kind = kind;
    action.uav = UavId(0);
    action.worker = WorkerId(0);
    action.vehicle = VehicleId(0);
    action.task = TaskId(0);
    action.charge = ChargeId(0);
    action.to = to;
    if (!IsPair(kind)) action.task = TaskId(), action.charge = ChargeId();
    if (kind == ActionKind::kCharge) action.task = TaskId();
    Begin(&agent_, action, decision_++, t_, scenario_.disturbances, 1);
    Follow("");
  }

  /// Ticks until `is_over`, at most until it is later than planned by the patience. How long it
  /// took.
  template <class IsOver>
  std::optional<double> Await(TimeUs from_us, TimeUs planned_us, IsOver is_over) {
    while (goes_on() && !is_over() && t_ < from_us + planned_us + kPatienceUs) Tick();
    if (!is_over()) return {};
    return ToSeconds(t_ - from_us);
  }

  /// Of a command that it does now.
  std::string NumberOf(std::string_view what) {
    std::string command = fmt::format("{} {}", what, ++commands_);
    Tell(command);
    return command;
  }

  void Tell(std::string_view what) const {
    if (options_.progress) options_.progress(fmt::format("{} {}", ClockText(t_), what));
  }

  void GoAndDo(ActionKind kind, Point to) {
    if (!goes_on()) return;
    const TimeUs from = t_;
    Send(kind, to);
    TimeUs arrived = kNever;
    const std::string go = NumberOf("goto");
    Await(from, kWayUs, [&] {
      if (agent_.measured && agent_.measured->arrived) arrived = agent_.arrive_us;
      return arrived != kNever;
    });
    DriverCheckResult::Step way{go, ToSeconds(kWayUs), {}, ""};
    if (arrived != kNever) way.took_s = ToSeconds(arrived - from);
    result_.steps.push_back(way);
    if (!goes_on()) return;
    if (arrived == kNever) return GiveUp("there");
    const TimeUs begun = arrived;
    DriverCheckResult::Step work{
        NumberOf(kind == ActionKind::kSense ? "sense" : "charge"), ToSeconds(kSensingUs), {}, ""};
    const auto took = Await(begun, kSensingUs, [&] { return agent_.action == ActionKind::kNone; });
    if (took) work.took_s = ToSeconds(agent_.busy_until_us - begun);
    result_.steps.push_back(work);
    if (goes_on() && !took) GiveUp("done");
  }

  void GiveUp(std::string_view what) {
    Wrong(fmt::format("not {} {:g} min after it should have been", what, ToMinutes(kPatienceUs)));
    Release();
  }

  /// Tells it to stop, at the next tick.
  void Release() {
    activity_.reset();
    Tick({{agent_.kind, 0, RulingKind::kReleased, t_ + kTickUs}});
  }

  void GoAndStay(Point to) {
    if (!goes_on()) return;
    Send(ActionKind::kGoTo, to);
    Tick();
    Release();
    result_.steps.push_back({NumberOf("goto"), ToSeconds(kWayUs), {}, "cancelled"});
    Tick();  // it may take until it hears of it
    const Point stopped = Place();
    Tick();
    Tick();
    const double moved = agent_.WayM(stopped, Place());
    if (goes_on() && moved > agent_.speed_m_s) {
      Wrong(fmt::format("it moved {:.0f} m after cancel", moved));
    }
  }

  Point Place() const { return agent_.measured ? agent_.measured->seen.at : agent_.to; }

  void GoTwice(Point first, Point second) {
    if (!goes_on()) return;
    Send(ActionKind::kGoTo, first);
    Tick();
    if (!goes_on()) return;
    result_.steps.push_back({NumberOf("goto"), ToSeconds(kWayUs), {}, "replaced"});
    // As if it had been released and commanded again at this very time.
    Settle(&agent_, Verdict({}, {{agent_.kind, 0, RulingKind::kReleased, t_}}), t_,
           scenario_.tasks);
    const TimeUs from = t_;
    Send(ActionKind::kGoTo, second);
    const TimeUs planned = agent_.arrive_us - from;
    const auto took = Await(from, planned, [&] { return agent_.action == ActionKind::kNone; });
    DriverCheckResult::Step way{NumberOf("goto"), ToSeconds(planned), {}, ""};
    if (took) way.took_s = ToSeconds(agent_.busy_until_us - from);
    result_.steps.push_back(way);
    if (goes_on() && !took) GiveUp("there");
  }

  const DriverCheckOptions& options_;
  const Scenario scenario_;
  AgentState agent_;
  DriverProgram program_;
  const Clock::time_point started_;
  TimeUs t_ = 0;
  std::int32_t decision_ = 0;
  int commands_ = 0;
  bool over_ = false;
  std::string waits_;  ///< what it waits for
  std::optional<Activity> activity_;
  DriverCheckResult result_;
};

}  // namespace

DriverCheckResult CheckDriver(const DriverCheckOptions& options) { return Check(options).Run(); }

}  // namespace muster::tools
