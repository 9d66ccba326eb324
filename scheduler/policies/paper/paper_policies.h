#pragma once

#include "scheduler/policies/paper/ils.h"
#include "scheduler/policy.h"
#include "scheduler/weights.h"

namespace muster::scheduler {

/// HoCs-ILS on the whole graph; with 0 iterations its first local optimum. Source: Alg. 1 to 4.
class IlsPolicy : public Policy {
 public:
  explicit IlsPolicy(int max_iterations = paper::kMaxIterations)
      : max_iterations_(max_iterations) {}
  Decision Decide(const Situation& situation) override;

 private:
  int max_iterations_;
};

/// HoCs-MPQ, with hierarchical or (section 5.3.3) uniform weights; with 0 iterations each round
/// ends at its first local optimum. Source: Alg. 1 to 5.
class MpqPolicy : public Policy {
 public:
  explicit MpqPolicy(Foundation foundation, int max_iterations = paper::kMaxIterations)
      : foundation_(foundation), max_iterations_(max_iterations) {}
  Decision Decide(const Situation& situation) override;

 private:
  Foundation foundation_;
  int max_iterations_;
};

}  // namespace muster::scheduler
