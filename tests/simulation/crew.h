#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "base/check.h"
#include "simulation/start_process.h"
#include "simulation/virtual_network.h"
#include "simulation/virtual_process.h"

namespace muster::tools::testing {

/// What becomes of packets: `delay_us` at most beyond the 50 us that each travels.
inline PacketFaults Lossy(double loss, double duplication = 0, TimeUs delay_us = 0) {
  return {.loss = loss, .duplication = duplication, .jitter_us = delay_us};
}

/// A process of run 1 with policy mpq.
inline std::unique_ptr<Process> StartProcess(
    const std::string& name, std::int64_t boot_id, const std::string& json,
    const world::WorldOptions& options = {}, const std::string& policy = "mpq",
    std::size_t most_whole = agents::AgentProcess::kMostWhole) {
  simulation::ProcessSettings settings;
  settings.scenario = json;
  settings.policy = policy;
  settings.world = options;
  settings.most_whole = most_whole;
  return simulation::StartProcess({1, name, boot_id}, settings);
}

/// Processes over a virtual network, by name.
class Crew {
 public:
  explicit Crew(PacketFaults faults = {}, std::uint64_t seed = 1)
      : faults_(std::move(faults)), seed_(seed), network_(seed, {50, 50}) {
    network_.set_tap([this](const simulation::Participant& sender, const Packet& packet) {
      if (&sender == &liar_) return;
      if (observe_) observe_(packet);
      if (intruder_) network_.Send(liar_, intruder_(packet));
    });
  }

  /// With the network's faults unless it has its own.
  void Add(std::unique_ptr<Process> core, const std::optional<PacketFaults>& faults = {}) {
    const std::string name = core->identity().name;
    if (faults) own_faults_[name] = *faults;
    processes_[name] = std::make_unique<simulation::VirtualProcess>(&network_, std::move(core),
                                                                    seed_, FaultsOf(name));
  }
  void Kill(const std::string& name) { processes_.erase(name); }
  /// SIGSTOP: what it hears waits. SIGCONT.
  void Stop(const std::string& name, bool stopped) { processes_.at(name)->set_stopped(stopped); }
  /// It neither hears nor is heard from now on, or again; what it says is observed all the same.
  void Isolate(const std::string& name, bool isolated) {
    isolated ? void(isolated_.insert(name)) : void(isolated_.erase(name));
    for (const auto& [other, process] : processes_) process->bus().SetFaults(FaultsOf(other));
  }
  /// Somebody who answers each packet with one of his own, which everybody receives.
  void set_intruder(std::function<Packet(const Packet&)> intruder) {
    intruder_ = std::move(intruder);
  }
  TimeUs now_us() const { return network_.now_us(); }

  /// Runs until `done` or until `limit_us` of virtual time; every packet sent goes to `observe`.
  /// Returns whether `done` was reached. Throws what a process ends of.
  bool Run(TimeUs limit_us, const std::function<bool()>& done,
           std::function<void(const Packet&)> observe) {
    observe_ = std::move(observe);
    while (!done()) {
      if (!network_.Advance(limit_us)) return false;
      for (const auto& [name, process] : processes_) {
        if (!process->failure().empty()) throw InputError(process->failure());
      }
    }
    return true;
  }

 private:
  struct Liar : simulation::Participant {
    void OnArrival(const SentPacket&) override {}
    TimeUs wake_us() const override { return kNever; }
    void Wake() override {}
  };

  PacketFaults FaultsOf(const std::string& name) const {
    const auto own = own_faults_.find(name);
    PacketFaults faults = own == own_faults_.end() ? faults_ : own->second;
    if (isolated_.contains(name)) faults.loss = 1;
    faults.unheard = isolated_;
    return faults;
  }

  PacketFaults faults_;
  std::map<std::string, PacketFaults> own_faults_;
  std::set<std::string> isolated_;
  std::uint64_t seed_;
  simulation::VirtualNetwork network_;
  std::map<std::string, std::unique_ptr<simulation::VirtualProcess>> processes_;
  std::function<void(const Packet&)> observe_;
  std::function<Packet(const Packet&)> intruder_;
  Liar liar_;
};

}  // namespace muster::tools::testing
