#include "tools/trials/shrink.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <utility>

namespace muster::tools {
namespace {

constexpr TimeUs kShortestUs = kMinuteUs;
constexpr TimeUs kShortestRealUs = 10'000;

class Shrinker {
 public:
  Shrinker(VirtualMission mission, const std::function<bool(const VirtualMission&)>& fails,
           const std::function<bool()>& stop)
      : best_(std::move(mission)), fails_(fails), stop_(stop) {}

  VirtualMission Run() {
    do {
      changed_ = false;
      LeaveOut(&VirtualMission::faults);
      LeaveOut(&VirtualMission::orders);
      LeaveOut(&VirtualMission::clock_jumps);
      Try([](VirtualMission* mission) { mission->drop = 0; },
          [](const VirtualMission& mission) { return mission.drop > 0; });
      Try(LetAgentsMoveAsComputed,
          [](const VirtualMission& mission) { return mission.drivers != nullptr; });
      Try(
          [](VirtualMission* mission) {
            mission->schedulers = 1;
            std::erase_if(mission->faults, [](const PlannedFault& fault) {
              return fault.target.find("scheduler-") != std::string::npos;
            });
          },
          [](const VirtualMission& mission) { return mission.schedulers > 1; });
      for (std::size_t i = 0; i < best_.faults.size(); ++i) {
        Shorten(i, &PlannedFault::for_us, kShortestUs);
        Shorten(i, &PlannedFault::for_real_us, kShortestRealUs);
      }
    } while (changed_ && !stop_());
    return std::move(best_);
  }

 private:
  static void LetAgentsMoveAsComputed(VirtualMission* mission) {
    mission->drivers = nullptr;
    Scenario& scenario = mission->scenario;
    for (const AgentKind kind : kAgentKinds) {
      for (AgentSpec& agent : ByKind(kind, scenario.uavs, scenario.workers, scenario.vehicles)) {
        agent.measured = false;
      }
    }
  }

  template <class Change, class Applies>
  bool Try(Change change, Applies applies) {
    if (!applies(best_) || stop_()) return false;
    VirtualMission less = best_;
    change(&less);
    if (!fails_(less)) return false;
    best_ = std::move(less);
    changed_ = true;
    return true;
  }

  /// Halves, quarters, ..., single ones.
  template <class List>
  void LeaveOut(List VirtualMission::*list) {
    for (std::size_t size = (best_.*list).size(); size > 0; size /= 2) {
      for (std::size_t from = 0; from < (best_.*list).size();) {
        const bool without = Try(
            [&](VirtualMission* mission) {
              auto& all = mission->*list;
              const std::size_t until = std::min(from + size, all.size());
              all.erase(all.begin() + static_cast<std::ptrdiff_t>(from),
                        all.begin() + static_cast<std::ptrdiff_t>(until));
            },
            [](const VirtualMission&) { return true; });
        if (!without) from += size;
        if (stop_()) return;
      }
    }
  }

  void Shorten(std::size_t fault, TimeUs PlannedFault::*duration, TimeUs shortest_us) {
    while (Try([&](VirtualMission* mission) { mission->faults[fault].*duration /= 2; },
               [&](const VirtualMission& mission) {
                 return mission.faults[fault].*duration >= 2 * shortest_us;
               })) {
    }
  }

  VirtualMission best_;
  const std::function<bool(const VirtualMission&)>& fails_;
  const std::function<bool()>& stop_;
  bool changed_ = false;
};

}  // namespace

std::string FindingKind(const std::string& finding) {
  std::string kind;
  for (const char c : finding) {
    if (std::isdigit(static_cast<unsigned char>(c)) == 0) kind += c;
  }
  return kind;
}

VirtualMission Shrink(VirtualMission mission,
                      const std::function<bool(const VirtualMission&)>& fails,
                      const std::function<bool()>& stop) {
  return Shrinker(std::move(mission), fails, stop).Run();
}

}  // namespace muster::tools
