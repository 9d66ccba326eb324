#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <muster/event_t.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "protocol/sender.h"
#include "tools/faults/fault_plan.h"

namespace muster::tools {

/// What the injector can do to a mission; the launcher does it.
class FaultActions {
 public:
  virtual ~FaultActions() = default;
  /// Publishes the fault; the returned packet can be sent again.
  virtual SentPacket Publish(const fault_t& fault) = 0;
  virtual void SendAgain(const SentPacket& packet) = 0;
  /// Confirms what the launcher itself does, 13 applied or 14 ended.
  virtual void Confirm(EventKind kind, const std::string& fault_id) = 0;
  /// False: the process has ended and is not yet started again.
  virtual bool IsRunning(const std::string& name) = 0;
  /// False: the process does not run now.
  virtual bool SignalProcess(const std::string& name, int signal) = 0;
  /// Do not start it again before ReleaseRestart.
  virtual void HoldRestart(const std::string& name) = 0;
  virtual void ReleaseRestart(const std::string& name) = 0;
  /// The log's disk takes no further byte, or does again.
  virtual void SetDiskFull(bool full) = 0;
  /// Whether a signal holds it now.
  virtual bool IsStopped(const std::string& name) const = 0;
  /// The mission goes on without it, for good: it will confirm nothing.
  virtual bool IsGone(const std::string& name) const = 0;
  /// How often it was started before.
  virtual std::int64_t BootOf(const std::string& name) const = 0;
};

/// Injects a plan's faults when they are due and waits until each is confirmed.
/// - A fault on packets is published until every process that it concerns, in its present start,
/// has
///   said by event_t that it has applied it. Its end is published in the same way; each process
///   then says how many packets were hit.
/// - The world says when an agent has failed.
/// - The launcher confirms a signal when it sees that the process is dead or stopped.
class FaultInjector {
 public:
  /// `names`: the mission's processes.
  FaultInjector(FaultPlan plan, std::vector<std::string> names);

  /// `mission_us`: of the newest clock; -1 before the mission runs.
  void Step(TimeUs mission_us, TimeUs monotonic_us, FaultActions* actions);
  /// An event of the mission.
  void OnEvent(const event_t& event);
  /// Ends everything that is under way: the mission is over.
  void EndAll(TimeUs monotonic_us, FaultActions* actions);
  /// No fault is under way, and all processes have confirmed that.
  bool Settled(const FaultActions& actions) const;

  /// The faults of the plan that were not confirmed, or that hit nothing: id and why.
  std::vector<std::string> WithoutEffect() const;
  /// A process has ended. True: the plan ended it, so its restart does not count against it.
  bool OnDeath(const std::string& name, FaultActions* actions);
  /// Foreign packets are to be sent now.
  bool foreign() const;

 private:
  enum class Phase { kWaiting, kActive, kOver };
  using Start = std::pair<std::string, std::int64_t>;  // sender, boot_id
  struct Injection {
    PlannedFault fault;
    Phase phase = Phase::kWaiting;
    TimeUs until_real_us = kNever;  ///< monotonic
    SentPacket begin = {}, end = {};
    std::set<Start> applied = {}, ended = {};
    bool confirmed = false;  ///< by the launcher
    bool died = false;  ///< a process that it was to hit, before or during it: nobody may confirm
    std::int64_t hits = 0;  ///< packets
    BackOff repeat{5'000, 100'000};
  };

  void Begin(Injection* injection, TimeUs monotonic_us, FaultActions* actions);
  void End(Injection* injection, TimeUs monotonic_us, FaultActions* actions);
  /// A process has not confirmed yet what was published last.
  bool Owed(const Injection& injection, const FaultActions& actions) const;

  std::vector<Injection> injections_;
  std::vector<std::string> names_;
  TimeUs mission_us_ = 0;
};

}  // namespace muster::tools
