#pragma once

#include <functional>
#include <map>
#include <muster/event_t.hpp>
#include <muster/fault_t.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "lcmtypes/bus/lossy_bus.h"
#include "lcmtypes/words.h"

namespace muster {

/// Whether a fault on packets concerns that process. Targets: a name, "*" (all), and for a
/// partition "one+two|three".
bool Concerns(const fault_t& fault, const std::string& name);

/// The names on both sides of a partition's target; none when it is no "one+two|three".
std::optional<std::pair<std::set<std::string>, std::set<std::string>>> SidesOf(
    const std::string& target);

/// The detail of a fault's end as a process says it: "NAME: N packets".
std::string HitsText(const std::string& name, std::int64_t packets);
/// N of such a text; none when it is none.
std::optional<std::int64_t> HitsOf(const std::string& text);

/// One process's share of the faults that are ordered on MUSTER_FAULT: sets its bus accordingly and
/// says what has changed, at the end how many packets were hit. Of several faults at a time the
/// largest share of each kind holds. A fault_t with for_us 0 ends the fault of that id.
class FaultSwitch {
 public:
  /// `rejected`: how many packets the process has rejected so far, which is what foreign ones do.
  FaultSwitch(std::int64_t run_id, std::string name, LossyBus* bus,
              std::function<std::int64_t()> rejected);

  /// What to say of it: applied or ended; nothing when the packet changes nothing here.
  std::optional<event_t> Take(const Packet& packet);
  std::optional<event_t> Take(const fault_t& fault);

 private:
  struct Active {
    fault_t fault;
    std::int64_t hits_before = 0;
  };
  void SetBus();
  /// Packets that faults of that kind have hit here.
  std::int64_t Hits(FaultKind kind) const;

  std::int64_t run_id_;
  std::string name_;
  LossyBus* bus_;
  PacketFaults always_;  ///< as found
  std::function<std::int64_t()> rejected_;
  std::map<std::string, Active> active_;
  std::set<std::string> over_;  ///< their order, heard once more, is no new one
};

}  // namespace muster
