#pragma once

#include <gtest/gtest.h>

#include "tools/audit/auditor.h"

namespace muster::tools {

/// Audits the mission whose packets it is given; what breaks a rule is the test's failure when this
/// goes out of scope.
class Audited {
 public:
  Audited() = default;
  Audited(const Audited&) = delete;
  Audited& operator=(const Audited&) = delete;
  ~Audited() {
    for (const audit::Violation& v : auditor_.Finish()) {
      ADD_FAILURE() << v.at_us << " us, " << v.invariant << ": " << v.text;
    }
  }
  void Add(const Packet& packet) { auditor_.Add(packet); }

 private:
  audit::Auditor auditor_;
};

}  // namespace muster::tools
