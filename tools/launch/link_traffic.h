#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/units.h"
#include "lcmtypes/bus/bus.h"
#include "tools/launch/hosts.h"

namespace muster::tools {

/// Bytes that a message takes on Ethernet with an MTU of 1500: its data with LCM's, UDP's, IP's and
/// Ethernet's headers, in as many datagrams and IP fragments as it needs.
std::int64_t WireBytes(const Packet& packet);

/// What the links of a mission's hosts carry, computed from the log. LCM sends to all hosts, so a
/// host's link carries what its own processes send and what all others send. Packets that are lost
/// before they reach the recorder are not counted.
class LinkTraffic {
 public:
  /// `here`: what the host of the launcher, the recorder and all that `hosts` does not name is
  /// called. `hosts` must outlive this object.
  LinkTraffic(const HostList& hosts, std::string here);

  /// The log's next event, repeats too. `now_us`: monotonic.
  void Add(const Packet& packet, TimeUs now_us);

  struct Link {
    std::string host;
    double mbit_s = 0;  ///< what it can carry each way; 0: not known
    std::int64_t sent_bytes = 0, heard_bytes = 0;
    double mean_mbit_s = 0, busiest_mbit_s = 0;  ///< the greater way; busiest: of one second
  };
  /// In the hosts' order, `here` first.
  std::vector<Link> links() const;
  /// For the summary: a line for each link, and whether a link limits the mission.
  std::string Text() const;

 private:
  struct Sent {
    std::int64_t bytes = 0;
    std::map<std::int64_t, std::int64_t> by_second;
  };
  const HostList& hosts_;
  const std::string here_;
  std::map<std::string, Sent> sent_;  ///< by host's name
  TimeUs first_us_ = kNever, last_us_ = 0;
};

}  // namespace muster::tools
