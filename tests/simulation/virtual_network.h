#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "agents/core/agent_process.h"
#include "base/check.h"
#include "base/random.h"
#include "protocol/process.h"
#include "scheduler/process/scheduler_process.h"
#include "world/world_process.h"

namespace muster::tools::testing {

/// A process of run 1: "world", "scheduler" (policy mpq), or an agent class with all its agents.
inline std::unique_ptr<Process> StartProcess(const std::string& name, std::int64_t boot_id,
                                             const std::string& json) {
  const Identity identity{1, name, boot_id};
  if (name == "world") {
    return std::make_unique<world::WorldProcess>(identity, 0, json, world::WorldOptions());
  }
  if (name == "scheduler") {
    return std::make_unique<scheduler::SchedulerProcess>(identity, 0, "mpq",
                                                         [] { return TimeUs{0}; });
  }
  for (const AgentKind kind : kAgentKinds) {
    if (name == ToString(kind)) {
      return std::make_unique<agents::AgentProcess>(identity, 0, kind, agents::IdRange());
    }
  }
  MUSTER_CHECK(false, "{}", name);
  return nullptr;
}

/// What a virtual network does to each packet at each receiver.
struct NetworkFaults {
  double loss = 0;
  double duplication = 0;
  TimeUs longest_delay_us = 100;  ///< uniform in [50, longest]: overtaking beyond 50
};

/// Processes in virtual time over a network that loses, doubles and reorders packets, all drawn
/// from a seed. No real clock, so a test of hours of protocol takes milliseconds and repeats
/// exactly.
class VirtualNetwork {
 public:
  VirtualNetwork(const NetworkFaults& faults, std::uint64_t seed)
      : faults_(faults), random_(seed, Stream::kTest) {}

  void Add(std::unique_ptr<Process> process) {
    const std::string name = process->identity().name;
    processes_[name] = std::move(process);
    arrivals_[{now_us_, serial_++}] = {name, std::nullopt};
  }
  void Kill(const std::string& name) { processes_.erase(name); }
  TimeUs now_us() const { return now_us_; }
  /// Somebody who answers each packet with one of his own, which everybody receives.
  void set_intruder(std::function<Packet(const Packet&)> intruder) {
    intruder_ = std::move(intruder);
  }
  /// It hears everything, as the recorder does in the end: its senders repeat what the log lacks.
  void Spare(const std::string& name) { spared_.insert(name); }
  /// It neither hears nor is heard from now on, or again.
  void Isolate(const std::string& name, bool isolated) {
    isolated ? void(isolated_.insert(name)) : void(isolated_.erase(name));
  }

  /// Runs until `done` or until `limit_us` of virtual time; every packet sent goes to `observe`.
  /// Returns whether `done` was reached.
  bool Run(TimeUs limit_us, const std::function<bool()>& done,
           const std::function<void(const Packet&)>& observe) {
    while (!done()) {
      TimeUs wake_us = arrivals_.empty() ? kNever : arrivals_.begin()->first.first;
      std::string waker;
      for (const auto& [name, process] : processes_) {
        if (process->wake_us() < wake_us) {
          wake_us = process->wake_us();
          waker = name;
        }
      }
      if (wake_us == kNever || wake_us > limit_us) return false;
      now_us_ = std::max(now_us_, wake_us);
      std::vector<Packet> arrived;
      if (waker.empty()) {
        auto arrival = arrivals_.extract(arrivals_.begin());
        waker = arrival.mapped().first;
        if (arrival.mapped().second) arrived.push_back(*arrival.mapped().second);
      }
      const auto process = processes_.find(waker);
      if (process == processes_.end()) continue;
      std::vector<Packet> out;
      process->second->Step(arrived, {now_us_, 0}, &out);
      for (const Packet& packet : out) {
        observe(packet);
        Send(waker, packet);
        if (intruder_) Send("", intruder_(packet));
      }
    }
    return true;
  }

 private:
  void Send(const std::string& sender, const Packet& packet) {
    for (const auto& [name, process] : processes_) {
      if (isolated_.contains(sender) || isolated_.contains(name)) continue;
      if (name == sender) continue;
      if (!spared_.contains(name) && random_.Uniform() < faults_.loss) continue;
      const int copies = random_.Uniform() < faults_.duplication ? 2 : 1;
      for (int i = 0; i < copies; ++i) {
        const auto delay =
            static_cast<TimeUs>(random_.Uniform(50, static_cast<double>(faults_.longest_delay_us)));
        arrivals_[{now_us_ + delay, serial_++}] = {name, packet};
      }
    }
  }

  NetworkFaults faults_;
  std::function<Packet(const Packet&)> intruder_;
  Random random_;
  TimeUs now_us_ = 0;
  std::int64_t serial_ = 0;
  std::set<std::string> isolated_, spared_;
  std::map<std::string, std::unique_ptr<Process>> processes_;
  std::map<std::pair<TimeUs, std::int64_t>, std::pair<std::string, std::optional<Packet>>>
      arrivals_;
};

}  // namespace muster::tools::testing
