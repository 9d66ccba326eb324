#pragma once

#include <fmt/format.h>

#include <map>
#include <utility>
#include <vector>

#include "agents/core/driver_port.h"
#include "base/random.h"

namespace muster {

/// Speaks for a class's measured agents: each tells the truth, at a pace of its own, late or on
/// time, not at every tick; now and then one cannot go on, or, where `some_wait`, set out. In the
/// place of programs, in virtual time.
class TruthfulDrivers : public agents::DriverPort {
 public:
  struct Counts {
    int reports = 0, failures = 0;
  };

  /// Of every other one of a class's first `n_agents`, which are all measured. `counts`: where to
  /// count; nullptr: nowhere.
  TruthfulDrivers(std::uint64_t seed, AgentKind kind, std::size_t n_agents,
                  Counts* counts = nullptr, bool some_wait = false)
      : random_(seed, Stream::kTest, 20 + static_cast<std::uint64_t>(kind)),
        waits_(seed, Stream::kTest, 30 + static_cast<std::uint64_t>(kind)),
        some_wait_(some_wait),
        seed_(seed),
        n_agents_(static_cast<std::int32_t>(n_agents)),
        counts_(counts) {}

  void Begin(const Scenario&, const AgentState& agent, TimeUs at) override {
    Body& body = bodies_[agent.id];
    body = {.slowness = random_.Below(3) == 0 ? 1 : random_.Uniform(1, 2.5),
            .agent = agent,
            .at = PositionAt(agent, at)};
    Wait(&body, at);
  }
  bool drives(std::int32_t id) const override {
    return id < n_agents_ && (static_cast<std::uint64_t>(id) + seed_) % 2 == 0;
  }
  void Tell(const AgentState& agent, TimeUs before, TimeUs at) override {
    Body& body = bodies_.at(agent.id);
    const bool is_new = agent.decision != body.agent.decision || agent.action != body.agent.action;
    if (is_new) body.is_there = false;
    if (is_new && agent.action == ActionKind::kNone) Wait(&body, at);
    body.agent = agent;
    body.is_told = true;
    Move(&body, at - before);
  }
  bool Listen() override { return true; }
  std::vector<MeasuredReport> TakeReports(TimeUs at) override {
    std::vector<MeasuredReport> reports;
    for (auto& [id, body] : bodies_) {
      if (std::exchange(body.is_told, false)) Speak(&body, at, &reports);
    }
    if (counts_ != nullptr) counts_->reports += static_cast<int>(reports.size());
    return reports;
  }
  TimeUs patience_us() const override { return kNever; }
  void Bye(std::string_view) override {}

 private:
  struct Body {
    double slowness = 1;
    AgentState agent;
    Point at;
    bool is_there = false, is_told = false;
    TimeUs ready_us = 0;
  };

  /// Draws whether it can set out now, and if not, when it can.
  void Wait(Body* body, TimeUs t) {
    if (some_wait_ && waits_.Below(4) == 0) {
      body->ready_us = t + waits_.Below(40 * 60) * kSecondUs;
    }
  }

  void Move(Body* body, TimeUs duration_us) {
    const AgentState& agent = body->agent;
    if (agent.action == ActionKind::kNone || body->is_there || agent.failed) return;
    const double way = Distance(body->at, agent.to);
    const double step = agent.speed_m_s / body->slowness * ToSeconds(duration_us);
    body->is_there = step >= way;
    body->at = body->is_there ? agent.to : Lerp(body->at, agent.to, step / way);
  }

  void Speak(Body* body, TimeUs t, std::vector<MeasuredReport>* reports) {
    const AgentState& agent = body->agent;
    const auto say = [&](MeasuredReport report) {
      report.agent_kind = agent.kind;
      report.agent = agent.id;
      report.decision = agent.decision;
      report.at_us = t;
      reports->push_back(std::move(report));
    };
    if (agent.failed) return;
    if (agent.action == ActionKind::kNone) {
      const bool waits = t < body->ready_us;
      if (waits && agent.idle(t)) {
        say({.kind = MeasuredReport::Kind::kNotReady,
             .reason = fmt::format("a fix ({} satellites)", waits_.Below(7))});
      }
      if (!waits && agent.not_ready()) say({.kind = MeasuredReport::Kind::kReady});
      return;
    }
    if (random_.Below(1000) == 0) {
      say({.kind = MeasuredReport::Kind::kFailed, .reason = "tired"});
      if (counts_ != nullptr) ++counts_->failures;
      return;
    }
    if (random_.Below(4) == 0) return;  // silent
    if (body->is_there) {
      if (!agent.measured->arrived) say({.kind = MeasuredReport::Kind::kArrived});
      const auto& activity = agent.activity;
      if (!agent.measured->arrived || !activity || activity->start_us > t) return;
      if (!agent.measured->done && (t >= activity->end_us || random_.Below(20) == 0)) {
        say({.kind = MeasuredReport::Kind::kDone});
      }
      return;
    }
    const double left_s = Distance(body->at, agent.to) / agent.speed_m_s * body->slowness;
    std::optional<TimeUs> expected_us;
    if (random_.Below(2) == 0) expected_us = t + ToUs(left_s);
    say({.at = body->at, .expected_us = expected_us});
  }

  Random random_, waits_;
  const bool some_wait_;
  const std::uint64_t seed_;
  const std::int32_t n_agents_;
  Counts* const counts_;
  std::map<std::int32_t, Body> bodies_;
};

}  // namespace muster
