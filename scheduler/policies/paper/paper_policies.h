#pragma once

#include "scheduler/policy.h"
#include "scheduler/weights.h"

namespace muster::scheduler {

/// HoCs-ILS on the whole graph. Source: Alg. 1 to 4.
class IlsPolicy : public Policy {
 public:
  Decision Decide(const Situation& situation) override;
};

/// HoCs-MPQ, with hierarchical or (section 5.3.3) uniform weights. Source: Alg. 1 to 5.
class MpqPolicy : public Policy {
 public:
  explicit MpqPolicy(Foundation foundation) : foundation_(foundation) {}
  Decision Decide(const Situation& situation) override;

 private:
  Foundation foundation_;
};

}  // namespace muster::scheduler
