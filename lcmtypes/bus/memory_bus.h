#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "lcmtypes/bus/bus.h"

namespace muster {

/// A bus in memory that loses nothing: what a member publishes is put into the queue of every
/// member, its own included, in order. A member hears itself because LCM's multicast loops back to
/// the sending process too; a core that copes with one bus copes with the other. All members belong
/// to one thread.
class MemoryHub {
 public:
  /// A new member, which hears what is published from now on. Destroying it leaves the hub. The hub
  /// must outlive its members.
  std::unique_ptr<Bus> Join();

  std::size_t members() const { return members_.size(); }

 private:
  class Member;
  void Send(const Packet& packet);

  std::vector<Member*> members_;
};

}  // namespace muster
